"""One panel on a page: its drawing, its caption, its labels and measures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.section_plane import SectionPlane
from lappet.plates.annotations import AnnotationDrawer, DrawnAnnotations
from lappet.plates.boundary_labels import PlacedLabel, place_labels
from lappet.plates.feature_lines import FeatureLine
from lappet.plates.filled_areas import AreaKind
from lappet.plates.ghost_outline import VARIANTS, ghost_areas, ghost_outline, variant_outlines
from lappet.plates.inset_places import InsetPlace, inset_places, uncovered
from lappet.plates.letter_places import LetterPlaces
from lappet.plates.measures import Measure, plan_measures
from lappet.plates.panel_camera import with_body, with_camera
from lappet.plates.panel_drawing import (
    AREA_LABELS,
    SECTION_LABELS,
    PanelDrawing,
    along,
    clipped,
    label_sites,
    panel_drawing,
)
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_request import PlateRequest
from lappet.plates.plate_scene import PlateScene
from lappet.plates.plate_steps import CUTS, PlateStep, StepKind
from lappet.plates.plate_style import PlateStyle
from lappet.plates.plate_words import PlateWords
from lappet.plates.printed_marks import SkinPrint
from lappet.plates.pull_arrows import pull_arrows
from lappet.plates.section_drawing import section_drawing, section_line, section_projection
from lappet.plates.section_measures import dissection_depth
from lappet.plates.skin_anchors import SkinAnchors
from lappet.plates.taken_places import taken_places
from lappet.plates.told_labels import ToldLabels
from lappet.plates.undermined_hatch import thinned_marks, undermined_hatch

LINE = 1.2  # times the size of a text
_ON_SKIN = 0.6  # mm: a landmark that is seen may lie so far behind the surface
_UNDER_TEXT = np.array([[x, 0.0] for x in (-2.4, -1.2, 0.0, 1.2, 2.4)])  # mm: places that a measure covers
_PLANS = (StepKind.PLAN, StepKind.PLAN_EXCISION)
_PULLED = (StepKind.RAISED, StepKind.RETRACTED)
_HATCH = 2.5  # mm on paper between the lines over an area undermined
_BARS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)  # mm


@dataclass(frozen=True, eq=False)
class PagePanel:
    """A panel on the page.

    Parameters
    ----------
    letter
        Its letter, from A on.
    step
        What it shows.
    scene
        Of which procedure.
    caption
        The lines of its caption.
    middle
        Its middle on the page in mm, shape (2,).
    drawing
        The drawing.
    labels
        Labels with leaders.
    measures
        Lengths and angles.
    bar
        Length of the scale bar in mm of tissue, 0 for none.
    goes_on
        Whether skin is drawn where a cut-out of skin ends.
    size
        Its width and height in mm.
    notes
        The plate's annotations on it.
    line
        Of an inset, the line from its frame to what it shows in its panel, on the page in mm, shape (2, 2); none of a
        panel that has a place of its own.
    hooks
        Whether it shows hooks.
    section
        Whether it shows a cross-section.
    """

    letter: str
    step: PlateStep
    scene: PlateScene
    caption: tuple[str, ...]
    middle: NDArray[np.float64]
    drawing: PanelDrawing
    labels: tuple[PlacedLabel, ...]
    measures: tuple[Measure, ...]
    bar: float
    goes_on: bool
    size: tuple[float, float]
    notes: DrawnAnnotations
    line: NDArray[np.float64] | None = None
    hooks: bool = False
    section: bool = False


@dataclass(frozen=True, eq=False)
class PanelMaker:
    """What all panels of a page are made with.

    Parameters
    ----------
    request
        What is to be on the plate.
    scenes
        Its procedures, each before its camera.
    style
        How the plate looks.
    words
        What it says.
    font
        Its font.
    size
        Width and height of a panel in mm.
    variants
        The operations that are drawn over the panels, each before a camera.
    """

    request: PlateRequest
    scenes: tuple[PlateScene, ...]
    style: PlateStyle
    words: PlateWords
    font: PlateFont
    size: tuple[float, float]
    variants: tuple[PlateScene, ...] = ()

    def panels(
        self, index: int, caption: tuple[str, ...], middle: NDArray[np.float64], told: ToldLabels
    ) -> list[PagePanel]:
        """Make a panel and what stands in its corners.

        Parameters
        ----------
        index
            Its index.
        caption
            The lines of its caption.
        middle
            Its middle on the page in mm, shape (2,).
        told
            Labels of the panels before it; those of this one are added.

        Returns
        -------
        list[PagePanel]
            The panel, then its insets.

        Raises
        ------
        RefusedError
            If it has too many labels or one that is too wide.
        """
        request, (row, k) = self.request, self.request.panels[index]
        steps = request.rows[row].steps
        step, letter = steps[k], request.letter(index)
        scene = self._scene(row, step, self.size)
        insets = request.rows[row].insets(k)
        drawing, areas = self._drawing(scene, steps, k, insets, told.letters)
        places = inset_places(len(insets), self.size, taken_places(drawing))
        drawing = uncovered(drawing, places)
        notes = self._notes(scene, steps, k, drawing)
        sites = label_sites(drawing, areas) if request.labels else {}
        fresh = told.choose([key for key, site in sites.items() if _free(site, places)])
        named = [(self.words(key), sites[key]) for key in fresh] + notes.named
        if areas is AREA_LABELS:
            named += _landmarks(scene, drawing, request.landmarks, self.size)
            named += self._variant_names(drawing, told)
        measures = self._measures(scene, step, drawing) if request.measures else []
        under = [each.at + _UNDER_TEXT for each in (*measures, *notes.measures)]
        taken = np.vstack([taken_places(drawing), *under, *(_filling(place) for place in places)])
        widths = [self.font.width(text, self.style.label_size) for text, _ in named]
        own_scale = areas is SECTION_LABELS or (step.panel is not None and step.panel.at is not None)
        # The first panel, and the first of the others where these have another scale.
        other_scale = index == 1 and scene.zoom != self._scene(0, request.rows[0].steps[0], self.size).zoom
        bar = self.bar(drawing, self.size) if index == 0 or other_scale or own_scale or request.bars else 0.0
        texts = self._texts(drawing, (*measures, *notes.measures), bar)
        line = LINE * self.style.label_size
        labels = place_labels(named, widths, self.size, line, taken, letter, texts, told.places)
        told.places.update({label.text: label for label in labels})
        goes_on = scene.goes_on and areas is AREA_LABELS
        host = PagePanel(
            *(letter, step, scene, caption, middle, drawing, tuple(labels), tuple(measures)),
            *(bar, goes_on, self.size, notes),
            hooks=request.shows_hooks(step),
            section=areas is SECTION_LABELS,
        )
        return [host, *(self._inset(row, each, place, host) for each, place in zip(insets, places, strict=False))]

    def is_section(self, index: int) -> bool:
        """Tell whether a panel shows a cross-section.

        Parameters
        ----------
        index
            Its index.

        Returns
        -------
        bool
            Whether it does.
        """
        row, k = self.request.panels[index]
        return self._cut(self.request.rows[row].steps[k]) is not None

    def _measures(self, scene: PlateScene, step: PlateStep, drawing: PanelDrawing) -> list[Measure]:
        """The program's own measures of a panel: of the plan, and the depth of dissection in a section."""
        if self._cut(step) is not None:
            return dissection_depth(drawing)
        if step.kind not in _PLANS:
            return []
        letters = [each.at for each in drawing.letters]
        return plan_measures(scene.lines, scene.corners, drawing.projection, letters, scene.kept)

    def _variant_names(self, drawing: PanelDrawing, told: ToldLabels) -> list[tuple[str, NDArray[np.float64]]]:
        """The names of operations that are drawn over the panel's, each on the first panel that shows it."""
        found = []
        for row, kind in zip(self.request.overlaid, VARIANTS, strict=False):
            own = [stroke.points for stroke in drawing.strokes if stroke.kind is kind]
            if own and row.title not in told.variants:
                told.variants.add(row.title)
                found.append((row.title, along(own)))
        return found

    def _texts(self, drawing: PanelDrawing, measures: Sequence[Measure], bar: float) -> NDArray[np.float64]:
        """Boxes of letters, of measures and of the scale bar, (b, 4)."""
        font, style = self.font, self.style
        placed = [(each.at, font.width(each.text, style.letter_size), style.letter_size) for each in drawing.letters]
        placed += [(each.at, font.width(each.text, style.label_size), style.label_size) for each in measures]
        boxes = [[at[0] - 0.5 * w, at[1] - 0.5 * h, at[0] + 0.5 * w, at[1] + 0.5 * h] for at, w, h in placed]
        if bar:
            right, bottom = 0.5 * self.size[0], 0.5 * self.size[1]
            boxes.append(
                [right - 1.5 - bar * drawing.projection.scale, bottom - 1.5 - 2.0 * style.label_size, right, bottom]
            )
        return np.array(boxes, np.float64).reshape(-1, 4)

    def _inset(self, row: int, step: PlateStep, place: InsetPlace, host: PagePanel) -> PagePanel:
        """A panel in the corner of another."""
        scene = self._scene(row, step, place.size)
        request = self.request
        held = request.shows_hooks(step)
        cut = self._cut(step)
        drawing = (
            self._section(scene, step, cut, place.size)
            if cut is not None
            else panel_drawing(
                scene, step.time, place.size, self.style, (), None, held, request.mapped, skin_print=self._print
            )
        )
        notes = DrawnAnnotations()
        if step.panel is not None:
            own = [each for each in request.annotations if step.panel.name in each.panels]
            notes = AnnotationDrawer(scene, drawing, step.panel.name, (), cut).draw(own)
        site = None
        if step.panel is not None and step.panel.at is not None:
            at, _ = SkinAnchors(scene.source).at(np.array([step.panel.at]), host.step.time, last_place=True)
            site = host.drawing.projection.paper(at)[0][0]
        line = None if site is None else host.middle + np.stack([place.outline_towards(site), site])
        middle = host.middle + place.middle
        bar = self.bar(drawing, place.size)
        return PagePanel(
            *("", step, scene, (), middle, drawing, (), (), bar, scene.goes_on and cut is None, place.size, notes),
            line if line is not None else np.zeros((0, 2)),
            held,
            cut is not None,
        )

    @property
    def _print(self) -> SkinPrint:
        return SkinPrint(self.request.marks, self.request.marks_spacing, self.request.skin_lines)

    def _scene(self, row: int, step: PlateStep, size: tuple[float, float]) -> PlateScene:
        """The procedure before a panel's camera."""
        panel = step.panel
        scene = self.scenes[row]
        if len(self.request.rows) == 1 and not self.variants:  # what is compared has one scale
            scene = with_body(scene, step is self.request.rows[row].steps[0] and step.kind in _PLANS)
        return scene if panel is None else with_camera(scene, panel, step.time, size)

    def _notes(
        self, scene: PlateScene, steps: Sequence[PlateStep], index: int, drawing: PanelDrawing
    ) -> DrawnAnnotations:
        """The plate's annotations on a panel."""
        step = steps[index]
        after = [each.time for each in steps[index + 1 :] if each.panel is None or not each.panel.inset_of]
        end = next((time for time in after if time > step.time), step.time)
        later = tuple(time for time in scene.source.frames if step.time < time <= end)
        name = step.panel.name if step.panel is not None else ""
        return AnnotationDrawer(scene, drawing, name, later, self._cut(step)).draw(self.request.annotations)

    def bar(self, drawing: PanelDrawing, size: tuple[float, float]) -> float:
        """Choose the length of a panel's scale bar.

        Parameters
        ----------
        drawing
            The panel's drawing.
        size
            Its width and height in mm.

        Returns
        -------
        float
            The length in mm of tissue, 0 where none fits.
        """
        return max((each for each in _BARS if each * drawing.projection.scale <= 0.3 * size[0]), default=0.0)

    def _cut(self, step: PlateStep) -> SectionPlane | None:
        """The plane in which a panel is cut: its own, or the plate's but in the plan."""
        if step.panel is not None and step.panel.section is not None:
            return SectionPlane.of(step.panel.section)
        return None if self.request.section is None or step.kind in _PLANS else SectionPlane.of(self.request.section)

    def _cut_lines(
        self, scene: PlateScene, steps: Sequence[PlateStep], index: int, insets: Sequence[PlateStep]
    ) -> list[FeatureLine]:
        """Where the planes of other panels meet the skin: in the plan all of them, elsewhere those of its insets."""
        step = steps[index]
        shown = [*steps, *insets] if step.kind in _PLANS else insets
        planes = {each.panel.section for each in shown if each.panel is not None and each.panel.section is not None}
        planes |= {self.request.section} if self.request.section is not None and step.kind in _PLANS else set()
        return [line for plane in sorted(planes) for line in section_line(scene, SectionPlane.of(plane), step.time)]

    def _section(
        self, scene: PlateScene, step: PlateStep, cut: SectionPlane, size: tuple[float, float]
    ) -> PanelDrawing:
        """A panel cut in a plane."""
        about, across = None, 0.0
        if step.panel is not None and step.panel.at is not None:
            places, _ = SkinAnchors(scene.source).at(np.array([step.panel.at]), step.time, last_place=True)
            about, across = places[0], step.panel.across
        projection = section_projection(scene, cut, size, about, across)
        return section_drawing(scene, cut, projection, step.time, self.request.shows_hooks(step))

    def _drawing(
        self,
        scene: PlateScene,
        steps: Sequence[PlateStep],
        index: int,
        insets: Sequence[PlateStep],
        placed: LetterPlaces,
    ) -> tuple[PanelDrawing, Mapping[AreaKind, str]]:
        """The drawing of a panel and the words for its areas."""
        request, step = self.request, steps[index]
        held = request.shows_hooks(step)
        cut = self._cut(step)
        if cut is not None:
            return self._section(scene, step, cut, self.size), SECTION_LABELS
        later = _later(scene, steps, index) if request.arrows else ()
        more = self._cut_lines(scene, steps, index, insets)
        if request.hatched:
            apart = _HATCH / scene.projection(self.size).scale
            more += [*undermined_hatch(scene, step.time, apart), *thinned_marks(scene, step.time, 0.5 * apart)]
        letters = placed if request.letters else None
        pulled = request.arrows and held and step.kind in _PULLED
        pulls = pull_arrows(scene, step.time, scene.projection(self.size)) if pulled else []
        drawing = panel_drawing(
            *(scene, step.time, self.size, self.style, later, letters, held, request.mapped, more),
            skin_print=self._print,
            pulls=pulls,
        )
        if step.ghost is not None:
            ghost = clipped(ghost_outline(scene, step.ghost, self.size), self.size)
            filled = step.panel is not None and step.panel.ghost_filled
            areas = ghost_areas(scene, step.ghost, self.size) if filled else ()
            drawing = replace(drawing, strokes=(*drawing.strokes, *ghost), ghosts=areas)
        variants = variant_outlines(scene, self.variants, request.overlaid, step, self.size)
        return replace(drawing, strokes=(*drawing.strokes, *variants)), AREA_LABELS


def _later(scene: PlateScene, steps: Sequence[PlateStep], index: int) -> list[float]:
    """The frames along which arrows run: from the panel of the cut to where the flaps come to lie."""
    cut = [k for k, step in enumerate(steps) if step.kind in CUTS]
    ends = [
        step.time
        for step in steps[index + 1 :]
        if step.kind in (StepKind.ON_PEDICLE, StepKind.SUTURED, StepKind.PLACED)
    ]
    if not cut or cut[-1] != index or not ends:
        return []
    return [time for time in scene.source.frames if steps[index].time < time <= ends[-1]]


def _landmarks(
    scene: PlateScene, drawing: PanelDrawing, labels: Sequence[str], size: tuple[float, float]
) -> list[tuple[str, NDArray[np.float64]]]:
    """The landmarks of some labels that are seen, with their places on the paper."""
    places = scene.source.named_landmarks(drawing.surface.time)
    found = []
    for label in labels:
        if label not in places:
            continue  # its tissue has been excised
        paper, depth = drawing.projection.paper(places[label][None])
        inside = (np.abs(paper[0]) < 0.5 * np.asarray(size)).all()
        if inside and depth[0] <= drawing.depth_at(paper[0]) + _ON_SKIN:
            found.append((label, paper[0]))
    return found


def _free(sites: NDArray[np.float64], places: Sequence[InsetPlace]) -> bool:
    """Whether a label has somewhere to lead to that no inset covers."""
    return not all(any(place.covers(site) for place in places) for site in np.atleast_2d(sites))


def _filling(place: InsetPlace) -> NDArray[np.float64]:
    """Places all over an inset, which labels should leave free."""
    across = [np.arange(-0.5 * each, 0.5 * each + 0.1, 1.0) for each in place.size]
    x, y = np.meshgrid(*across)
    return place.middle + np.stack([x.ravel(), y.ravel()], axis=1)
