"""A file that may not be larger than so much is refused before it is there, with what would fit."""

from __future__ import annotations

from pathlib import Path

import pytest

import synthetic_skin_cache as synthetic
from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.export import size_limit
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export, exporter_of
from lappet.export.simplify_target import SimplifyTarget
from lappet.export.size_limit import ESTIMATE_ERROR, bytes_of, estimated_size


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    """Of 60 frames, so that some of them stand for the others."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"FRAMES": tuple(range(1, 61)), "INCISED": 9, "LIFTED": 36, "SUTURED": 50}.items():
            patch.setattr(synthetic, name, value)
        return SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("sized"), step=4.0))


def refusal(cache: SkinCache, target: Path, **options: object) -> Problem:
    with pytest.raises(RefusedError) as refused:
        export(ExportRequest((cache.path,), target, options))
    assert list(target.parent.iterdir()) == []
    (problem,) = refused.value.problems
    return problem


@pytest.mark.parametrize(("text", "size"), [("5MB", 5_000_000), ("800 kB", 800_000), ("1.5GB", 1_500_000_000)])
def test_a_size_is_read_as_it_is_written(text: str, size: int) -> None:
    assert bytes_of(text) == size


@pytest.mark.parametrize("text", ["5", "MB", "0MB", "-3MB", "5 mb", "5MiB"])
def test_what_is_no_size_is_refused(text: str) -> None:
    with pytest.raises(RefusedError) as refused:
        bytes_of(text)
    assert [each.code for each in refused.value.problems] == [ProblemCode.EXPORT_MAX_SIZE_TARGET]


@pytest.mark.parametrize("suffix", [".html", ".zip", ".glb"])
def test_an_estimate_from_a_few_frames_is_as_far_off_as_it_says(
    cache: SkinCache, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    monkeypatch.setattr(size_limit, "_WORTH", 1)
    request = ExportRequest((cache.path,), tmp_path / f"x{suffix}")
    found = estimated_size(exporter_of(request.target).load(), request, cache, cache.frames)
    (path,) = export(request)
    assert found is not None
    assert found.total == pytest.approx(path.stat().st_size, rel=ESTIMATE_ERROR)


def test_a_file_that_fits_is_as_it_is_without_a_limit(cache: SkinCache, tmp_path: Path) -> None:
    (plain,) = export(ExportRequest((cache.path,), tmp_path / "x.glb"))
    (within,) = export(ExportRequest((cache.path,), tmp_path / "y.glb", {"max_size": plain.stat().st_size}))
    assert within.read_bytes() == plain.read_bytes()


def test_a_file_that_is_too_large_is_not_written_and_fits_with_the_triangles_that_are_named(
    tmp_path_factory: pytest.TempPathFactory, tmp_path: Path
) -> None:
    pytest.importorskip("meshoptimizer")
    cache = SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("finer"), step=2.0))
    (plain,) = export(ExportRequest((cache.path,), tmp_path / "plain.glb"))
    most = int(0.8 * plain.stat().st_size)
    plain.unlink()
    found = refusal(cache, tmp_path / "x.glb", max_size=most)
    assert found.code == ProblemCode.EXPORT_MAX_SIZE
    triangles = int(found.remedy.split("--simplify ")[1].split(",")[0])
    options = {"max_size": most, "simplify": SimplifyTarget(triangles=triangles)}
    (path,) = export(ExportRequest((cache.path,), tmp_path / "x.glb", options))
    assert 0.5 * most < path.stat().st_size <= most


def test_a_lesson_smaller_than_its_program_is_not_to_be_had_and_what_was_there_stays(
    cache: SkinCache, tmp_path: Path
) -> None:
    (tmp_path / "x.html").write_text("before")
    with pytest.raises(RefusedError) as refused:
        export(ExportRequest((cache.path,), tmp_path / "x.html", {"max_size": 10_000}))
    (found,) = refused.value.problems
    assert found.code == ProblemCode.EXPORT_MAX_SIZE_LEAST
    assert "0.01 MB are allowed" in found.message
    assert (tmp_path / "x.html").read_text() == "before"


def test_a_package_by_bones_is_refused_before_any_bone_is_found(
    cache: SkinCache, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(size_limit, "_fitting_triangles", lambda *_: None)
    found = refusal(cache, tmp_path / "x.usdz", max_size=100_000, frames=list(cache.frames[:20]))
    assert "would take at least" in found.message
