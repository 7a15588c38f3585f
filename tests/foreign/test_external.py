"""What lies outside the folder of a file is followed only where that is allowed, and no error tells whether it is."""

from __future__ import annotations

import os
from pathlib import Path

import bombs
import numpy as np
import pytest

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import ReadLimits
from lappet.tissue.mesh_file import read_mesh
from lappet.usd.stage import open_stage, read_here, read_procedure, write_procedure

ALLOWED = ReadLimits(allow_external=True)
HOOK = "/Procedure/Timeline/hook"
ARCS = {
    "sublayer": ("", "@./sound.usda@, {at}"),
    "reference": ('def "a" (\n    references = {at}</Procedure>\n)\n{{\n}}\n', ""),
    "payload": ('def "a" (\n    payload = {at}</Procedure>\n)\n{{\n}}\n', ""),
    "variant": (
        'def "a" (\n    variants = {{ string v = "one" }}\n    variantSets = "v"\n)\n{{\n    variantSet "v" = {{\n'
        '        "one" {{\n        }}\n        "two" (\n            references = {at}</Procedure>\n        ) {{\n'
        "        }}\n    }}\n}}\n",
        "",
    ),
    "clip": (
        'over "Procedure" (\n    clips = {{\n        dictionary default = {{\n            asset[] assetPaths = [{at}]\n'
        '            string primPath = "/Procedure"\n            double2[] active = [(0, 0)]\n'
        "            double2[] times = [(0, 0)]\n        }}\n    }}\n)\n{{\n}}\n",
        "",
    ),
    "manifest": (
        'over "Procedure" (\n    clips = {{\n        dictionary default = {{\n'
        "            asset manifestAssetPath = {at}\n        }}\n    }}\n)\n{{\n}}\n",
        "",
    ),
}


@pytest.fixture
def inside(tmp_path: Path) -> Path:
    """A folder beside a procedure that lies outside."""
    folder = tmp_path / "inside"
    folder.mkdir()
    bombs.procedure(tmp_path, "outside.usda")
    return folder


def over(folder: Path, arc: str, named: str) -> Path:
    prims, layers = (each.format(at=f"@{named}@") for each in ARCS[arc])
    file = bombs.with_prims(folder, prims)
    if layers:
        file.write_text(file.read_text(encoding="utf-8").replace("@./sound.usda@", layers), encoding="utf-8")
    return file


def refusal(file: Path) -> tuple[ProblemCode, str, str]:
    with pytest.raises(RefusedError) as error:
        read_here(file)
    (problem,) = error.value.problems
    return problem.code, problem.value, problem.message


@pytest.mark.parametrize("arc", ARCS)
@pytest.mark.parametrize("named", ["../{}.usda", "{}.usda", "./a/../../{}.usda", "../{}.usda[inner.usda]"])
def test_a_layer_outside_is_refused_in_the_same_words_whether_it_is_there_or_not(
    inside: Path, arc: str, named: str
) -> None:
    said = []
    for name in ("outside", "missing"):
        place = name if named.startswith((".", "/")) else str(inside.parent / name)
        path = named.format(place)
        code, value, message = refusal(over(inside, arc, path))
        assert code is ProblemCode.READ_OUTSIDE
        assert value == path
        said.append(message.replace(f"{name}.usda", "X"))
    assert said[0] == said[1]


@pytest.mark.parametrize("arc", ["sublayer", "reference", "payload"])
def test_a_layer_outside_is_followed_where_that_is_allowed(inside: Path, arc: str) -> None:
    file = over(inside, arc, "../outside.usda")
    stage = open_stage(file, ALLOWED)
    assert any(layer.realPath.endswith("outside.usda") for layer in stage.GetUsedLayers())
    assert read_here(file, ALLOWED).procedure is not None
    assert refusal(file)[0] is ProblemCode.READ_OUTSIDE


def test_layers_inside_are_followed_wherever_they_lie_there(inside: Path) -> None:
    (inside / "deeper").mkdir()
    bombs.procedure(inside / "deeper", "below.usda")
    middle = inside / "deeper" / "middle.usda"
    middle.write_text("#usda 1.0\n(\n    subLayers = [@./below.usda@, @../beside.usda@]\n)\n")
    bombs.procedure(inside, "beside.usda")
    file = inside / "top.usda"
    file.write_text(bombs.HEADER.format(layers="@./deeper/middle.usda@"), encoding="utf-8")
    procedure = read_procedure(file)
    assert [event.name for event in procedure.events] == ["hook"]


def test_a_layer_outside_that_a_layer_inside_names_is_refused(inside: Path) -> None:
    (inside / "deeper").mkdir()
    middle = inside / "deeper" / "middle.usda"
    middle.write_text("#usda 1.0\n(\n    subLayers = [@../../outside.usda@]\n)\n")
    assert refusal(over(inside, "sublayer", "./deeper/middle.usda"))[0] is ProblemCode.READ_OUTSIDE


def test_an_expression_that_may_name_anything_is_refused(inside: Path) -> None:
    file = over(inside, "reference", '`"${V}"`')
    variables = '    expressionVariables = { string V = "../outside.usda" }\n'
    file.write_text(file.read_text(encoding="utf-8").replace("(\n", "(\n" + variables, 1), encoding="utf-8")
    assert refusal(file)[0] is ProblemCode.READ_OUTSIDE


@pytest.mark.skipif(os.name != "posix", reason="links are not everybody's here")
@pytest.mark.parametrize("name", ["outside", "missing"])
def test_a_link_inside_that_leads_outside_is_refused(inside: Path, name: str) -> None:
    (inside / "link.usda").symlink_to(f"../{name}.usda")
    (inside / "folder").symlink_to("..")
    assert refusal(over(inside, "reference", "./link.usda"))[0] is ProblemCode.READ_OUTSIDE
    assert refusal(over(inside, "reference", f"./folder/{name}.usda"))[0] is ProblemCode.READ_OUTSIDE
    (inside / "round.usda").symlink_to("round.usda")
    assert refusal(over(inside, "reference", "./round.usda"))[0] is ProblemCode.USD_COMPOSITION


@pytest.mark.skipif(os.name != "posix", reason="links are not everybody's here")
def test_clips_of_a_template_that_are_links_outside_are_refused(inside: Path) -> None:
    (inside / "clip.7.usda").symlink_to("../outside.usda")
    assert refusal(bombs.clips(inside, "double templateStride = 1"))[0] is ProblemCode.READ_OUTSIDE
    assert refusal(bombs.clips(inside, "double templateStride = 1", "../#.usda"))[0] is ProblemCode.READ_OUTSIDE


def test_a_terminal_obeys_nothing_that_a_file_says(inside: Path) -> None:
    file = bombs.gltf(inside, buffers=[{"uri": "../\x1b]0;title\x07.bin", "byteLength": 36}])
    with pytest.raises(RefusedError) as error:
        read_mesh(file)
    assert str(error.value).isprintable()
    assert "?]0;title?" in str(error.value)


def test_pictures_that_materials_name_are_left_alone(inside: Path) -> None:
    """Lappet opens none, so a scene with pictures elsewhere is read as ever."""
    file = bombs.with_prims(inside, 'def "a"\n{\n    asset picture = @/elsewhere/skin.png@\n}\n')
    assert read_here(file).procedure is not None


def test_the_search_path_of_usd_leads_nowhere(inside: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PXR_AR_DEFAULT_SEARCH_PATH", str(inside.parent))
    file = over(inside, "reference", "outside.usda")
    with pytest.raises(RefusedError) as error:
        read_procedure(file)
    assert [problem.code for problem in error.value.problems] == [ProblemCode.USD_COMPOSITION]


@pytest.mark.parametrize("name", ["outside", "missing"])
def test_a_buffer_outside_is_refused_in_the_same_words_whether_it_is_there_or_not(inside: Path, name: str) -> None:
    file = bombs.gltf(inside)
    points = (inside / "points.bin").read_bytes()
    (inside.parent / "outside.bin").write_bytes(points)
    named = f"../{name}.bin"
    bombs.gltf(inside, buffers=[{"uri": named, "byteLength": len(points)}])
    with pytest.raises(RefusedError) as error:
        read_mesh(file)
    assert [(each.code, each.value) for each in error.value.problems] == [(ProblemCode.READ_OUTSIDE, named)]
    if name == "outside":
        mesh, _ = read_mesh(file, limits=ALLOWED)
        assert np.allclose(np.ptp(mesh.points, axis=0), (100.0, 0.0, 100.0))


def test_a_buffer_whose_name_is_written_as_a_web_address_is_read(inside: Path) -> None:
    file = bombs.gltf(inside)
    (inside / "points.bin").rename(inside / "my points.bin")
    size = (inside / "my points.bin").stat().st_size
    bombs.gltf(inside, buffers=[{"uri": "my%20points.bin", "byteLength": size}])
    (inside / "points.bin").unlink()
    assert len(read_mesh(file)[0].triangles) == 1


def test_what_is_allowed_is_read_as_it_stands(inside: Path) -> None:
    procedure = read_procedure(over(inside, "sublayer", "../outside.usda"), limits=ALLOWED)
    write_procedure(procedure, inside / "again.usda")
    assert read_here(inside / "again.usda").procedure == procedure
