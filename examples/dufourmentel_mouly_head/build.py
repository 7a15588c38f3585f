"""Builds dufourmentel_mouly_head.usda: Dufourmentel and Mouly's flap closes a rhombic defect on a real head.

The scalp is the part of the outer skin of FreeSurfer's average head inside a sphere over the right parietal bone,
thickened inwards. The bone under it reaches from just below that scalp to the inner surface of the same head's skull.
Both surfaces come with the Python package MNE.

Usage: pip install 'lappet[examples]', then python build.py [dufourmentel_mouly_head.usda]
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from lappet.designs import Row, Schedule, Technique, draped_on, dufourmentel, flap_operation
from lappet.geometry.border_loops import border_loops
from lappet.geometry.closest_point import ClosestPoint
from lappet.procedure import POSITIONS, Bone, Procedure, Tissue
from lappet.tissue.presets import SKIN
from lappet.tissue.skin_sheet import SkinSheet
from lappet.tissue.tissue_from_mesh import new_tissue
from lappet.usd.stage import write_procedure

ABOVE = (69.0, -42.0, 60.0)  # mm: the design lies on the skin closest to this point, over the right parietal bone
DIRECTION = (0.0, 0.0, -1.0)  # from the defect to the flap: towards the ear
SIDE, ANGLE = 15.0, 66.0  # mm, degrees
THICKNESS = 5.5  # mm, of the scalp
REACH, BONE_REACH = 52.0, 58.0  # mm: radii of the spheres around the design that cut scalp and bone out of the head
CLEARANCE = 0.1  # mm between scalp and bone
RESOLUTION, SPACING = 2.5, 1.0  # mm: edges of the skin's triangles and of the lattice's cells
WHEN = Schedule()
HOW = Technique(beyond=15.0, apart=2.6, inside=3.0, rows=(Row("galea", 4.3), Row("dermal", 1.0, 0.5), Row("skin", 0.0)))

Surface = tuple[NDArray[np.float64], NDArray[np.int64]]


def surface(name: str) -> Surface:
    """A surface of the head that comes with MNE: points (n, 3) in mm and triangles (m, 3). Raises ImportError."""
    import mne

    found = mne.read_bem_surfaces(Path(mne.__file__).parent / "data" / "fsaverage" / name, verbose=False)[0]
    return 1000.0 * np.asarray(found["rr"], np.float64), np.asarray(found["tris"], np.int64)


def sheet(reach: float, thickness: float) -> Tissue:
    """The outer skin within reach of the design, so thick, as `lappet new` makes it; mm."""
    points, triangles = surface("fsaverage-head.fif")
    x, y, z = ClosestPoint(points, triangles).query([ABOVE])[1][0].round(4)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "fsaverage-head.ply"
        trimesh.Trimesh(points, triangles, process=False).export(file)
        tissue, _ = new_tissue(
            file, thickness, sphere=((x, y, z), reach), spacing=SPACING, units="mm", resolution=RESOLUTION
        )
    return replace(tissue, points=np.round(tissue.points, 4), uv=None if tissue.uv is None else np.round(tissue.uv, 5))


def skull() -> Bone:
    """The bone: its outer face CLEARANCE below the scalp, its inner face that of the head's own skull below it."""
    above = sheet(BONE_REACH, THICKNESS + CLEARANCE)
    used, compact = np.unique(above.face_vertex_indices.reshape(-1, 3)[above.subsets["bed"]], return_inverse=True)
    outer = above.points[used]
    inwards = outer - above.points[used - len(used)]  # the vertices of the underside follow those of the skin
    inwards /= np.linalg.norm(inwards, axis=1, keepdims=True)
    cavity = ClosestPoint(*surface("fsaverage-inner_skull-bem.fif"))
    inner = outer
    for _ in range(5):  # as far as is free in any direction, until the cavity is met
        inner = inner + cavity.query(inner)[2][:, None] * inwards
    low = compact.reshape(-1, 3)  # the underside of the scalp looks inwards, as the inner face of the bone does
    (loop,) = border_loops(low)
    count, following = len(outer), np.roll(loop, -1)
    rim = [np.stack([loop, following, loop + count], 1), np.stack([following, following + count, loop + count], 1)]
    faces = np.concatenate([low[:, ::-1], low + count, *rim])
    return Bone(
        name="skull",
        points=np.round(np.vstack([outer, inner]), 4),
        face_vertex_counts=np.full(len(faces), 3, np.int32),
        face_vertex_indices=faces.ravel().astype(np.int32),
    )


def build() -> Procedure:
    """The whole procedure. Raises ImportError without MNE."""
    tissue = replace(sheet(REACH, THICKNESS), gravity_direction=POSITIONS["left_lateral"])  # the defect is on the right
    skin = SkinSheet.of(tissue)
    middle, normal = (value[0] for value in skin.at(ABOVE))
    design = dufourmentel(middle, DIRECTION, SIDE, ANGLE, normal=normal, project=draped_on(skin, middle))
    return Procedure(
        tissue=tissue,
        materials=(SKIN.material,),
        events=flap_operation(design, skin, WHEN, HOW),
        bones=(skull(),),
        start_time=1,
        end_time=WHEN.end,
        fps=12,
    )


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("dufourmentel_mouly_head.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
