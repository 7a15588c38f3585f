"""Loads, rollers, reactions and sections of a procedure, from its file to the report and the tables.

The bar is 24 x 8 x 4 mm along x, of corotated tissue without lateral contraction: E 50 kPa. It hangs on its left end.
"""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from lappet import (
    Excision,
    Hook,
    Incision,
    Material,
    Pressure,
    Procedure,
    Retractor,
    Roller,
    Section,
    SolveResult,
    SolverSettings,
    Traction,
    solve_procedure,
    write_procedure,
)
from lappet.checks.validation import check
from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import connect_to
from lappet.procedure import Event, Tissue
from lappet.program.compile import compile_program
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch
from refusals import refuses

SKIN = Material("skin", "corotated", 50.0, 0.0)
AREA = 8.0 * 4.0
STRETCH = Traction("stretch", "right", ((1.0, (0.0, 0.0, 0.0)), (3.0, (10.0, 0.0, 0.0))), 1.0, 5.0)


def bar(**changes: Any) -> Tissue:
    """The bar; its sides have names."""
    tissue = flat_patch((24.0, 8.0, 4.0), 2.0, gravity=0.0)
    corners = np.split(tissue.face_vertex_indices, np.cumsum(tissue.face_vertex_counts)[:-1])
    middles = np.array([tissue.points[each].mean(axis=0) for each in corners])
    low, high = tissue.points.min(axis=0), tissue.points.max(axis=0)
    sides = {
        "left": (0, low),
        "right": (0, high),
        "front": (1, low),
        "back": (1, high),
        "under": (2, low),
        "over": (2, high),
    }
    named = {
        name: np.flatnonzero(np.abs(middles[:, axis] - end[axis]) < 1e-6).astype(np.int32)
        for name, (axis, end) in sides.items()
    }
    return replace(tissue, subsets={"fixed": named["left"], **named}, **changes)


def solved(folder: Path, *events: Event, tissue: Tissue | None = None, **settings: Any) -> SolveResult:
    procedure = Procedure(tissue or bar(), (SKIN,), events=events, start_time=1, end_time=5)
    chosen = SolverSettings(spacing=2.0, tolerance=1e-5, **settings)
    result = solve_procedure(
        procedure, folder / "p.usdc", chosen, store=FrameStore(folder / "store"), error_estimate=False
    )
    assert result.complete, result.reason
    return result


def forces(result: SolveResult, holder: str, name: str) -> np.ndarray:
    rows = [row for row in result.reactions if (row.holder, row.name) == (holder, name)]
    return np.array([[row.force_x_mn, row.force_y_mn, row.force_z_mn] for row in rows])


def test_a_traction_grows_with_its_samples_and_every_section_and_the_fixed_end_bear_it(tmp_path: Path) -> None:
    sections = [Section(f"at_{k}", (x, 0, 0), (2.0, 0, 0), f"at {x:g}") for k, x in enumerate((-9.0, 0.7, 6.0))]
    tissue = bar(bed_stiffness=0.0, bed_shear=0.0)
    around = np.concatenate([tissue.subsets[name] for name in ("left", "right", "front", "back")])
    tissue = replace(tissue, subsets={**tissue.subsets, "underside": tissue.subsets["under"], "rim": around})
    result = solved(tmp_path, STRETCH, *sections, tissue=tissue)
    pull = np.array([0.0, 5.0, 10.0, 10.0])[:, None] * AREA * [1.0, 0.0, 0.0]
    assert forces(result, "load", "right") == pytest.approx(pull, abs=1e-6)  # the last frame is after its release
    assert forces(result, "fixed", "left")[:4] == pytest.approx(-pull, abs=0.05)
    assert forces(result, "fixed", "left")[4] == pytest.approx(0.0, abs=0.05)
    for row in result.sections:
        assert row.across_mn == pytest.approx(([0.0, 160.0, 320.0, 320.0, 0.0])[int(row.time) - 1], abs=0.1)
        assert row.skin_length_mm == pytest.approx(8.0, rel=1e-3)
        assert row.tension_n_per_mm == pytest.approx(row.across_mn / 8000.0, rel=1e-3)
    ends = result.frames[3].solved.points[:, 0]
    assert ends.max() - ends.min() == pytest.approx(24.0 * (1.0 + 10.0 / 50.0), rel=1e-3)


def test_a_load_that_begins_in_a_later_epoch_is_kept_over_a_cut(tmp_path: Path) -> None:
    cut = Incision("cut", 3.0, ((-2.0, 0.0, 4.0), (2.0, 0.0, 4.0)))
    result = solved(tmp_path, STRETCH, cut)
    assert [len(epoch.boundary.loaded_index) for epoch in result.program.epochs] == [1, 1]
    assert forces(result, "fixed", "left")[3, 0] == pytest.approx(-320.0, rel=1e-3)


def test_a_load_on_faces_that_are_excised_is_refused() -> None:
    ring = ((3.0, -5.0, 4.0), (3.0, 5.0, 4.0))
    events = (Incision("cut", 2.0, ring), Excision("end", 2.0, ((8.0, 0.0, 4.0),)), STRETCH)
    procedure = Procedure(bar(), (SKIN,), events=events, start_time=1, end_time=5)
    with refuses(ProblemCode.LOAD_EXCISED, "/Procedure/Timeline/stretch"):
        compile_program(procedure, settings=SolverSettings(spacing=2.0))


def test_a_solve_that_is_resumed_goes_on_bit_for_bit_under_loads_and_on_rollers(tmp_path: Path) -> None:
    tissue = bar(rollers=(Roller("under"), Roller("front", (0.0, 1.0, 0.0))))
    events = (STRETCH, Pressure("air", "over", ((1.0, 0.0), (5.0, 4.0)), 1.0, 9.0))
    procedure = Procedure(tissue, (replace(SKIN, poissons_ratio=0.3),), events=events, start_time=1, end_time=5)
    program = compile_program(procedure, settings=SolverSettings(spacing=2.0))
    session = connect_to(None)(program.settings, program.bones)
    session.set_epoch(program.epochs[0], program.grips[0], program.landmarks_at[0])
    frames = [session.solve(frame, lambda _: None) for frame in program.frames]
    assert all(frame.converged for frame in frames)
    state = frames[2].state
    assert state is not None
    assert len(state.loads) == 2
    other = connect_to(None)(program.settings, program.bones)
    other.set_epoch(program.epochs[0], program.grips[0], program.landmarks_at[0])
    other.set_state(state)
    again = [other.solve(frame, lambda _: None) for frame in program.frames[3:]]
    for before, after in zip(frames[3:], again, strict=True):
        assert np.array_equal(before.points, after.points)
        assert np.array_equal(before.reactions, after.reactions)
    session.close()
    other.close()


def test_rollers_let_faces_slide_but_not_leave_their_plane(tmp_path: Path) -> None:
    tissue = bar(rollers=(Roller("under"), Roller("front", (0.0, 1.0, 0.0))))
    result = solved(tmp_path, STRETCH, tissue=tissue)
    surface = result.program.epochs[0].surface
    points = result.frames[3].solved.points
    for axis, low in ((2, 0.0), (1, -4.0)):
        on_plane = np.abs(surface.points[:, axis] - low) < 1e-6
        assert points[on_plane, axis] == pytest.approx(low, abs=4e-3)  # gaps of a thousandth of the spacing may be open
        assert np.ptp(points[on_plane, 0]) > 24.0 * 1.15
    assert np.abs(forces(result, "roller", "under")).max() < 1.0  # nothing presses on it


def test_a_retractor_pulls_with_the_force_that_holds_the_other_end(tmp_path: Path) -> None:
    still, moved = np.eye(4), np.eye(4)
    moved[3, 0] = 4.8
    pull = Retractor("jaw", "right", ((1.0, tuple(still.ravel())), (4.0, tuple(moved.ravel()))), 1.0, 9.0)
    result = solved(tmp_path, pull)
    assert forces(result, "retractor", "jaw")[-1] == pytest.approx([320.0, 0.0, 0.0], abs=0.1)
    assert forces(result, "fixed", "left")[-1] == pytest.approx([-320.0, 0.0, 0.0], abs=0.1)


def test_parts_of_what_is_fixed_have_the_names_of_their_subsets_or_numbers() -> None:
    tissue = bar()
    sides = {name: tissue.subsets[name] for name in ("left", "right")}
    both = np.concatenate([*sides.values()])
    for subsets, names in (
        ({"fixed": both}, ("fixed 1", "fixed 2")),
        ({"fixed": both, "jaw": sides["right"]}, ("jaw", "fixed")),
        ({"fixed": both, **sides}, ("left", "right")),
        ({"fixed": sides["left"]}, ("fixed",)),
    ):
        procedure = Procedure(replace(tissue, subsets=subsets), (SKIN,), start_time=1, end_time=1)
        program = compile_program(procedure, settings=SolverSettings(spacing=2.0))
        assert program.fixed_parts == names
        (epoch,) = program.epochs
        parts = epoch.boundary.fixed_parts
        if len(names) == 1:
            assert len(parts) == 0
            continue
        middles = epoch.surface.points[epoch.surface.triangles].mean(axis=1)
        assert np.array_equal(parts >= 0, epoch.surface.fixed)
        for part in (0, 1):
            assert np.ptp(middles[parts == part, 0]) < 1e-6


def test_what_loads_rollers_and_sections_lack_is_said(tmp_path: Path) -> None:
    bad = (
        Traction("t", "nowhere", ((1.0, (0.0, 0.0, float("nan"))),), 2.0, 1.0),
        Pressure("p", "none", (), 1.0, 3.0),
        Section("flat", (0, 0, 0), (0, 0, 0), "flat"),
        Section("far", (99, 0, 0), (1, 0, 0), ""),
    )
    tissue = bar(rollers=(Roller("left"), Roller("none"), Roller("over", (0, 0, 0)), Roller("top")))
    subsets = {**tissue.subsets, "none": np.zeros(0, np.int32), "top": tissue.subsets["over"][:2]}
    procedure = Procedure(replace(tissue, subsets=subsets), (SKIN,), events=bad, start_time=1, end_time=5)
    found = {(each.prim.rpartition("/")[2], str(each.code)) for each in check(procedure)}
    assert found == {
        ("t", "event-release"),
        ("t", "load-faces-unknown"),
        ("t", "load-not-finite"),
        ("p", "load-faces-empty"),
        ("p", "event-no-samples"),
        ("flat", "section-no-plane"),
        ("far", "section-off-tissue"),
        ("far", "landmark-no-label"),
        ("left", "roller-held"),
        ("none", "roller-faces-empty"),
        ("over", "roller-normal"),
        ("top", "roller-shared"),
    }


def test_the_command_writes_reactions_and_sections(tmp_path: Path) -> None:
    hook = Hook("hook", (6.0, 0.0, 4.0), ((1.0, (6.0, 0.0, 4.0)), (3.0, (6.0, 0.0, 8.0))), 1.0, 9.0, 50.0)
    events = (STRETCH, hook, Section("across", (0, 0, 0), (1, 0, 0), "the middle"))
    procedure = Procedure(bar(spacing=2.0, gravity=9.81), (SKIN,), events=events, start_time=1, end_time=4)
    write_procedure(procedure, tmp_path / "p.usda")
    names = ("report", "reactions", "sections")
    told = [part for name in names for part in (f"--{name}", str(tmp_path / f"{name}.csv"))]
    run = CliRunner().invoke(cli, ["solve", str(tmp_path / "p.usda"), "--no-error-estimate", *told])
    assert run.exit_code == 0, run.output
    report = json.loads((tmp_path / "report.csv").read_text())
    last = report["frames"][-1]
    weight = np.array([0.0, 0.0, -1100.0 * 9.81e-6 * 24.0 * AREA])
    held = np.array(last["reactions_mn"]["fixed"]["left"])
    load = np.array(last["reactions_mn"]["load"]["right"])
    assert load == pytest.approx([320.0, 0.0, 0.0])
    assert held + load + weight + last["hook_forces_mn"]["hook"] == pytest.approx(np.zeros(3), abs=0.5)
    assert {"tractions", "sections"} <= {name for name, needed in report["scene_profile"].items() if needed}
    with (tmp_path / "reactions.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows if row["time"] == "4"] == ["left", "right"]
    with (tmp_path / "sections.csv").open() as file:
        (*_, section) = csv.DictReader(file)
    assert section["section"] == "the middle"
    assert float(section["tension_n_per_mm"]) == pytest.approx(report["sections"][-1]["tension_n_per_mm"], rel=1e-5)
