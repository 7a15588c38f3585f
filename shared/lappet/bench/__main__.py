"""`python -m lappet.bench [kernels] [scenes] [sheets] [pipeline] -o DIR`: measures, writes the tables, prints them.

Writes kernels.json, scenes.json, sheets.json and pipeline.json with a .csv of the rows of each, and bench.md with all
of them as Markdown. Parts that are not asked for keep the files of an earlier run, but for bench.md. Exits with 1 where
a scene or a sheet does not converge.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from lappet.bench import kernels as kernel_suite
from lappet.bench import pipeline as pipeline_suite
from lappet.bench import scenes as scene_suite
from lappet.bench import tables
from lappet.bench.circumstances import circumstances, cores
from lappet.core.problem import RefusedError

PARTS = ("kernels", "scenes", "sheets", "pipeline")
# What the scenes need to know of the machine, when the kernels are not measured: its limits, in a second or two.
QUICK_UNTIL = 3  # of the stages' scenes
LIMITS_ONLY = "^(copy|multiply_add)/"


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("parts", nargs=-1, type=click.Choice(PARTS))
@click.option(
    "-o", "--output", "folder", default=Path("build/bench"), show_default=True, type=click.Path(path_type=Path)
)
@click.option("--examples", default=Path("examples"), show_default=True, type=click.Path(path_type=Path))
@click.option("--fine", is_flag=True, help="Scenes at their fine spacings too, sheets up to a million cells: an hour.")
@click.option(
    "--quick",
    is_flag=True,
    help="Kernels once and on little memory, stages of a few frames: to see that all of it works.",
)
def main(parts: tuple[str, ...], folder: Path, examples: Path, fine: bool, quick: bool) -> None:
    """Measure the PARTS (kernels, scenes, sheets, pipeline; all of them by default)."""
    folder.mkdir(parents=True, exist_ok=True)
    try:
        failures = run(parts or PARTS, folder, examples, fine, quick)
    except RefusedError as error:
        sys.exit(str(error))
    if failures:
        sys.exit("\n".join(failures))


def run(parts: tuple[str, ...], folder: Path, examples: Path, fine: bool, quick: bool) -> list[str]:
    """Measure and write the tables.

    Parameters
    ----------
    parts
        What to measure: kernels, scenes, sheets.
    folder
        Folder of the files.
    examples
        Folder of the examples.
    fine
        Whether to measure up to a million cells.
    quick
        Whether to measure a little of everything.

    Returns
    -------
    list[str]
        A sentence per scene or sheet that did not converge.
    """
    hurry: dict[str, Any] = {"repetitions": 2, "seconds": 1e-3, "stream_bytes": 1 << 24} if quick else {}
    only = None if "kernels" in parts else LIMITS_ONLY
    suite = kernel_suite.read_suite(kernel_suite.run_suite(kernel_suite.find_benchmarks(), only=only, **hurry))
    head = {**circumstances(suite.context, cores()), "limits": suite.limits.as_dict()}
    document, failures = [f"# Benchmarks\n\n{described(head)}\n"], []

    def write(title: str, name: str, text: str, rows: Any, **more: Any) -> None:
        tables.write_json(folder / f"{name}.json", {**head, **more.pop("head", {})}, rows=rows, **more)
        tables.write_csv(folder / f"{name}.csv", rows, head)
        document.append(f"## {title}\n\n{text}")
        print(f"\n{title}\n\n{text}")

    if "kernels" in parts:
        context = {"threads": 1, "suite": suite.context}
        text = tables.kernels_markdown(suite)
        write("Kernels", "kernels", text, suite.rows, head=context, parallel=suite.parallel)
    if "scenes" in parts:
        rows = []
        for scene in scene_suite.suite(examples):
            for spacing in [scene.moderate, *([scene.fine] if fine and scene.fine else [])]:
                print(f"{scene.procedure.stem} at {spacing:g} mm …", file=sys.stderr)
                rows.append(scene_suite.solve_scene(scene.procedure, spacing, folder))
        write("Scenes", "scenes", tables.scenes_markdown(rows), rows)
        failures += [f"{row.scene}: {row.reason}" for row in rows if not row.converged]
    if "sheets" in parts:
        from lappet.bench.sheets import sheets, summary

        found = sheets(fine)
        write("Sheets", "sheets", tables.sheets_markdown(found), found, summary=summary(found))
        failures += [f"{row.benchmark} at {row.spacing_mm:g} mm: {row.reason}" for row in found if not row.converged]
    if "pipeline" in parts:
        stages = pipeline_suite.pipeline(examples, folder, until=QUICK_UNTIL if quick else None)
        write("Pipeline", "pipeline", tables.pipeline_markdown(stages), stages)
    (folder / "bench.md").write_text("\n".join(document), encoding="utf-8")
    print(f"written: {folder}")
    return failures


def described(head: dict[str, Any]) -> str:
    """Say where and when the numbers were taken, for people.

    Parameters
    ----------
    head
        What each file of results starts with.

    Returns
    -------
    str
        A line of text.
    """
    machine = head["machine"]
    return (
        f"{machine['processor']}, {machine['cores']} cores, {machine['memory_bytes'] / 2**30:.0f} GiB; "
        f"{head['compiler']}; {head['isa']}; revision {head['revision']}; {head['date']}."
    )


if __name__ == "__main__":
    main()
