"""What is drawn on a panel that its labels should leave free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.plates.feature_lines import LineKind
from lappet.plates.filled_areas import AreaKind
from lappet.plates.panel_drawing import PanelDrawing
from lappet.plates.strokes import sampled

_KINDS = tuple(AreaKind)
_KEEP_OFF = (
    *(LineKind.PLAN, LineKind.THREAD, LineKind.WOUND_EDGE, LineKind.INSTRUMENT),
    *(LineKind.UNDERMINED, LineKind.THINNED, LineKind.DISSECTION),
)


def taken_places(drawing: PanelDrawing) -> NDArray[np.float64]:
    """Find places that labels should leave free: wounds, marks, threads and letters.

    Parameters
    ----------
    drawing
        A panel.

    Returns
    -------
    NDArray[np.float64]
        The places in mm, shape (k, 2).
    """
    kinds = drawing.pixels.kind[::6, ::6]
    rows, columns = np.nonzero((kinds > _KINDS.index(AreaKind.SKIN)) & (kinds < _KINDS.index(AreaKind.EYE)))
    found = [np.stack([drawing.pixels.x[::6][columns], drawing.pixels.y[::6][rows]], axis=1)]
    found += [sampled(stroke.points, 1.0) for stroke in drawing.strokes if stroke.kind in _KEEP_OFF]
    found += [letter.at[None] for letter in drawing.letters]
    return np.vstack(found)
