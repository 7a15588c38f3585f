"""What is to be on a plate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from string import ascii_lowercase, ascii_uppercase

from lappet.drawing.skin_read import SkinCache
from lappet.plates.plate_steps import PlateStep, StepKind
from lappet.procedure.plate import PlateAnnotation


@dataclass(frozen=True, eq=False)
class PlateRow:
    """The panels of one solved procedure.

    Parameters
    ----------
    source
        The solved procedure.
    steps
        What its panels show.
    title
        What stands before its captions; empty where a plate shows one procedure.
    """

    source: SkinCache
    steps: tuple[PlateStep, ...]
    title: str = ""

    def is_inset(self, index: int) -> bool:
        """Tell whether a panel stands in the corner of another.

        Parameters
        ----------
        index
            Its index among the steps.

        Returns
        -------
        bool
            Whether it does.
        """
        panel = self.steps[index].panel
        return panel is not None and bool(panel.inset_of)

    def insets(self, index: int) -> list[PlateStep]:
        """List the panels that stand in the corners of a panel.

        Parameters
        ----------
        index
            The panel's index among the steps.

        Returns
        -------
        list[PlateStep]
            The panels.
        """
        host = self.steps[index].panel
        if host is None:
            return []
        return [each for each in self.steps if each.panel is not None and each.panel.inset_of == host.name]


@dataclass(frozen=True)
class PlateRequest:
    """What is to be on a plate.

    Parameters
    ----------
    rows
        Its procedures; several are drawn at one scale.
    captions
        By the index of a panel, a caption in place of the catalogue's.
    width
        Width of the page in mm.
    columns
        Panels in a row; None: as many as fit.
    view
        One of `lappet.drawing.framing.VIEWS`.
    labels, letters, arrows, measures
        Whether there are labels with leaders, letters at corners, arrows of movement, lengths and angles.
    instruments
        Whether hooks are drawn.
    landmarks
        Labels of the landmarks that are named on every panel on which they are seen.
    section
        A point in mm and a normal: all panels but that of the plan show the section there. None for no section.
    mapped
        A quantity of the skin that is mapped in color, one of `lappet.drawing.skin_source.SCALARS`, or None.
    annotations
        What is written and drawn besides, anchored to the tissue.
    small_letters
        Whether panels are called a, b, c and not A, B, C.
    bars
        Whether each panel has a scale bar, and not only the first.
    marks
        What is printed on the skin, one of `lappet.plates.printed_marks.MARKS`, or None.
    marks_spacing
        Distance of the marks at rest in mm.
    skin_lines
        Whether the procedure's skin lines are drawn.
    hatched
        Whether the area undermined is hatched.
    overlaid
        Other operations on the same tissue whose outlines are drawn over the panels, at most three.
    """

    rows: tuple[PlateRow, ...]
    captions: Mapping[int, str]
    width: float = 174.0
    columns: int | None = None
    view: str = "oblique"
    labels: bool = True
    letters: bool = True
    arrows: bool = True
    measures: bool = True
    instruments: bool = True
    landmarks: tuple[str, ...] = ()
    section: tuple[float, ...] | None = None
    mapped: str | None = None
    annotations: tuple[PlateAnnotation, ...] = ()
    small_letters: bool = False
    bars: bool = False
    marks: str | None = None
    marks_spacing: float = 5.0
    skin_lines: bool = False
    hatched: bool = True
    overlaid: tuple[PlateRow, ...] = ()

    def letter(self, index: int) -> str:
        """Name a panel.

        Parameters
        ----------
        index
            Its index.

        Returns
        -------
        str
            Its letter; empty beyond the alphabet, and where it is alone.
        """
        if len(self.panels) == 1:
            return ""
        letters = ascii_lowercase if self.small_letters else ascii_uppercase
        return letters[index] if index < len(letters) else ""

    @property
    def panels(self) -> tuple[tuple[int, int], ...]:
        """The row and the step in it of each panel that has a place of its own, in order."""
        return tuple((r, k) for r, row in enumerate(self.rows) for k in range(len(row.steps)) if not row.is_inset(k))

    def shows_hooks(self, step: PlateStep) -> bool:
        """Tell whether a panel shows the hooks: not where the wound is sewn.

        Parameters
        ----------
        step
            What the panel shows.

        Returns
        -------
        bool
            Whether it does.
        """
        return self.instruments and step.kind not in (StepKind.ON_PEDICLE, StepKind.SUTURED, StepKind.RESULT)
