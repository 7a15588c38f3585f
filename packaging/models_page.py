"""The page of the anatomical models, from their catalogue."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from lappet.models.catalogue import BODY_MODELS
from lappet.models.deep_layer import DEEP_LAYERS
from lappet.models.description import LICENSE, sources_of
from lappet.models.model import Depth, Model
from lappet.models.muscle_plans import MUSCLES
from lappet.models.muscle_plans import SOURCE as MUSCLE_SOURCE
from lappet.models.plain_models import PLAIN_MODELS
from lappet.models.sources import CHOSEN, SOURCES
from lappet.models.vessel_plans import COURSES, FACIAL_ARTERY
from lappet.models.whole_body import MUSCLE, SOFT_TISSUE, WHOLE_BODY
from lappet.reports.surroundings.measurement import SurroundingsRow
from lappet.reports.surroundings.table import surroundings_table
from lappet.tissue.presets import PRESETS

PAGE = "docs/models.md"
INTRODUCTION = """# Anatomical models

`make docs` writes this page from `shared/lappet/models/`. *chosen* means that no measurement was found.

```
lappet models fetch                        # once: downloads the package that the body models are cut from (48 MB)
lappet models list
lappet models show nose                    # what it is made of, with sources
lappet models new nose -o nose.usda
lappet models new face -o face.usda --age 70 --sex female --weight 0.3
lappet models new nose -o nose.usda --target nose/nose-hump-incr=0.8
lappet models targets nose                 # all shape targets with "nose" in their name
lappet models new cheek -o cheek.usda --excision      # with a first operation: a fusiform excision, closed
lappet models new scalp -o scalp.usda --deep          # with the galea, a layer of its own
lappet models new cheek -o cheek.usda --reach 1.3     # tissue that reaches 1.3 times as far, with more cells
```

In Blender: *Add > Lappet > Model*. It never downloads anything; fetch the package on the command line first.

![The models, each in its surroundings; the printed grid lies on the tissue](images/models.png)

## What a model is

A model is a procedure without an operation: a closed sheet of tissue, skin over fat, below a part of a body's skin.

- **Coordinates** are millimeters: x runs to the patient's right, y to the front, z up. *Left* is the patient's left.
  All models of the body keep their place in it, so that their coordinates agree.
- **Held**: the rim at the outer border is the group `fixed`, the underside lies on an elastic `bed`. The borders of
  lids, lips and nostrils are free (`rim` without `fixed`), and what lies on free inner skin, such as the back of an
  ear, has no bed.
- **Thickness** follows from the tables below. Where the surface leaves no room, at a lid's edge or in the ear, the
  tissue is thinner. Below it is what the bed stands for; no bone is modeled but that of the dome.
- **Skin lines** are relaxed skin tension lines, drawn by hand after Borges. `--laxity 0` puts the skin under the
  tension of its preset along them, 1 (the default) under none; at the edges of lids and lips it vanishes.
- **Landmarks** have their anatomical names, paired ones with `_left` and `_right`.
- **Subunits** of the face are groups of skin faces, `subunit_nasal_tip`, `subunit_ala_left` and so on: the units of
  Gonzalez-Ulloa, for the nose those of Burget and Menick, with borders placed by hand. The ear has its parts, from
  `subunit_helix_left` to `subunit_lobule_left`.
- **Scenery** (`/Procedure/Scenery`) is the rest of the body around the tissue, with eyes and teeth: shown, not
  solved. `--no-scenery` leaves it out.
- **Clefts** are made of the uncleft body by moving its tissue (`shared/lappet/models/cleft.py`): the free border is
  drawn up into a notch, red lines both margins, Cupid's bow rises towards it, the ala is flattened, its base goes to
  the side and back, the foot of the columella to the other side; in the complete cleft a strip of skin up into the
  nostril is missing. Heights and widths are chosen after plates, not measured, and the face is an adult's unless
  `--age` says otherwise. The free lip has no bed. The landmarks and lines of a repair are `cleft_peak_medial`,
  `cleft_peak_lateral`, `cleft_apex`, `columella_base_cleft`, `cleft_red_medial`, `cleft_red_lateral` and
  `alar_crease_cleft`; the design that repairs it is [`millard`](flaps/millard.md).
- **The layer below**: `--deep` gives some models one layer more, in the table [below](#the-layer-below-the-fat). A cut
  without a depth goes through it as well, and undermining lies below it.
- **Shape**: age, sex and weight mix the package's own targets as MakeHuman does, all other targets are added in the
  amounts that `--target` gives. A model holds the same skin whatever the shape.

What a model is not: a patient. The body is one that artists made, not a scan; thicknesses are means or chosen and one
number for each model; the deeper layer, where there is one, is a sheet as thick everywhere. The auricle is two sheets
back to back, each on a bed that holds it, so that it does not bend as a whole: its cartilage belongs to the front,
where skin lies on it without fat, and what lies below the skin of its back is fat as far as the middle.
"""


def models_page(surroundings: Sequence[Mapping[str, Any]]) -> str:
    """Return the text of docs/models.md.

    Parameters
    ----------
    surroundings
        The kept rows of `lappet report surroundings --reach`.

    Returns
    -------
    str
        Markdown.
    """
    rows = [
        "## The models",
        "",
        "Tried: a fusiform excision of this length, a third as wide, cut through, undermined and closed at the "
        "spacing of the table, with laxity 1; every frame converged.",
        "",
        "| model | what | skin mm | below mm | material | bed | spacing mm | tried mm |",
        "|---|---|---:|---:|---|---|---:|---:|",
    ]
    for model in BODY_MODELS.values():
        rows.append(
            f"| `{model.name}` | {model.title} | {model.skin.mm:g} | {model.fat.mm:g} | "
            f"[`{model.preset}`](tissues.md#{model.preset}) | {model.bed} | {model.spacing:g} | "
            f"{model.trial.length:g} |"
        )
    for plain in PLAIN_MODELS.values():
        rows.append(
            f"| `{plain.name}` | {plain.title} | {plain.skin:g} | 2.5 | [`skin`](tissues.md#skin) | default | "
            f"{plain.spacing:g} | {plain.trial.length:g} |"
        )
    rows += [
        "",
        *_deep_layers(),
        "",
        *_beyond_the_rim(surroundings),
        "",
        *_whole_body(),
        "",
        *_vessels(),
        "",
        "## Where the thicknesses come from",
        "",
    ]
    for model in BODY_MODELS.values():
        rows.append(f"- `{model.name}`: skin {_depth(model.skin)}; below it {_depth(model.fat)}. {_tension(model)}")
    drawn = ["Borges 1962", "Borges 1984", *(course.source for course in COURSES), FACIAL_ARTERY]
    used = dict.fromkeys([*(name for model in BODY_MODELS.values() for name in sources_of(model)), *drawn])
    rows += ["", "## Sources", "", *(f"- {name}: {SOURCES[name]}." for name in SOURCES if name in used), ""]
    rows += [
        "## License",
        "",
        f"Every model of the body: {LICENSE}. `lappet models fetch` downloads that file by its SHA-256 with pip into "
        "the user's data folder (`LAPPET_MODELS` names another one) and installs nothing. `patch` and `dome` are "
        "made by Lappet itself.",
        "",
    ]
    return INTRODUCTION + "\n" + "\n".join(rows)


def _deep_layers() -> list[str]:
    """The section about the layers below the fat."""
    return [
        "## The layer below the fat",
        "",
        "With `--deep`, or *Deep Layer* in Blender. The fibers of muscles run across the skin lines (Borges 1984). The "
        "excisions of the table above were tried with it too, cut through the layer: every frame converged."
        + _own_trials(),
        "",
        "| model | layer | mm | where | material | thickness from |",
        "|---|---|---:|---|---|---|",
        *(
            f"| `{name}` | {layer.title} | {layer.depth.mm:g} | "
            f"{'the deepest of what lies below the skin' if layer.within else 'below it, added'} | "
            f"`{layer.material.name}` | {layer.depth.source}: {layer.depth.how} |"
            for name, layer in DEEP_LAYERS.items()
        ),
    ]


def _own_trials() -> str:
    """The models whose excision through the layer is another one."""
    own = [f"`{name}` ({layer.trial.length:g} mm)" for name, layer in DEEP_LAYERS.items() if layer.trial]
    return f" Those of {' and '.join(own)} are others, as the table's lie beside the layer." if own else ""


def _beyond_the_rim(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """The section about what the models leave out around them."""
    return [
        "## What lies beyond the rim",
        "",
        "A model is cut out of a body and held at its rim, as if what lies beyond it could not move. `lappet report "
        "surroundings` solves an operation again with the rim free, as if nothing lay beyond it: holding a rim makes "
        "tissue stiffer than it is and leaving out what lies beyond makes it softer, so how far the two scars lie "
        "apart is taken for the most that the cut-out leaves out. To try whether it is, `--reach` solves the model a "
        "third time with tissue that reaches farther (`lappet models new NAME --reach`), its rim held again. "
        "Distances are greatest ones between the scars of the last frame, forces those of all sutures that every one "
        "of the three resolves; nothing says that they lie between the others, and those of the neck, whose scar "
        "contracts by itself, do not.",
        "",
        surroundings_table([SurroundingsRow(**row) for row in rows]),
    ]


def _vessels() -> list[str]:
    """The section about vessels and nerves."""
    return [
        "## Vessels and nerves",
        "",
        "Models of the head have those that run above the plane in which flaps are raised, in their layer, as [vessels]"
        "(anatomy.md) that are flagged as typical courses: an incision that crosses one divides it and says so, "
        "pictures with `--translucent` show them, and a long flap that carries one is not warned about. The facial "
        f"artery with its labial and angular branches lies deeper ({FACIAL_ARTERY}: 9 mm below the skin beside the "
        "ala, 22 mm beside the mouth), and so do the branches of the facial nerve: no model's tissue reaches them.",
        "",
        "| vessel or nerve, on both sides | thick, mm | course | source |",
        "|---|---:|---|---|",
        *(f"| {each.name} | {2.0 * each.radius:g} | {each.how} | {each.source} |" for each in COURSES),
    ]


def _whole_body() -> list[str]:
    """The section about the whole body."""
    model = WHOLE_BODY
    return [
        "## The whole body",
        "",
        f"`{model.name}` is {model.title}: soft tissue around a skeleton, solved as one solid with a spacing of "
        f"{model.spacing:g} mm. Its right elbow bends by {model.flexion:g}° in {model.frames} frames while its flexors "
        f"rise to an activation of {model.activation:g}. Bones are sweeps along the joints of the "
        "package's rig, with gaps "
        "of soft tissue at the joints; skull and rib cage are ellipsoids that stand for what they hold "
        "as well. They are "
        "cavities of the tissue: the walls of those that stay are held, those of the right forearm and "
        "hand are gripped "
        "by a retractor. There is no air in it, no organ, no tendon and no contact between one part and another, and "
        "an activation pulls on what moves the bones without moving them.",
        "",
        "Solve it with `--precision double`: its six frames then converge at the default tolerances with 10 to 40 "
        "Newton iterations each. Where walls of bones are closed to a thousandth of the spacing, far from where they "
        "were, single precision has too few digits: its third frame was not found. Nor was it at 14 mm in either "
        "precision, as cells there hold walls of two bones that move apart, unless tolerances are looser "
        "(`--tolerance 2e-3 --gap-tolerance 5e-3`). At 6 mm the first three frames converged in double precision with "
        "17 to 21 iterations; the others, finer lattices and further bending are not tried or did not converge.",
        "",
        f"Soft tissue has {SOFT_TISSUE.youngs_modulus:g} kPa and muscle {MUSCLE.youngs_modulus:g} kPa "
        "(chosen), with an "
        f"isometric stress of {MUSCLE.muscle_stress:g} kPa (Teran, Blemker, Ng Thow Hing and Fedkiw 2003). Each of the "
        f"{2 * len(MUSCLES)} muscles has a material of its own. Origins and insertions are those of {MUSCLE_SOURCE}; "
        "where a belly lies and how thick it is was chosen, and each is pushed inwards until skin and fat cover it.",
        "",
        "| muscle, on both sides | origin | insertion | strands |",
        "|---|---|---|---:|",
        *(f"| `{each.name}` | {each.origin} | {each.insertion} | {len(each.strands)} |" for each in MUSCLES),
    ]


def _depth(depth: Depth) -> str:
    source = "chosen" if depth.source == CHOSEN else depth.source
    return f"{depth.mm:g} mm ({source}: {depth.how})"


def _tension(model: Model) -> str:
    along, across = PRESETS[model.preset].tension
    return f"Tension at laxity 0: {along:g} kPa along the lines, {across:g} across."
