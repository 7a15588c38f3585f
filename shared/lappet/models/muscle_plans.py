"""The muscles of the whole body: where each begins and ends, and how thick its belly is.

Origins and insertions are those of Gray's Anatomy (20th edition, 1918, chapter IV, Myology, in the public domain),
placed by the rig's joints; where a belly bulges to and how thick it is are chosen by eye within the body.
"""

from __future__ import annotations

from dataclasses import dataclass

from lappet.procedure import Point

SOURCE = "Gray H. Anatomy of the Human Body, 20th edition, Lea & Febiger, 1918, chapter IV: Myology"


@dataclass(frozen=True)
class End:
    """Where a strand begins or ends.

    Parameters
    ----------
    joints
        Two joints; `*` stands for the side.
    share
        Share of the way from the first to the second.
    shift
        From there in mm: sideways away from the middle, to the front, up.
    """

    joints: tuple[str, str]
    share: float
    shift: Point = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class StrandPlan:
    """A strand from its origin to its insertion.

    Parameters
    ----------
    origin
        Where it begins.
    insertion
        Where it ends.
    bulge
        How far its middle lies off the straight way in mm, as the shift of an end.
    radius
        Radius of its belly in mm; at its ends it has `_TENDON` of it.
    """

    origin: End
    insertion: End
    bulge: Point
    radius: float


@dataclass(frozen=True)
class MusclePlan:
    """A muscle on both sides of the body.

    Parameters
    ----------
    name
        Its name, which gets the side.
    origin
        Its origin in the source's words, shortened.
    insertion
        Its insertion.
    strands
        Its strands.
    """

    name: str
    origin: str
    insertion: str
    strands: tuple[StrandPlan, ...]


def _on(first: str, second: str, share: float, *shift: float) -> End:
    side, front, up = shift or (0.0, 0.0, 0.0)
    return End((first, second), share, (side, front, up))


def _strand(origin: End, insertion: End, bulge: Point, radius: float) -> StrandPlan:
    return StrandPlan(origin, insertion, bulge, radius)


_ARM, _FOREARM = ("*-shoulder", "*-elbow"), ("*-elbow", "*-hand")
_THIGH, _SHANK = ("*-upper-leg", "*-knee"), ("*-knee", "*-ankle")

MUSCLES: tuple[MusclePlan, ...] = (
    MusclePlan("biceps_brachii", "coracoid process; supraglenoid tuberosity", "tuberosity of the radius", (
        _strand(_on(*_ARM, -0.02, -4, 24, -4), _on(*_FOREARM, 0.16, -6, 10, 12), (0, 18, 2), 19),
    )),
    MusclePlan("brachialis", "lower half of the front of the humerus", "tuberosity of the ulna", (
        _strand(_on(*_ARM, 0.5, 6, 13, 4), _on(*_FOREARM, 0.13, 0, 6, 10), (4, 8, 4), 13),
    )),
    MusclePlan("triceps_brachii", "infraglenoid tuberosity; back of the humerus", "olecranon", (
        _strand(_on(*_ARM, 0.06, -6, -16, -10), _on(*_FOREARM, 0.0, 4, -16, -8), (0, -16, -2), 20),
    )),
    MusclePlan("deltoideus", "clavicle, acromion, spine of the scapula", "deltoid tuberosity of the humerus", (
        _strand(_on("*-scapula", "*-shoulder", 0.5, 0, 26, 12), _on(*_ARM, 0.48, 12, 8, 8), (12, 18, 14), 18),
        _strand(_on("*-scapula", "*-shoulder", 0.6, 0, 0, 26), _on(*_ARM, 0.48, 14, 0, 10), (18, 0, 18), 18),
        _strand(_on("*-scapula", "*-shoulder", 0.5, 0, -26, 8), _on(*_ARM, 0.48, 12, -8, 8), (12, -16, 12), 18),
    )),
    MusclePlan("brachioradialis", "lateral supracondylar ridge of the humerus", "styloid process of the radius", (
        _strand(_on(*_ARM, 0.76, 12, 8, 10), _on(*_FOREARM, 0.92, 6, 2, 12), (10, 2, 16), 11),
    )),
    MusclePlan("flexor_digitorum", "medial epicondyle of the humerus", "middle phalanges", (
        _strand(_on(*_ARM, 0.97, -14, 8, -10), _on(*_FOREARM, 0.98, -8, 4, -8), (-14, 8, -8), 14),
    )),
    MusclePlan("extensor_digitorum", "lateral epicondyle of the humerus", "middle and distal phalanges", (
        _strand(_on(*_ARM, 0.95, 14, -6, 6), _on(*_FOREARM, 0.98, 8, -4, 8), (14, -10, 6), 13),
    )),
    MusclePlan("pectoralis_major", "clavicle, sternum, upper six ribs", "crest of the greater tubercle", (
        _strand(_on("*-clavicle", "spine-1", 0.0, 10, 40, -8), _on(*_ARM, 0.22, -4, 16, -2), (0, 26, -6), 16),
        _strand(_on("spine-1", "spine-2", 0.1, 24, 118, 0), _on(*_ARM, 0.24, -6, 16, -4), (10, 26, -6), 18),
        _strand(_on("spine-1", "spine-2", 0.5, 30, 122, 0), _on(*_ARM, 0.26, -8, 15, -6), (16, 26, -6), 18),
    )),
    MusclePlan("latissimus_dorsi", "lower six thoracic spines, iliac crest", "intertubercular groove", (
        _strand(_on("spine-2", "spine-3", 0.0, 26, -52, 0), _on(*_ARM, 0.16, -14, -10, -12), (34, -26, 10), 16),
        _strand(_on("spine-3", "spine-4", 0.0, 34, -46, 0), _on(*_ARM, 0.18, -16, -10, -14), (46, -22, 20), 16),
    )),
    MusclePlan("trapezius", "occipital bone, nuchal ligament, thoracic spines", "clavicle, acromion, scapular spine", (
        _strand(_on("head", "neck", 0.3, 16, -40, 0), _on("*-scapula", "*-shoulder", 0.2, 0, -8, 20), (0, -14, 0), 14),
        _strand(_on("neck", "spine-1", 0.7, 14, -62, 0), _on("*-scapula", "*-shoulder", 0.2, 0, -26, 8),
                (0, -20, 6), 14),
        _strand(_on("spine-1", "spine-2", 0.5, 14, -58, 0), _on("*-scapula", "*-shoulder", 0.1, 0, -34, 0),
                (0, -22, 0), 14),
    )),
    MusclePlan("sternocleidomastoideus", "manubrium of the sternum; clavicle", "mastoid process", (
        _strand(_on("*-clavicle", "neck", 0.1, 2, 26, 0), _on("head", "head-2", 0.05, 56, -14, 0), (8, 6, 0), 10),
    )),
    MusclePlan("masseter", "zygomatic arch", "angle and ramus of the mandible", (
        _strand(_on("head", "head-2", 0.1, 58, 66, 0), _on("head", "jaw", 0.25, 50, 20, -10), (4, 2, 0), 9),
    )),
    MusclePlan("rectus_abdominis", "pubic crest", "cartilages of ribs five to seven", (
        _strand(_on("pelvis", "spine-4", 0.0, 24, 78, -10), _on("spine-2", "spine-1", 0.25, 36, 108, 0),
                (6, 12, 0), 16),
    )),
    MusclePlan("obliquus_externus", "lower eight ribs", "iliac crest, linea alba", (
        _strand(_on("spine-2", "spine-1", 0.1, 104, 26, 0), _on("spine-4", "pelvis", 0.3, 96, 62, 0), (18, 22, 0), 14),
        _strand(_on("spine-2", "spine-1", 0.1, 108, -8, 0), _on("spine-4", "pelvis", 0.3, 112, 20, 0), (16, 6, 0), 14),
    )),
    MusclePlan("erector_spinae", "sacrum, iliac crest, lumbar spines", "ribs, thoracic and cervical vertebrae", (
        _strand(_on("pelvis", "spine-4", 0.4, 30, -52, 0), _on("spine-1", "neck", 0.0, 26, -38, 0), (6, -8, 0), 18),
    )),
    MusclePlan("gluteus_maximus", "ilium, sacrum, coccyx", "gluteal tuberosity, iliotibial tract", (
        _strand(_on("pelvis", "spine-4", 0.3, 40, -72, 0), _on(*_THIGH, 0.22, 16, -26, 0), (18, -40, 0), 28),
        _strand(_on("pelvis", "spine-4", -0.4, 34, -70, 0), _on(*_THIGH, 0.28, 12, -28, 0), (14, -40, 0), 26),
    )),
    MusclePlan("gluteus_medius", "outer surface of the ilium", "greater trochanter", (
        _strand(_on("pelvis", "spine-4", 0.9, 92, -16, 0), _on(*_THIGH, 0.1, 36, -2, 0), (26, -6, 0), 22),
    )),
    MusclePlan("rectus_femoris", "anterior inferior iliac spine", "patella, tibial tuberosity", (
        _strand(_on(*_THIGH, -0.05, 0, 42, 0), _on(*_THIGH, 0.96, 0, 34, 0), (0, 22, 0), 22),
    )),
    MusclePlan("vastus_lateralis", "greater trochanter, linea aspera", "patella", (
        _strand(_on(*_THIGH, 0.14, 30, 4, 0), _on(*_THIGH, 0.94, 18, 26, 0), (22, 14, 0), 23),
    )),
    MusclePlan("vastus_medialis", "linea aspera", "patella", (
        _strand(_on(*_THIGH, 0.3, -18, 22, 0), _on(*_THIGH, 0.96, -16, 24, 0), (-14, 12, 0), 20),
    )),
    MusclePlan("biceps_femoris", "ischial tuberosity; linea aspera", "head of the fibula", (
        _strand(_on(*_THIGH, 0.06, -14, -40, 0), _on(*_SHANK, 0.06, 22, -20, 0), (8, -26, 0), 20),
    )),
    MusclePlan("semitendinosus", "ischial tuberosity", "medial surface of the tibia", (
        _strand(_on(*_THIGH, 0.06, -26, -40, 0), _on(*_SHANK, 0.08, -22, -12, 0), (-10, -24, 0), 18),
    )),
    MusclePlan("adductor_magnus", "inferior ramus of the pubis, ischium", "linea aspera, adductor tubercle", (
        _strand(_on(*_THIGH, 0.06, -48, -8, 0), _on(*_THIGH, 0.8, -18, -8, 0), (-10, -6, 0), 24),
    )),
    MusclePlan("gastrocnemius", "condyles of the femur", "calcaneus by the Achilles tendon", (
        _strand(_on(*_THIGH, 0.97, 16, -28, 0), _on(*_SHANK, 0.94, 0, -32, 0), (10, -22, 40), 17),
        _strand(_on(*_THIGH, 0.97, -16, -28, 0), _on(*_SHANK, 0.94, 0, -32, 0), (-10, -22, 40), 17),
    )),
    MusclePlan("soleus", "head of the fibula, back of the tibia", "calcaneus by the Achilles tendon", (
        _strand(_on(*_SHANK, 0.12, 6, -22, 0), _on(*_SHANK, 0.95, 0, -28, 0), (0, -10, 30), 18),
    )),
    MusclePlan("tibialis_anterior", "lateral condyle and surface of the tibia", "first cuneiform and metatarsal", (
        _strand(_on(*_SHANK, 0.08, 18, 14, 0), _on(*_SHANK, 0.96, -2, 22, 0), (10, 6, 40), 13),
    )),
)  # fmt: skip
