"""The layers of a suture run as one choice: on the skin, deep, both, or as they are."""

from __future__ import annotations

from typing import Any

from .changes import property_changed

LAYER_CHOICES = (
    ("SKIN", "Skin", "Stitches on the skin", 0),
    ("DEEP", "Deep", "Stitches in the depth, that hold the walls of the wound", 1),
    ("BOTH", "Deep and Skin", "Stitches in the depth, and others on the skin between them", 2),
    ("OWN", "Several", "The layers listed below", 3),
)
DEEP = 2.0  # mm below the skin, where none is given; chosen


def sewn_in(event: Any) -> int:
    """The choice that the layers of a run are."""
    deep = [layer.depth > 0.0 for layer in event.layers]
    return {(): 0, (False,): 0, (True,): 1, (True, False): 2}.get(tuple(deep), 3)


def set_sewn_in(event: Any, choice: int) -> None:
    """Give a run the layers of a choice; the depth that its deepest layer has is kept."""
    if choice == 3 or choice == sewn_in(event):
        return
    depth = max((layer.depth for layer in event.layers), default=0.0) or DEEP
    event.layers.clear()
    for name, deep, wanted in (("deep", depth, choice in (1, 2)), ("skin", 0.0, choice in (0, 2))):
        if wanted:
            layer = event.layers.add()
            layer.name, layer.depth, layer.between = name, deep, name == "skin" and choice == 2
    property_changed(event, None)
