"""The kinds of events and of lines, as Blender's lists name them."""

from __future__ import annotations

from lappet.procedure import Basis, SutureMode, SutureOrder, SuturePattern
from lappet.procedure.threads import THREADS

KINDS = (
    ("INCISION", "Incision", "A cut along a line on the skin", "SCULPTMODE_HLT", 0),
    ("EXCISION", "Excision", "Removes a piece of tissue", "TRASH", 1),
    ("UNDERMINE", "Undermining", "Frees the skin inside a line from its bed", "MOD_EXPLODE", 2),
    ("THIN", "Thinning", "Takes the deep tissue inside a line away, so that a flap is thinner", "MOD_THICKNESS", 8),
    ("HOOK", "Hook", "Pulls a point of the skin to a target", "HOOK", 3),
    ("RETRACTOR", "Retractor", "Grips faces of the skin and moves them as one", "VIEW_PAN", 4),
    ("SUTURE", "Suture", "Draws two points together and holds them", "LINKED", 5),
    ("SUTURE_RUN", "Suture Run", "Sews two edges of a wound together, stitch by stitch", "DRIVER_DISTANCE", 7),
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
PATTERNS = (
    ("INTERRUPTED", "Interrupted", "Each stitch holds one point of each edge"),
    ("SIMPLE", "Simple", "A loop across the wound in the tissue and back over it"),
    ("RUNNING", "Running", "One thread through all places, which slides"),
    ("VERTICAL_MATTRESS", "Vertical Mattress", "Far-far-near-near: the edges turn out"),
    ("HORIZONTAL_MATTRESS", "Horizontal Mattress", "Across, along the edge and back: the edges turn out"),
    ("HALF_BURIED", "Half-Buried Mattress", "On the second edge it stays in the tissue, as in the tip of a flap"),
    ("DEEP_DERMAL", "Deep Dermal", "Buried, tied below"),
    ("FIGURE_OF_EIGHT", "Figure of Eight", "Two passes whose threads cross above the wound"),
)
ORDERS = (
    ("HALVING", "By Halving", "Corners and the middle first, then the middles of the halves"),
    ("FORWARD", "From the Start", "One after the other from the start of the edges"),
    ("TOGETHER", "All at Once", "All stitches are drawn together at the same time"),
)
CUT_KINDS = frozenset({"INCISION", "EXCISION", "UNDERMINE", "THIN"})
HOLD_KINDS = frozenset({"HOOK", "RETRACTOR"})
SEWN_KINDS = frozenset({"SUTURE", "SUTURE_RUN"})
BASIS_OF: dict[str, Basis] = {"LINEAR": "linear", "CATMULL_ROM": "catmullRom", "BSPLINE": "bspline", "BEZIER": "bezier"}
PATTERN_OF: dict[str, SuturePattern] = {
    "INTERRUPTED": "interrupted",
    "SIMPLE": "simple",
    "RUNNING": "running",
    "VERTICAL_MATTRESS": "verticalMattress",
    "HORIZONTAL_MATTRESS": "horizontalMattress",
    "HALF_BURIED": "halfBuriedMattress",
    "DEEP_DERMAL": "deepDermal",
    "FIGURE_OF_EIGHT": "figureOfEight",
}
ORDER_OF: dict[str, SutureOrder] = {"HALVING": "halving", "FORWARD": "forward", "TOGETHER": "together"}
MODE_OF: dict[str, SutureMode] = {"EXACT": "exact", "THREAD": "thread"}
THREAD_OF = {item: "" if item == "NONE" else name for item, name, _ in THREAD_ITEMS}
