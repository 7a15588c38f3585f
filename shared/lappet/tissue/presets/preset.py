"""A preset: a material, its tension in vivo, and where each of its numbers comes from. Moduli are kPa, lengths mm."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from lappet.procedure import Material
from lappet.tissue.uniaxial import prestretch_for

CHOSEN = "chosen"
WORDS = {
    "youngs_modulus": "Young's modulus",
    "poissons_ratio": "Poisson's ratio",
    "fiber_k1": "fibers' k₁",
    "fiber_k2": "fibers' k₂",
    "fiber_dispersion": "dispersion",
    "fiber_slack": "slack",
    "muscle_stress": "muscle stress",
    "density": "density",
    "tension": "tension",
}
_DIGITS = 4  # of a prestretch


@dataclass(frozen=True)
class Sourced:
    """A number of a preset.

    Parameters
    ----------
    parameter
        A key of `WORDS`: a field of `Material`, or "tension".
    value
        What it is, with its unit.
    source
        A key of `SOURCES`, or `CHOSEN` where nothing was measured.
    how
        How it was measured and follows from the source; why it was chosen.
    """

    parameter: str
    value: str
    source: str
    how: str


@dataclass(frozen=True)
class PublishedCurve:
    """A published uniaxial curve, as its paper sums it up.

    Parameters
    ----------
    source
        A key of `SOURCES`.
    what
        The specimens.
    terminal_slope
        Slope of its linear end in kPa.
    last
        Stretch at which it ends.
    last_stress
        Nominal stress there in kPa.
    initial_slope
        Slope at rest in kPa; None where the paper's summary has none.
    """

    source: str
    what: str
    terminal_slope: float
    last: float
    last_stress: float
    initial_slope: float | None = None

    @property
    def knee(self) -> float:
        """Stretch at which the linear end, prolonged, meets the axis."""
        return self.last - self.last_stress / self.terminal_slope


@dataclass(frozen=True)
class Preset:
    """A material to start from.

    Parameters
    ----------
    unstretched
        The material without prestretch.
    summary
        What it is, in a sentence.
    values
        Its numbers; every one of the material that is not a default is among them.
    tension
        In-vivo tension along and across the fibers in kPa of true stress; (0, 0) for tissue at rest.
    published
        The curve that its own was fitted to, if any.
    """

    unstretched: Material
    summary: str
    values: tuple[Sourced, ...]
    tension: tuple[float, float] = (0.0, 0.0)
    published: PublishedCurve | None = None

    @cached_property
    def material(self) -> Material:
        """The material, prestretched so that it has its tension."""
        if self.tension == (0.0, 0.0):
            return self.unstretched
        along, across = prestretch_for(self.unstretched, *self.tension)
        return replace(self.unstretched, prestretch=(round(along, _DIGITS), round(across, _DIGITS)))

    @property
    def source(self) -> str:
        """Where its numbers come from, in sentences."""
        names = dict.fromkeys(value.source for value in self.values if value.source != CHOSEN)
        chosen = [WORDS[value.parameter] for value in self.values if value.source == CHOSEN]
        text = self.summary
        if names:
            text += " From " + "; ".join(SOURCES[name] for name in names) + "."
        return f"{text} Chosen: {', '.join(chosen)}." if chosen else text


SOURCES: dict[str, str] = {
    "Ní Annaidh 2012": (
        "Ní Annaidh et al. 2012, J Mech Behav Biomed Mater 5:139, doi 10.1016/j.jmbbm.2011.08.016: 56 strips of "
        "excised skin of the human back drawn to failure"
    ),
    "Ní Annaidh 2012b": (
        "Ní Annaidh et al. 2012, Ann Biomed Eng 40:1666, doi 10.1007/s10439-012-0542-3: the fibers of excised skin of "
        "the human back"
    ),
    "Jor 2011": (
        "Jor et al. 2011, Biomech Model Mechanobiol 10:767, doi 10.1007/s10237-010-0272-0: excised pig skin stretched "
        "biaxially: matrix of 5 to 32 kPa, mean undulation of the fibers of 1.04 to 1.34"
    ),
    "Diridollou 2000": (
        "Diridollou et al. 2000, Skin Res Technol 6:214: suction on the forearms of 10 men: Young's modulus of "
        "129 ± 88 kPa at a tension of 13.5 ± 5 kPa"
    ),
    "Flynn 2011": (
        "Flynn, Taberner, Nielsen 2011, Ann Biomed Eng 39:1935: a micro-robot on forearms and upper arms: tensions of "
        "28 to 92 kPa"
    ),
    "Flynn 2018": (
        "Flynn et al. 2018, Lect Notes Bioeng p. 43, doi 10.1007/978-3-319-59764-5_6: a probe on the faces of "
        "volunteers: tensions of 7 kPa at the lip to 53 kPa in the middle of the cheek"
    ),
    "Agache 1980": (
        "Agache et al. 1980, Arch Dermatol Res 269:221, doi 10.1007/BF00406415: torsion on 138 people of 3 to 89 "
        "years: Young's modulus doubles with age"
    ),
    "Sims 2010": (
        "Sims et al. 2010, Biomech Model Mechanobiol 9:703, doi 10.1007/s10237-010-0207-9: pigs' subdermal fat under "
        "an indenter: shear modulus of 0.53 ± 0.31 kPa"
    ),
    "Zwirner 2020a": (
        "Zwirner et al. 2020, J Mech Behav Biomed Mater 108:103833: 52 temporal muscle fasciae drawn to failure: "
        "26.2 MPa, 2.9 MPa at a strain of 14.1 %"
    ),
    "Zwirner 2020b": (
        "Zwirner et al. 2020, J Biomech 106:109829, doi 10.1016/j.jbiomech.2020.109829: 88 temporal muscles drawn to "
        "failure: 1.58 ± 0.64 MPa, 0.26 MPa at a strain of 26.2 %"
    ),
    "Blemker 2005": "Blemker, Pinsky, Delp 2005, J Biomech 38:657: greatest isometric stress of 300 kPa",
    "Richmon 2005": (
        "Richmon et al. 2005, Am J Rhinol 19:617: 55 strips of human septal cartilage drawn to failure: equilibrium "
        "modulus of 3.01 ± 0.39 MPa, 1.90 MPa at a strain of 35 %, the same in every direction"
    ),
    "Sun 2015": (
        "Sun et al. 2015, J Biomech 48:3455: ten human tarsal plates: toe modulus of 0.14 MPa, elastic modulus of "
        "1.73 MPa, extensibility of 15.8 %"
    ),
}
