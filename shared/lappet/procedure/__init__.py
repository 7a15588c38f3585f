"""The timeline of an operation as plain values: tissue, materials, events, and the procedure that holds them."""

from __future__ import annotations

from lappet.procedure.cuts import CUTS, Basis, Excision, Incision, Thin, Undermine
from lappet.procedure.events import (
    HOLDS,
    LOADS,
    MEASURES,
    Event,
    Hook,
    Landmark,
    Pressure,
    Retractor,
    Section,
    Suture,
    Traction,
)
from lappet.procedure.exact_values import Point
from lappet.procedure.laid_flap import FlapLines, LaidFlap
from lappet.procedure.muscle import Muscle, Strand
from lappet.procedure.plate import (
    ANNOTATION_ANCHORS,
    PANEL_STEPS,
    PLATE_STYLES,
    PLATE_VIEWS,
    Plate,
    PlateAnnotation,
    PlatePanel,
)
from lappet.procedure.pose import Pose, matrix_pose, place_of, pose_at, pose_matrix
from lappet.procedure.position import POSITIONS, position_of
from lappet.procedure.procedure import Procedure
from lappet.procedure.scenery import SCENERY_KINDS, Scenery, SceneryKind
from lappet.procedure.skin_line import SkinLine
from lappet.procedure.suture_run import (
    SKIN_LAYER,
    SutureLayer,
    SutureMode,
    SutureOrder,
    SuturePattern,
    SutureRun,
)
from lappet.procedure.tissue import DEFAULT_SKIN, MODELS, Bone, Material, Region, Roller, Tissue
from lappet.procedure.vessel import VESSEL_KINDS, Vessel, VesselKind

__all__ = [
    "ANNOTATION_ANCHORS",
    "CUTS",
    "DEFAULT_SKIN",
    "HOLDS",
    "LOADS",
    "MEASURES",
    "MODELS",
    "PANEL_STEPS",
    "PLATE_STYLES",
    "PLATE_VIEWS",
    "POSITIONS",
    "SCENERY_KINDS",
    "SKIN_LAYER",
    "VESSEL_KINDS",
    "Basis",
    "Bone",
    "Event",
    "Excision",
    "FlapLines",
    "Hook",
    "Incision",
    "LaidFlap",
    "Landmark",
    "Material",
    "Muscle",
    "Plate",
    "PlateAnnotation",
    "PlatePanel",
    "Point",
    "Pose",
    "Pressure",
    "Procedure",
    "Region",
    "Retractor",
    "Roller",
    "Scenery",
    "SceneryKind",
    "Section",
    "SkinLine",
    "Strand",
    "Suture",
    "SutureLayer",
    "SutureMode",
    "SutureOrder",
    "SuturePattern",
    "SutureRun",
    "Thin",
    "Tissue",
    "Traction",
    "Undermine",
    "Vessel",
    "VesselKind",
    "matrix_pose",
    "place_of",
    "pose_at",
    "pose_matrix",
    "position_of",
]
