"""The comparison of placed labels: what it counts, and that the record of ours is what the program does."""

from __future__ import annotations

import json

import numpy as np
from shapely import LineString, box

from compare_labels import RESULT, SETS, LabelSet, Placed, by_lappet, faults, label_set


def test_faults_are_counted_once_each() -> None:
    labels = LabelSet(("a", "b", "c"), np.array([[0.0, 0.0], [0.0, 4.0], [26.0, 0.0]]))
    crossing = [
        Placed(box(10.0, 3.0, 14.0, 5.0), LineString([(0.0, 0.0), (10.0, 4.0)])),
        Placed(box(10.0, -1.0, 14.0, 1.0), LineString([(0.0, 4.0), (10.0, 0.0)])),
        Placed(box(13.0, 0.0, 30.0, 2.0), LineString([(26.0, 0.0), (26.0, 0.0)])),
    ]
    found = faults(crossing, labels)
    assert found == {
        "overlapping": 1,
        "crossing": 1,
        "leader_over_text": 0,
        "over_place": 0,
        "outside": 1,
        "missing": 0,
    }
    over = [Placed(box(-1.0, -1.0, 1.0, 5.0), LineString([(0.0, 0.0), (0.0, 0.0)])), *crossing[1:]]
    assert faults(over, labels)["over_place"] == 2
    assert faults(over, labels)["leader_over_text"] >= 1
    assert faults(crossing[:2], labels)["missing"] == 1


def test_labels_of_plates_have_no_fault_as_the_record_says() -> None:
    record = json.loads(RESULT.read_text(encoding="utf-8"))["rows"]["lappet"]
    lengths = 0.0
    for seed in range(SETS):
        labels = label_set(seed)
        placed = by_lappet(labels)
        assert set(faults(placed, labels).values()) == {0}, seed
        lengths += sum(each.leader.length for each in placed)
    assert round(lengths, 1) == record["leaders_mm"]
    assert not any(record[name] for name in faults(placed, labels))
