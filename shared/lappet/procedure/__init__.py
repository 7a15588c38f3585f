"""The timeline of an operation as plain values: tissue, materials, events, and the procedure that holds them."""

from __future__ import annotations

from lappet.procedure.events import (
    CUTS,
    HOLDS,
    Basis,
    Event,
    Excision,
    Hook,
    Incision,
    Landmark,
    Retractor,
    Suture,
    SutureMode,
    Undermine,
)
from lappet.procedure.exact_values import Point
from lappet.procedure.procedure import Procedure
from lappet.procedure.tissue import MODELS, Bone, Material, Region, Tissue

__all__ = [
    "CUTS",
    "HOLDS",
    "MODELS",
    "Basis",
    "Bone",
    "Event",
    "Excision",
    "Hook",
    "Incision",
    "Landmark",
    "Material",
    "Point",
    "Procedure",
    "Region",
    "Retractor",
    "Suture",
    "SutureMode",
    "Tissue",
    "Undermine",
]
