"""The page of the literature: every published number beside the program's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from lappet.bench.tables import markdown_table
from lappet.reports.literature.published import Published, Verdict
from lappet.reports.literature.rows import ROWS
from lappet.reports.literature.run import value_text
from lappet.reports.report_files import described

_INTRODUCTION = """# Beside the literature

`lappet report literature` solves operations of the flap library and holds what it measures against what papers
published. `make docs` writes this page from the last run, kept in `docs/literature.json`.

```
lappet report literature                             # all rows, half an hour on two busy cores
lappet report literature z-plasty-gain-60 -o DIR     # some of them
```

No preset of the skin is fitted to any of these rows, and none of them may be: a disagreement says what to look at next.
A number *agrees* where it lies in the published range, and is *within its error* where its estimated error reaches into
it; it is *too uncertain* where that error is larger than the number itself and could make it either. Forces leave out
the sutures that the lattice does not resolve. Where a paper has words instead of a number, the bound was chosen here,
and the row says so. The numbers were collected from papers, abstracts and textbooks that quote them; look at the paper
before you quote one.
"""


def literature_page(results: Mapping[str, Any]) -> str:
    """Write the page of the literature.

    Parameters
    ----------
    results
        What the last run wrote.

    Returns
    -------
    str
        The text of docs/literature.md.
    """
    found = {row["name"]: row for row in results["rows"]}
    shown = [row for row in ROWS if row.name in found]
    counts = Counter(found[row.name]["verdict"] for row in shown)
    totals = ", ".join(f"{counts[verdict.value]} {_COUNTED[verdict]}" for verdict in Verdict if counts[verdict.value])
    number = "1 row" if len(shown) == 1 else f"{len(shown)} rows"
    table = [
        [
            row.quantity,
            row.range_text,
            value_text(found[row.name]["value"], found[row.name]["error"], row.unit),
            found[row.name]["verdict"],
        ]
        for row in shown
    ]
    return "\n".join(
        [
            _INTRODUCTION,
            f"## All rows\n\n{number}: {totals}. Cells of {float(results['spacing_mm']):.3g} mm.\n",
            described(results) + "\n",
            markdown_table(["what", "published", "here", ""], table) + "\n",
            "## Row by row\n",
            *(_section(row, found[row.name]["verdict"]) for row in shown),
        ]
    )


_COUNTED = {
    Verdict.AGREES: "agree",
    Verdict.WITHIN_ERROR: "agree within their error",
    Verdict.UNCERTAIN: "are too uncertain to say",
    Verdict.DISAGREES: "disagree",
    Verdict.NOT_SOLVED: "were not solved",
}


def _section(row: Published, verdict: str) -> str:
    lines = [
        f"### {row.name}",
        "",
        f"{row.quantity[0].upper()}{row.quantity[1:]}: {row.range_text}.",
        "",
        f"- There: {row.there}. {row.source}.",
        f"- Here: {row.here}.",
    ]
    if verdict == Verdict.DISAGREES.value:
        lines.append(f"- Disagrees: {row.why or 'the reason is not known'}.")
    return "\n".join([*lines, ""])
