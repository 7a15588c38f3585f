"""Reactions and the forces across sections in the skin cache are those of the tables, frame by frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdValidation

from lappet import Material, Procedure, Section, SolveResult, SolverSettings, Traction, solve_procedure
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch

LOADED = (2, 3)  # frames in which the traction acts


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> SolveResult:
    """A bar of 24 x 8 x 4 mm, held at its left end, under its weight and for a while under a traction."""
    folder = tmp_path_factory.mktemp("bar")
    tissue = flat_patch((24.0, 8.0, 4.0), 2.0, bed_stiffness=0.0, bed_shear=0.0)
    corners = np.split(tissue.face_vertex_indices, np.cumsum(tissue.face_vertex_counts)[:-1])
    x, _, z = np.array([tissue.points[each].mean(axis=0) for each in corners]).T
    sides = {"fixed": x < -11.99, "right": x > 11.99, "underside": z < 0.01, "rim": (z > 0.01) & (z < 3.99)}
    subsets = {name: np.flatnonzero(faces).astype(np.int32) for name, faces in sides.items()}
    tissue = replace(tissue, subsets=subsets)
    pull = Traction("pull", "right", ((2.0, (1.0, 0.0, 0.5)), (3.0, (2.0, 0.0, 1.0))), 2.0, 4.0)
    cuts = (Section("near", (-6.0, 0, 0), (1, 0, 0), "near"), Section("along", (0, 0, 2.0), (0, 0, 1), "level"))
    procedure = Procedure(tissue, (Material("skin"),), events=(pull, *cuts), start_time=1, end_time=4)
    settings = SolverSettings(spacing=2.0)
    store = FrameStore(folder / "store")
    return solve_procedure(procedure, folder / "bar.usdc", settings, store=store, error_estimate=False)


@pytest.fixture(scope="module")
def stage(result: SolveResult) -> Usd.Stage:
    return Usd.Stage.Open(str(result.output))


def scope(stage: Usd.Stage, name: str) -> UsdGeom.PrimvarsAPI:
    prim = stage.GetPrimAtPath(f"/Procedure/Skin/{name}")
    assert prim.IsA(UsdGeom.Scope)
    return UsdGeom.PrimvarsAPI(prim)


def test_what_holds_or_loads_the_tissue_has_its_force_and_none_while_it_does_not_act(
    result: SolveResult, stage: Usd.Stage
) -> None:
    primvars = scope(stage, "Reactions")
    held = list(zip(primvars.GetPrimvar("holder").Get(), primvars.GetPrimvar("label").Get(), strict=True))
    assert set(held) == {("fixed", "fixed"), ("bed", "bed"), ("load", "right")}
    force = primvars.GetPrimvar("force")
    assert (force.GetInterpolation(), force.GetElementSize()) == ("constant", 3)
    for time in (1, 2, 3, 4):
        rows = {(row.holder, row.name): row for row in result.reactions if row.time == time}
        assert (("load", "right") in rows) == (time in LOADED)
        for key, found in zip(held, np.array(force.Get(time)), strict=True):
            row = rows.get(key)
            told = np.zeros(3) if row is None else [row.force_x_mn, row.force_y_mn, row.force_z_mn]
            assert found == pytest.approx(told, rel=1e-6)
    loaded = np.array(force.Get(3))[held.index(("load", "right"))]
    assert loaded == pytest.approx([2.0 * 32.0, 0.0, 1.0 * 32.0], rel=1e-6)


def test_a_section_has_its_force_and_tension_and_one_that_crosses_no_skin_has_no_tension(
    result: SolveResult, stage: Usd.Stage
) -> None:
    primvars = scope(stage, "Sections")
    assert list(primvars.GetPrimvar("label").Get()) == ["near", "level"]
    for time in (1, 4):
        rows = [row for row in result.sections if row.time == time]
        told = [[row.force_x_mn, row.force_y_mn, row.force_z_mn] for row in rows]
        assert np.array(primvars.GetPrimvar("force").Get(time)) == pytest.approx(np.array(told), rel=1e-6)
        near, level = primvars.GetPrimvar("tension").Get(time)
        assert near == pytest.approx(rows[0].tension_n_per_mm, rel=1e-6)
        assert np.isnan(level)
    assert primvars.GetPrimvar("tension").Get(3)[0] == pytest.approx(2.0 * 4.0 / 1000.0, rel=0.1)  # stress x thickness


def test_every_validator_of_usd_passes(stage: Usd.Stage) -> None:
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [f"{error.GetName()}: {error.GetMessage()}" for error in errors] == []
