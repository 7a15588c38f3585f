"""The kinds of properties that the procedure or its picture depends on: whoever listens to `changes` hears of them."""

from functools import partial

from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .changes import property_changed

count = partial(IntProperty, update=property_changed)
number = partial(FloatProperty, update=property_changed)
vector = partial(FloatVectorProperty, update=property_changed)
flag = partial(BoolProperty, update=property_changed)
text = partial(StringProperty, update=property_changed)
choice = partial(EnumProperty, update=property_changed)
pointer = partial(PointerProperty, update=property_changed)
