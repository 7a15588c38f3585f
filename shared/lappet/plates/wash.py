"""A soft shading below the lines, as an image: light on the tissue and shadow in the depth of wounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter, zoom

from lappet.drawing.quantity_scale import ramp_display
from lappet.plates.filled_areas import PIXEL, AreaKind, corner_weights
from lappet.plates.panel_drawing import PanelDrawing
from lappet.plates.smooth_normals import smooth_normals

_AMBIENT = 0.55
_FACET = 1.8  # mm on paper: what is smaller on the surface throws no light of its own
_SOFT = 2.0  # pixels by which light is blurred
_OUTLINE = 0.8  # pixels by which the outlines of areas are smoothed
_HALO = 1.6  # mm on paper: how far from an edge its shadow reaches
_SHADOW = 0.30  # of the light that a place deep in a wound loses
_CONTRAST = 1.3  # power of the light: a little more than one models a face, which is lit from everywhere
_WARM = (0.8, 1.08, 1.25)  # powers of the light in red, green and blue: the shadows of skin are warmer than its lights
_LIT = 90.0  # percent of the skin that is darker than its own color
_DEEP = 4.0  # mm below what is around it at which it has lost nearly all of that


def wash(
    drawing: PanelDrawing,
    towards: NDArray[np.float64],
    fills: dict[AreaKind, str],
    goes_on: bool,
    dpi: float,
    full: float = 1.0,
) -> NDArray[np.uint8]:
    """Shade a panel.

    The shadows of depth are those of an unsharp mask of the depth buffer (Luft, Colditz and Deussen 2006).

    Parameters
    ----------
    drawing
        The panel.
    towards
        Unit vector towards the light, shape (3,).
    fills
        Color of each kind of area, #rrggbb.
    goes_on
        Whether skin is drawn where nothing is seen.
    dpi
        Pixels of the image per inch.
    full
        Value at the top of the scale of what is mapped.

    Returns
    -------
    NDArray[np.uint8]
        The image, RGB, shape (h, w, 3), first row on top.
    """
    pixels = drawing.pixels
    shape = pixels.kind.shape
    seen = (pixels.kind >= 0) & (pixels.triangle >= 0)
    shade = np.ones(shape)
    shade[seen] = _AMBIENT + (1.0 - _AMBIENT) * np.clip(_facing(drawing, seen, towards), 0.0, 1.0)
    beside = tuple(_nearest(seen)) if seen.any() else (slice(None),)
    shade = gaussian_filter(shade[beside], _SOFT)
    # What lies flat before the camera throws no shadow, neither at the panel's border nor where a cut-out ends.
    depth = _above_slope(pixels.depth, seen)[beside]
    around = _blurred(depth, _HALO / PIXEL)
    shade = shade * (1.0 - _SHADOW * np.tanh(np.clip(depth - around, 0.0, None) / _DEEP * 2.0))
    palette = np.array([[int(fills[kind][k : k + 2], 16) for k in (1, 3, 5)] for kind in AreaKind], np.float64)
    level = np.percentile(shade[pixels.kind == 0], _LIT) if (pixels.kind == 0).any() else 1.0
    shade = np.clip(shade / max(float(level), 1e-6), 0.0, 1.08) ** _CONTRAST
    shade = shade[beside] if goes_on and drawing.pixels.quantity is None else np.where(seen, shade, 1.0)
    shade[pixels.kind == tuple(AreaKind).index(AreaKind.HOLLOW)] = 1.0
    factor = dpi / 25.4 * PIXEL
    kinds = np.where(seen, pixels.kind, -1)
    mapped = drawing.pixels.quantity
    ground = palette[0] if goes_on and mapped is None else np.full(3, 255.0)
    color = _colored(kinds, palette, ground, factor)
    if mapped is not None:
        known = np.isfinite(mapped)
        hue = np.zeros((*shape, 3))
        hue[known] = 255.0 * ramp_display(np.abs(mapped[known]) / full)
        share = _crisp(known, factor)[..., None]
        color = share * _enlarged(hue[tuple(_nearest(known))] if known.any() else hue, factor) + (1.0 - share) * color
    grey = mapped is not None or np.ptp(palette[0]) == 0.0
    light = _enlarged(shade, factor)[..., None] ** (np.ones(3) if grey else np.array(_WARM))
    return np.clip(np.rint(color * light), 0, 255).astype(np.uint8)


def _colored(
    kinds: NDArray[np.int64], palette: NDArray[np.float64], ground: NDArray[np.float64], factor: float
) -> NDArray[np.float64]:
    """Colors of areas by their kinds (h, w), with smooth outlines, at `factor` times as many pixels, (H, W, 3)."""
    present = np.unique(kinds)
    shares = np.stack([_crisp(kinds == kind, factor) for kind in present])
    shares /= np.maximum(shares.sum(axis=0), 1e-9)
    colors = np.stack([ground if kind < 0 else palette[kind] for kind in present])
    colored: NDArray[np.float64] = np.einsum("khw,kc->hwc", shares, colors)
    return colored


def _crisp(mask: NDArray[np.bool_], factor: float) -> NDArray[np.float64]:
    """How much of each pixel an area covers whose outline is traced between the pixels of a mask."""
    soft = _enlarged(gaussian_filter(mask.astype(np.float64), _OUTLINE, mode="nearest"), factor)
    # Across a straight outline a blurred mask rises by 1 / (sigma sqrt(2 pi)) in a pixel.
    return np.clip(0.5 + (soft - 0.5) * factor * _OUTLINE * np.sqrt(2.0 * np.pi), 0.0, 1.0)


def _enlarged(values: NDArray[np.float64], factor: float) -> NDArray[np.float64]:
    """Values (h, w) or (h, w, c) at `factor` times as many pixels."""
    if values.ndim == 3:
        return np.stack([_enlarged(values[..., k], factor) for k in range(values.shape[-1])], axis=-1)
    return np.asarray(zoom(values, factor, order=1, mode="nearest"))


def _nearest(there: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each pixel the indices of the nearest one that is there, (2, h, w)."""
    return np.asarray(distance_transform_edt(~there, return_distances=False, return_indices=True))


def _facing(drawing: PanelDrawing, seen: NDArray[np.bool_], light: NDArray[np.float64]) -> NDArray[np.float64]:
    """How much the surface faces the light at the pixels that show it, between the corners of its triangles, (k,)."""
    pixels, surface = drawing.pixels, drawing.surface
    corners = np.einsum("mki,i->mk", smooth_normals(surface, _FACET / drawing.projection.scale), light)
    triangle = pixels.triangle[seen]
    places = np.stack(np.meshgrid(pixels.x, pixels.y), axis=-1)[seen]
    weights = np.clip(corner_weights(surface, drawing.projection, triangle, places), 0.0, 1.0)
    weights /= weights.sum(axis=1, keepdims=True)
    facing: NDArray[np.float64] = (weights * corners[triangle]).sum(axis=1)
    return facing


def _blurred(values: NDArray[np.float64], sigma: float) -> NDArray[np.float64]:
    """Values by a Gaussian of `sigma` pixels; beyond the border they go on as they come to it, (h, w)."""
    beyond = int(np.ceil(4.0 * sigma))
    wide = gaussian_filter(np.pad(values, beyond, mode="reflect", reflect_type="odd"), sigma)
    return np.asarray(wide[beyond:-beyond, beyond:-beyond])


def _above_slope(depth: NDArray[np.float64], seen: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Depths less the plane that fits those that are seen best; 0 where nothing is seen, (h, w)."""
    rows, columns = np.nonzero(seen)
    found = np.zeros(depth.shape)
    if len(rows):
        terms = np.stack([np.ones(len(rows)), rows, columns], axis=1)
        found[seen] = depth[seen] - terms @ np.linalg.lstsq(terms, depth[seen], rcond=None)[0]
    return found
