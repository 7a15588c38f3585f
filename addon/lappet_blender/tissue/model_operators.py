"""The operator that adds an anatomical model with its tissue, lines, landmarks and surroundings; and its menu."""

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.body_model import usual_shape
from lappet.models.body_shape import BodyShape
from lappet.models.model import Model
from lappet.models.model_choice import REACH_RANGE, ModelChoice
from lappet.models.new_model import MODELS, new_model

from ..interface.operator_base import OperatorBase
from ..model.scene_filling import fill_scene

_SEXES = (
    ("MODEL", "The Model's", "", 0),
    ("FEMALE", "Female", "", 1),
    ("NEUTRAL", "Neutral", "", 2),
    ("MALE", "Male", "", 3),
)
_SHARE = {"FEMALE": 0.0, "NEUTRAL": 0.5, "MALE": 1.0}


class LAPPET_OT_model_add(OperatorBase, bpy.types.Operator):
    """Begin with an anatomical model: part of a face or a body, with skin lines, landmarks and what is around it"""

    bl_label = "Add Anatomical Model"
    edits_procedure = True

    model: EnumProperty(name="Model", items=[(name, name.capitalize(), each.title) for name, each in MODELS.items()])
    age: FloatProperty(name="Age", description="Age in years", default=25.0, min=1.0, max=90.0)
    sex: EnumProperty(name="Sex", items=_SEXES)
    weight: FloatProperty(
        name="Weight", description="0 for the lightest, 1 for the heaviest", default=0.5, min=0.0, max=1.0
    )
    skin: FloatProperty(
        name="Skin", description="Thickness of the skin in mm; 0 for the model's", default=0.0, min=0.0, max=5.0
    )
    laxity: FloatProperty(
        name="Laxity", description="0 for skin under its published tension, 1 for none", default=1.0, min=0.0, max=1.0
    )
    scenery: BoolProperty(name="Surroundings", description="Show the body around the tissue", default=True)
    excision: BoolProperty(
        name="Excision", description="With a first operation: a fusiform excision, closed", default=False
    )
    deep: BoolProperty(
        name="Deep Layer",
        description="With the layer below the fat, where the model has one: SMAS, fascia, muscle or cartilage",
        default=False,
    )
    reach: FloatProperty(
        name="Reach",
        description="How many times as far as usual the tissue reaches",
        default=1.0,
        min=REACH_RANGE[0],
        max=REACH_RANGE[1],
    )

    def run(self, context: bpy.types.Context) -> str:
        scene = context.scene
        if scene.lappet.tissue.object is not None or len(scene.lappet.events):
            raise refused(ProblemCode.MODEL_SCENE_TAKEN, scene.name, self.model)
        choice = ModelChoice(
            self._shape(), self.skin or None, self.laxity, None, self.scenery, self.excision, self.deep, self.reach
        )
        procedure = new_model(self.model, choice)
        collection = bpy.data.collections.new(self.model.capitalize())
        scene.collection.children.link(collection)
        try:
            fill_scene(scene, procedure, collection)
        except BaseException:
            bpy.data.collections.remove(collection)
            raise
        return f"Added the model {self.model}: {MODELS[self.model].title}."

    def _shape(self) -> BodyShape | None:
        """The shape that is asked for; None for the model's own, and for what is no body."""
        model = MODELS[self.model]
        if not isinstance(model, Model):
            return None
        usual = usual_shape(model)
        return BodyShape(self.age, _SHARE.get(self.sex, usual.sex), self.weight)


class VIEW3D_MT_lappet_model(bpy.types.Menu):
    bl_label = "Model"

    def draw(self, _context: bpy.types.Context) -> None:
        for name in MODELS:
            self._entry(name)

    def _entry(self, name: str) -> None:
        entry: Any = self.layout.operator(LAPPET_OT_model_add.bl_idname, text=name.capitalize())
        entry.model = name


CLASSES = (LAPPET_OT_model_add, VIEW3D_MT_lappet_model)
