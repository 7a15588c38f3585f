"""The whole body: soft tissue around a skeleton, with muscles that bend an arm.

Its tissue is the body without its bones. The walls of the cavities are held by the bones: those of groups that stay are
the subset `fixed`, those of each group that moves are gripped by a retractor that moves as the group does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.solid import closed_solid
from lappet.models.body_mesh import BODY, body_mesh
from lappet.models.body_shape import NEUTRAL, shaped
from lappet.models.body_skin import BodySkin, apart
from lappet.models.deep_layer import deep_layer
from lappet.models.joints import joints
from lappet.models.model_choice import SPACING_RANGE, ModelChoice, checked
from lappet.models.muscle_plans import MUSCLES, End, StrandPlan
from lappet.models.skeleton import skeleton
from lappet.procedure import Material, Muscle, Procedure, Retractor, Strand, Tissue

_POINTS = 7  # of a strand
_TENDON = 0.4  # radius of a strand's ends over that of its belly
_COVER = 4.0  # mm of skin and fat over a muscle
_LEAST_RADIUS = 2.0  # mm
# A strand is pushed inwards until the skin is its cover and so much of its radius away; so often, as skin is curved.
_BELOW_COVER, _PUSHES = 0.7, 4

# Chosen: soft tissue as one; muscle at rest as stiff as passive muscle across its fibers is in elastography, 10 to
# 30 kPa. 300 kPa of isometric stress: Teran, Blemker, Ng Thow Hing, Fedkiw 2003, table 1.
SOFT_TISSUE = Material("soft_tissue", "neoHookean", 15.0, 0.45, density=1000.0)
MUSCLE = Material("muscle", "neoHookean", 25.0, 0.45, density=1060.0, muscle_stress=300.0)


@dataclass(frozen=True)
class WholeBodyModel:
    """The model of the whole body.

    Parameters
    ----------
    name
        What the command line calls it.
    title
        What it shows, in a few words.
    spacing
        Edge of the lattice's cells in mm by default.
    frames
        Frames of its movement.
    flexion
        How far the right elbow bends, in degrees.
    activation
        Greatest activation of the muscles that bend it.
    """

    name: str
    title: str
    spacing: float
    frames: int
    flexion: float
    activation: float


WHOLE_BODY = WholeBodyModel("body", "a whole body with bones and muscles that bends an arm", 10.0, 6, 25.0, 0.15)
# What bends the right elbow, by Gray's Anatomy (`lappet.models.muscle_plans.SOURCE`).
_FLEXORS = ("biceps_brachii_r", "brachialis_r", "brachioradialis_r")
_MOVED = "forearm_r"


def whole_body_model(model: WholeBodyModel, choice: ModelChoice) -> Procedure:
    """Make the procedure of the whole body.

    Parameters
    ----------
    model
        The model.
    choice
        The shape of the body and the spacing; an excision, a skin and a laxity do nothing here.

    Returns
    -------
    Procedure
        The procedure: the right elbow bends over its frames while its flexors become active.

    Raises
    ------
    RefusedError
        If a parameter is out of its range, the package is not there, or a reach, an excision or a deeper layer is
        asked for.
    """
    if choice.reach != 1.0:
        raise refused(ProblemCode.MODEL_NO_BODY, model.name, "a reach")
    if choice.excision:
        raise refused(ProblemCode.MODEL_NO_BODY, model.name, "an excision")
    if choice.deep:
        deep_layer(model.name)
    spacing = checked("spacing", choice.spacing if choice.spacing is not None else model.spacing, *SPACING_RANGE)
    points = shaped(choice.shape or NEUTRAL)
    places = joints(points)
    quads = body_mesh().faces_of(BODY)
    used, faces = np.unique(np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), return_inverse=True)
    faces = faces.reshape(-1, 3)
    corners = apart(points[used], faces)
    skin = BodySkin.of(corners, faces)
    solid = closed_solid(corners, faces, model.name)
    tissue = replace(_tissue(solid, skeleton(places, skin)), spacing=spacing)
    muscles = _muscles(places, skin)
    materials = tuple(_material(model, muscle.name) for muscle in muscles)
    return Procedure(
        tissue,
        materials=(SOFT_TISSUE, *materials),
        events=(_bent(model, places),),
        muscles=muscles,
        start_time=1.0,
        end_time=float(model.frames),
    )


def _material(model: WholeBodyModel, name: str) -> Material:
    """A material of its own for each muscle, so that each can be active by itself."""
    rises = ((1.0, 0.0), (float(model.frames), model.activation)) if name in _FLEXORS else ()
    return replace(MUSCLE, name=name, muscle_activation=rises)


def _tissue(skin: manifold3d.Manifold, bones: Mapping[str, manifold3d.Manifold]) -> Tissue:
    """The body without its bones, with the walls of their cavities as subsets."""
    skin = skin.as_original()
    originals = {name: (solid ^ skin).as_original() for name, solid in bones.items()}
    whole = skin - manifold3d.Manifold.batch_boolean(list(originals.values()), manifold3d.OpType.Add)
    mesh = whole.to_mesh()
    triangles = np.asarray(mesh.tri_verts, np.int64)
    origin = np.repeat(np.asarray(mesh.run_original_id), np.diff(np.asarray(mesh.run_index)) // 3)
    walls = {name: np.flatnonzero(origin == solid.original_id()) for name, solid in originals.items()}
    subsets = {f"bone_{name}": faces.astype(np.int32) for name, faces in walls.items()}
    still = np.concatenate([faces for name, faces in walls.items() if name != _MOVED])
    subsets["underside"] = np.sort(np.concatenate(list(walls.values()))).astype(np.int32)
    subsets["fixed"] = np.sort(still).astype(np.int32)
    return Tissue(
        points=np.asarray(mesh.vert_properties)[:, :3].astype(np.float32).astype(np.float64),
        face_vertex_counts=np.full(len(triangles), 3, np.int32),
        face_vertex_indices=triangles.reshape(-1).astype(np.int32),
        subsets=subsets,
        material=SOFT_TISSUE.name,
    )


def _bent(model: WholeBodyModel, places: Mapping[str, NDArray[np.float64]]) -> Retractor:
    """The bones of the right forearm, which turn about the elbow in the plane of the arm."""
    elbow = places["r-elbow"]
    upper, lower = elbow - places["r-shoulder"], places["r-hand"] - elbow
    axis = np.cross(upper, lower)
    axis /= np.linalg.norm(axis)
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    samples = []
    for frame in range(1, model.frames + 1):
        angle = np.radians(model.flexion) * (frame - 1) / (model.frames - 1)
        turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
        matrix = np.eye(4)
        matrix[:3, :3], matrix[3, :3] = turn.T, elbow - turn @ elbow  # row vectors
        samples.append((float(frame), tuple(matrix.ravel())))
    return Retractor("right_elbow_bends", f"bone_{_MOVED}", tuple(samples), 1.0, model.frames + 1.0)


def _muscles(places: Mapping[str, NDArray[np.float64]], skin: BodySkin) -> tuple[Muscle, ...]:
    """The muscles; those of the left side mirror those of the right, also in a body that is not quite symmetric."""
    made = []
    for plan in MUSCLES:
        right = tuple(_strand(each, places, skin) for each in plan.strands)
        left = tuple(Strand(tuple((-x, y, z) for x, y, z in each.points), each.radii) for each in right)
        for side, strands in (("r", right), ("l", left)):
            name = f"{plan.name}_{side}"
            made.append(Muscle(name, strands, name))
    return tuple(made)


def _strand(plan: StrandPlan, places: Mapping[str, NDArray[np.float64]], skin: BodySkin) -> Strand:
    """A strand whose belly bulges like a parabola, pushed inwards to where skin and fat cover it."""
    first, last = _place(plan.origin, places), _place(plan.insertion, places)
    share = np.linspace(0.0, 1.0, _POINTS)
    belly = 4.0 * share * (1.0 - share)
    course = (1.0 - share[:, None]) * first + share[:, None] * last + belly[:, None] * np.array(plan.bulge)
    radii = plan.radius * (_TENDON + (1.0 - _TENDON) * belly)
    for _ in range(_PUSHES):
        depth, inwards = skin.depth(course)
        course += np.maximum(_COVER + _BELOW_COVER * radii - depth, 0.0)[:, None] * inwards
    radii = np.maximum(np.minimum(radii, skin.depth(course)[0] - _COVER), _LEAST_RADIUS)
    return Strand(tuple((float(x), float(y), float(z)) for x, y, z in course), tuple(radii.tolist()))


def _place(end: End, places: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """A place of an end on the right side."""
    first, second = (places[name.replace("*", "r")] for name in end.joints)
    return (1.0 - end.share) * first + end.share * second + np.array(end.shift)
