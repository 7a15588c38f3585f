"""Writes docs/label_placement.md: how labels are placed, beside two other programs, from the last comparison."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PAGE = "docs/label_placement.md"
RESULT = "docs/label_comparison.json"
COUNTS = {
    "overlapping": "texts over texts",
    "crossing": "leaders that cross",
    "leader_over_text": "leaders over texts",
    "over_place": "texts over a named place",
    "outside": "texts beyond the panel",
}

TEXT = """# Placing labels

The labels of a [plate](plates.md) stand at the sides of a panel, each on a row of its own, so that leaders are straight
and a wound in the middle stays free. Which label takes which row is an assignment of the least total length of leaders
(boundary labeling: Bekos et al. 2007, *Boundary labeling: models and efficient algorithms for rectangular maps*),
solved exactly as an integer program under the conditions that no leader crosses another or a text.

Beside it two programs that put texts near the places that they name, by forces and by candidates: {adjust}
and {textalloc}, with their usual settings, textalloc told to avoid crossings. {sets} sets
of 2 to 20 labels, {labels} in all, words of plates at 7 pt in a panel of 56 by 42 mm, the same places for all three:

{table}

Their leaders are shorter, because their texts stand among what is named; on a plate that is the wound. The times are
medians of a set on two busy cores. `packaging/compare_labels.py` makes the comparison and writes
[the record](label_comparison.json); `tests/packaging/test_label_comparison.py` repeats our row.
"""


def label_page() -> str:
    """Return the text of docs/label_placement.md."""
    record: dict[str, Any] = json.loads((ROOT / RESULT).read_text(encoding="utf-8"))
    rows = record["rows"]
    head = ["", *rows]
    lines = [head, ["---", *("---:" for _ in rows)]]
    lines += [[text, *(str(row[name]) for row in rows.values())] for name, text in COUNTS.items()]
    lines.append(["leaders, mm", *(f"{row['leaders_mm']:.0f}" for row in rows.values())])
    lines.append(["seconds a set", *(f"{row['seconds']:.2g}" for row in rows.values())])
    table = "\n".join("| " + " | ".join(line) + " |" for line in lines)
    named = {name: f"{name} {rows[name]['version']}" for name in ("adjustText", "textalloc")}
    return TEXT.format(
        adjust=named["adjustText"],
        textalloc=named["textalloc"],
        sets=record["sets"],
        labels=record["labels"],
        table=table,
    )
