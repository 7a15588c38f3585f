"""What is wrong with a material, and with a region of the tissue that is made of it."""

from __future__ import annotations

import math

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import MODELS, Material, Procedure
from lappet.procedure.prim_paths import MATERIALS, TISSUE
from lappet.tissue.surface import LABELS, skin_faces

LEAST_PRESTRETCH, MOST_PRESTRETCH = 0.5, 2.0
MOST_POISSONS_RATIO = 0.4999
MOST_MATERIALS = MOST_REGIONS = 64  # the entries of a list in a message


def material_problems(material: Material, path: str) -> list[Problem]:
    """Every problem of one material."""
    problems: list[Problem] = []

    def add(value: object, sentence: str, remedy: str) -> None:
        problems.append(Problem(ProblemCode.UNSORTED, path, str(value), sentence, remedy))

    def number(name: str, value: float, allowed: bool, remedy: str, unit: str = "") -> None:
        if not (math.isfinite(value) and allowed):
            add(f"{value:g}", f"{name} is {value:g}{unit}.", remedy)

    if material.model not in MODELS:
        known = ", ".join(MODELS)
        add(material.model, f"The model {material.model!r} is not known.", f"Use one of {known}.")
    e = material.youngs_modulus
    number("Young's modulus", e, e > 0.0, "Give a modulus above 0, in kPa; skin has about 50.", " kPa")
    nu = material.poissons_ratio
    if not math.isfinite(nu) or nu < 0.0:
        number("Poisson's ratio", nu, False, "Use a ratio from 0 to 0.4999; skin has about 0.45.")
    elif nu >= 0.5:
        add(f"{nu:g}", f"Poisson's ratio is {nu:g}: not solvable, its bulk modulus is infinite.", "Use 0.499.")
    elif nu > MOST_POISSONS_RATIO:
        add(f"{nu:g}", f"Poisson's ratio is {nu:g}, above {MOST_POISSONS_RATIO}.", "Use 0.499.")
    ratio = material.mooney_ratio
    number("The Mooney ratio μ₀₁/μ₁₀", ratio, ratio >= 0.0, "Give a ratio of at least 0.")
    k1, k2, kappa = material.fiber_k1, material.fiber_k2, material.fiber_dispersion
    number("The fibre stiffness k₁", k1, k1 >= 0.0, "Give at least 0, in kPa; 0 means no fibres.", " kPa")
    number("The fibre exponent k₂", k2, k2 >= 0.0, "Give at least 0.")
    remedy = "Give a number between 0 (aligned) and 1/3 (isotropic)."
    number("The fibre dispersion", kappa, 0.0 <= kappa <= 1.0 / 3.0 + 1e-12, remedy)
    direction = material.fiber_direction
    length = math.hypot(*direction)
    if not (math.isfinite(length) and length > 0.0):
        add(direction, f"The fibre direction is {_numbers(direction)}.", "Give a finite direction that is not zero.")
    stretch = material.prestretch
    if not all(LEAST_PRESTRETCH <= v <= MOST_PRESTRETCH for v in stretch):
        sentence = f"The prestretch is {_numbers(stretch)}."
        remedy = f"Give two stretches from {LEAST_PRESTRETCH:g} to {MOST_PRESTRETCH:g}; (1, 1) means none."
        add(stretch, sentence, remedy)
    stress = material.muscle_stress
    number("The muscle stress", stress, stress >= 0.0, "Give at least 0, in kPa; 0 means no muscle.", " kPa")
    for time, value in material.muscle_activation:
        if not (math.isfinite(time) and 0.0 <= value <= 1.0):
            sentence = f"The muscle activation is {value:g} at time {time:g}."
            add(f"{value:g}", sentence, "Give a number from 0 (slack) to 1 (fully active) at a finite time.")
    times = [time for time, _ in material.muscle_activation]
    if len(set(times)) < len(times):
        twice = next(time for time in times if times.count(time) > 1)
        sentence = f"The muscle activation has two values at time {twice:g}."
        add(f"{twice:g}", sentence, "Leave one sample for each time.")
    if stress == 0.0 and any(value > 0.0 for _, value in material.muscle_activation):
        sentence = "The muscle activation has no effect: the muscle stress is 0 kPa."
        remedy = "Set lappet:muscleStress, or remove lappet:muscleActivation."
        problems.append(Problem(ProblemCode.UNSORTED, path, "0", sentence, remedy, "warning"))
    density = material.density
    number("The density", density, density > 0.0, "Give a density above 0; skin has about 1100.", " kg/m³")
    return problems


def region_problems(procedure: Procedure) -> list[Problem]:
    """Every problem of the tissue's regions but for their names (`lappet.usd.writer.name_problems`)."""
    tissue = procedure.tissue
    problems: list[Problem] = []
    known = [material.name for material in procedure.materials]
    faces = len(tissue.face_vertex_counts)
    readable = all(((subset >= 0) & (subset < faces)).all() for subset in tissue.subsets.values())
    skin = skin_faces(tissue) if readable else None
    for region in tissue.regions:
        path = f"{TISSUE}/{region.faces}"

        def add(value: object, sentence: str, remedy: str, path: str = path) -> None:
            problems.append(Problem(ProblemCode.UNSORTED, path, str(value), sentence, remedy))

        if region.material not in known:
            sentence = f"The region is made of {region.material!r}, which no material is named."
            remedy = f"Point lappet:material to one under {MATERIALS}; there are: {', '.join(known) or 'none'}."
            add(region.material, sentence, remedy)
        top, bottom = region.depth_from, region.depth_to
        if not (math.isfinite(top) and top >= 0.0):
            sentence = f"The region begins {top:g} mm below the skin."
            add(f"{top:g}", sentence, "Give lappet:depthFrom at least 0, in mm; 0 is the skin itself.")
        if math.isnan(bottom) or bottom <= top:
            sentence = f"The region ends {bottom:g} mm below the skin, but begins at {top:g} mm."
            add(f"{bottom:g}", sentence, "Give lappet:depthTo more than lappet:depthFrom, or leave it out for no end.")
        if region.faces in LABELS:
            sentence = f"The region lies below the subset {region.faces!r}, which says how the tissue is held."
            add(region.faces, sentence, "Put the region on a subset of its own, of faces of the skin.")
        elif skin is not None and region.faces in tissue.subsets and not skin[tissue.subsets[region.faces]].any():
            sentence = f"The region lies below the subset {region.faces!r}, none of whose faces is skin."
            add(region.faces, sentence, "Select faces of the skin; fixed and bed faces are none.")
    models = dict.fromkeys(material.model for material in procedure.materials_in_use())
    if len(models) > 1:
        sentence = f"The materials of the tissue are of the models {', '.join(models)}."
        problems.append(
            Problem(
                ProblemCode.UNSORTED,
                TISSUE,
                ", ".join(models),
                sentence,
                "Give all materials in use the same lappet:model.",
            )
        )
    for what, count, most in (
        ("regions", len(tissue.regions), MOST_REGIONS),
        ("materials", len(procedure.materials_in_use()), MOST_MATERIALS),
    ):
        if count > most:
            sentence = f"The tissue has {count} {what}."
            problems.append(Problem(ProblemCode.UNSORTED, TISSUE, str(count), sentence, f"Use at most {most}."))
    return problems


def _numbers(values: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{v:g}" for v in values) + ")"
