"""What is wrong with a material, and what the daemon cannot solve of it yet."""

from __future__ import annotations

import math

from lappet.problem import Problem
from lappet.procedure import MODELS, SOLVED_MODELS, Material


def material_problems(material: Material, path: str, in_use: bool) -> list[Problem]:
    """Every problem of one material; what is not solved yet counts only for the material that the tissue is made of."""
    problems: list[Problem] = []

    def add(value: object, sentence: str, mend: str) -> None:
        problems.append(Problem(path, str(value), sentence, mend))

    def number(name: str, value: float, allowed: bool, mend: str, unit: str = "") -> None:
        if not (math.isfinite(value) and allowed):
            add(f"{value:g}", f"{name} is {value:g}{unit}.", mend)

    if material.model not in MODELS:
        known = ", ".join(MODELS)
        add(material.model, f"The model {material.model!r} is not known.", f"Use one of {known}.")
    elif in_use and material.model not in SOLVED_MODELS:
        sentence = f"The model {material.model} is not solved yet."
        add(material.model, sentence, f"Use {' or '.join(SOLVED_MODELS)}.")
    e = material.youngs_modulus
    number("Young's modulus", e, e > 0.0, "Give a modulus above 0, in kPa; skin has about 50.", " kPa")
    nu = material.poissons_ratio
    if not math.isfinite(nu) or nu <= -1.0:
        number("Poisson's ratio", nu, False, "Use a ratio above -1 and below 0.5; skin has about 0.45.")
    elif nu >= 0.5:
        add(f"{nu:g}", f"Poisson's ratio is {nu:g}: not solvable, its bulk modulus is infinite.", "Use 0.499.")
    ratio = material.mooney_ratio
    number("The Mooney ratio μ₀₁/μ₁₀", ratio, ratio >= 0.0, "Give a ratio of at least 0.")
    k1, k2, kappa = material.fiber_k1, material.fiber_k2, material.fiber_dispersion
    number("The fibre stiffness k₁", k1, k1 >= 0.0, "Give at least 0, in kPa; 0 means no fibres.", " kPa")
    number("The fibre exponent k₂", k2, k2 >= 0.0, "Give at least 0.")
    mend = "Give a number between 0 (aligned) and 1/3 (isotropic)."
    number("The fibre dispersion", kappa, 0.0 <= kappa <= 1.0 / 3.0 + 1e-12, mend)
    direction = material.fiber_direction
    length = math.hypot(*direction)
    if not (math.isfinite(length) and length > 0.0):
        add(direction, f"The fibre direction is {_numbers(direction)}.", "Give a finite direction that is not zero.")
    stretch = material.prestretch
    if not all(math.isfinite(v) and v > 0.0 for v in stretch):
        sentence = f"The prestretch is {_numbers(stretch)}."
        add(stretch, sentence, "Give two stretches above 0; (1, 1) means none.")
    elif in_use and stretch != (1.0, 1.0):
        sentence = f"The prestretch {_numbers(stretch)} is not solved yet."
        add(stretch, sentence, "Set lappet:prestretch to (1, 1).")
    if in_use and math.isfinite(k1) and k1 > 0.0:
        add(f"{k1:g}", f"Fibres (k₁ = {k1:g} kPa) are not solved yet.", "Set lappet:fiber:k1 to 0.")
    density = material.density
    number("The density", density, density > 0.0, "Give a density above 0; skin has about 1100.", " kg/m³")
    return problems


def _numbers(values: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{v:g}" for v in values) + ")"
