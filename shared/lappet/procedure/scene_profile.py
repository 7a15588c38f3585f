"""Which features a scene needs, and because of which prims: what decides what is set up, computed and sent."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS
from lappet.foreign.regular_file import refuse_irregular
from lappet.procedure.cuts import Excision, Incision, Thin, Undermine
from lappet.procedure.events import (
    Event,
    Hook,
    Landmark,
    Pressure,
    Retractor,
    Section,
    Suture,
    Traction,
)
from lappet.procedure.suture_run import SutureRun
from lappet.procedure.tissue import Material

if TYPE_CHECKING:
    from lappet.procedure.procedure import Procedure

# Features of the report of economy, and their names here.
_MEASURED = {
    name: name
    for name in ("contact", "fibers", "muscle", "prestretch", "landmarks", "error_estimate", "strain", "region")
} | {"heterogeneity": "materials"}
# Those that are measured on a wide patch, all others on a bar.
_ON_A_PATCH = frozenset({"region"})
# What no prim asks for: computed unless an option of `lappet solve` says otherwise.
BY_OPTION = {"error_estimate": "--no-error-estimate", "strain": "--no-strain", "region": "--whole"}

_SHOWN = 3  # prims named in a reason; the others are counted


def scene_reasons(procedure: Procedure) -> dict[str, str]:
    """Find why the scene needs each feature.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    dict[str, str]
        By feature the prims that ask for it, as text; empty for what the scene does without. `fixed` stands for faces
        held in space, `contact` for bones, `self_contact` for tissue that is kept from passing through itself;
        `fibers`, `muscle` and `prestretch` are of a material in use, `materials` stands for more than one in use; the
        others are there where their prims are.
    """
    tissue = procedure.tissue
    materials = procedure.materials_in_use()

    def faces(subset: str) -> str:
        count = len(tissue.subsets.get(subset, ()))
        return f"{count} face{'' if count == 1 else 's'} in /Procedure/Tissue/{subset}" if count else ""

    def events(*kinds: type[Event]) -> str:
        return _named(f"/Procedure/Timeline/{event.name}" for event in procedure.events if isinstance(event, kinds))

    def of_materials(chosen: Sequence[Material]) -> str:
        return _named(f"/Procedure/Materials/{material.name}" for material in chosen)

    return {
        "fixed": faces("fixed"),
        "bed": faces("bed"),
        "undermining": events(Undermine),
        "thinning": events(Thin),
        "incisions": events(Incision),
        "excisions": events(Excision),
        "hooks": events(Hook),
        "retractors": events(Retractor),
        "sutures": events(Suture, SutureRun),
        "tractions": events(Traction),
        "pressures": _named(
            f"/Procedure/Timeline/{event.name}"
            for event in procedure.events
            if isinstance(event, Pressure) or (isinstance(event, Thin) and event.dressing > 0.0)
        ),
        "rollers": _named(f"/Procedure/Tissue/{roller.faces}" for roller in tissue.rollers),
        "sections": events(Section),
        "landmarks": events(Landmark),
        "gravity": f"{tissue.gravity:g} m/s² on /Procedure/Tissue" if tissue.has_gravity else "",
        "contact": _named(f"/Procedure/Bone/{bone.name}" for bone in procedure.bones),
        "self_contact": "/Procedure/Tissue" if tissue.self_contact else "",
        "fibers": of_materials([material for material in materials if material.has_fibers]),
        "muscle": of_materials([material for material in materials if material.has_muscle]),
        "prestretch": of_materials([material for material in materials if material.has_prestretch]),
        "materials": of_materials(materials) if len(materials) > 1 else "",
    }


def scene_profile(procedure: Procedure) -> dict[str, bool]:
    """Find which features the scene needs.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    dict[str, bool]
        Whether each feature of `scene_reasons` is needed; the report and `lappet inspect` share it.
    """
    return {name: bool(reason) for name, reason in scene_reasons(procedure).items()}


def profile_lines(procedure: Procedure, costs: Mapping[str, str] | None = None) -> list[str]:
    """Describe the scene profile in lines: what the scene needs, why and at what cost; then what it does without.

    Parameters
    ----------
    procedure
        The procedure.
    costs
        What features cost, as text by name, for those where it is known.

    Returns
    -------
    list[str]
        Lines of text.
    """
    reasons, costs = scene_reasons(procedure), costs or {}
    lines = []
    for name, reason in reasons.items():
        if reason:
            lines.append(f"needs    {name}: {reason}{f'; {costs[name]}' if name in costs else ''}")
    absent = [name for name, reason in reasons.items() if not reason]
    lines = lines or ["needs    nothing"]
    lines.append(f"without  {', '.join(absent)}")
    for name, option in BY_OPTION.items():
        lines.append(f"by option  {name}: on unless {option}{f'; {costs[name]}' if name in costs else ''}")
    return lines


def measured_costs(path: Path) -> dict[str, str]:
    """Read what features cost from a file that `lappet report economy` wrote.

    Parameters
    ----------
    path
        The file `economy.json`.

    Returns
    -------
    dict[str, str]
        Costs as text, by the names of the profile.

    Raises
    ------
    RefusedError
        If the file is no such report.
    """
    try:
        refuse_irregular(path, DEFAULT_LIMITS)
        rows = json.loads(path.read_text(encoding="utf-8"))["rows"]
        found = {(str(row["feature"]), bool(row["present"])): row for row in rows}
        costs = {}
        for feature, name in _MEASURED.items():
            absent, present = found.get((feature, False)), found.get((feature, True))
            if absent is None or present is None:
                continue
            unit = "instructions" if absent["instructions"] and present["instructions"] else "seconds"
            share = 100.0 * (present[unit] / absent[unit] - 1.0)
            scene = "patch" if feature in _ON_A_PATCH else "bar"
            costs[name] = f"{share:+.0f} % {unit} in the {scene} of `lappet report economy`"
        return costs
    except (OSError, ValueError, KeyError, TypeError, ZeroDivisionError, RecursionError) as error:
        raise refused(ProblemCode.ECONOMY_FILE, path, type(error).__name__) from error


def _named(paths: Iterable[str]) -> str:
    """Paths in a row, the last ones counted where there are many; empty for none."""
    found = list(dict.fromkeys(paths))
    more = f" and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    return ", ".join(found[:_SHOWN]) + more
