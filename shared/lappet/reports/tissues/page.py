"""The page of the presets: a table for each with parameter, value, source and how it was measured; and their curves."""

from __future__ import annotations

from lappet.bench.tables import markdown_table
from lappet.tissue.presets import CHOSEN, PRESETS, SOURCES, Preset
from lappet.tissue.presets.preset import WORDS
from lappet.tissue.uniaxial import curve_shape

FIGURE = "images/tissue_curves.png"
LAST = 1.4  # stretch at which curves without a published one end
_INTRODUCTION = """# Presets of tissue

`make docs` writes this page from `shared/lappet/tissue/presets/`; `lappet report tissues` draws the figure. *chosen*
means that no measurement was found. [materials.md](materials.md) explains the parameters.

![Nominal stress over stretch of a strip with free sides, along and across the fibers](images/tissue_curves.png)

The curves are Lappet's own solution of its law for a strip with free sides. Where a preset was fitted to a published
curve, dashed lines show that curve as its paper sums it up: the initial slope, and the linear end with its knee, the
stretch at which the end, prolonged, meets the axis.

## Curves

"""
_ELSEWHERE = """
## What was not used

The strips of excised human skin that Gasson and Lapeer (2007, Stud Health Technol Inform p. 143) drew reached 15.3 MPa
along Langer's lines and 3.48 MPa across, a ratio of 4.4; the chosen dispersion gives 2.7 in vivo. Groves et al. (2013,
J Mech Behav Biomed Mater 18:167), Gambarotta et al. (2005) and Flynn et al. (2013) fitted other laws, whose parameters
do not carry over; only what their summaries say of curves and tensions could be used. Lear et al. (2019, J Mech Behav
Biomed Mater 97:85) measured closing forces of scalp wounds that relax by 44 % within 300 s: Lappet has no relaxation.
"""


def tissue_page() -> str:
    """Write the page of the presets.

    Returns
    -------
    str
        The text of docs/tissues.md.
    """
    parts = [_INTRODUCTION + _curves(), *(_section(name, preset) for name, preset in PRESETS.items()), _sources()]
    return "\n".join([*parts, _ELSEWHERE.lstrip("\n")])


def _curves() -> str:
    rows = []
    for name, preset in PRESETS.items():
        published = preset.published
        shape = curve_shape(preset.unstretched, published.last if published else LAST)
        rows.append(
            [
                f"[`{name}`](#{name})",
                _three(shape.initial_slope),
                f"{shape.knee:.2f}" if shape.knee > 1.0 else "none",
                f"{_three(shape.terminal_slope)} at {shape.last:g}",
                "" if published is None else _published(preset),
            ]
        )
    titles = ["preset", "initial slope kPa", "knee", "terminal slope kPa", "published: the same three"]
    return markdown_table(titles, rows)


def _published(preset: Preset) -> str:
    found = preset.published
    if found is None:
        return ""
    first = "–" if found.initial_slope is None else _three(found.initial_slope)
    return f"{first}, {found.knee:.2f}, {_three(found.terminal_slope)} ({found.source})"


def _three(value: float) -> str:
    """Three digits, without an exponent."""
    return f"{float(f'{value:.3g}'):g}"


def _section(name: str, preset: Preset) -> str:
    rows = [[WORDS[value.parameter], value.value, value.source, value.how] for value in preset.values]
    if preset.tension != (0.0, 0.0):
        along, across = preset.material.prestretch
        how = "follows from the tension and the law"
        rows.append(["prestretch", f"{along:g} along, {across:g} across", "", how])
    table = markdown_table(["parameter", "value", "source", "how"], rows)
    return f"## {name}\n\n{preset.summary}\n\n{table}"


def _sources() -> str:
    lines = [f"- **{name}**: {text}." for name, text in SOURCES.items()]
    return "\n".join(["## Sources", "", *lines, f"- **{CHOSEN}**: no measurement was found; the reason is given.", ""])
