"""Brings the procedures of older files up to this version of the properties, and speaks up about newer ones."""

from __future__ import annotations

from collections.abc import Callable

import bpy
from bpy.app.handlers import persistent

from .procedure_properties import VERSION
from .scene_problem import SceneProblem, problem

# From the version that is the key to the next one. Version 0 is a scene that no operator has touched.
STEPS: dict[int, Callable[[bpy.types.Scene], None]] = {}


def migrate(scene: bpy.types.Scene) -> bool:
    """Brings the scene's procedure up to date, a version at a time; whether anything was to be done.

    Scenes of a library, scenes without a procedure and those of a newer version are left alone.
    """
    procedure = scene.lappet
    if scene.library is not None or procedure.version >= VERSION:
        return False
    if procedure.version == 0 and procedure.tissue.object is None and len(procedure.events) == 0:
        return False
    while procedure.version < VERSION:
        step = STEPS.get(procedure.version)
        if step is not None:
            step(scene)
        procedure.version += 1
    return True


def version_problems(scene: bpy.types.Scene) -> list[SceneProblem]:
    """A warning where the scene was made by a newer Lappet than this."""
    version = scene.lappet.version
    if version <= VERSION:
        return []
    sentence = (
        f"The scene {scene.name!r} was made by a newer Lappet (its properties are of version {version}, "
        f"this one knows {VERSION}); what is new in it is not seen here."
    )
    return [problem(scene.name, version, sentence, "Install the newer Lappet.", severity="warning")]


@persistent  # type: ignore[untyped-decorator]
def on_load(*_: object) -> None:
    """After a file was loaded."""
    for scene in bpy.data.scenes:
        migrate(scene)
        for each in version_problems(scene):
            print(f"Lappet: {each.sentence} {each.mend}")


def register() -> None:
    """Migrates from now on whatever is loaded."""
    if on_load not in bpy.app.handlers.load_post:
        bpy.app.handlers.load_post.append(on_load)


def unregister() -> None:
    """Migrates no more."""
    if on_load in bpy.app.handlers.load_post:
        bpy.app.handlers.load_post.remove(on_load)
