"""The first picture of a film: its title, and below it the steps that it shows."""

from __future__ import annotations

from collections.abc import Sequence

import drawsvg

from lappet.plates.page_ground import PageGround
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_style import PlateStyle

_TITLE = 2.2  # times the size of captions
_LINE = 1.45  # times the size of a line
_SHARE = 0.8  # of the width


def title_card(
    title: str,
    steps: Sequence[str],
    size: tuple[float, float],
    style: PlateStyle,
    font: PlateFont,
    ground: PageGround,
) -> str:
    """Write a title card as SVG.

    Parameters
    ----------
    title
        The title.
    steps
        Captions of the steps; those that there is no room for are left out.
    size
        Width and height in mm.
    style
        How the film looks.
    font
        Its font.
    ground
        Colors of the ground and of what is written on it.

    Returns
    -------
    str
        The document, in mm.
    """
    small, large = style.caption_size, _TITLE * style.caption_size
    lines = font.wrapped(title, large, _SHARE * size[0])
    numbered = [f"{k}   {step}" for k, step in enumerate(steps, 1)]
    room = int((0.86 * size[1] - _LINE * large * len(lines)) / (_LINE * small)) - 1
    numbered = numbered[: max(room, 0)]
    height = _LINE * (large * len(lines) + small * (len(numbered) + bool(numbered)))
    top = 0.5 * (size[1] - height)
    left = 0.5 * (size[0] - max(font.width(each, large) for each in lines))
    left = min(left, 0.5 * (size[0] - max((font.width(each, small) for each in numbered), default=0.0)))
    drawing = drawsvg.Drawing(*size, id_prefix="t")
    if ground.paper:
        drawing.append(drawsvg.Rectangle(0, 0, *size, fill=ground.paper))
    family = f"'{font.family}', 'Source Sans 3', Arial, sans-serif"
    for line in lines:
        top += _LINE * large
        drawing.append(drawsvg.Text(line, round(large, 3), round(left, 3), round(top, 3), **_font(family, ground.ink)))
    top += 0.6 * _LINE * small
    for line in numbered:
        top += _LINE * small
        drawing.append(
            drawsvg.Text(line, round(small, 3), round(left, 3), round(top, 3), **_font(family, ground.quiet))
        )
    svg = str(drawing.as_svg(header=""))
    width, high = (f"{each:.3f}" for each in size)
    return svg.replace(svg[: svg.index(">") + 1], _head(width, high), 1)


def _head(width: str, height: str) -> str:
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f'width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}">'
    )


def _font(family: str, color: str) -> dict[str, str]:
    return {"font_family": family, "fill": color}
