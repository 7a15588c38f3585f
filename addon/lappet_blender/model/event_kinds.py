"""The kinds of events and of lines, as Blender's lists name them."""

from __future__ import annotations

from lappet.procedure import Basis, SutureMode
from lappet.procedure.threads import THREADS

KINDS = (
    ("INCISION", "Incision", "A cut along a line on the skin", "SCULPTMODE_HLT", 0),
    ("EXCISION", "Excision", "Removes a piece of tissue", "TRASH", 1),
    ("UNDERMINE", "Undermining", "Frees the skin inside a line from its bed", "MOD_EXPLODE", 2),
    ("HOOK", "Hook", "Pulls a point of the skin to a target", "HOOK", 3),
    ("RETRACTOR", "Retractor", "Grips faces of the skin and moves them as one", "VIEW_PAN", 4),
    ("SUTURE", "Suture", "Draws two points together and holds them", "LINKED", 5),
    ("LANDMARK", "Landmark", "Points to follow and measure", "EMPTY_AXIS", 6),
)
BASES = (
    ("LINEAR", "Straight", "Straight from point to point"),
    ("CATMULL_ROM", "Smooth", "A smooth curve through the points"),
    ("BSPLINE", "B-spline", "A smoother curve near the points"),
    ("BEZIER", "Bézier", "Cubic Bézier segments: a point, two handles, a point ..."),
)
SUTURE_MODES = (
    ("EXACT", "Closed exactly", "The two points meet, whatever force that takes"),
    ("THREAD", "Thread", "A thread pulls and never pushes, and stretches"),
)
THREAD_ITEMS = (
    ("NONE", "Own stiffness", "A thread of the stiffness given below"),
    *((name.replace(" ", "_").replace("-", "_").upper(), name, f"A thread of {name}") for name in THREADS),
)
CUT_KINDS = frozenset({"INCISION", "EXCISION", "UNDERMINE"})
HOLD_KINDS = frozenset({"HOOK", "RETRACTOR"})
BASIS_OF: dict[str, Basis] = {"LINEAR": "linear", "CATMULL_ROM": "catmullRom", "BSPLINE": "bspline", "BEZIER": "bezier"}
MODE_OF: dict[str, SutureMode] = {"EXACT": "exact", "THREAD": "thread"}
THREAD_OF = {item: "" if item == "NONE" else name for item, name, _ in THREAD_ITEMS}
