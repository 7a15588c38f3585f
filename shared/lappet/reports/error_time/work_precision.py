"""Work–precision plots: error over seconds, log–log, one curve per setting, the default marked."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from lappet.core.durable import write_whole
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.reports.error_time.measurement import CHOICES, DEFAULT, Measure, SceneReport

_COLORS = {"quadrature": "#c1272d", "tolerance": "#0b6e4f", "precision": "#1f4e8c", "preconditioner": "#8a5a00"}
_DASHES = ("--", ":", "-.")
_WORDS = {
    "quadrature": "{} points",
    "tolerance": "tolerance {:g}",
    "precision": "{}",
    "preconditioner": "{}",
    "twoLevel": "two-level",
    "chebyshev": "Chebyshev only",
}


def plot_scene(report: SceneReport, path: Path) -> None:
    """Plot one scene: the root mean square error over the daemon's seconds.

    Curves in color vary one setting from the default; all other combinations are gray.

    Parameters
    ----------
    report
        The scene's report.
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

    figure, axes = pyplot.subplots(figsize=(7.2, 5.0), layout="constrained")
    for curve in curves(report.rows):
        changed = [name for name, value in DEFAULT.items() if getattr(curve[0], name) != value]
        x = [row.seconds for row in curve]
        y = [row.error_mm or 0.0 for row in curve]
        if not changed:
            axes.plot(x, y, "o-", color="black", lw=2.2, ms=7, zorder=5, label="default")
            for row in curve:
                axes.annotate(
                    f"{row.spacing_mm:.3g} mm",
                    (row.seconds, row.error_mm or 0.0),
                    textcoords="offset points",
                    xytext=(-7, -6),
                    ha="right",
                    va="top",
                    fontsize=8,
                )
            estimated = [(row.seconds, row.estimate_mm) for row in curve if row.estimate_mm]
            if estimated:
                axes.plot(*zip(*estimated, strict=True), "x", color="black", ms=7, label="its estimate")
        elif len(changed) == 1:
            name = changed[0]
            value = getattr(curve[0], name)
            others = [each for each in CHOICES[name] if each != DEFAULT[name]]
            label = _WORDS[name].format(_WORDS.get(str(value), value))
            style = _DASHES[others.index(value)]
            axes.plot(x, y, style, marker=".", color=_COLORS[name], lw=1.5, zorder=4, label=label)
        else:
            axes.plot(x, y, "-", color="0.82", lw=0.7, zorder=1)
    uncertain = report.reference.uncertainty
    axes.axhspan(1e-12, max(uncertain, 1e-12), color="0.93", zorder=0, lw=0)
    axes.margins(x=0.1)  # room for the labels of the spacings
    axes.set_xscale("log")
    axes.set_yscale("log")
    errors = [row.error_mm for row in report.rows if row.error_mm]
    if errors:
        highest = max([*errors, *(row.estimate_mm for row in report.rows if row.default and row.estimate_mm)])
        axes.set_ylim(min(min(errors) / 2.0, max(uncertain, min(errors) / 10.0)), 2.0 * highest)
    axes.set_xlabel("seconds of the daemon, lattice included")
    axes.set_ylabel("root mean square error of the skin, mm")
    axes.set_title(report.scene.what[0].upper() + report.scene.what[1:], fontsize=10, wrap=True)
    axes.grid(True, which="major", color="0.9", lw=0.8)
    axes.legend(fontsize=8, frameon=False, loc="best")
    drawn = io.BytesIO()
    figure.savefig(drawn, format=path.suffix[1:], dpi=150)
    write_whole(path, drawn.getvalue())
    pyplot.close(figure)


def curves(rows: Sequence[Measure]) -> list[list[Measure]]:
    """Sort the rows that converged into curves.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    list[list[Measure]]
        A list per combination of settings, from coarse to fine.
    """
    found: dict[tuple[object, ...], list[Measure]] = {}
    for row in rows:
        if row.error_mm:
            found.setdefault(tuple(getattr(row, name) for name in DEFAULT), []).append(row)
    return [sorted(curve, key=lambda row: -row.spacing_mm) for curve in found.values()]
