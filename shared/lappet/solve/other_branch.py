"""Whether the coarse solve of the error estimate is on another branch: one of several equilibria, not an error.

Where tissue may fold either way, what it does at twice the spacing may be another true minimum. The distance between
two minima says nothing about the lattice. So where the two solves are far apart the coarse frame is solved once more,
from the shape of the fine one. If it stays there, and its own path led elsewhere, the same constraints on the same
lattice have two equilibria, each found to the tolerance. That is proof, and the one on the fine solve's branch is what
the error of the lattice is taken from.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch
from lappet.daemon.frame_solver import Connect, FrameRefusedError, FrameSolver, SolverDiedError
from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import Program

# Chosen: two converged frames of one lattice are different equilibria where a point of theirs is this many spacings
# apart; the one from the fine shape counts where it is so much nearer to the fine frame than the one of the path.
DIFFERENT, NEARER = 0.1, 0.5
# Vertices that a node takes the way to the fine shape from. A spacing between their displacements counts like so many
# spacings between their places: that tells the sides of a wound apart.
NEIGHBORS, APART = 8, 10.0
# Vertices of a surface that has more are thinned out: nodes of the coarse lattice lie wider apart.
MOST_VERTICES, CHUNK = 5000, 512


@dataclass(frozen=True, eq=False)
class OtherBranch:
    """What was found where the coarse solve's path leads to another equilibrium than the fine one's.

    Parameters
    ----------
    frame
        The coarse frame on the branch of the fine one.
    distance
        Greatest distance between the two coarse equilibria over the surface in mm.
    place
        Rest point of the surface in mm where that is.
    """

    frame: SolvedFrame
    distance: float
    place: tuple[float, float, float]


def other_branches(
    program: Program,
    fine: Mapping[int, SolvedFrame],
    coarse: Mapping[int, SolvedFrame],
    connect: Connect,
) -> dict[int, OtherBranch]:
    """Find the frames whose coarse solve is on another branch than the fine one.

    Each takes one coarse frame. What cannot be solved, or a solver that dies or is stopped, ends in no finding.

    Parameters
    ----------
    program
        The coarse program.
    fine
        Frames of the program by their index, those that are in doubt.
    coarse
        The frames of the coarse program with the same indices, with their states.
    connect
        Makes the solver.

    Returns
    -------
    dict[int, OtherBranch]
        The findings by index.
    """
    found: dict[int, OtherBranch] = {}
    doubted = sorted(index for index in fine if index in coarse and coarse[index].state is not None)
    if not doubted:
        return found
    try:
        session = connect(program.settings, program.bones)
        try:
            _search(session, program, doubted, fine, coarse, found)
        finally:
            session.close()
    except (FrameRefusedError, SolverDiedError, KeyboardInterrupt):
        return found
    return found


def _search(
    session: FrameSolver,
    program: Program,
    doubted: Sequence[int],
    fine: Mapping[int, SolvedFrame],
    coarse: Mapping[int, SolvedFrame],
    found: dict[int, OtherBranch],
) -> None:
    at, near = None, Neighbors.of(np.zeros((0, 3)), np.zeros((1, 3)))
    for index in doubted:
        constraints = program.frames[index]
        here = next(i for i, epoch in enumerate(program.epochs) if epoch.index == constraints.epoch)
        epoch = program.epochs[here]
        if constraints.epoch != at:
            _, rest = session.set_epoch_with_nodes(epoch, program.grips[here], program.landmarks_at[here])
            at, near = constraints.epoch, Neighbors.of(rest, np.asarray(epoch.surface.points, float))
        path, target = coarse[index], fine[index]
        assert path.state is not None
        if len(path.state.nodes) != len(near.vertices) or path.points.shape != target.points.shape:
            continue
        nodes = path.state.nodes + way_to(epoch, near, path, target, program.settings.spacing)
        nodes = nodes.astype(path.state.nodes.dtype)
        no_motion = np.zeros((0, 3), np.float32)
        session.set_state(replace(path.state, nodes=nodes, stability=np.zeros(0), motion=no_motion))
        again = session.solve(constraints, lambda _: None)
        branch = judged(epoch, path, again, target, program.settings.spacing)
        if branch is not None:
            found[index] = branch


@dataclass(frozen=True, eq=False)
class Neighbors:
    """The vertices of a surface that are nearest to the nodes of a lattice, at rest.

    Parameters
    ----------
    vertices
        Their indices, shape (N, k).
    distance
        How far they are in mm, shape (N, k).
    """

    vertices: NDArray[np.intp]
    distance: NDArray[np.float64]

    @classmethod
    def of(cls, nodes: NDArray[np.float64], points: NDArray[np.float64]) -> Neighbors:
        """Find the `NEIGHBORS` nearest vertices of each node.

        Parameters
        ----------
        nodes
            Nodes at rest in mm, shape (N, 3).
        points
            Vertices at rest in mm, shape (n, 3).

        Returns
        -------
        Neighbors
            What was found.
        """
        kept = np.arange(0, len(points), max(1, -(-len(points) // MOST_VERTICES)))
        count = min(NEIGHBORS, len(kept))
        found = np.zeros((len(nodes), count), np.intp)
        distance = np.zeros((len(nodes), count))
        # |a - b|^2 = |a|^2 - 2 a.b + |b|^2, of which |a|^2 does not change which b are near
        center = points[kept].mean(axis=0)
        around = points[kept] - center
        squares = np.sum(around**2, axis=1)
        for first in range(0, len(nodes), CHUNK):
            some = slice(first, first + CHUNK)
            apart = squares - 2.0 * (nodes[some] - center) @ around.T
            nearest = kept[np.argpartition(apart, count - 1, axis=1)[:, :count]]
            found[some] = nearest
            distance[some] = np.linalg.norm(nodes[some, None, :] - points[nearest], axis=2)
        return cls(found, distance)


def way_to(
    epoch: Epoch, near: Neighbors, path: SolvedFrame, target: SolvedFrame, spacing: float
) -> NDArray[np.float64]:
    """Interpolate the way from one shape of a surface to another at the nodes of its lattice.

    Parameters
    ----------
    epoch
        The epoch with the surface.
    near
        Vertices near each node.
    path
        The shape at its vertices, and the state at the nodes.
    target
        The other shape at its vertices.
    spacing
        Lattice spacing in mm.

    Returns
    -------
    NDArray[np.float64]
        Displacements in mm, shape (N, 3).
    """
    assert path.state is not None
    points = np.asarray(epoch.surface.points, float)
    moved, way = np.asarray(path.points, float) - points, np.asarray(target.points, float) - path.points
    apart = APART * np.linalg.norm(moved[near.vertices] - path.state.nodes[:, None, :], axis=2)
    weight = 1.0 / (near.distance**2 + apart**2 + (0.1 * spacing) ** 2)
    weight /= weight.sum(axis=1, keepdims=True)
    shared: NDArray[np.float64] = np.einsum("nk,nki->ni", weight, way[near.vertices])
    return shared


def judged(
    epoch: Epoch, path: SolvedFrame, again: SolvedFrame, target: SolvedFrame, spacing: float
) -> OtherBranch | None:
    """Judge whether two frames of a lattice are different equilibria, the second on the branch of a third frame.

    Parameters
    ----------
    epoch
        The epoch with the surface.
    path
        The frame that the path led to.
    again
        The frame from the shape of the third.
    target
        The third frame, of a finer lattice.
    spacing
        Lattice spacing of the first two in mm.

    Returns
    -------
    OtherBranch | None
        What was found, or None.
    """
    if not (path.converged and again.converged):
        return None
    apart = np.linalg.norm(again.points - path.points, axis=1)
    at = int(np.argmax(apart))
    before, after = (np.linalg.norm(each.points - target.points, axis=1).max() for each in (path, again))
    if not (apart[at] > DIFFERENT * spacing and after < NEARER * before):
        return None
    x, y, z = (float(each) for each in epoch.surface.points[at])
    return OtherBranch(again, float(apart[at]), (x, y, z))
