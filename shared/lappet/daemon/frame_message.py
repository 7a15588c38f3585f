"""Read the message `frame` (PROTOCOL.md): the one place where a solved frame comes off the wire."""

from __future__ import annotations

import numpy as np

from lappet.daemon.frame_diagnostics import Diagnostics
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.solved_frame import HOLDERS, SCALARS, SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.daemon.wire import Message, WireError, read_array, read_fields
from lappet.program.program import FrameConstraints, Landmarks
from lappet.program.settings import SolverSettings


def read_frame(
    message: Message,
    constraints: FrameConstraints,
    settings: SolverSettings,
    landmarks: Landmarks,
    lattice: LatticeCounts | None,
    sections: int = 0,
) -> SolvedFrame:
    """Read the message that answers the constraints of a frame.

    Parameters
    ----------
    message
        The message.
    constraints
        The constraints.
    settings
        Those of the session.
    landmarks
        The landmarks of the epoch, with its points of vessels.
    lattice
        Counts of the epoch's lattice.
    sections
        Number of sections across the epoch's tissue.

    Returns
    -------
    SolvedFrame
        The frame.

    Raises
    ------
    WireError
        If it does not answer them.
    """
    hooks, sutures, marks = len(constraints.hook_stiffness), len(constraints.suture_index), len(landmarks.index)
    followed = marks + len(landmarks.vessel_triangles)
    points = read_array(message, "points", "f4", (None, 3))
    measured = len(points) if settings.strain else 0
    corrections = {}
    if settings.correction and message.fields.get("converged") is True:
        corrections = {
            "correction": read_array(message, "correction", "f4", points.shape),
            "landmark_correction": read_array(message, "landmark_correction", "f8", (followed, 3))[:marks],
        }
    optional = {}
    if len(constraints.suture_inner_bites):
        optional = {
            "suture_inner_bites": np.asarray(constraints.suture_inner_bites, np.int32),
            "inner_bite_points": read_array(
                message, "inner_bite_points", "f8", (len(constraints.inner_bite_triangles), 3)
            ),
        }
    if sections:
        optional["section_forces"] = read_array(message, "section_forces", "f8", (sections, 3))
    holders = read_array(message, "holders", "i4", (None, 2))
    if len(holders) and not 0 <= holders[:, 0].min() <= holders[:, 0].max() < len(HOLDERS):
        raise WireError("The array 'holders' of 'frame' has a kind that is not known.")
    time = message.fields.get("time")
    if time != constraints.time:
        raise WireError(f"The daemon answered frame {time!r:.60} where frame {constraints.time:g} was due.")
    places = read_array(message, "landmarks", "f8", (followed, 3))
    return SolvedFrame(
        constraints.time,
        points,
        **{name: read_array(message, name, "f4", (measured,)) for name in SCALARS},
        landmark_index=np.asarray(landmarks.index, np.int32),
        landmarks=places[:marks],
        vessel_points=places[marks:],
        hook_index=read_array(message, "hook_index", "i4", (hooks,)),
        hook_points=read_array(message, "hook_points", "f8", (hooks, 3)),
        hook_forces=read_array(message, "hook_forces", "f8", (hooks, 3)),
        suture_index=read_array(message, "suture_index", "i4", (sutures,)),
        suture_points=read_array(message, "suture_points", "f8", (sutures, 2, 3)),
        suture_gaps=read_array(message, "suture_gaps", "f8", (sutures,)),
        suture_forces=read_array(message, "suture_forces", "f8", (sutures,)),
        suture_force_vectors=read_array(message, "suture_force_vectors", "f8", (sutures, 3)),
        suture_shared=read_array(message, "suture_shared", "f8", (sutures + len(constraints.inner_bite_triangles),)),
        **optional,
        **corrections,
        holders=holders,
        reactions=read_array(message, "reactions", "f8", (len(holders), 3)),
        softest_point=read_array(message, "softest_point", "f8", (None, 3)),
        diagnostics=read_fields(Diagnostics, message.fields, "frame"),
        lattice=lattice,
        state=_read_state(message),
    )


def _read_state(message: Message) -> SolverState:
    precision = message.fields.get("precision")
    if precision not in ("float", "double"):
        raise WireError(f"The field 'precision' of 'frame' is {precision!r:.60}; it must be 'float' or 'double'.")
    return SolverState(
        precision,
        read_array(message, "nodes", "f8" if precision == "double" else "f4", (None, 3)),
        read_array(message, "suture_separations", "f8", (None, 3)),
        read_array(message, "suture_multipliers", "f8", (None, 3)),
        read_array(message, "grip_multipliers", "f8", (None,)),
        read_array(message, "activation", "f8", (None,)),
        read_array(message, "stability", "f8", (None,)),
        **{
            name: read_array(message, name, kind, shape)
            for name, kind, shape in (
                ("roller_multipliers", "f8", (None,)),
                ("loads", "f8", (None, 5)),
                ("bone_motion", "f8", (None, 4, 4)),
                ("motion", "f4", (None, 3)),
            )
            if name in message.arrays
        },
    )
