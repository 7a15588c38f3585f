"""Segments joined into chains that are as long as they can be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def joined_chains(segments: NDArray[np.integer]) -> list[NDArray[np.int64]]:
    """Join segments at the nodes that exactly two of them share.

    Parameters
    ----------
    segments
        The two nodes of each segment, shape (k, 2).

    Returns
    -------
    list[NDArray[np.int64]]
        Chains of nodes; a closed one repeats its first.
    """
    neighbors: dict[int, list[int]] = {}
    for a, b in np.unique(np.sort(segments, axis=1), axis=0):
        neighbors.setdefault(int(a), []).append(int(b))
        neighbors.setdefault(int(b), []).append(int(a))
    degree = {node: len(each) for node, each in neighbors.items()}
    chains = []
    # Ends and crossings first, so that what is left over is closed loops.
    for start in sorted(neighbors, key=lambda node: (degree[node] == 2, node)):
        while neighbors[start]:
            chain = [start]
            while neighbors[chain[-1]]:
                here = chain[-1]
                there = neighbors[here].pop()
                neighbors[there].remove(here)
                chain.append(there)
                if degree[there] != 2:
                    break
            chains.append(np.array(chain, np.int64))
    return chains
