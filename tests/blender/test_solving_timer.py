"""The timer and the keys of live mode, as Blender's event loop calls them."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import pytest

from fake_worker import Script
from lappet_blender.solving import controller, frames, solve_settings, solve_timer
from lappet_blender.solving.live_operator import LAPPET_OT_live
from solving_steps import QUIET

pytest_plugins = ("solving_fixtures",)


def test_the_timer_comes_often_while_something_is_under_way_and_seldom_when_not(
    patch: bpy.types.Scene, script: Script
) -> None:
    assert bpy.app.timers.is_registered(solve_timer._timer)
    assert solve_timer._timer() <= 0.05
    solve_timer.run_timer(QUIET)
    idle = solve_timer._timer()
    assert 0.1 <= idle <= 0.5
    patch.frame_set(5)
    bpy.ops.lappet.live(hook="hook_1")
    assert solve_timer._timer() <= 0.02
    bpy.ops.lappet.live()


def test_a_target_that_lies_still_is_looked_at_less_often_until_it_moves(
    patch: bpy.types.Scene, script: Script, monkeypatch: pytest.MonkeyPatch
) -> None:
    solve_timer.run_timer(QUIET)
    patch.frame_set(5)
    bpy.ops.lappet.live(hook="hook_1")
    for _ in range(4):
        solve_timer.run_timer()
    script.held = True  # no frame comes any more
    live = controller.controller_of(patch).live
    live.stirred_at -= 10.0
    with monkeypatch.context() as watched:
        watched.setattr(solve_settings, "default_folder", lambda: pytest.fail("a still turn looks for the folder"))
        assert solve_timer._timer() >= 0.03
    bpy.data.objects["target"].location.z += 1.0
    bpy.context.view_layer.update()
    assert solve_timer._timer() <= 0.02
    live.stirred_at -= 10.0
    assert solve_timer._timer() >= 0.03
    script.held = False
    assert solve_timer._timer() <= 0.02, "a frame that comes is a sign of life"
    bpy.ops.lappet.live()


def test_an_error_in_the_timer_does_not_end_it(
    patch: bpy.types.Scene, script: Script, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(scene: bpy.types.Scene) -> None:
        raise ValueError("a listener failed")

    solve_timer.run_timer(QUIET)
    frames.subscribe(fail)
    try:
        controller.controller_of(patch).notify()
        assert solve_timer._timer() == 1.0
    finally:
        frames.unsubscribe(fail)
    assert "a listener failed" in capsys.readouterr().err
    assert solve_timer._timer() < 1.0


@pytest.mark.parametrize(
    ("key", "value", "ends"), [("ESC", "PRESS", True), ("RET", "PRESS", True), ("G", "PRESS", False)]
)
def test_return_and_escape_end_live_mode_and_every_other_key_is_left_alone(
    patch: bpy.types.Scene, script: Script, key: str, value: str, ends: bool
) -> None:
    said: list[str | None] = []
    context = SimpleNamespace(scene=patch, workspace=SimpleNamespace(status_text_set=said.append))
    patch.frame_set(5)
    bpy.ops.lappet.live(hook="hook_1")
    result = LAPPET_OT_live.modal(SimpleNamespace(), context, SimpleNamespace(type=key, value=value))
    assert result == ({"FINISHED"} if ends else {"PASS_THROUGH"})
    assert (controller.controller_of(patch).live is None) == ends
    assert said == ([None] if ends else [])


def test_a_listener_that_fails_keeps_no_other_from_being_told(patch: bpy.types.Scene, script: Script) -> None:
    notified: list[str] = []

    def fail(scene: bpy.types.Scene) -> None:
        raise ValueError("a listener failed")

    def listen(scene: bpy.types.Scene) -> None:
        notified.append(scene.name)

    solve_timer.run_timer(QUIET)
    frames.subscribe(fail)
    frames.subscribe(listen)
    try:
        controller.controller_of(patch).notify()
        with pytest.raises(ValueError, match="a listener failed"):
            solve_timer.run_timer()
    finally:
        frames.unsubscribe(fail)
        frames.unsubscribe(listen)
    assert notified == [patch.name]
