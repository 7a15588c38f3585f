"""How long Blender's window leaves its user without an answer, and how long Lappet keeps its main thread."""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

import bpy
from event_driver import Driver

MODULE = "bl_ext.user_default.lappet_blender"
_BEAT = 0.005
_WATCHED = (
    ("solving.solve_timer", "run_timer"),
    ("display.skin_display", "show"),
    ("tools.plan_overlay", "plan_lines"),
)


class Pulse:
    """Measures from `begin` on.

    gap: the longest time between two turns of Blender's loop, drawing included, wall clock, s. longest: by name the
    longest call of Lappet's timer, of showing a frame, of the lines of the plan, of an operator, of undo and of opening
    a file, the thread's own time, s.
    """

    def __init__(self, blender: Driver) -> None:
        self._blender = blender
        self.begin()
        for module, name in _WATCHED:
            self._watch(import_module(f"{MODULE}.{module}"), name)
        operators = import_module(f"{MODULE}.interface.operator_base").OperatorBase
        timed = self._timed(operators.execute, "operator")
        operators.execute = lambda self, context: timed(self, context)  # Blender counts what a method takes
        after = bpy.app.handlers
        for name, handlers in (("undo", after.undo_post), ("undo", after.redo_post), ("opening", after.load_post)):
            for index, handler in enumerate(handlers):
                if handler.__module__.startswith(MODULE):
                    handlers[index] = bpy.app.handlers.persistent(self._timed(handler, name))
        bpy.app.timers.register(self._beat, persistent=True)

    def begin(self) -> None:
        """Measures anew."""
        self.gap, self.beats, self.longest = 0.0, 0, dict[str, float]()
        self._last = self._now()

    def words(self) -> str:
        """What was measured."""
        calls = ", ".join(f"{name} {1e3 * seconds:.0f} ms" for name, seconds in sorted(self.longest.items()))
        return f"longest gap {1e3 * self.gap:.0f} ms over {self.beats} turns; of the processor at once: {calls}"

    def _now(self) -> float:
        """Seconds, without those of taking pictures."""
        return time.monotonic() - self._blender.seconds_of_pictures

    def _beat(self) -> float:
        now = self._now()
        self.gap, self._last, self.beats = max(self.gap, now - self._last), now, self.beats + 1
        return _BEAT

    def _watch(self, module: Any, name: str) -> None:
        setattr(module, name, self._timed(getattr(module, name), name))

    def _timed(self, call: Callable[..., Any], name: str) -> Callable[..., Any]:
        def timed(*given: Any, **named: Any) -> Any:
            begun = time.thread_time()
            try:
                return call(*given, **named)
            finally:
                self.longest[name] = max(self.longest.get(name, 0.0), time.thread_time() - begun)

        return timed
