"""Plates are written into a procedure and read back as they were; what they should not hold is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from lappet.core.problem_code import ProblemCode
from lappet.designs.library_operation import add_flap
from lappet.plates.plate_templates import TEMPLATES, from_template, steps_of
from lappet.procedure import Plate, PlateAnnotation, PlatePanel, Procedure
from lappet.program.compile import compile_program
from lappet.program.keys import frame_keys
from lappet.tissue import flat_patch
from lappet.usd.stage import pxr, read_procedure, write_procedure
from refusals import refuses

TOP = 4.0


@pytest.fixture(scope="module")
def limberg() -> Procedure:
    patch = Procedure(flat_patch((120.0, 100.0, TOP), spacing=4.0), start_time=1, end_time=1)
    return add_flap(patch, "limberg", (0.0, 0.0, TOP), (1.0, 0.0, 0.0), {"side": 12.0}, start=1)


def full() -> Plate:
    panels = (
        PlatePanel("before", "plan", caption="Défaut – 12 mm"),
        PlatePanel("frame", time=7.25, view="top", at=(1.5, 2.25, 4.0), across=20.0),
        PlatePanel(
            "detail", "result", at=(1.0, 2.0, 4.0), across=6.0, inset_of="before", ghost="plan", ghost_filled=True
        ),
        PlatePanel("cut", "result", section_at=(0.0, 1.0, 4.0), section_normal=(0.0, 1.0, 0.0)),
    )
    notes = (
        PlateAnnotation("tip", "label", ((0.1, 0.2, 4.0),), "tip", ("before",), (3.0, -2.5), "last-place"),
        PlateAnnotation("scar", "length", ((0.0, 0.0, 4.0), (5.0, 0.0, 4.0), (5.0, 3.0, 4.0))),
    )
    flags = {"labels": False, "letters": False, "arrows": False, "measures": False, "instruments": False}
    return Plate(
        *("mine", "wash", 7, 85.0, 2, "fr", "low", "tension", (0.0, 0.5, 4.0), (0.0, 1.0, 0.0)),
        **flags,
        landmarks=("lid margin", "ala"),
        panels=panels,
        annotations=notes,
        text=9.5,
        journal="plos",
        marks="squares",
        marks_spacing=4.0,
        skin_lines=True,
        plan_pen="dotted",
        hatched=False,
    )


def test_a_plate_comes_back_as_it_was(limberg: Procedure, tmp_path: Path) -> None:
    given = replace(limberg, plates=(full(), Plate("plain")))
    for name in ("p.usda", "p.usdc"):
        write_procedure(given, tmp_path / name)
        assert read_procedure(tmp_path / name) == given


def test_a_plate_changes_no_frame(limberg: Procedure) -> None:
    with_plate = replace(limberg, plates=(full(),))
    one, other = (frame_keys(compile_program(each), "") for each in (limberg, with_plate))
    assert one == other


@pytest.mark.parametrize("template", list(TEMPLATES))
def test_a_template_is_a_plate_that_can_be_written_and_read(limberg: Procedure, template: str, tmp_path: Path) -> None:
    first = from_template(limberg, template)
    given = replace(limberg, plates=(first,))
    second = from_template(given, template)
    assert (first.name, second.name) == (template, f"{template}_2")
    write_procedure(replace(given, plates=(first, second)), tmp_path / "p.usda")
    assert read_procedure(tmp_path / "p.usda").plates == (first, second)


def test_the_steps_of_a_limberg_are_all_there_are(limberg: Procedure) -> None:
    assert steps_of(limberg) == ("plan", "cut", "raised", "placed", "sutured", "result")
    assert steps_of(replace(limberg, events=())) == ("plan", "result")


def test_two_panels_of_a_name_are_refused(limberg: Procedure, tmp_path: Path) -> None:
    twice = Plate("twice", panels=(PlatePanel("a", "plan"), PlatePanel("a", "cut")))
    with refuses(ProblemCode.NAME_TWICE, "/Procedure/Plates/twice/Panels/a"):
        write_procedure(replace(limberg, plates=(twice,)), tmp_path / "p.usda")


@pytest.mark.parametrize(
    ("path", "name", "value", "code"),
    [
        ("mine", "style", "oil", ProblemCode.PLATE_TOKEN),
        ("mine", "view", "under", ProblemCode.PLATE_TOKEN),
        ("mine/Panels/before", "step", "later", ProblemCode.PLATE_TOKEN),
        ("mine/Annotations/scar", "kind", "angle", None),
        ("mine/Annotations/tip", "kind", "angle", ProblemCode.ANNOTATION_ANCHORS),
    ],
)
def test_a_choice_that_does_not_exist_is_refused_by_its_prim(
    limberg: Procedure, tmp_path: Path, path: str, name: str, value: str, code: ProblemCode | None
) -> None:
    file = tmp_path / "p.usda"
    write_procedure(replace(limberg, plates=(full(),)), file)
    stage = pxr().Usd.Stage.Open(str(file))
    stage.GetPrimAtPath(f"/Procedure/Plates/{path}").GetAttribute(f"lappet:{name}").Set(value)
    stage.Save()
    if code is None:
        assert read_procedure(file).plates[0].annotations[1].kind == value
        return
    with refuses(code, f"/Procedure/Plates/{path}"):
        read_procedure(file)
