"""The curves of the presets, drawn against the published ones."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from lappet.core.durable import write_whole
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.tissue.presets import PRESETS, Preset
from lappet.tissue.uniaxial import curve

_IN_VIVO = ("skin", "young_skin", "old_skin", "scar")
_FITTED = ("dermis", "galea", "muscle", "tarsus")
_COLORS = ("#c1272d", "#0b6e4f", "#1f4e8c", "#8a5a00")
_LAST = 1.5


def plot_tissues(path: Path) -> None:
    """Draw the presets' curves: skins in vivo in one field, each preset that was fitted to a curve in its own.

    Parameters
    ----------
    path
        The picture.

    Raises
    ------
    RefusedError
        If matplotlib is missing.
    """
    try:
        import matplotlib as mpl

        mpl.use("Agg")
        from matplotlib import pyplot
    except ImportError as error:
        raise refused(
            ProblemCode.REPORT_NEEDS, "", error, what="A plot", package="matplotlib", extra="report"
        ) from error
    figure, fields = pyplot.subplots(2, 3, figsize=(11.0, 6.4), layout="constrained")
    _skins(fields[0, 0])
    for axes, name in zip(fields.ravel()[1:], (*_FITTED, "cartilage"), strict=True):
        _one(axes, name, PRESETS[name])
    figure.supxlabel("stretch")
    figure.supylabel("nominal stress")
    drawn = io.BytesIO()
    figure.savefig(drawn, format=path.suffix[1:], dpi=110)
    write_whole(path, drawn.getvalue())
    pyplot.close(figure)


def _skins(axes: Any) -> None:
    stretches = np.linspace(1.0, _LAST, 101)
    for name, color in zip(_IN_VIVO, _COLORS, strict=True):
        material = PRESETS[name].unstretched
        axes.plot(stretches, curve(material, stretches), color=color, lw=1.6, label=name.replace("_", " "))
        axes.plot(stretches, curve(material, stretches, axis=1), ":", color=color, lw=1.2)
    axes.plot([], [], ":", color="black", label="across the fibers")
    axes.set_ylim(0.0, 200.0)
    _finish(axes, "skins, kPa")


def _one(axes: Any, name: str, preset: Preset) -> None:
    found = preset.published
    last = found.last if found else 1.35
    stretches = np.linspace(1.0, last, 101)
    axes.plot(stretches, curve(preset.unstretched, stretches) / 1e3, color="black", lw=1.8, label="along the fibers")
    if preset.unstretched.has_fibers:
        across = curve(preset.unstretched, stretches, axis=1) / 1e3
        axes.plot(stretches, across, ":", color="black", lw=1.2, label="across")
    if found is not None:
        ends = np.array([found.knee, found.last])
        slope = (ends - found.knee) * found.terminal_slope / 1e3
        axes.plot(ends, slope, "--", color=_COLORS[0], lw=1.4, label=found.source)
        if found.initial_slope is not None:
            first = np.array([1.0, found.knee])
            axes.plot(first, (first - 1.0) * found.initial_slope / 1e3, "--", color=_COLORS[0], lw=1.4)
    else:
        axes.plot([1.0, last], [0.0, (last - 1.0) * 3.01], "--", color=_COLORS[0], lw=1.4, label="Richmon 2005")
    _finish(axes, f"{name}, MPa")


def _finish(axes: Any, title: str) -> None:
    axes.set_title(title, fontsize=10)
    axes.set_xlim(left=1.0)
    axes.set_ylim(bottom=0.0)
    axes.grid(True, color="0.9", lw=0.8)
    axes.legend(fontsize=8, frameon=False, loc="upper left")
