"""Add > Lappet > Flap: a design of the library becomes events of the scene in one step of undo."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from event_patch import co, patch_scene
from lappet.core.problem_code import ProblemCode
from lappet.designs.flap_plan import flap_plan
from lappet.designs.library import DESIGNS
from lappet.procedure import Excision, Hook, Incision, Landmark, SutureRun, Undermine
from lappet_blender.events.flap_operators import OPERATORS, VIEW3D_PT_lappet_flaps
from lappet_blender.events.flap_thumbnails import SIZE
from lappet_blender.events.flap_thumbnails import drawn as picture_of
from lappet_blender.model.event_values import event_value
from lappet_blender.model.scene_procedure import read_scene
from refusals import refusal_code

TOP = 4.0
ops = bpy.ops.lappet


@pytest.fixture
def patch(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A scene in mm with a patch of 140 x 120 x 4 mm, the 3D cursor on it."""
    patch_scene(scene, (140.0, 120.0, TOP), 40)
    scene.cursor.location = (0.0, 0.0, TOP)
    bpy.ops.ed.undo_push(message="the patch")
    return scene


def events(scene: bpy.types.Scene) -> list:
    return [event_value(scene, each) for each in scene.lappet.events]


def test_there_is_an_operator_for_every_design() -> None:
    assert [each.design.name for each in OPERATORS] == list(DESIGNS)


ON_THEIR_BED = ("upper-lid", "island-v-y", "keystone", "keystone-ii", "keystone-iii")  # nothing is undermined


@pytest.mark.parametrize("name", DESIGNS)
def test_a_design_adds_its_operation_without_a_problem(patch: bpy.types.Scene, name: str) -> None:
    assert getattr(ops, f"flap_{name.replace('-', '_')}")(time=1) == {"FINISHED"}
    found = {type(event) for event in events(patch)}
    assert {Incision, SutureRun, Landmark} <= found
    assert (Undermine in found) == (name not in ON_THEIR_BED)
    procedure = read_scene(patch).procedure
    assert procedure is not None
    assert len(procedure.events) == len(patch.lappet.events)


def test_a_flap_on_a_narrow_base_is_added_with_a_warning(patch: bpy.types.Scene, capfd: pytest.CaptureFixture) -> None:
    """`bpy.ops` prints what an operator reports."""
    assert ops.flap_u_plasty(width=12.0, length=4.0, lines="X", time=1) == {"FINISHED"}
    assert "more than 3:1" in capfd.readouterr().out
    assert len(patch.lappet.events)


def test_a_limberg_lies_at_the_cursor_with_the_measures_given(patch: bpy.types.Scene) -> None:
    patch.cursor.location = (-20.0, 10.0, TOP)
    assert ops.flap_limberg(side=10.0, lines="X", time=1) == {"FINISHED"}
    found = {event.name: event for event in events(patch)}
    excision = found["excision"]
    assert isinstance(excision, Excision)
    assert excision.seeds[0] == pytest.approx((-20.0, 10.0, TOP), abs=1e-3)
    assert max(x for x, _, _ in found["limbs"].points) == pytest.approx(-20.0 + 15.0, abs=0.01)
    assert isinstance(found["hook_tip"], Hook)


def test_it_is_one_step_of_undo_and_the_timeline_grows_to_hold_it(patch: bpy.types.Scene) -> None:
    patch.frame_end = 10
    bpy.ops.ed.undo_push(message="short")
    assert ops.flap_z_plasty("EXEC_DEFAULT", True, time=3) == {"FINISHED"}
    scene = bpy.context.scene
    assert scene.frame_end == 42
    assert len(scene.lappet.events) > 10
    bpy.ops.ed.undo()
    assert len(bpy.context.scene.lappet.events) == 0
    assert bpy.context.scene.frame_end == 10


def test_a_design_larger_than_the_skin_is_refused_and_changes_nothing(patch: bpy.types.Scene) -> None:
    patch.frame_end = 10
    code = refusal_code(lambda: ops.flap_limberg(side=60.0, at=(50.0, 0.0, TOP), lines="X"))
    assert code == ProblemCode.DESIGN_OFF_SKIN
    assert len(patch.lappet.events) == 0
    assert patch.frame_end == 10


def test_without_tissue_there_is_nothing_to_draw_on(scene: bpy.types.Scene) -> None:
    assert refusal_code(lambda: ops.flap_limberg()) == ProblemCode.TISSUE_NONE


class Grid:
    """A layout that writes down the pictures and buttons of the library."""

    def __init__(self, drawn: list) -> None:
        self.__dict__["drawn"] = drawn

    def __setattr__(self, name: str, value: object) -> None:
        assert name in bpy.types.UILayout.bl_rna.properties, name

    def grid_flow(self, **how: object) -> Grid:
        assert set(how) <= set(bpy.types.UILayout.bl_rna.functions["grid_flow"].parameters.keys())
        return self

    def column(self, **_: object) -> Grid:
        return self

    def label(self, text: str) -> None:
        assert text

    def template_icon(self, icon_value: int, scale: float) -> None:
        self.drawn.append(icon_value)

    def operator(self, name: str, text: str = "", icon: str = "") -> None:
        assert name.startswith("lappet.flap_")
        if text:
            self.drawn.append(text)


def test_the_library_shows_every_design_by_a_picture_of_its_plan_and_its_name() -> None:
    drawn: list = []
    VIEW3D_PT_lappet_flaps.draw(SimpleNamespace(layout=Grid(drawn)), None)
    assert drawn[1::2] == [design.title for design in DESIGNS.values()]
    assert all(isinstance(each, int) for each in drawn[::2])


@pytest.mark.parametrize("name", DESIGNS)
def test_a_picture_shows_the_cuts_within_its_frame_and_what_is_excised(name: str) -> None:
    plan = flap_plan(DESIGNS[name])
    pixels = picture_of(plan)
    assert pixels.shape == (SIZE, SIZE, 4)
    clear = pixels[:, :, 3] == 0.0
    assert all(edge.all() for edge in (clear[:4], clear[-4:], clear[:, :4], clear[:, -4:]))
    assert 0.01 < np.mean(pixels[:, :, 0] > 0.8) < 0.5
    low, high = plan.bounds
    scale = (SIZE - 18.0) / float((high - low).max())
    row = DESIGNS[name]
    drawn = row.draw(np.zeros(3), (1.0, 0.0, 0.0), **row.values({}))
    assert len(plan.outlines) == len(drawn.excised)
    for cut in drawn.excised:  # the seed lies in what is excised, also where that is bent, as a crescent
        middle = np.array(cut.seed[:2]) * scale + 0.5 * SIZE - 0.5 * scale * (low + high)
        assert pixels[int(middle[1]), int(middle[0]), 3] > 0.5


@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.usefixtures("scene")
def test_presets_of_ones_own_keep_the_measures_of_a_flap_and_not_where_which_way_and_when_it_is(name: str) -> None:
    """A preset that set the place would lay every later flap at the scene's origin."""
    fields = getattr(ops, f"flap_{name.replace('-', '_')}").get_rna_type().properties
    kept = {each.identifier for each in fields if not each.is_skip_preset}
    assert kept - {"rna_type"} == {"mirrored", *(each.name for each in DESIGNS[name].parameters)}
    assert all("PRESET" in each.bl_options for each in OPERATORS)


def test_a_flap_takes_the_place_and_the_size_of_the_outline_that_is_active(patch: bpy.types.Scene) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    ring = [(-10.0 + 6.0 * np.cos(a), 5.0 + 6.0 * np.sin(a), TOP) for a in angle]
    ops.incision_add(points=co(ring), time=1, closed=True, name="lesion")
    assert ops.flap_limberg(fit=True, lines="X", time=1) == {"FINISHED"}
    found = {event.name: event for event in events(patch)}
    assert "lesion" not in found
    excision = found["excision"]
    assert isinstance(excision, Excision)
    assert excision.seeds[0] == pytest.approx((-10.0, 5.0, TOP), abs=0.1)
    outline = np.array(found["defect"].points)
    side = 2.0 * 6.0 / np.sin(np.radians(60.0))  # of a rhombus of 60 degrees around the circle
    assert np.ptp(outline[:, 1]) == pytest.approx(side * np.sqrt(3.0), rel=0.01)


def test_a_flap_without_an_active_outline_is_refused_and_nothing_changes(patch: bpy.types.Scene) -> None:
    ops.landmark_add(point=(5, 5, TOP), label="here")
    assert refusal_code(lambda: ops.flap_limberg(fit=True, time=1)) == ProblemCode.DESIGN_DEFECT_UNKNOWN
    assert len(patch.lappet.events) == 1


def faces_near(scene: bpy.types.Scene, reach: float, z: float = TOP) -> np.ndarray:
    """The faces of the patch around (-10, 5) at a height."""
    mesh = scene.lappet.tissue.object.data
    centers = np.array([tuple(face.center) for face in mesh.polygons])
    return (np.linalg.norm(centers[:, :2] - (-10.0, 5.0), axis=1) < reach) & (np.abs(centers[:, 2] - z) < 0.1)


def test_a_flap_lies_where_faces_are_selected_as_large_as_these(patch: bpy.types.Scene) -> None:
    obj = patch.lappet.tissue.object
    chosen = faces_near(patch, 9.0)
    below = faces_near(patch, 9.0, 0.0)  # what is selected through the mesh
    obj.data.polygons.foreach_set("select", chosen | below)
    corners = np.array(
        [tuple(obj.data.vertices[k].co) for f in np.flatnonzero(chosen) for k in obj.data.polygons[f].vertices]
    )
    assert ops.flap_u_plasty(selection=True, lines="X", time=1) == {"FINISHED"}
    outline = np.array({event.name: event for event in events(patch)}["defect"].points)
    low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    assert (outline[:, :2].min(axis=0) <= low + 0.05).all()
    assert (outline[:, :2].max(axis=0) >= high - 0.05).all()
    assert np.ptp(outline[:, 1]) == pytest.approx((high - low).max(), rel=0.02)


@pytest.mark.parametrize("how", ["vertex group", "attribute"])
def test_a_flap_lies_where_a_region_of_the_mesh_is_painted(patch: bpy.types.Scene, how: str) -> None:
    obj = patch.lappet.tissue.object
    chosen = np.flatnonzero(faces_near(patch, 9.0))
    if how == "vertex group":
        group = obj.vertex_groups.new(name="lesion")
        group.add(sorted({k for f in chosen for k in obj.data.polygons[f].vertices}), 1.0, "REPLACE")
    else:
        values = np.zeros(len(obj.data.polygons), np.int32)
        values[chosen] = 3
        obj.data.attributes.new("lesion", "INT", "FACE").data.foreach_set("value", values)
    assert ops.flap_o_z(region="lesion", lines="X", time=1) == {"FINISHED"}
    excision = next(event for event in events(patch) if isinstance(event, Excision))
    assert np.linalg.norm(np.array(excision.seeds[0]) - (-10.0, 5.0, TOP)) < 3.0


def test_a_mark_that_is_none_or_in_pieces_is_refused_and_nothing_changes(patch: bpy.types.Scene) -> None:
    polygons = patch.lappet.tissue.object.data.polygons
    polygons.foreach_set("select", np.zeros(len(polygons), bool))
    assert refusal_code(lambda: ops.flap_limberg(selection=True)) == ProblemCode.FACES_NONE
    polygons.foreach_set("select", faces_near(patch, 9.0, 0.0))
    assert refusal_code(lambda: ops.flap_limberg(selection=True)) == ProblemCode.DESIGN_DEFECT_UNMARKED
    assert refusal_code(lambda: ops.flap_limberg(region="lesion")) == ProblemCode.DESIGN_REGION_UNKNOWN
    assert len(patch.lappet.events) == 0


def test_a_cursor_that_is_not_on_the_skin_is_refused(patch: bpy.types.Scene) -> None:
    patch.cursor.location = (0.0, 0.0, 60.0)
    assert refusal_code(lambda: ops.flap_limberg(side=10.0, lines="X", time=1)) == ProblemCode.DESIGN_PLACE_OFF
    assert refusal_code(lambda: ops.flap_s_excision(at=(0, 0, TOP), length=15.4, width=10.0, swing=22.5, time=1)) == (
        ProblemCode.DESIGN_CROSSES
    )
    assert len(patch.lappet.events) == 0


def test_plans_of_all_designs_are_assets_with_a_picture_and_a_catalog(scene: bpy.types.Scene, tmp_path: Path) -> None:
    scene.unit_settings.scale_length = 0.001
    assert ops.flap_assets(directory=str(tmp_path)) == {"FINISHED"}
    assert bpy.context.preferences.filepaths.asset_libraries["Lappet Flaps"].path == str(tmp_path)
    with bpy.data.libraries.load(str(tmp_path / "flaps.blend"), assets_only=True) as (there, wanted):
        assert sorted(there.objects) == sorted(design.title for design in DESIGNS.values())
        wanted.objects = ["Limberg flap"]
    (plan,) = wanted.objects
    catalog = (tmp_path / "blender_assets.cats.txt").read_text(encoding="utf-8")
    assert f"{plan.asset_data.catalog_id}:Lappet/Flaps:" in catalog
    pixels = np.array(plan.preview.image_pixels_float).reshape(SIZE, SIZE, 4)
    assert (pixels[..., 3] == 1.0).all()
    assert np.ptp(pixels[..., 1]) > 0.3
    corners = np.array([tuple(point.co[:2]) for point in plan.data.splines[0].points])
    assert np.ptp(corners[:, 1]) == pytest.approx(18.0 * np.sqrt(3.0), rel=1e-4)  # mm: of a rhombus of 60 degrees


def test_a_plan_that_was_dragged_onto_the_skin_becomes_the_flap_that_it_shows(
    patch: bpy.types.Scene, tmp_path: Path
) -> None:
    assert ops.flap_assets(directory=str(tmp_path)) == {"FINISHED"}
    with bpy.data.libraries.load(str(tmp_path / "flaps.blend")) as (_, wanted):
        wanted.objects = ["Limberg flap"]
    (plan,) = wanted.objects
    patch.collection.objects.link(plan)
    bpy.context.view_layer.objects.active = plan
    plan.location, plan.rotation_euler, plan.scale = (-15.0, 5.0, TOP), (0.0, 0.0, np.pi / 2), (0.5, 0.5, 0.5)
    assert ops.flap_from_plan() == {"FINISHED"}
    procedure = read_scene(patch).procedure
    assert procedure is not None
    (laid,) = procedure.flaps
    assert (laid.design, dict(laid.measures), laid.mirrored) == ("limberg", {"side": 9.0}, False)
    assert laid.at == pytest.approx((-15.0, 5.0, TOP))
    assert laid.direction == pytest.approx((0.0, 1.0, 0.0), abs=1e-5)  # along the object's x axis
    assert "Limberg flap" not in patch.objects
    assert not ops.flap_from_plan.poll()
