"""A scene as a procedure, and a procedure as a scene."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from lappet.core.problem import Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Event, Procedure

from .decimals import decimal
from .event_values import event_value
from .kept_values import kept_values
from .laid_flaps import flap_values
from .material_values import material_values
from .plate_values import plate_values
from .scene_filling import fill_scene
from .skin_line_values import skin_line_values
from .tissue_values import bone_values, tissue_value
from .vessel_values import vessel_values


@dataclass(frozen=True)
class SceneReading:
    """What reading a scene gave.

    procedure: None where a problem that is an error stands in the way. problems: those of Blender's side; what the
    values themselves are wrong about `lappet.check` and the manifest say.
    """

    procedure: Procedure | None
    problems: tuple[Problem, ...]


def read_scene(scene: bpy.types.Scene) -> SceneReading:
    """The procedure that the scene holds. Never raises; under 2 ms at 20 000 vertices where nothing has changed."""
    tissue, problems = tissue_value(scene)
    bones, wrong = bone_values(scene)
    problems += wrong
    events = _events(scene, problems)
    if tissue is None or any(each.severity == "error" for each in problems):
        return SceneReading(None, tuple(problems))
    kept = kept_values(scene)
    procedure = Procedure(
        tissue=kept.rolling(tissue) if kept.rollers else tissue,
        materials=material_values(scene),
        events=(*events, *kept.events),
        bones=kept.moving(bones) if kept.moving_bones else bones,
        skin_lines=skin_line_values(scene),
        vessels=vessel_values(scene),
        flaps=flap_values(scene, {event.name for event in events}),
        plates=plate_values(scene),
        muscles=kept.muscles,
        start_time=float(scene.frame_start),
        end_time=float(scene.frame_end),
        fps=scene.render.fps / decimal(scene.render.fps_base),
    )
    return SceneReading(procedure, tuple(problems))


def _events(scene: bpy.types.Scene, problems: list[Problem]) -> tuple[Event, ...]:
    found = []
    for each in scene.lappet.events:
        if not each.enabled:
            continue
        try:
            found.append(event_value(scene, each))
        except RefusedError as refused:
            problems += refused.problems
        except (ValueError, ReferenceError, TypeError, KeyError, AttributeError) as error:
            # A scene may hold anything, and panels read it while they draw: say which event, and go on.
            problems.append(problem(ProblemCode.EVENT_UNREADABLE, each.name, error))
    return tuple(found)


__all__ = ["SceneReading", "fill_scene", "read_scene"]
