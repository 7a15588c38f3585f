"""What is wrong with a material, and with a region of the tissue that is made of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from lappet.checks.suspicious_tissue import overlapping_regions
from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import MODELS, Material, Procedure
from lappet.procedure.prim_paths import MATERIALS, TISSUE
from lappet.tissue.surface import LABELS, skin_faces

LEAST_PRESTRETCH, MOST_PRESTRETCH = 0.5, 2.0
MOST_POISSONS_RATIO = 0.4999
MOST_FIBER_SLACK = 4.0
MOST_FIBER_ANGLE = 90.0  # degrees
MOST_MATERIALS = MOST_REGIONS = 64  # the entries of a list in a message


def material_problems(material: Material, path: str) -> list[Problem]:
    """Find every problem of one material.

    Parameters
    ----------
    material
        The material.
    path
        Path of its prim.

    Returns
    -------
    list[Problem]
        The problems.
    """
    problems: list[Problem] = []

    def add(code: ProblemCode, value: object, **fields: Any) -> None:
        problems.append(problem(code, path, f"{value:g}" if isinstance(value, float) else value, **fields))

    def at_least_0(name: str, value: float, unit: str = "") -> None:
        if not (math.isfinite(value) and value >= 0.0):
            add(ProblemCode.MATERIAL_BELOW_ZERO, value, name=name, unit=unit)

    if material.model not in MODELS:
        add(ProblemCode.MATERIAL_MODEL, material.model, known=", ".join(MODELS))
    if not (math.isfinite(material.youngs_modulus) and material.youngs_modulus > 0.0):
        add(ProblemCode.MATERIAL_YOUNGS_MODULUS, material.youngs_modulus)
    nu = material.poissons_ratio
    if math.isfinite(nu) and nu >= 0.5:
        add(ProblemCode.MATERIAL_INCOMPRESSIBLE, nu)
    elif not 0.0 <= nu <= MOST_POISSONS_RATIO:
        add(ProblemCode.MATERIAL_POISSONS_RATIO, nu, most=MOST_POISSONS_RATIO)
    at_least_0("The Mooney ratio μ₀₁/μ₁₀", material.mooney_ratio)
    at_least_0("The fiber stiffness k₁", material.fiber_k1, " kPa")
    at_least_0("The fiber exponent k₂", material.fiber_k2)
    if not 0.0 <= material.fiber_dispersion <= 1.0 / 3.0 + 1e-12:
        add(ProblemCode.MATERIAL_FIBER_DISPERSION, material.fiber_dispersion)
    if not 1.0 <= material.fiber_slack <= MOST_FIBER_SLACK:
        add(ProblemCode.MATERIAL_FIBER_SLACK, material.fiber_slack, most=MOST_FIBER_SLACK)
    if not 0.0 <= material.fiber_angle <= MOST_FIBER_ANGLE:
        add(ProblemCode.MATERIAL_FIBER_ANGLE, material.fiber_angle, most=MOST_FIBER_ANGLE)
    direction, stretch = material.fiber_direction, material.prestretch
    length = math.hypot(*direction)
    if not (math.isfinite(length) and length > 0.0):
        add(ProblemCode.MATERIAL_FIBER_DIRECTION, direction, shown=_numbers(direction))
    if not all(LEAST_PRESTRETCH <= v <= MOST_PRESTRETCH for v in stretch):
        limits = {"least": LEAST_PRESTRETCH, "most": MOST_PRESTRETCH}
        add(ProblemCode.MATERIAL_PRESTRETCH, stretch, shown=_numbers(stretch), **limits)
    at_least_0("The muscle stress", material.muscle_stress, " kPa")
    _activation(material, add)
    if not (math.isfinite(material.density) and material.density > 0.0):
        add(ProblemCode.MATERIAL_DENSITY, material.density)
    return problems


def _activation(material: Material, add: Callable[..., None]) -> None:
    for time, value in material.muscle_activation:
        if not (math.isfinite(time) and 0.0 <= value <= 1.0):
            add(ProblemCode.MATERIAL_ACTIVATION, value, time=time)
    times = [time for time, _ in material.muscle_activation]
    if len(set(times)) < len(times):
        add(ProblemCode.MATERIAL_ACTIVATION_TWICE, next(time for time in times if times.count(time) > 1))
    if material.muscle_stress == 0.0 and any(value > 0.0 for _, value in material.muscle_activation):
        add(ProblemCode.MATERIAL_ACTIVATION_UNUSED, 0)


def region_problems(procedure: Procedure) -> list[Problem]:
    """Find every problem of the tissue's regions but for their names (`lappet.procedure.prim_names.name_problems`).

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    list[Problem]
        The problems.
    """
    tissue = procedure.tissue
    problems: list[Problem] = []
    known = [material.name for material in procedure.materials]
    faces = len(tissue.face_vertex_counts)
    readable = all(((subset >= 0) & (subset < faces)).all() for subset in tissue.subsets.values())
    skin = skin_faces(tissue) if readable else None
    for region in tissue.regions:

        def add(code: ProblemCode, value: object, prim: str = f"{TISSUE}/{region.faces}", **fields: Any) -> None:
            problems.append(problem(code, prim, value, **fields))

        if region.material not in known:
            names = ", ".join(known) or "none"
            add(ProblemCode.REGION_MATERIAL_UNKNOWN, region.material, materials=MATERIALS, known=names)
        top, bottom = region.depth_from, region.depth_to
        if not (math.isfinite(top) and top >= 0.0):
            add(ProblemCode.REGION_DEPTH_FROM, f"{top:g}")
        if math.isnan(bottom) or bottom <= top:
            add(ProblemCode.REGION_DEPTH_TO, f"{bottom:g}", top=top)
        if region.faces in LABELS:
            add(ProblemCode.REGION_ON_LABEL, region.faces)
        elif skin is not None and region.faces in tissue.subsets and not skin[tissue.subsets[region.faces]].any():
            add(ProblemCode.REGION_OFF_SKIN, region.faces)
    if skin is not None:
        problems += overlapping_regions(tissue, skin)
    models = dict.fromkeys(material.model for material in procedure.materials_in_use())
    if len(models) > 1:
        problems.append(problem(ProblemCode.MATERIAL_MIXED_MODELS, TISSUE, ", ".join(models)))
    for what, count, most in (
        ("regions", len(tissue.regions), MOST_REGIONS),
        ("materials", len(procedure.materials_in_use()), MOST_MATERIALS),
    ):
        if count > most:
            problems.append(problem(ProblemCode.TISSUE_TOO_MANY, TISSUE, count, what=what, most=most))
    return problems


def _numbers(values: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{v:g}" for v in values) + ")"
