"""The bases of the operators on the tissue, its materials, groups and bones."""

from __future__ import annotations

import bpy

from ..interface.operator_base import OperatorBase


class TissueOperator(OperatorBase):
    """An operator in any scene."""

    edits_procedure = True

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene is not None


class OnTissue(TissueOperator):
    """An operator in a scene that has a tissue."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene is not None and context.scene.lappet.tissue.object is not None
