"""Read a .glb of `lappet export` and write it as Alembic or FBX: `convert_glb GLB TARGET FPS LAST_FRAME`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import bpy

WHOLE = "Operation"


def convert(source: Path, target: Path, fps: float, last: int) -> None:
    """Write the file; its first frame is 0, as the importer lays second 0 there, and frame `last` its last one."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = max(round(fps), 1), max(round(fps), 1) / fps
    bpy.ops.import_scene.gltf(filepath=str(source))
    scene.frame_start, scene.frame_end = 0, last
    _keep_whole()
    if target.suffix.lower() == ".abc":
        bpy.ops.wm.alembic_export(
            filepath=str(target),
            start=0,
            end=last,
            face_sets=True,
            uvs=True,
            normals=True,
            as_background_job=False,
        )
    else:
        bpy.ops.export_scene.fbx(
            filepath=str(target),
            bake_anim=True,
            bake_anim_use_nla_strips=False,
            bake_anim_use_all_actions=False,
            bake_anim_simplify_factor=0.0,
            path_mode="COPY",
            embed_textures=True,
            use_mesh_modifiers=False,  # modifiers would apply, and drop, the shape keys
        )


def _keep_whole() -> None:
    """Leave the animation of all frames alone: the steps' would be mixed into it."""
    holders = [each for each in bpy.data.objects if each.animation_data]
    keys = [each.data.shape_keys for each in bpy.data.objects if each.type == "MESH" and each.data.shape_keys]
    for holder in (*holders, *(each for each in keys if each.animation_data)):
        for track in list(holder.animation_data.nla_tracks):
            holder.animation_data.nla_tracks.remove(track)
    for action in list(bpy.data.actions):
        if action.name != WHOLE:
            bpy.data.actions.remove(action)


def main() -> None:
    """Run as a program; prints a line of JSON: `done`, or `error` with what Blender said."""
    source, target, fps, last = Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4])
    try:
        convert(source, target, fps, last)
    except RuntimeError as error:  # what Blender's operators raise
        print(json.dumps({"error": " ".join(str(error).split())}))
        return
    print(json.dumps({"done": target.is_file()}))


if __name__ == "__main__":
    main()
