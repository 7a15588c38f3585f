"""What an epoch's lattice has, as the daemon counts it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LatticeCounts:
    """What an epoch's lattice has.

    Parameters
    ----------
    fine_voxels
        Fine voxels inside the tissue.
    cells
        Cells.
    grid_cells
        Cells of which the grid has one copy.
    mesh_cells
        Cells of which it has several, one per fragment.
    nodes
        Nodes.
    fragments
        Fragments of the tissue.
    blocks
        Blocks of cells that are computed.
    fixed_nodes
        Nodes that do not move.
    dropped_voxels
        Voxels at sharp tips that nothing holds; they are not among the fine voxels.
    volume
        Volume of the tissue in the cells in mm³.
    bytes
        Memory of the session in bytes.
    seconds
        Time that it took to build.
    """

    fine_voxels: int
    cells: int
    grid_cells: int
    mesh_cells: int
    nodes: int
    fragments: int
    blocks: int
    fixed_nodes: int
    dropped_voxels: int
    volume: float
    bytes: float
    seconds: float
