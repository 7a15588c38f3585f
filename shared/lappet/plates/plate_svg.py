"""A page as SVG: lines, labels, arrows and measures as vectors in named layers, text as text, shading as an image.

Numbers are rounded to a micrometer, so that the same page gives the same bytes.
"""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import drawsvg
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.quantity_scale import ramp_display
from lappet.plates.feature_lines import LineKind
from lappet.plates.filled_areas import Area, AreaKind
from lappet.plates.page_ground import WHITE, PageGround
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import PlatePage
from lappet.plates.plate_panel import LINE, PagePanel
from lappet.plates.plate_style import PAINTED, POINT, PlateStyle, Shading
from lappet.plates.wash import wash

_INK = "#111111"
_HALO = "#ffffff"
_GHOST = "#5a6068"
_FINE = 0.5 * POINT  # the least width of a line in print
_SITE = 0.35  # mm: radius of the dot at which a leader ends
_HEAD = 2.2  # mm: length of an arrow's head
_DIGITS = 3
_LAYERS = (
    "shading",
    "areas",
    "ghosts",
    "hatching",
    "lines",
    "threads",
    "instruments",
    "arrows",
    "measures",
    "letters",
    "labels",
)


def plate_svg(
    page: PlatePage,
    style: PlateStyle,
    font: PlateFont,
    dpi: float,
    ground: PageGround = WHITE,
    paintings: Mapping[int, bytes] = MappingProxyType({}),
    carries_font: bool = True,
) -> str:
    """Write a page as SVG.

    Parameters
    ----------
    page
        The page.
    style
        How it looks.
    font
        Its font.
    dpi
        Pixels per inch of shading.
    ground
        Color of the paper and of captions.
    paintings
        By the index of a panel, the PNG that lies below its lines.
    carries_font
        Whether the part of the font that is needed is embedded, which takes a second: whoever sets it as pixels or as
        PDF has the font itself.

    Returns
    -------
    str
        The document, in mm.
    """
    drawing = drawsvg.Drawing(*page.size, id_prefix="d")
    for group in _layers(page, style, font, dpi, ground, paintings):
        drawing.append(group)
    svg = str(drawing.as_svg(header=""))
    begin, end = svg.index("<svg"), svg.index(">", svg.index("<svg"))
    width, height = (f"{each:.{_DIGITS}f}" for each in page.size)
    head = (
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}" '
        f'role="img" aria-label="{_plain(page.alt)}"'
    )
    title, face = f"<title>{_plain(page.alt)}</title>", ""
    if carries_font:
        source = font.embedded(page.texts())
        face = f"<style>@font-face{{font-family:'{font.family}';src:url({source})}}</style>"
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + svg[:begin] + head + ">" + title + face + svg[end + 1 :]


def _plain(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


def _layers(
    page: PlatePage,
    style: PlateStyle,
    font: PlateFont,
    dpi: float,
    ground: PageGround,
    paintings: Mapping[int, bytes],
) -> list[drawsvg.DrawingElement]:
    layers = {name: _layer(name) for name in _LAYERS}
    captions = _layer("captions")
    defs = []
    for k, panel in enumerate(page.panels):
        tag = panel.letter or f"inset{k}"
        clip = drawsvg.ClipPath(id=f"panel{tag}")
        clip.append(drawsvg.Rectangle(*_round(-0.5 * np.asarray(panel.size)), *_round(panel.size)))
        defs.append(clip)
        groups = {name: drawsvg.Group(transform=_at(panel.middle), id=f"{name}-{tag}") for name in _LAYERS}
        for name in ("shading", "areas", "ghosts"):
            groups[name] = drawsvg.Group(transform=_at(panel.middle), id=f"{name}-{tag}", clip_path=f"url(#{clip.id})")
        bare = panel.line is not None and not panel.goes_on  # an inset over what its panel shows
        if bare or (style.shading is Shading.NONE and ground.paper not in ("", WHITE.paper)):
            corner, size = _round(-0.5 * np.asarray(panel.size)), _round(panel.size)
            groups["areas"].append(drawsvg.Rectangle(*corner, *size, fill=WHITE.paper))
        painting = paintings.get(k)
        if painting is None:
            _shade(groups, panel, page, style, dpi)
        else:
            groups["shading"].append(_picture(panel, painting))
        for area in panel.drawing.ghosts:
            groups["ghosts"].append(_filled(area, _GHOST, fill_opacity=0.3))
        _draw_lines(groups, panel, style, painting is not None)
        _annotate(groups, panel, page, style, font)
        for name, group in groups.items():
            if group.children:
                layers[name].append(group)
        if panel.line is None:
            captions.append(_caption(panel, style, font, ground.ink))
        else:
            _frame(groups["measures"], panel)
    paper = [drawsvg.Rectangle(0, 0, *_round(page.size), fill=ground.paper)] if ground.paper else []
    return [*defs, *paper, *(layers[name] for name in _LAYERS if layers[name].children), captions]


def _layer(name: str) -> drawsvg.Group:
    return drawsvg.Group(id=f"layer-{name}", **{"inkscape:groupmode": "layer", "inkscape:label": name})


def _at(place: NDArray[np.float64]) -> str:
    x, y = _round(place)
    return f"translate({x},{y})"


def _round(values: Any) -> list[float]:
    return [float(each) for each in np.round(np.asarray(values, np.float64).ravel(), _DIGITS) + 0.0]


def _at_least(length: float) -> float:
    """A length rounded up, so that what is as fine as print allows does not come out finer."""
    return math.ceil(length * 10**_DIGITS - 1e-6) / 10**_DIGITS


def _shade(groups: dict[str, drawsvg.Group], panel: PagePanel, page: PlatePage, style: PlateStyle, dpi: float) -> None:
    if page.key or style.shading is Shading.WASH:
        from PIL import Image

        picture = wash(panel.drawing, panel.scene.light, style.fills, panel.goes_on, dpi, page.full)
        buffer = io.BytesIO()
        Image.fromarray(picture).save(buffer, "PNG")
        groups["shading"].append(_picture(panel, buffer.getvalue()))
    elif style.shading is not Shading.NONE:
        if panel.goes_on:
            corner, size = _round(-0.5 * np.asarray(panel.size)), _round(panel.size)
            groups["areas"].append(drawsvg.Rectangle(*corner, *size, fill=style.fills[AreaKind.SKIN]))
        for area in panel.drawing.areas:
            groups["areas"].append(_filled(area, style.fills[area.kind]))


def _picture(panel: PagePanel, png: bytes) -> drawsvg.Image:
    """A picture that fills a panel."""
    data = "data:image/png;base64," + base64.b64encode(png).decode()
    corner, size = _round(-0.5 * np.asarray(panel.size)), _round(panel.size)
    return drawsvg.Image(*corner, *size, path=data, preserveAspectRatio="none")


def _filled(area: Area, color: str, **more: Any) -> drawsvg.Path:
    path = drawsvg.Path(fill=color, fill_rule="evenodd", **more)
    for ring in area.rings:
        points = np.round(ring, _DIGITS) + 0.0
        path.M(*points[0].tolist())
        for point in points[1:]:
            path.L(*point.tolist())
        path.Z()
    return path


_LAYER_OF = {
    LineKind.HATCHING: "hatching",
    LineKind.THREAD: "threads",
    LineKind.INSTRUMENT: "instruments",
}


def _draw_lines(groups: dict[str, drawsvg.Group], panel: PagePanel, style: PlateStyle, painted: bool) -> None:
    for stroke in panel.drawing.strokes:
        if painted and stroke.kind in PAINTED:
            continue
        pen = style.pens[stroke.kind]
        group = groups[_LAYER_OF.get(stroke.kind, "lines")]
        more = {"stroke_dasharray": ",".join(f"{each:g}" for each in pen.dashes)} if pen.dashes else {}
        group.append(_line(stroke.points, pen.width, pen.color, **more))
        if stroke.kind is LineKind.INSTRUMENT:  # steel: a light core
            group.append(_line(stroke.points, 0.4 * pen.width, "#f2f4f6"))


def _line(points: NDArray[np.float64], width: float, color: str, **more: Any) -> drawsvg.Lines:
    return drawsvg.Lines(
        *_round(points),
        fill="none",
        stroke=color,
        stroke_width=_at_least(max(width, _FINE)),
        stroke_linecap="round",
        stroke_linejoin="round",
        **more,
    )


def _annotate(
    groups: dict[str, drawsvg.Group], panel: PagePanel, page: PlatePage, style: PlateStyle, font: PlateFont
) -> None:
    for way in (*panel.drawing.arrows, *panel.notes.arrows):
        _arrow(groups["arrows"], way, style.accent)
    for at in panel.notes.pivots:
        _pivot(groups["arrows"], at, style.accent)
    # Those of the user may lie on dark wounds.
    for measure in (*(panel.measures if style.dark else ()), *panel.notes.measures):
        if len(measure.arc):
            groups["measures"].append(_line(measure.arc, 2.0 * _FINE + 0.25, _HALO))
    for measure in (*panel.measures, *panel.notes.measures):
        if len(measure.arc):
            groups["measures"].append(_line(measure.arc, _FINE, _INK))
        groups["measures"].append(_text(measure.text, measure.at, style.label_size, font, "middle"))
    for letter in panel.drawing.letters:
        groups["letters"].append(_text(letter.text, letter.at, style.letter_size, font, "middle", style="italic"))
    for label in (*panel.labels, *panel.notes.placed):
        groups["labels"].append(_line(np.stack([label.port, label.site]), 1.6 * _FINE + 0.25, _HALO))
        groups["labels"].append(_line(np.stack([label.port, label.site]), _FINE, _INK))
        groups["labels"].append(drawsvg.Circle(*_round(label.site), _SITE, fill=_INK))
        gap = 0.4 * LINE * style.label_size * (-1.0 if label.left else 1.0)
        at = label.port + np.array([gap, 0.0])
        groups["labels"].append(_text(label.text, at, style.label_size, font, "end" if label.left else "start"))
    if page.key and panel is [each for each in page.panels if each.line is None][-1]:
        _key(groups["measures"], page, style, font)
    if panel.bar:
        _bar(groups["measures"], panel, style, font)


def _frame(group: drawsvg.Group, panel: PagePanel) -> None:
    """The frame of an inset and the line to what it shows; coordinates are from the inset's middle."""
    corner, size = _round(-0.5 * np.asarray(panel.size)), _round(panel.size)
    if panel.line is not None and len(panel.line):
        way = panel.line - panel.middle
        group.append(_line(way, 1.6 * _FINE + 0.25, _HALO))
        group.append(_line(way, _FINE, _INK))
        group.append(drawsvg.Circle(*_round(way[-1]), _SITE, fill=_INK))
    group.append(drawsvg.Rectangle(*corner, *size, fill="none", stroke=_HALO, stroke_width=1.2))
    group.append(drawsvg.Rectangle(*corner, *size, fill="none", stroke=_INK, stroke_width=_at_least(_FINE)))


def _pivot(group: drawsvg.Group, at: NDArray[np.float64], color: str) -> None:
    """The point about which a flap turns: a dot in a ring."""
    group.append(drawsvg.Circle(*_round(at), 1.3, fill="none", stroke=_HALO, stroke_width=0.9))
    group.append(drawsvg.Circle(*_round(at), 1.3, fill="none", stroke=color, stroke_width=0.4))
    group.append(drawsvg.Circle(*_round(at), 0.45, fill=color))


def _arrow(group: drawsvg.Group, way: NDArray[np.float64], color: str) -> None:
    """An arrow with a white border, so that it is seen on any ground."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    neck = max(float(along[-1]) - 0.8 * _HEAD, 0.5 * float(along[-1]))
    shaft = np.vstack([way[along < neck], [np.interp(neck, along, way[:, k]) for k in (0, 1)]])
    tip = way[-1]
    back = shaft[-1] - tip
    back /= max(float(np.linalg.norm(back)), 1e-9)
    side = np.array([-back[1], back[0]])
    head = np.stack([tip, tip + _HEAD * back + 0.38 * _HEAD * side, tip + _HEAD * back - 0.38 * _HEAD * side])
    group.append(_line(shaft, 1.3, _HALO))
    group.append(drawsvg.Lines(*_round(head), close=True, fill=_HALO, stroke=_HALO, stroke_width=0.7))
    group.append(_line(shaft, 0.6, color))
    group.append(drawsvg.Lines(*_round(head), close=True, fill=color))


def _bar(group: drawsvg.Group, panel: PagePanel, style: PlateStyle, font: PlateFont) -> None:
    length = panel.bar * panel.drawing.projection.scale
    right, bottom = 0.5 * panel.size[0] - 1.5, 0.5 * panel.size[1] - 1.5
    bar = np.array([[right - length, bottom], [right, bottom]])
    group.append(_line(bar, 1.0, _HALO))
    group.append(_line(bar, 0.5, _INK))
    at = np.array([right - 0.5 * length, bottom - 0.75 * style.label_size])
    group.append(_text(f"{panel.bar:g} mm", at, style.label_size, font, "middle"))


def _key(group: drawsvg.Group, page: PlatePage, style: PlateStyle, font: PlateFont) -> None:
    """The color key of a map, in the lower left of a panel."""
    size = style.label_size
    left, bottom = -0.5 * page.panel[0] + 2.0, 0.5 * page.panel[1] - 1.5 - LINE * size
    width, height, count = 0.36 * page.panel[0], 1.8, 36
    colors = np.rint(255.0 * ramp_display(np.linspace(0.0, 1.0, count))).astype(int)
    for k, color in enumerate(colors):
        corner = _round((left + k * width / count, bottom - height))
        fill = "#" + "".join(f"{each:02x}" for each in color)
        group.append(drawsvg.Rectangle(*corner, *_round((1.05 * width / count, height)), fill=fill))
    name, low, top = page.key
    group.append(_text(name, np.array([left, bottom - height - 0.8 * size]), size, font, "start"))
    group.append(_text(low, np.array([left, bottom + 0.7 * size]), size, font, "start"))
    group.append(_text(top, np.array([left + width, bottom + 0.7 * size]), size, font, "end"))


def _caption(panel: PagePanel, style: PlateStyle, font: PlateFont, ink: str) -> drawsvg.Group:
    group = drawsvg.Group(id=f"caption-{panel.letter}")
    size = style.caption_size
    left = panel.middle[0] - 0.5 * panel.size[0]
    top = panel.middle[1] + 0.5 * panel.size[1] + 1.5 + 0.5 * LINE * size
    indent = font.width("M", size) + 1.5 if panel.letter else 1.5
    if panel.letter:
        at = np.array([left, top])
        group.append(_text(panel.letter, at, size, font, "start", halo=False, weight="bold", color=ink))
    for k, line in enumerate(panel.caption):
        at = np.array([left + indent, top + k * LINE * size])
        group.append(_text(line, at, size, font, "start", halo=False, color=ink))
    return group


def _text(
    text: str,
    at: Sequence[float] | NDArray[np.float64],
    size: float,
    font: PlateFont,
    anchor: str,
    halo: bool = True,
    style: str = "",
    weight: str = "",
    color: str = _INK,
) -> drawsvg.DrawingElement:
    """A line of text whose middle height is at a place; a halo is a copy of it in white below."""
    x, y = at[0], at[1] + 0.34 * size
    shared: dict[str, Any] = {
        "font_family": f"'{font.family}', 'Source Sans 3', Arial, sans-serif",
        "text_anchor": anchor,
        **({"font_style": style} if style else {}),
        **({"font_weight": weight} if weight else {}),
    }
    place = _round((x, y))
    words = drawsvg.Text(text, _at_least(size), *place, fill=color, **shared)
    if not halo:
        return words
    group = drawsvg.Group()
    white = {"stroke": _HALO, "stroke_width": round(0.3 * size, _DIGITS), "stroke_linejoin": "round"}
    group.append(drawsvg.Text(text, _at_least(size), *place, fill=_HALO, aria_hidden="true", **white, **shared))
    group.append(words)
    return group
