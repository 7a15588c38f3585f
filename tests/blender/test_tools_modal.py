"""How the running tools answer events, without a window: what they take, what they let through, how they end."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from lappet.core.problem_code import ProblemCode
from lappet_blender.interface.operator_base import last_refusal
from lappet_blender.tools import shown_surface as shown
from lappet_blender.tools import skin_modal
from lappet_blender.tools.incision_tool import _LineTool
from lappet_blender.tools.preview import clear_preview, preview_of
from lappet_blender.tools.skin_modal import RUNNING, SkinModal
from lappet_blender.tools.skin_pick import pick_along_ray
from tool_scenes import flat_tissue, stand_in_display


class FakeView:
    """A view from straight above, 10 pixels a millimetre."""

    space = None

    def __init__(self, mouse: tuple[float, float]) -> None:
        self.mouse = mouse

    def project(self, places: Any) -> Any:
        return 10.0 * places[:, :2]

    def pick(self, scene: bpy.types.Scene, any_face: bool = False) -> Any:
        return pick_along_ray(scene, (self.mouse[0] / 10, self.mouse[1] / 10, 50.0), (0, 0, -1), any_face)


class Tool(_LineTool):
    """The incision tool without Blender's operator around it; what it would cut is noted."""

    title = "Incision"

    def __init__(self, context: Any) -> None:
        self.line, self.tolerance, self.cut = "STRAIGHT", 0.4, None
        self.points = Points()
        self._scene = context.scene.name
        self.begin(context)

    def execute(self, context: Any) -> set[str]:
        self.cut = [tuple(round(v, 3) for v in point.co) for point in self.points]
        return {"FINISHED"}


class Points(list):
    """Stands in for a collection property."""

    def add(self) -> Any:
        self.append(SimpleNamespace(co=(0.0, 0.0, 0.0)))
        return self[-1]


@pytest.fixture
def context(scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> Any:
    stand_in_display(monkeypatch)
    shown.clear_cache()
    flat_tissue(scene)
    said: dict[str, Any] = {"header": "", "status": ""}
    area = SimpleNamespace(type="VIEW_3D", header_text_set=lambda text: said.update(header=text))
    workspace = SimpleNamespace(status_text_set=lambda text: said.update(status=text))
    preferences = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))
    monkeypatch.setattr(
        skin_modal, "view_under", lambda _context, at: FakeView(at) if abs(at[0]) < 500 and abs(at[1]) < 500 else None
    )
    yield SimpleNamespace(
        scene=scene, area=area, workspace=workspace, preferences=preferences, space_data=None, said=said
    )
    clear_preview()


def event(kind: str, value: str = "PRESS", at: tuple[float, float] = (0, 0), **keys: bool) -> Any:
    held = {"shift": False, "ctrl": False, "alt": False, "oskey": False, **keys}
    return SimpleNamespace(type=kind, value=value, mouse_x=at[0], mouse_y=at[1], **held)


def click(tool: SkinModal, context: Any, at: tuple[float, float], **keys: bool) -> set[str]:
    tool.modal(context, event("MOUSEMOVE", "NOTHING", at, **keys))
    ended = tool.modal(context, event("LEFTMOUSE", "PRESS", at, **keys))
    return tool.modal(context, event("LEFTMOUSE", "RELEASE", at, **keys)) if ended == RUNNING else ended


@pytest.mark.parametrize("end", ["RET", "NUMPAD_ENTER", "RIGHTMOUSE"])
def test_clicks_and_an_end_make_the_cut_and_clean_up(context: Any, end: str) -> None:
    tool = Tool(context)
    assert click(tool, context, (-80, 0)) == RUNNING
    assert click(tool, context, (80, 30)) == RUNNING
    assert context.said["header"] == "Incision at frame 1: 16.3 mm, points: 2"
    assert preview_of(context.scene) is not None
    assert tool.modal(context, event(end)) == {"FINISHED"}
    assert tool.cut == [(-8.0, 0.0, 0.0), (8.0, 3.0, 0.0)]
    assert (context.said["header"], context.said["status"]) == (None, None)
    assert preview_of(context.scene) is None


def test_a_double_click_ends_the_line(context: Any) -> None:
    tool = Tool(context)
    click(tool, context, (-80, 0))
    click(tool, context, (80, 30))
    assert tool.modal(context, event("LEFTMOUSE", "DOUBLE_CLICK", (80, 30))) == {"FINISHED"}
    assert len(tool.cut) == 2


def test_escape_makes_no_cut_and_cleans_up(context: Any) -> None:
    tool = Tool(context)
    click(tool, context, (-80, 0))
    assert tool.modal(context, event("ESC")) == {"CANCELLED"}
    assert tool.cut is None
    assert preview_of(context.scene) is None


def test_an_end_with_too_few_points_says_so_and_goes_on(context: Any) -> None:
    tool = Tool(context)
    click(tool, context, (-80, 0))
    assert tool.modal(context, event("RET")) == RUNNING
    assert "click at least 2 on the skin" in context.said["header"]


@pytest.mark.parametrize(
    "kind", ["MIDDLEMOUSE", "WHEELUPMOUSE", "TRACKPADPAN", "NUMPAD_1", "RIGHT_ARROW", "SPACE", "TIMER"]
)
def test_turning_the_view_and_changing_the_frame_are_let_through(context: Any, kind: str) -> None:
    tool = Tool(context)
    click(tool, context, (-80, 0))
    assert tool.modal(context, event(kind)) == {"PASS_THROUGH"}
    assert len(tool.drawing.points) == 1


def test_clicks_on_panels_and_the_two_button_orbit_are_let_through(context: Any) -> None:
    tool = Tool(context)
    assert tool.modal(context, event("LEFTMOUSE", "PRESS", (900, 0))) == {"PASS_THROUGH"}
    assert tool.modal(context, event("RIGHTMOUSE", "PRESS", (900, 0))) == {"PASS_THROUGH"}
    assert tool.modal(context, event("LEFTMOUSE", "PRESS", (10, 0), alt=True)) == {"PASS_THROUGH"}
    assert tool.drawing.points == []


def test_backspace_and_ctrl_z_take_points_back_and_the_last_ends_the_tool(context: Any) -> None:
    tool = Tool(context)
    for x in (-80, -40, 40):
        click(tool, context, (x, 0))
    tool.modal(context, event("BACK_SPACE"))
    assert len(tool.drawing.points) == 2
    tool.modal(context, event("Z", ctrl=True))
    assert len(tool.drawing.points) == 1
    assert tool.modal(context, event("Z", "RELEASE", ctrl=True)) == RUNNING
    tool.modal(context, event("BACK_SPACE"))
    assert tool.modal(context, event("BACK_SPACE")) == {"CANCELLED"}


def test_a_click_near_the_first_point_or_c_closes_the_line(context: Any) -> None:
    for by_key in (False, True):
        tool = Tool(context)
        for at in ((-80, 0), (0, 80), (80, 0)):
            click(tool, context, at)
        ended = tool.modal(context, event("C")) if by_key else click(tool, context, (-75, 4))
        assert ended == {"FINISHED"}
        assert tool.closed
        assert tool.cut == [(-8.0, 0.0, 0.0), (0.0, 8.0, 0.0), (8.0, 0.0, 0.0)]


def test_ctrl_snaps_to_the_end_of_an_incision(context: Any) -> None:
    bpy.ops.lappet.incision_add(points=[{"name": "", "co": (-5, 2, 0)}, {"name": "", "co": (5, 2, 0)}])
    tool = Tool(context)
    click(tool, context, (55, 25))
    click(tool, context, (-45, 25), ctrl=True)
    tool.modal(context, event("RET"))
    assert tool.cut == [(5.5, 2.5, 0.0), (-5.0, 2.0, 0.0)]


def test_the_scene_the_area_or_the_tissue_may_go_while_a_line_is_drawn(context: Any) -> None:
    tool = Tool(context)
    click(tool, context, (-80, 0))
    there = context.area
    context.area = None
    assert tool.modal(context, event("MOUSEMOVE", "NOTHING")) == {"CANCELLED"}
    context.area = there
    tool = Tool(context)
    click(tool, context, (-80, 0))
    bpy.data.objects.remove(context.scene.lappet.tissue.object)
    shown.clear_cache()
    assert tool.modal(context, event("MOUSEMOVE", "NOTHING", (10, 10))) == RUNNING
    assert tool.modal(context, event("LEFTMOUSE", "PRESS", (10, 10))) == RUNNING
    assert "The mouse is not on the skin" in context.said["header"]
    other = bpy.data.scenes.new("other")
    context.scene = other
    assert tool.modal(context, event("MOUSEMOVE", "NOTHING")) == {"CANCELLED"}


def test_what_was_drawn_on_may_be_deleted_under_the_hand(context: Any) -> None:
    class Broken(Tool):
        def moved(self, _context: Any, _view: Any) -> None:
            raise ReferenceError("StructRNA of type Object has been removed")

        def report(self, kind: set[str], text: str) -> None:
            context.said["report"] = text

    tool = Broken(context)
    assert tool.modal(context, event("MOUSEMOVE", "NOTHING")) == {"CANCELLED"}
    assert [each.code for each in last_refusal()] == [ProblemCode.TOOL_GROUND_GONE]
    assert "Incision" in context.said["report"]


def test_tools_that_run_are_ended_before_their_classes_go(context: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    tool = Tool(context)
    abandoned: list[object] = []
    monkeypatch.setattr(tool, "abandoned", abandoned.append)
    click(tool, context, (-80, 0))
    assert preview_of(context.scene) is not None
    skin_modal.running.append(tool)
    skin_modal.end_running()
    assert len(abandoned) == 1
    assert preview_of(context.scene) is None
    assert not skin_modal.running


def test_a_tool_that_has_ended_is_not_ended_again(context: Any) -> None:
    tool = Tool(context)
    skin_modal.running.append(tool)
    assert tool.modal(context, event("ESC")) == {"CANCELLED"}
    assert not skin_modal.running
