"""Every format is refused, or what it lacks is told, before any work."""

from __future__ import annotations

from pathlib import Path

import pytest

import synthetic_skin_cache as synthetic
from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.export import blender_file
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import missing_frames
from lappet.export.formats import EXPORTERS, FILMS, export

SUFFIXES = [each.suffix for each in EXPORTERS]


@pytest.fixture(scope="module")
def holed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache that lacks frames 5 to 7 and 10."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(synthetic, "FRAMES", (1, 2, 3, 4, 8, 9, 11, 12))
        return synthetic.write_cache(tmp_path_factory.mktemp("holed"), step=8.0)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_frames_missing_in_the_middle_are_told_before_work(
    suffix: str, holed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(blender_file, "_check_blender", lambda _: None)
    still = suffix in (".stl", ".obj", ".ply", ".3mf")
    told: list[Problem] = []

    def note(problem: Problem) -> None:
        told.append(problem)
        raise InterruptedError

    request = ExportRequest((holed,), tmp_path / f"skin{suffix}", {"every_frame": True} if still else {}, note=note)
    with pytest.raises(InterruptedError):
        export(request)
    assert [(each.code, each.value) for each in told] == [(ProblemCode.EXPORT_FRAMES_MISSING, "5 to 7, 10")]
    assert "does not hold frames 5 to 7, 10;" in told[0].message
    assert "Solve the procedure again" in told[0].remedy
    assert not list(tmp_path.iterdir())


def test_nothing_is_said_of_frames_that_were_chosen(holed: Path, tmp_path: Path) -> None:
    told: list[Problem] = []
    export(ExportRequest((holed,), tmp_path / "skin.csv", {"frames": (1, 4, 12)}, note=told.append))
    assert told == []


@pytest.mark.parametrize(
    ("frames", "missing"),
    [
        ((1, 2, 3), []),
        ((1,), []),
        ((1, 5, 9, 13), []),
        ((1, 5, 13, 17), [(9, 9)]),
        ((1, 2, 7, 20), [(3, 6), (8, 19)]),
        ((0.1, 0.2, 0.3, 0.5), [(0.4, 0.4)]),
    ],
)
def test_frames_are_missing_where_others_are_nearer(
    frames: tuple[float, ...], missing: list[tuple[float, float]]
) -> None:
    found = missing_frames(frames)
    assert [value for span in found for value in span] == pytest.approx([value for span in missing for value in span])


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="/proc is the folder that nobody, root neither, can write")
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_place_that_cannot_be_written_is_refused_before_the_cache_is_read(suffix: str) -> None:
    target = Path("/proc") / f"skin{suffix}"
    with pytest.raises(RefusedError) as refused:
        export(ExportRequest((Path("no cache is there.usdc"),), target))
    assert [each.code for each in refused.value.problems] == [ProblemCode.EXPORT_PLACE]
    assert refused.value.problems[0].value == "/proc"


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_in_place_of_the_folder_or_a_folder_in_place_of_the_file_is_refused(suffix: str, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / f"taken{suffix}").mkdir()
    for target, code in (
        (tmp_path / "file" / f"skin{suffix}", ProblemCode.EXPORT_FOLDER),
        (tmp_path / f"taken{suffix}", ProblemCode.EXPORT_PLACE),
    ):
        with pytest.raises(RefusedError) as refused:
            export(ExportRequest((Path("no cache is there.usdc"),), target))
        assert [each.code for each in refused.value.problems] == [code]


@pytest.mark.parametrize("suffix", FILMS)
def test_a_film_is_refused_with_the_commands_that_make_one(suffix: str, tmp_path: Path) -> None:
    with pytest.raises(RefusedError) as refusal:
        export(ExportRequest((tmp_path / "no.usdc",), tmp_path / f"x{suffix}"))
    (found,) = refusal.value.problems
    assert found.code == ProblemCode.EXPORT_FILM
    assert f"lappet film CACHE -o {tmp_path}" in found.remedy
