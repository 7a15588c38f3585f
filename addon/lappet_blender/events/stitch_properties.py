"""The properties of operators that make stitches of a shape, alike in the tool and in scripts."""

from typing import Any

from bpy.props import BoolProperty, EnumProperty, FloatProperty

from ..model.event_kinds import ORDERS
from .stitch_shapes import DRAWN, SHAPES


def shape_property() -> Any:
    """Return the property of the shape."""
    return EnumProperty(name="Shape", description="What the thread of each suture does", items=SHAPES)


def drawn_property() -> Any:
    """Return the property of how far the thread of a shape is drawn."""
    return FloatProperty(
        name="Drawn",
        description="Share of the length at which the wound's edges just meet to which the thread of a shape is drawn",
        default=DRAWN,
        min=0.05,
        max=1.5,
    )


def order_property() -> Any:
    """Return the property of the order in which the stitches of a run are made."""
    return EnumProperty(name="Order", description="In which order the stitches are made", items=ORDERS)


def single_property() -> Any:
    """Return the property that asks for an event for each stitch."""
    return BoolProperty(
        name="Single Sutures", description="Make an event for each stitch instead of one run", default=False
    )
