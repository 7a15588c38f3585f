"""Procedures as USD files: exact round trips, the schemas, atomic writing, other units and axes."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings

import lappet.usd.stage
from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.procedure import (
    Hook,
    Incision,
    Landmark,
    Material,
    Pressure,
    Procedure,
    Region,
    Retractor,
    Roller,
    Section,
    Suture,
    SutureLayer,
    SutureRun,
    Tissue,
    Traction,
    Vessel,
)
from lappet.tissue.patch import flat_patch
from lappet.tissue.surface import skin_faces
from lappet.usd.stage import SCHEMA, pxr, read_here, read_procedure, write_procedure
from procedure_strategies import procedures
from refusals import refuses

TURN = (0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 2.0, 3.0, 1.0)
STILL = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 2.0, 3.0, 1.0)


def _flat(value: object) -> list[float]:
    return [v for part in value for v in _flat(part)] if isinstance(value, tuple) else [float(value)]  # type: ignore[arg-type]


def _small() -> Procedure:
    return Procedure(flat_patch((10, 10, 2), 5.0), end_time=9.0).with_events(
        Incision("cut", 2.0, ((-1.1, 0, 2), (1.1, 0, 2)), 1.5),
        Incision("bevel", 2.5, ((-1.1, 1, 2), (1.1, 1, 2)), direction=(0.25, 1.0, -1.1)),
        Hook("hook", (0.1, 0.2, 2), ((2.0, (0.1, 0.2, 2)), (4.5, (0.1, 3.2, 4))), 2.0, 6.0),
        Retractor("pull", "fixed", ((2.0, STILL), (4.0, TURN)), 2.0, 6.0),
        Suture("stitch", ((0, -1.3, 2), (0, 1.3, 2)), 6.0),
        Landmark("tip", ((0, 1, 2), (0, 2, 2)), "the tip, “A”"),
        Traction("push", "bed", ((1.0, (0.0, 0.0, 0.0)), (3.0, (0.1, -2.0, 0.3))), 1.0, 8.0),
        Pressure("air", "bed", ((1.0, 0.0), (4.0, 0.7)), 1.0, 8.0),
        Section("across", (1.0, 0.0, 1.0), (2.0, 0.0, 0.5), "the neck"),
    )


def _layered() -> Procedure:
    tissue = _small().tissue
    skin = np.flatnonzero(skin_faces(tissue))
    subsets = {**tissue.subsets, "under": skin, "cheek": skin[:2], "plane": skin[:1], "side": skin[1:2]}
    regions = (Region("cheek", "muscle", 0.5), Region("under", "fat", 1.0, 2.0))
    muscle = Material("muscle", muscle_stress=300.0, muscle_activation=((2.0, 0.0), (5.0, 0.8)))
    return replace(
        _small(),
        tissue=replace(tissue, subsets=subsets, regions=regions, rollers=(Roller("plane", (0, 3, 4)), Roller("side"))),
        materials=(Material(), Material("fat"), muscle),
    )


@settings(
    max_examples=20,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(procedures())
def test_any_procedure_comes_back_equal_and_is_written_again_byte_for_byte(procedure: Procedure) -> None:
    with tempfile.TemporaryDirectory() as folder:
        first, second, crate = (Path(folder) / name for name in ("first.usda", "second.usda", "crate.usdc"))
        write_procedure(procedure, first)
        back = read_here(first).procedure  # in this process: a child for each of them takes minutes
        assert back == procedure
        assert [event.name for event in back.events] == [event.name for event in procedure.events]
        assert list(back.tissue.subsets) == list(procedure.tissue.subsets)
        write_procedure(back, second)
        assert second.read_bytes() == first.read_bytes()
        write_procedure(procedure, crate)
        assert read_here(crate).procedure == procedure


def test_equality_sees_every_field_of_the_tissue() -> None:
    tissue = flat_patch((10, 10, 2), 5.0)
    moved = tissue.points.copy()
    moved[3, 1] = np.nextafter(np.float32(moved[3, 1]), np.float32(100.0))
    others = {
        "points": moved,
        "face_vertex_counts": tissue.face_vertex_counts[:-1],
        "face_vertex_indices": tissue.face_vertex_indices[::-1],
        "uv": None,
        "subsets": {"bed": tissue.subsets["bed"], "fixed": tissue.subsets["fixed"]},
        "material": "fat",
        "spacing": 2.0,
        "gravity": 0.0,
        "gravity_direction": (0.0, -1.0, 0.0),
        "bed_stiffness": 1.0,
        "bed_shear": 0.5,
        "self_contact": True,
        "regions": (Region("fixed", "fat"),),
        "rollers": (Roller("fixed"),),
    }
    assert set(others) == {field.name for field in fields(Tissue)}
    assert replace(tissue) == tissue
    for name, value in others.items():
        assert replace(tissue, **{name: value}) != tissue, name


def test_values_are_rounded_to_what_usd_holds_and_cannot_be_changed() -> None:
    procedure = _small()
    assert procedure.events[0].points[0][0] == float(np.float32(-1.1))  # type: ignore[union-attr]
    with pytest.raises(ValueError, match="read-only"):
        procedure.tissue.points[0, 0] = 1.0


def test_the_stage_says_its_units_axis_time_and_default_prim(tmp_path: Path) -> None:
    write_procedure(_small(), tmp_path / "p.usda")
    stage = pxr().Usd.Stage.Open(str(tmp_path / "p.usda"))
    assert pxr().UsdGeom.GetStageMetersPerUnit(stage) == 0.001
    assert pxr().UsdGeom.GetStageUpAxis(stage) == "Z"
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (1.0, 9.0, 24.0)
    assert str(stage.GetDefaultPrim().GetPath()) == "/Procedure"


def test_regions_and_muscle_read_as_usd_has_them(tmp_path: Path) -> None:
    """What another program authors: default values, a subset order, an activation that does not move."""
    write_procedure(_layered(), tmp_path / "p.usda")
    stage = pxr().Usd.Stage.Open(str(tmp_path / "p.usda"))
    cheek = stage.GetPrimAtPath("/Procedure/Tissue/cheek")
    for name in ("depthFrom", "depthTo"):
        cheek.RemoveProperty(f"lappet:{name}")
    activation = stage.GetPrimAtPath("/Procedure/Materials/muscle").GetAttribute("lappet:muscleActivation")
    assert activation.GetTimeSamples() == [2.0, 5.0]
    assert activation.Get(3.5) == pytest.approx(0.4)
    activation.Clear()
    activation.Set(0.3)
    stage.GetRootLayer().Export(str(tmp_path / "q.usda"))
    notes: list[Problem] = []
    back = read_procedure(tmp_path / "q.usda", notes)
    assert back.tissue.regions == (Region("under", "fat", 1.0, 2.0), Region("cheek", "muscle"))
    assert back.material("muscle").muscle_activation == ((1.0, 0.3),)
    assert notes == []


def test_a_region_that_has_no_subset_or_shares_one_cannot_be_written(tmp_path: Path) -> None:
    for regions, code in [
        ((Region("nowhere", "skin"),), ProblemCode.REGION_NO_SUBSET),
        ((Region("bed", "skin"), Region("bed", "fat")), ProblemCode.REGION_SUBSET_TWICE),
    ]:
        odd = replace(_small(), tissue=replace(_small().tissue, regions=regions))
        with refuses(code, f"/Procedure/Tissue/{regions[0].faces}"):
            write_procedure(odd, tmp_path / "p.usda")


def test_usd_recognises_the_schemas_and_every_property_is_authored(tmp_path: Path) -> None:
    ends = ((0, -1.3, 2), (0, 1.3, 2))
    thread = Suture("stitch", ends, 6.0, 1.0, 50.0, "thread", "nylon 5-0", 1.5, 300.0, 900.0)
    run = SutureRun(
        "run",
        (((-2, 1, 2), (0, 1, 2), (2, 1, 2)), ((-2, -1, 2), (2, -1, 2))),
        6.0,
        corners=((2, 1),),
        margin=0.5,
        bite=0.1,
        layers=(SutureLayer("deep", 1.5), SutureLayer("skin", between=True)),
        pattern="running",
        pass_depth=1.0,
        mode="thread",
        thread="silk 4-0",
        drawn=0.8,
        tension=300.0,
        pull_through=900.0,
        insides=(((2, 2, 2), (2, -2, 2)),),
    )
    events = (*(thread if event.name == "stitch" else event for event in _layered().events), run)
    write_procedure(replace(_layered(), events=events), tmp_path / "p.usda")
    stage = pxr().Usd.Stage.Open(str(tmp_path / "p.usda"))
    registry = pxr().Usd.SchemaRegistry()
    expected = {"Tissue": "Tissue", "Timeline/cut": "Incision", "Timeline/hook": "Hook", "Timeline/pull": "Retractor"}
    expected |= {"Timeline/stitch": "Suture", "Timeline/tip": "Landmark", "Materials/skin": "Material"}
    expected |= {"Timeline/push": "Traction", "Timeline/air": "Pressure", "Timeline/across": "Section"}
    expected |= {"Timeline/run": "SutureRun"}
    expected |= {"Tissue/cheek": "Region", "Tissue/plane": "Roller"}
    unlike_0_1 = (
        "lappet:gravityDirection",
        "lappet:bedShear",
        "lappet:selfContact",
        "lappet:direction",
        "lappet:fiber:slack",
        "lappet:fiber:angle",
    )  # authored where they are not the default
    may_be_left_out = ("lappet:muscleActivation", *unlike_0_1)
    for path, kind in expected.items():
        prim = stage.GetPrimAtPath(f"/Procedure/{path}")
        schema = f"Lappet{kind}API"
        assert prim.HasAPI(schema), schema
        definition = registry.FindAppliedAPIPrimDefinition(schema)
        for name in definition.GetPropertyNames():
            assert prim.GetProperty(name).IsAuthored() or name in may_be_left_out, (path, name)
        for name in [p.GetName() for p in prim.GetAuthoredProperties() if p.GetNamespace() == "lappet"]:
            assert not prim.GetProperty(name).IsCustom(), (path, name)


def test_the_three_schema_files_agree() -> None:
    sdf = pxr().Sdf
    source = sdf.Layer.FindOrOpen(str(SCHEMA / "schema.usda"))
    generated = sdf.Layer.FindOrOpen(str(SCHEMA / "generatedSchema.usda"))
    plugin = json.loads(re.sub(r"(?m)^#.*$", "", (SCHEMA / "plugInfo.json").read_text()))["Plugins"][0]
    types = {entry["schemaIdentifier"]: (key, entry) for key, entry in plugin["Info"]["Types"].items()}
    classes = {prim.name: prim for prim in source.rootPrims if prim.name != "GLOBAL"}
    assert set(classes) == {prim.name for prim in generated.rootPrims} == set(types)
    for name, prim in classes.items():
        key, entry = types[name]
        assert key != name
        assert entry["alias"]["UsdSchemaBase"] == name
        assert entry["schemaKind"] == "singleApplyAPI"
        assert entry.get("apiSchemaCanOnlyApplyTo", []) == list(prim.customData.get("apiSchemaCanOnlyApplyTo", []))
        made = generated.GetPrimAtPath(f"/{name}")
        assert {p.name for p in made.properties} == {p.name for p in prim.properties}
        for attribute in prim.attributes:
            twin = made.attributes[attribute.name]
            assert (twin.typeName, twin.variability) == (attribute.typeName, attribute.variability)
            assert (twin.default, twin.HasDefaultValue()) == (attribute.default, attribute.HasDefaultValue())
            assert twin.allowedTokens == attribute.allowedTokens


def test_the_schema_falls_back_to_the_defaults_of_the_dataclasses() -> None:
    registry = pxr().Usd.SchemaRegistry()
    pairs = [
        ("LappetMaterialAPI", Material, {"fiber:k1": "fiber_k1", "fiber:k2": "fiber_k2"}),
        ("LappetTissueAPI", Tissue, {}),
        ("LappetRegionAPI", Region, {}),
        ("LappetIncisionAPI", Incision, {}),
        ("LappetHookAPI", Hook, {}),
        ("LappetSutureAPI", Suture, {}),
        ("LappetSutureRunAPI", SutureRun, {"layers": "-"}),
        ("LappetVesselAPI", Vessel, {}),
    ]
    compared = 0
    for schema, kind, names in pairs:
        definition = registry.FindAppliedAPIPrimDefinition(schema)
        defaults = {field.name: field.default for field in fields(kind)}
        for name in definition.GetPropertyNames():
            short = name.removeprefix("lappet:")
            field = names.get(short) or re.sub(r"[A-Z]", lambda m: "_" + m[0].lower(), short.replace(":", "_"))
            fallback = definition.GetAttributeFallbackValue(name)
            if isinstance(defaults.get(field), (float, str, tuple)) and fallback is not None:
                value = fallback if isinstance(fallback, (str, float)) else None
                if value is None:
                    value = tuple(fallback) if hasattr(fallback, "__len__") else fallback.GetValue()
                assert value == defaults[field], (schema, name)
                compared += 1
    assert compared >= 22


def test_a_stage_in_centimetres_with_y_up_is_converted_and_says_so(tmp_path: Path) -> None:
    procedure = _small()
    write_procedure(procedure, tmp_path / "mm.usda")
    stage = pxr().Usd.Stage.Open(str(tmp_path / "mm.usda"))
    geom, gf = pxr().UsdGeom, pxr().Gf
    # The same scene in cm with Y up: (x, y, z) mm stands at (x, z, -y) / 10.
    to_cm = np.array([[0.1, 0, 0, 0], [0, 0, -0.1, 0], [0, 0.1, 0, 0], [0, 0, 0, 1.0]])
    geom.SetStageMetersPerUnit(stage, 0.01)
    geom.SetStageUpAxis(stage, "Y")
    for prim in stage.Traverse():
        for name in ("points", "lappet:anchor", "lappet:anchors", "lappet:point"):
            attribute = prim.GetAttribute(name)
            if attribute and attribute.HasAuthoredValue():
                value = np.atleast_2d(np.array(attribute.Get(), np.float64)) @ to_cm[:3, :3]
                vectors = [gf.Vec3d(*row) for row in value.tolist()]
                attribute.Set(vectors[0] if name in ("lappet:anchor", "lappet:point") else vectors)
    hook = stage.GetAttributeAtPath("/Procedure/Timeline/hook.xformOp:translate")
    for time in hook.GetTimeSamples():
        hook.Set(gf.Vec3d(*(np.array(hook.Get(time)) @ to_cm[:3, :3]).tolist()), time)
    pull = stage.GetAttributeAtPath("/Procedure/Timeline/pull.xformOp:transform")
    for time in pull.GetTimeSamples():
        pull.Set(gf.Matrix4d(np.linalg.inv(to_cm) @ np.array(pull.Get(time)) @ to_cm), time)
    stage.GetRootLayer().Export(str(tmp_path / "cm.usda"))
    notes: list[Problem] = []
    back = read_procedure(tmp_path / "cm.usda", notes)
    assert [note.code for note in notes] == [ProblemCode.STAGE_CONVERTED, ProblemCode.STAGE_TURNED]
    assert {note.severity for note in notes} == {"note"}
    assert back.tissue.points == pytest.approx(procedure.tissue.points, abs=1e-5)
    for mine, other in zip(procedure.events, back.events, strict=True):
        for field in fields(mine):
            value = getattr(mine, field.name)
            if isinstance(value, tuple):
                found = _flat(getattr(other, field.name))
                assert found == pytest.approx(_flat(value), abs=1e-5), (mine.name, field.name)
            else:
                assert getattr(other, field.name) == value


def test_loads_and_rollers_on_what_is_no_face_subset_of_the_tissue_are_refused(tmp_path: Path) -> None:
    write_procedure(_layered(), tmp_path / "p.usda")
    stage = pxr().Usd.Stage.Open(str(tmp_path / "p.usda"))
    stage.GetPrimAtPath("/Procedure/Timeline/push").GetRelationship("lappet:faces").SetTargets([])
    stage.GetPrimAtPath("/Procedure/Timeline/air").GetRelationship("lappet:faces").SetTargets(["/Procedure/Materials"])
    stage.GetPrimAtPath("/Procedure/Tissue/side").GetAttribute("familyName").Set("other")
    stage.GetRootLayer().Export(str(tmp_path / "q.usda"))
    with pytest.raises(RefusedError) as refusal:
        read_procedure(tmp_path / "q.usda")
    assert {(each.prim.rpartition("/")[2], each.code) for each in refusal.value.problems} == {
        ("push", ProblemCode.LOAD_MISSING),
        ("air", ProblemCode.LOAD_ELSEWHERE),
        ("side", ProblemCode.ROLLER_NOT_A_SUBSET),
    }


def test_a_face_subset_with_a_roller_has_nothing_else(tmp_path: Path) -> None:
    for rollers, code in [
        ((Roller("nowhere"),), ProblemCode.ROLLER_FACES_UNKNOWN),
        ((Roller("cheek"),), ProblemCode.ROLLER_SUBSET_TWICE),
        ((Roller("side"), Roller("side")), ProblemCode.ROLLER_SUBSET_TWICE),
    ]:
        odd = replace(_layered(), tissue=replace(_layered().tissue, rollers=rollers))
        with refuses(code, f"/Procedure/Tissue/{rollers[0].faces}"):
            write_procedure(odd, tmp_path / "p.usda")


def test_a_moved_parent_moves_the_geometry(tmp_path: Path) -> None:
    procedure = _small()
    write_procedure(procedure, tmp_path / "p.usda")
    stage = pxr().Usd.Stage.Open(str(tmp_path / "p.usda"))
    pxr().UsdGeom.Xformable(stage.GetPrimAtPath("/Procedure")).AddTranslateOp().Set((1.0, 2.0, 3.0))
    stage.GetRootLayer().Export(str(tmp_path / "moved.usda"))
    back = read_procedure(tmp_path / "moved.usda")
    assert back.tissue.points == pytest.approx(procedure.tissue.points + np.array([1, 2, 3]), abs=1e-5)
    hook, was = back.event("hook"), procedure.event("hook")
    assert isinstance(hook, Hook)
    assert isinstance(was, Hook)
    assert hook.anchor == pytest.approx(np.add(was.anchor, [1, 2, 3]))
    assert hook.targets[1][1] == pytest.approx(np.add(was.targets[1][1], [1, 2, 3]))


def test_left_handed_faces_and_vertex_uvs_are_turned(tmp_path: Path) -> None:
    tissue = flat_patch((10, 10, 2), 5.0)
    write_procedure(Procedure(tissue), tmp_path / "p.usda")
    stage = pxr().Usd.Stage.Open(str(tmp_path / "p.usda"))
    mesh = stage.GetPrimAtPath("/Procedure/Tissue")
    mesh.GetAttribute("orientation").Set("leftHanded")
    st = pxr().UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    st.SetInterpolation("vertex")
    st.Set([pxr().Gf.Vec2f(float(x), float(y)) for x, y, _ in tissue.points])
    stage.GetRootLayer().Export(str(tmp_path / "left.usda"))
    back = read_procedure(tmp_path / "left.usda").tissue
    faces = tissue.face_vertex_indices.reshape(-1, 4)
    assert np.array_equal(back.face_vertex_indices.reshape(-1, 4), faces[:, ::-1])
    assert back.uv is not None
    assert np.array_equal(back.uv, back.points[back.face_vertex_indices, :2].astype(np.float32))


def test_a_pinned_curve_gets_its_phantom_points(tmp_path: Path) -> None:
    cut = Incision("cut", 1.0, ((-4, 0, 2), (-1, 1, 2), (1, 0, 2), (4, 0, 2)), basis="catmullRom")
    write_procedure(Procedure(flat_patch((10, 10, 2), 5.0)).with_events(cut), tmp_path / "p.usda")
    text = (tmp_path / "p.usda").read_text().replace('wrap = "nonperiodic"', 'wrap = "pinned"')
    (tmp_path / "p.usda").write_text(text)
    back = read_procedure(tmp_path / "p.usda").events[0]
    assert isinstance(back, Incision)
    assert back.points == ((-7, -1, 2), *cut.points, (7, 0, 2))


def test_a_failing_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "p.usda"
    write_procedure(_small(), path)
    before = path.read_bytes()

    def refuse(self: Path, target: Path) -> None:
        raise OSError("the disk is full")

    monkeypatch.setattr(lappet.usd.stage.Path, "replace", refuse)
    with pytest.raises(OSError, match="disk is full"):
        write_procedure(replace(_small(), end_time=77.0), path)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["p.usda"]


def test_reading_sees_what_was_written_since_the_stage_was_opened(tmp_path: Path) -> None:
    path = tmp_path / "p.usdc"
    write_procedure(_small(), path)
    held = pxr().Usd.Stage.Open(str(path))
    write_procedure(replace(_small(), end_time=33.0), path)
    assert read_procedure(path).end_time == 33.0
    assert held.GetEndTimeCode() == 33.0


@pytest.mark.parametrize("name", ["1cut", "a b", "", "cut/edge", "naïve"])
def test_a_name_that_no_prim_can_have_is_refused(tmp_path: Path, name: str) -> None:
    with refuses(ProblemCode.NAME_NOT_A_PRIM, f"/Procedure/Timeline/{name}"):
        write_procedure(_small().with_events(Landmark(name, ((0, 0, 2),), "x")), tmp_path / "p.usda")
    assert not list(tmp_path.iterdir())


def test_two_events_of_one_name_are_refused(tmp_path: Path) -> None:
    with refuses(ProblemCode.NAME_TWICE, "/Procedure/Timeline/cut"):
        write_procedure(_small().with_events(Landmark("cut", ((0, 0, 2),), "x")), tmp_path / "p.usda")


@pytest.mark.parametrize(
    ("name", "code"), [("p.obj", ProblemCode.USD_SUFFIX), ("no/such/p.usda", ProblemCode.FILE_NO_FOLDER)]
)
def test_a_path_that_cannot_be_written_is_refused(tmp_path: Path, name: str, code: ProblemCode) -> None:
    with refuses(code):
        write_procedure(_small(), tmp_path / name)


def test_without_usd_the_package_imports_and_says_how_to_install_it(tmp_path: Path) -> None:
    """A file is read by a child process, which finds no pxr either."""
    (tmp_path / "pxr.py").write_text("raise ModuleNotFoundError('no pxr here')\n", encoding="utf-8")
    write_procedure(_small(), tmp_path / "p.usda")
    code = (
        "import sys, lappet, lappet.usd.stage, lappet.checks.validation, lappet.procedure.history\n"
        "for act in (lappet.usd.stage.pxr, lambda: lappet.read_procedure(sys.argv[1])):\n"
        "    try: act()\n"
        "    except (ModuleNotFoundError, lappet.RefusedError) as error: print(error)\n"
    )
    paths = [str(tmp_path), str(Path(lappet.usd.stage.__file__).parents[2]), *sys.path]
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "p.usda")],
        capture_output=True,
        text=True,
        check=True,
        env={"PYTHONPATH": ":".join(paths)},
    )
    assert done.stdout.count("pip install usd-core") == 2, done.stdout + done.stderr
