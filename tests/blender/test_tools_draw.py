"""Drawing as a state machine, free-hand strokes, icons, the toolbar, and the tools' operators run from Python."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree

import lappet_blender
from lappet.core.problem_code import ProblemCode
from lappet.geometry.curve import sample_curve
from lappet_blender.events import registration as timeline_registration
from lappet_blender.events.run_preview import stitches_of
from lappet_blender.tools import registration, toolbar
from lappet_blender.tools import shown_surface as shown
from lappet_blender.tools.click_tool import next_label
from lappet_blender.tools.drawing import LineDrawing
from lappet_blender.tools.face_patch import faces_around
from lappet_blender.tools.icon_file import MAGIC, Icon, write_icon
from lappet_blender.tools.icon_shapes import ICONS, draw_icon, icon_path
from lappet_blender.tools.stroke_fit import fit_stroke, simplify, with_ends
from refusals import refusal_code
from tool_scenes import flat_tissue, stand_in_display

Point = tuple[float, float, float]


def read_icon(path: Path) -> Icon:
    """Reads an icon. Raises ValueError for a file that is none."""
    data = path.read_bytes()
    count, rest = divmod(len(data) - 8, 18)
    if data[:4] != MAGIC or rest:
        raise ValueError(f"{path} is no icon of Blender: {len(data)} bytes that begin with {data[:4]!r}.")
    corners = np.frombuffer(data, np.uint8, 6 * count, 8).reshape(-1, 3, 2)
    return Icon(corners, np.frombuffer(data, np.uint8, 12 * count, 8 + 6 * count).reshape(-1, 3, 4))


@pytest.fixture(autouse=True)
def _display(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    stand_in_display(monkeypatch)
    shown.clear_cache()
    yield
    shown.clear_cache()


def click(drawing: LineDrawing, *points: Point) -> None:
    for point in points:
        drawing.press(point, (10 * point[0], 10 * point[1]))
        drawing.release()


def drag(drawing: LineDrawing, points: np.ndarray) -> None:
    places = [(float(x), float(y), float(z)) for x, y, z in points]
    drawing.press(places[0], 10 * points[0, :2])
    for place in places[1:]:
        drawing.move(place, (10 * place[0], 10 * place[1]))
    drawing.release()


def farthest(points: np.ndarray, line: np.ndarray) -> float:
    """The greatest distance of points from a densely sampled line."""
    return float(cKDTree(line).query(points)[0].max())


def test_clicks_make_a_straight_line_through_the_points() -> None:
    drawing = LineDrawing()
    click(drawing, (0, 0, 0), (5, 0, 0), (5, 5, 1))
    drawing.move((9, 9, 9), (90, 90))
    assert drawing.preview().points[-1] == (9, 9, 9)  # the mouse shows where the line would go
    line = drawing.finish()
    assert line is not None
    assert (line.points, line.basis, line.closed) == (((0, 0, 0), (5, 0, 0), (5, 5, 1)), "LINEAR", False)


def test_a_press_off_the_skin_adds_nothing() -> None:
    drawing = LineDrawing()
    assert not drawing.press(None, (0, 0))
    drawing.release()
    assert drawing.points == []
    click(drawing, (1, 0, 0))
    assert drawing.finish() is None
    assert drawing.problem() == "The line has 1 point; click at least 2 on the skin."


def test_a_second_click_on_the_same_point_adds_none() -> None:
    drawing = LineDrawing()
    click(drawing, (0, 0, 0), (4, 0, 0), (4, 0, 0))
    assert len(drawing.points) == 2


def test_a_smooth_line_begins_and_ends_at_the_first_and_last_click() -> None:
    drawing = LineDrawing(smooth=True)
    click(drawing, (0, 0, 0), (5, 3, 0), (10, 0, 0))
    line = drawing.finish()
    assert line is not None
    assert line.basis == "CATMULL_ROM"
    curve = sample_curve(line.points, "catmullRom", step=0.05)
    assert np.allclose(curve[[0, -1]], [(0, 0, 0), (10, 0, 0)], atol=1e-9)
    assert np.linalg.norm(curve - (5, 3, 0), axis=1).min() < 0.05  # through the one between, too


def test_a_closed_line_needs_three_points_and_does_not_repeat_the_first() -> None:
    drawing = LineDrawing(smooth=True)
    click(drawing, (0, 0, 0), (5, 0, 0))
    assert not drawing.close()
    click(drawing, (5, 5, 0), (0, 0, 0))
    assert drawing.close()
    line = drawing.finish()
    assert line is not None
    assert line.closed
    assert line.points == ((0, 0, 0), (5, 0, 0), (5, 5, 0))


def test_an_outline_is_closed_whether_one_says_so_or_not() -> None:
    drawing = LineDrawing(must_close=True)
    click(drawing, (0, 0, 0), (5, 0, 0))
    assert drawing.finish() is None
    click(drawing, (5, 5, 0))
    line = drawing.finish()
    assert line is not None
    assert line.closed


def test_a_step_back_takes_the_last_click_or_the_whole_stroke() -> None:
    drawing = LineDrawing()
    click(drawing, (0, 0, 0), (2, 0, 0))
    t = np.linspace(0, 3, 40)
    drag(drawing, np.stack([2 + t, np.sin(2 * t), 0 * t], axis=1))
    assert drawing.smooth
    assert drawing.back()
    assert drawing.points == [(0, 0, 0), (2, 0, 0)]
    assert not drawing.smooth
    assert drawing.back()
    assert drawing.back()
    assert not drawing.back()


def test_a_small_tremble_of_the_hand_is_still_a_click() -> None:
    drawing = LineDrawing()
    drawing.press((1, 1, 0), (10, 10))
    drawing.move((1.3, 1.2, 0), (13, 12))
    drawing.release()
    assert drawing.points == [(1, 1, 0)]
    assert not drawing.smooth


def test_a_stroke_that_leaves_the_skin_goes_on_where_it_returns() -> None:
    drawing = LineDrawing(tolerance=0.1)
    drawing.press((0, 0, 0), (0, 0))
    for x in (1.0, 2.0, None, None, 5.0, 6.0):
        drawing.move(None if x is None else (x, 0, 0), (10 * (x or 3), 0))
    drawing.release()
    assert drawing.points[0] == (0, 0, 0)
    assert drawing.points[-1] == (6, 0, 0)


def test_simplifying_keeps_every_point_within_the_tolerance() -> None:
    t = np.linspace(0, 4 * np.pi, 400)
    line = np.stack([t, np.sin(t), 0.2 * np.cos(3 * t)], axis=1)
    kept = simplify(line, 0.05)
    assert kept[0] == 0
    assert kept[-1] == 399
    assert len(kept) < 80
    dense = sample_curve(line[kept], step=0.002)
    assert farthest(line, dense) <= 0.05 + 0.002
    assert simplify(line[:2], 0.05) == [0, 1]
    assert len(simplify(np.stack([t, 2 * t, 0 * t], axis=1), 1e-6)) == 2


@pytest.mark.parametrize("seed", range(5))
def test_a_free_hand_stroke_becomes_a_smooth_curve_within_the_tolerance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.005, 0.12, 220))  # a hand that is now fast, now slow
    stroke = np.stack([6 * np.sin(0.7 * t), 5 * np.cos(0.4 * t) + 0.3 * t, 0.5 * np.sin(t)], axis=1)
    stroke += rng.normal(scale=0.02, size=stroke.shape)
    points = fit_stroke(stroke, 0.4)
    assert len(points) < 0.25 * len(stroke)
    curve = sample_curve(with_ends(points), "catmullRom", step=0.01)
    assert farthest(stroke, curve) <= 0.4 + 0.01
    assert farthest(curve, sample_curve(stroke, step=0.01)) <= 0.4 + 0.01
    assert np.allclose(points[[0, -1]], stroke[[0, -1]])


def test_the_icons_that_ship_are_those_that_the_shapes_draw(tmp_path: Path) -> None:
    shipped = {path.name for path in Path(icon_path("edit")).parent.glob("*.dat")}
    assert shipped == {f"lappet.{name}.dat" for name in ICONS}
    for name in ICONS:
        icon = read_icon(Path(icon_path(name) + ".dat"))
        write_icon(tmp_path / "icon.dat", draw_icon(name))
        assert (tmp_path / "icon.dat").read_bytes() == Path(icon_path(name) + ".dat").read_bytes()
        a, b, c = np.moveaxis(icon.corners.astype(int), 1, 0)
        turn = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
        assert (turn >= 0).all()
        assert 0.05 < 0.5 * turn.sum() / 255**2 < 0.8  # neither empty nor a blot
        assert bpy.app.icons.new_triangles_from_file(icon_path(name) + ".dat") > 0  # Blender's own reader takes it


def test_blenders_own_icons_are_read_and_other_files_are_not(tmp_path: Path) -> None:
    folder = Path(bpy.utils.system_resource("DATAFILES", path="icons"))
    icon = read_icon(folder / "ops.generic.select.dat")
    assert icon.corners.shape == (len(icon.colors), 3, 2)
    (tmp_path / "no.dat").write_bytes(b"VCO\x00" + bytes(20))
    with pytest.raises(ValueError, match="is no icon of Blender: 24 bytes"):
        read_icon(tmp_path / "no.dat")


def tools_in_toolbar() -> list[str]:
    from bl_ui.space_toolsystem_common import ToolSelectPanelHelper as Helper

    tools = Helper._tool_class_from_space_type("VIEW_3D")._tools["OBJECT"]
    return [tool.idname for tool in Helper._tools_flatten(tools) if tool is not None]


def test_the_tools_come_and_go_with_the_add_on_and_leave_nothing_behind(scene: bpy.types.Scene) -> None:
    mine = [tool.bl_idname for tool in toolbar.TOOLS]
    assert tools_in_toolbar()[-len(mine) :] == mine
    lappet_blender.unregister()
    try:
        before = tools_in_toolbar()
        handlers = len(bpy.app.handlers.load_pre)
        assert not set(mine) & set(before)
        assert not hasattr(bpy.types, "LAPPET_OT_draw_incision")
        for _ in range(2):
            lappet_blender.register()
            assert tools_in_toolbar() == [*before, *mine]
            lappet_blender.unregister()
            assert tools_in_toolbar() == before
            assert len(bpy.app.handlers.load_pre) == handlers
            assert not hasattr(bpy.types, "VIEW3D_MT_lappet")
    finally:
        lappet_blender.register()


def test_every_text_is_given_when_a_tool_is_put_down_since_blender_crashes_on_one_that_is_left_out() -> None:
    parameters = bpy.types.WorkSpaceTool.bl_rna.functions["setup"].parameters
    texts = {each.identifier for each in parameters if each.type == "STRING"}
    assert texts == {"idname", "keymap", *toolbar.TEXTS_OF_SETUP}


def test_a_part_that_cannot_be_taken_away_does_not_keep_the_others(
    scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail() -> None:
        raise RuntimeError("the timeline is busy")

    with monkeypatch.context() as patched:
        patched.setattr(timeline_registration, "unregister", fail)
        with pytest.raises(RuntimeError, match="busy"):
            lappet_blender.unregister()
    try:
        assert not hasattr(bpy.types, "LAPPET_OT_draw_incision")
        assert not hasattr(bpy.types, "LAPPET_OT_incision_add")
        assert not hasattr(bpy.types.Scene, "lappet")
    finally:
        timeline_registration.unregister()
        lappet_blender.register()


def test_every_tool_starts_operators_that_exist_and_says_what_it_does() -> None:
    names = {cls.bl_idname for cls in registration.CLASSES if hasattr(cls, "bl_idname")}
    for tool in toolbar.TOOLS:
        assert Path(tool.bl_icon + ".dat").is_file()
        assert len(tool.bl_description) > 20
        for operator, keys, _ in tool.bl_keymap[0].keymap_data if callable(tool.bl_keymap[0]) else tool.bl_keymap:
            assert operator in names
            assert keys["value"] in ("PRESS", "DOUBLE_CLICK", "CLICK")


def points(*places: Point) -> list[dict[str, object]]:
    return [{"name": "", "co": place} for place in places]


def test_every_tool_runs_from_python_and_is_one_event_of_the_timeline(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    scene.frame_set(7)
    ops, events = bpy.ops.lappet, scene.lappet.events
    assert ops.draw_incision(points=points((-8, 0, 0), (8, 0, 0)), through=False, depth=1.5, kerf=0.1) == {"FINISHED"}
    cut = events[-1]
    assert (cut.kind, cut.start, cut.through) == ("INCISION", 7.0, False)
    name = cut.name
    assert (round(cut.depth, 4), round(cut.kerf, 4), len(cut.points)) == (1.5, 0.1, 2)
    ops.draw_undermining(points=points((-5, 1, 0), (5, 1, 0), (0, 9, 0)), time=9.0)
    assert (events[-1].kind, events[-1].start) == ("UNDERMINE", 9.0)
    ops.draw_thinning(points=points((-5, 1, 0), (5, 1, 0), (0, 9, 0)), time=10.0, thickness=1.5)
    assert (events[-1].kind, events[-1].start, round(events[-1].thickness, 4)) == ("THIN", 10.0, 1.5)
    ops.place_hook(anchor=(0, 2, 0), begins=(0, 2, 0.5), target=(0, 12, 8), frames=6, stiffness=250.0)
    hook = events[-1]
    assert (hook.kind, hook.start, hook.stiffness) == ("HOOK", 7.0, 250.0)
    for frame, place in ((7, (0, 2, 0.5)), (10, (0, 7, 4.25)), (13, (0, 12, 8)), (20, (0, 12, 8))):
        scene.frame_set(frame)
        assert np.allclose(hook.target.matrix_world.translation, place, atol=1e-4)
    scene.frame_set(7)
    ops.place_suture(first=points((2, 0.3, 0)), second=points((2, -0.3, 0)), duration=4.0)
    assert (events[-1].kind, events[-1].duration) == ("SUTURE", 4.0)
    before = len(events)
    ops.place_suture(incision=name, spacing=4.0)
    assert [event.kind for event in events[before:]] == ["SUTURE_RUN"]
    assert len(stitches_of(scene, events[-1])) == 4  # 16 mm, one in 4 mm
    before = len(events)
    edges = {"first": points((-8, 0.5, 0), (8, 0.5, 0)), "second": points((8, -0.5, 0), (-8, -0.5, 0))}
    ops.place_suture(**edges, count=3)  # the second edge was clicked the other way round
    assert len(events) == before + 1
    run = [stitch.anchors for stitch in stitches_of(scene, events[-1])]
    assert len(run) == 3
    assert all(abs(a[0] - b[0]) < 1e-3 for a, b in run)
    ops.place_suture(**edges, count=3, single=True)
    assert [event.kind for event in events[-3:]] == ["SUTURE"] * 3
    ops.place_landmark(point=(4, 4, 0))
    ops.place_landmark(point=(6, 4, 0))
    assert [event.label for event in events[-2:]] == ["A", "B"]
    ops.click_excision(point=(4, 4, 0), time=12.0)
    assert (events[-1].kind, events[-1].start) == ("EXCISION", 12.0)


@pytest.mark.parametrize(
    ("shape", "bites"),
    [
        ("SIMPLE", 5),
        ("VERTICAL_MATTRESS", 9),
        ("HORIZONTAL_MATTRESS", 9),
        ("HALF_BURIED", 7),
        ("DEEP_DERMAL", 5),
        ("FIGURE_OF_EIGHT", 9),
    ],
)
def test_a_suture_gets_the_bites_of_its_shape(scene: bpy.types.Scene, shape: str, bites: int) -> None:
    flat_tissue(scene)
    bpy.ops.lappet.place_suture(
        first=points((2, 0.5, 0)), second=points((2, -0.5, 0)), shape=shape, bite=3.0, depth=1.5, drawn=0.8
    )
    event = scene.lappet.events[-1]
    places = np.array([point.co for point in event.points])
    assert (event.mode, len(places)) == ("THREAD", bites)
    assert np.allclose(places[0], places[-1])
    assert np.isclose(np.abs(places[:, 1]), 3.5, atol=1e-5).sum() >= 4
    assert places[:, 2].min() == pytest.approx(-1.5, abs=1e-5)
    closed = places - 0.5 * np.sign(places) * (0.0, 1.0, 0.0)
    length = np.linalg.norm(np.diff(closed, axis=0), axis=1).sum()
    assert event.length == pytest.approx(0.8 * length, rel=1e-5)


def test_a_running_suture_is_one_thread_through_all_places_of_a_run(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    before = len(scene.lappet.events)
    edges = {"first": points((-8, 0.5, 0), (8, 0.5, 0)), "second": points((8, -0.5, 0), (-8, -0.5, 0))}
    bpy.ops.lappet.place_suture(**edges, count=3, shape="RUNNING")
    assert len(scene.lappet.events) == before + 1
    (thread,) = stitches_of(scene, scene.lappet.events[-1])
    places = np.array(thread.anchors)
    assert len(places) == 3 * 4
    assert np.allclose(np.abs(places[:, 1]), 4.5, atol=1e-3)
    assert (np.diff(places[::4, 0]) > 4.0).all()


def test_a_retractor_grips_the_faces_around_the_point(scene: bpy.types.Scene) -> None:
    tissue = flat_tissue(scene)
    bpy.ops.lappet.place_retractor(at=(5, 5, 0), way=(0, 0, 6), radius=2.2, frames=5)
    event = scene.lappet.events[-1]
    assert (event.kind, event.grip) == ("RETRACTOR", "grip_1")
    held = np.zeros(len(tissue.data.polygons), bool)
    tissue.data.attributes["lappet_grip_1"].data.foreach_get("value", held)
    centers = np.array([polygon.center for polygon in tissue.data.polygons])[held]
    assert 8 <= held.sum() <= 24
    assert np.linalg.norm(centers - (5, 5, 0), axis=1).max() < 2.6
    scene.frame_set(scene.frame_current + 5)
    assert event.target.matrix_world.translation.z > 5.9
    bpy.ops.lappet.place_retractor(at=(-5, 5, 0), way=(0, 0, 6))
    assert scene.lappet.events[-1].grip == "grip_2"


def test_what_cannot_be_done_is_refused_and_changes_nothing(scene: bpy.types.Scene) -> None:
    draw = bpy.ops.lappet.draw_incision
    assert refusal_code(lambda: draw(points=points((0, 0, 0), (1, 0, 0)))) is ProblemCode.TISSUE_NONE
    flat_tissue(scene)
    assert refusal_code(lambda: draw(points=points((0, 0, 0)))) is ProblemCode.CURVE_TOO_SHORT
    assert refusal_code(bpy.ops.lappet.place_suture) is ProblemCode.SUTURE_NO_EDGES
    # Without a window there is nothing to click on.
    assert refusal_code(lambda: draw("INVOKE_DEFAULT")) is ProblemCode.EVENT_NO_POINT
    assert len(scene.lappet.events) == 0


def test_one_step_of_undo_takes_a_drawn_incision_back(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    bpy.ops.ed.undo_push(message="tissue")
    bpy.ops.lappet.draw_incision("EXEC_DEFAULT", True, points=points((-8, 0, 0), (8, 0, 0)))
    bpy.ops.lappet.place_hook("EXEC_DEFAULT", True, anchor=(0, 2, 0), target=(0, 12, 8))
    assert [event.kind for event in bpy.context.scene.lappet.events] == ["INCISION", "HOOK"]
    bpy.ops.ed.undo()
    assert [event.kind for event in bpy.context.scene.lappet.events] == ["INCISION"]
    bpy.ops.ed.undo()
    assert len(bpy.context.scene.lappet.events) == 0
    bpy.ops.ed.redo()
    assert [event.kind for event in bpy.context.scene.lappet.events] == ["INCISION"]


def test_moving_and_removing_the_end_of_a_smooth_line_keeps_its_end_doubled(scene: bpy.types.Scene) -> None:
    from lappet_blender.tools.edit_tool import HeldHandle
    from lappet_blender.tools.handles import event_points, indices_at
    from lappet_blender.tools.point_edit import insert_nearest, move_points

    flat_tissue(scene)
    line = with_ends([(-8, 0, 0), (-2, 3, 0), (2, -3, 0), (8, 0, 0)])
    bpy.ops.lappet.draw_incision(points=points(*map(tuple, line.tolist())), basis="CATMULL_ROM")
    event = scene.lappet.events[-1]
    assert indices_at(event, 0) == [0, 1]
    move_points(event, 0, (-9, 1, 0))
    assert np.allclose(event_points(event)[:3], [(-9, 1, 0), (-9, 1, 0), (-2, 3, 0)])
    assert insert_nearest(event, (5, -1.5, 0)) == 4
    assert np.allclose(event_points(event)[3:6], [(2, -3, 0), (5, -1.5, 0), (8, 0, 0)])
    HeldHandle.hold(event.uid, 0)
    bpy.ops.lappet.edit_delete()
    assert np.allclose(event_points(event)[:3], [(-2, 3, 0), (-2, 3, 0), (2, -3, 0)])
    HeldHandle.hold(event.uid, 2)
    bpy.ops.lappet.edit_delete()
    HeldHandle.hold(event.uid, 2)
    bpy.ops.lappet.edit_delete()
    assert np.allclose(event_points(event), [(-2, 3, 0), (-2, 3, 0), (8, 0, 0), (8, 0, 0)])
    HeldHandle.hold(event.uid, 0)
    bpy.ops.lappet.edit_delete()  # two points are the least: the event goes
    assert len(scene.lappet.events) == 0


def test_faces_around_a_point_are_at_least_the_nearest(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    surface = shown.shown_surface(scene)
    assert surface is not None
    (face,) = faces_around(surface.rest, (0.4, 0.4, 0), 1e-3)
    assert np.allclose(scene.lappet.tissue.object.data.polygons[face].center, (0.5, 0.5, 0), atol=1e-4)


def test_landmarks_are_lettered(scene: bpy.types.Scene) -> None:
    for label in ("A", "C"):
        event = scene.lappet.events.add()
        event.kind, event.label = "LANDMARK", label
    assert next_label(scene) == "B"
