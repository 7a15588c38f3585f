"""Which operator repairs a problem: a table by the problem's code."""

from __future__ import annotations

from dataclasses import dataclass

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure.prim_paths import BONE


@dataclass(frozen=True)
class Repair:
    """An operator that repairs a problem, to be called with these arguments.

    label: what its button says; "" = its own.
    """

    operator: str
    arguments: tuple[tuple[str, str], ...] = ()
    label: str = ""


REPAIRS = (
    ("HOLES", "Fill Small Holes", "Close the holes that are small compared with the mesh or its rim"),
    ("WELD", "Weld", "Merge vertices at the same place and remove faces without area"),
    ("ORIENT", "Turn Faces Alike", "Make all faces point outwards"),
    ("LOOSE", "Remove Loose Parts", "Remove vertices and edges without a face"),
    ("THICKEN", "Thicken", "Turn Thicken on for an open surface, off for a closed one"),
    ("SPACING", "Choose Spacing", "Choose a lattice spacing that fits the tissue and the memory"),
)
# Of the tissue's mesh and lattice: the kind of `lappet.tissue_repair`.
_KIND_OF = {
    ProblemCode.MESH_OPEN: "HOLES",
    ProblemCode.SHEET_BORDERS: "HOLES",
    ProblemCode.MESH_NOT_MANIFOLD: "WELD",
    ProblemCode.MESH_NO_AREA: "WELD",
    ProblemCode.MESH_NOT_ORIENTED: "ORIENT",
    ProblemCode.MESH_INSIDE_OUT: "ORIENT",
    ProblemCode.MESH_LOOSE_POINTS: "LOOSE",
    ProblemCode.SHEET_OF_CLOSED_SURFACE: "THICKEN",
    ProblemCode.LATTICE_MEMORY: "SPACING",
    ProblemCode.LATTICE_TOO_COARSE: "SPACING",
}
# Of the object that the problem names.
_OF_OBJECT = {
    ProblemCode.OBJECT_NOT_IN_SCENE: "lappet.tissue_restore",
    ProblemCode.OBJECT_LINKED: "lappet.tissue_make_local",
    ProblemCode.OBJECT_MODIFIERS: "lappet.tissue_apply_modifiers",
    ProblemCode.OBJECT_SHAPE_KEYS: "lappet.tissue_apply_modifiers",
    ProblemCode.OBJECT_MIRRORED: "lappet.tissue_apply_scale",
    ProblemCode.OBJECT_STRETCHED: "lappet.tissue_apply_scale",
    ProblemCode.OBJECT_MOVES: "lappet.tissue_fix_place",
    ProblemCode.BONE_IS_TISSUE: "lappet.bone_remove",
    ProblemCode.BONE_TWICE: "lappet.bone_remove",
}
_LABELS = {kind: label for kind, label, _ in REPAIRS}


def repair_of(found: Problem) -> Repair | None:
    """Return the operator that repairs a problem, None where there is none."""
    if found.code is ProblemCode.TISSUE_NONE:
        return Repair("lappet.tissue_set")
    if found.code in _OF_OBJECT:
        return Repair(_OF_OBJECT[found.code], (("object", found.prim),))
    kind = _KIND_OF.get(found.code)
    if kind is None or found.prim.startswith(BONE):
        return None
    return Repair("lappet.tissue_repair", (("kind", kind),), _LABELS[kind])
