"""Drives a Blender window as a person does: moves, clicks, drags, keys, pictures and what is expected to be seen.

A scenario is a generator: it takes a `Driver`, and yields the seconds to wait until it goes on. Steps that need time
are generators too, called with `yield from`:

    def scenario(blender: Driver) -> Steps:
        yield from blender.click(blender.at((0.0, 0.0, 1.0)))
        yield from blender.wait_until(lambda: bpy.context.object is not None, 2.0, "a click selects the object")
        yield from blender.screenshot("selected")

    run(scenario)

Blender goes on between the steps, since a timer takes them. `run` writes the verdict and ends Blender. Blender must
have been started with --enable-event-simulate; from then on it takes no event but these.
"""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Generator, Iterable, Sequence
from pathlib import Path
from typing import Any

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d

Steps = Generator[float, None, None]
Point = tuple[int, int]

TICK = 0.03  # seconds between two events: Blender's loop turns in between
FOLDER = Path(os.environ.get("LAPPET_GUI_RESULTS", "build/gui/results"))
_TEXT_KEYS = {" ": "SPACE", ".": "PERIOD", "-": "MINUS", ",": "COMMA", "/": "SLASH"}
_DIGITS = ("ZERO", "ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE")


class Driver:
    """The first window of Blender, and what a scenario has seen of it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.expectations: list[dict[str, Any]] = []
        self.screenshots: list[str] = []
        self.notes: dict[str, Any] = {}
        self.seconds_of_pictures = 0.0  # that Blender stood still for them
        self._mouse: Point = (0, 0)

    # --- where ---------------------------------------------------------------------------------------------------

    @property
    def window(self) -> bpy.types.Window:
        """The window."""
        return bpy.context.window_manager.windows[0]

    def area(self, kind: str = "VIEW_3D") -> bpy.types.Area:
        """The largest area of a kind. Raises LookupError where the window shows none."""
        found = [area for area in self.window.screen.areas if area.type == kind]
        if not found:
            raise LookupError(f"The window shows no {kind}; it has {[area.type for area in self.window.screen.areas]}.")
        return max(found, key=lambda area: area.width * area.height)

    def region(self, kind: str = "WINDOW", area: str = "VIEW_3D") -> bpy.types.Region:
        """The region of a kind in an area: WINDOW, UI (the sidebar), TOOLS (the toolbar), HEADER, TOOL_HEADER."""
        return next(region for region in self.area(area).regions if region.type == kind)

    def at(self, location: Sequence[float]) -> Point:
        """The window's pixel where the 3D view shows a point of the world. Raises LookupError where it does not."""
        region = self.region()
        seen = location_3d_to_region_2d(region, self.area().spaces.active.region_3d, location)
        if seen is None or not (0 <= seen[0] < region.width and 0 <= seen[1] < region.height):
            raise LookupError(f"The 3D view does not show the point {tuple(location)}; turn or zoom it first.")
        return round(region.x + seen[0]), round(region.y + seen[1])

    def within(self, across: float, up: float, region: str = "WINDOW", area: str = "VIEW_3D") -> Point:
        """The window's pixel at fractions of a region's width and height, from its lower left corner."""
        found = self.region(region, area)
        return round(found.x + across * (found.width - 1)), round(found.y + up * (found.height - 1))

    def override(self, region: str = "WINDOW", area: str = "VIEW_3D") -> Any:
        """The context of a region, for operators that are called: `with blender.override(): bpy.ops...`."""
        return bpy.context.temp_override(
            window=self.window, screen=self.window.screen, area=self.area(area), region=self.region(region, area)
        )

    # --- what a hand does ----------------------------------------------------------------------------------------

    def event(self, kind: str, value: str, **how: Any) -> None:
        """One event where the mouse is. how: shift, ctrl, alt, oskey, unicode."""
        self.window.event_simulate(type=kind, value=value, x=self._mouse[0], y=self._mouse[1], **how)

    def move(self, to: Point, **how: Any) -> Steps:
        """Moves the mouse, without a button."""
        self._mouse = to
        self.event("MOUSEMOVE", "NOTHING", **how)
        yield TICK

    def click(self, at: Point, button: str = "LEFTMOUSE", **how: Any) -> Steps:
        """Moves to a pixel, presses and releases a button there."""
        yield from self.move(at, **how)
        self.event(button, "PRESS", **how)
        yield TICK
        self.event(button, "RELEASE", **how)
        yield TICK

    def drag(self, path: Sequence[Point], button: str = "LEFTMOUSE", steps: int = 8, **how: Any) -> Steps:
        """Presses a button at the first pixel, moves through the others in `steps` moves each, releases at the last."""
        yield from self.move(path[0], **how)
        self.event(button, "PRESS", **how)
        yield TICK
        for start, end in itertools.pairwise(path):
            for step in range(1, steps + 1):
                between = tuple(round(a + (b - a) * step / steps) for a, b in zip(start, end, strict=True))
                yield from self.move((between[0], between[1]), **how)
        self.event(button, "RELEASE", **how)
        yield TICK

    def key(self, kind: str, **how: Any) -> Steps:
        """Presses and releases a key: Blender's name of it, as "Z", "RET", "ESC"; how: ctrl, shift, alt, unicode."""
        self.event(kind, "PRESS", **how)
        yield TICK
        how.pop("unicode", None)
        self.event(kind, "RELEASE", **how)
        yield TICK

    def text(self, words: str) -> Steps:
        """Types into a field that is being edited: letters, digits, space and . , - /."""
        for letter in words:
            kind = _TEXT_KEYS.get(letter) or (_DIGITS[int(letter)] if letter.isdigit() else letter.upper())
            yield from self.key(kind, unicode=letter, shift=letter.isupper())

    # --- what an eye sees ----------------------------------------------------------------------------------------

    def wait(self, seconds: float) -> Steps:
        """Lets Blender go on."""
        yield seconds

    def wait_until(self, condition: Callable[[], bool], timeout: float, sentence: str) -> Steps:
        """Waits until the condition holds, and expects that it does within `timeout` seconds."""
        end = time.monotonic() + timeout
        while not (held := condition()) and time.monotonic() < end:
            yield TICK
        self.expect(held, sentence)

    def expect(self, condition: bool, sentence: str) -> bool:
        """Notes whether it is as the sentence says; the scenario goes on in either case."""
        self.expectations.append({"sentence": sentence, "held": bool(condition)})
        print(f"{'as expected' if condition else 'NOT SO'}: {sentence}", flush=True)
        return bool(condition)

    def screenshot(self, name: str) -> Steps:
        """Takes a picture of the whole screen, as `<name>.png`, after Blender has drawn once more."""
        for area in self.window.screen.areas:
            area.tag_redraw()
        yield 0.3
        self._picture(name)

    def _picture(self, name: str) -> None:
        path, begun = self.folder / f"{name}.png", time.monotonic()
        subprocess.run(["import", "-window", "root", str(path)], check=True, timeout=30)
        self.screenshots.append(path.name)
        self.seconds_of_pictures += time.monotonic() - begun

    # --- what Blender offers -------------------------------------------------------------------------------------

    def tabs(self) -> list[str]:
        """The names of the sidebar's tabs in the 3D view, of every panel that is registered."""
        panels = (getattr(bpy.types, name) for name in dir(bpy.types))
        return sorted(
            {
                panel.bl_category
                for panel in panels
                if getattr(panel, "bl_space_type", "") == "VIEW_3D"
                and getattr(panel, "bl_region_type", "") == "UI"
                and getattr(panel, "bl_category", "")
            }
        )

    def show_tab(self, name: str) -> Steps:
        """Opens the 3D view's sidebar at a tab."""
        self.area().spaces.active.show_region_ui = True
        yield 0.2
        self.region("UI").active_panel_category = name
        yield 0.2

    def tools(self) -> list[str]:
        """The identifiers of the toolbar's tools in the 3D view's object mode."""
        from bl_ui.space_toolsystem_toolbar import VIEW3D_PT_tools_active as toolbar

        return sorted(tool.idname for tool in _flat(toolbar.tools_from_context(bpy.context, mode="OBJECT")))

    def set_tool(self, name: str) -> Steps:
        """Makes a tool of the toolbar the active one."""
        with self.override():
            bpy.ops.wm.tool_set_by_id(name=name)
        yield 0.1


def _flat(tools: Iterable[Any]) -> Iterable[Any]:
    """Tools without separators; those of a group one by one."""
    for tool in tools:
        if isinstance(tool, tuple) and not hasattr(tool, "idname"):
            yield from _flat(tool)
        elif tool is not None:
            yield tool


def run(scenario: Callable[[Driver], Steps], *, limit: float = 240.0, folder: Path = FOLDER) -> None:
    """Runs the scenario once the window is there, writes `verdict.json` into the folder and ends Blender.

    limit: seconds after which it has failed. The exit status is 0 where every expectation held.
    """
    folder.mkdir(parents=True, exist_ok=True)
    driver = Driver(folder)
    began = time.monotonic()
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.view.show_developer_ui = True
    preferences.system.viewport_aa = "OFF"  # software draws
    steps = scenario(driver)

    def finish(error: str | None) -> None:
        if error is not None:
            print(error, file=sys.stderr, flush=True)
            try:
                driver._picture("failure")
            except (OSError, subprocess.SubprocessError) as trouble:
                print(f"There is no picture of the failure: {trouble}", file=sys.stderr)
        expected = driver.expectations
        passed = error is None and bool(expected) and all(each["held"] for each in expected)
        verdict = {
            "passed": passed,
            "error": error,
            "expectations": expected,
            "screenshots": driver.screenshots,
            "notes": driver.notes,
            "blender": bpy.app.version_string,
            "seconds": round(time.monotonic() - began, 1),
        }
        (folder / "verdict.json").write_text(json.dumps(verdict, indent=1), encoding="utf-8")
        os._exit(0 if passed else 1)  # Blender's own end may wait for a person, or crash in software OpenGL

    def tick() -> float | None:
        if time.monotonic() - began > limit:
            finish(f"The scenario took longer than {limit:g} s; the last thing it noted: {driver.expectations[-1:]}.")
        try:
            return max(next(steps), 0.001)
        except StopIteration:
            finish(None)
        except Exception:
            finish(traceback.format_exc())
        return None

    bpy.app.timers.register(tick, first_interval=1.0, persistent=True)
