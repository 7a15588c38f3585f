"""The import directions of the design hold, and the check sees every way to break them."""

from __future__ import annotations

from pathlib import Path

import pytest

from check_imports import breaches

ROOT = Path(__file__).resolve().parents[2]


def write(root: Path, path: str, text: str) -> None:
    file = root / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def test_the_repository_keeps_the_import_directions() -> None:
    assert (ROOT / "shared/lappet/procedure/procedure.py").is_file()
    assert (ROOT / "solverd/src/session/session.h").is_file()
    assert [str(breach) for breach in breaches(ROOT)] == []


@pytest.mark.parametrize(
    ("path", "text", "said"),
    [
        ("shared/lappet/a.py", "import bpy\n", "only addon/ may know Blender"),
        ("shared/lappet/a.py", "def f():\n    from mathutils import Vector\n", "only addon/ may know Blender"),
        ("shared/lappet/a.py", "import importlib\nimportlib.import_module('bpy')\n", "only addon/ may know Blender"),
        ("shared/lappet/a.py", "from lappet_blender.figure import draw\n", "not the reverse"),
        ("shared/lappet/a.py", "from pxr import Usd\n", "usd/stage.py"),
        ("shared/lappet/core/stage.py", "import pxr.Usd\n", "usd/stage.py"),
        ("solverd/src/lattice/a.h", '#include "solve/newton/a.h"\n', "includes solve/newton/a.h"),
        ("solverd/src/force/materials/a.h", '#include "force/kernels/a.h"\n', "includes force/kernels/a.h"),
        ("solverd/src/solve/system/a.h", '#include "solve/multigrid/a.h"\n', "includes solve/multigrid/a.h"),
        ("solverd/src/solve/subdomain/inner/a.h", '#include "solve/newton/a.h"\n', "includes solve/newton/a.h"),
        ("solverd/src/solve/a.h", "#include <vector>\n", "solve/ is none of the layers"),
        ("solverd/src/session/a.cpp", "#include <server/decode.h>\n", "includes server/decode.h"),
        ("solverd/src/odd/a.cpp", '#include "math/svd3.h"\n', "none of the layers"),
        ("solverd/src/force/elastic/a.cpp", "#include <immintrin.h>\n", "kernel files only"),
        ("solverd/src/solve/newton/a.cpp", "#include <xsimd/xsimd.hpp>\n", "kernel files only"),
        ("solverd/src/server/a.cpp", "# include <pxr/usd/usd/stage.h>\n", "knows nothing of Python"),
    ],
)
def test_a_wrong_import_is_named_with_its_file_and_line(tmp_path: Path, path: str, text: str, said: str) -> None:
    write(tmp_path, path, text)
    found = breaches(tmp_path)
    assert len(found) == 1
    assert said in found[0].sentence
    assert str(found[0]).startswith(f"{path}:{len(text.splitlines())}: ")


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("shared/lappet/usd/stage.py", "from pxr import Usd\n"),
        ("shared/lappet/solve/a.py", "from . import pxr\nfrom ..procedure import Hook\n"),
        ("addon/lappet_blender/a.py", "import bpy\nfrom lappet.procedure import Hook\nfrom pxr import Usd\n"),
        ("solverd/src/server/a.cpp", '#include "math/svd3.h"\n#include "server/decode.h"\n#include <vector>\n'),
        ("solverd/src/solve/newton/a.h", '#include "solve/newton/b.h"\n#include "force/elastic/elastic.h"\n'),
        ("solverd/src/math/simd.h", "#include <immintrin.h>\n"),
        ("solverd/src/force/kernels/product_avx2.cpp", "#include <xsimd/xsimd.hpp>\n"),
    ],
)
def test_a_right_import_passes(tmp_path: Path, path: str, text: str) -> None:
    write(tmp_path, path, text)
    assert breaches(tmp_path) == []


@pytest.mark.parametrize(
    "text",
    [
        "from ..solving.b import f\n",
        "from ..solving import b\n",
        "def g():\n    from ..solving.b import f\n",
        "from lappet_blender.solving.b import f\n",
    ],
)
def test_a_folder_of_the_add_on_may_not_import_from_one_below_it(tmp_path: Path, text: str) -> None:
    write(tmp_path, "addon/lappet_blender/solving/b.py", "f = 1\n")
    write(tmp_path, "addon/lappet_blender/model/a.py", text)
    (found,) = breaches(tmp_path)
    assert found.sentence == "model/ imports lappet_blender.solving.b, but solving/ comes after it."
    assert str(found).startswith(f"addon/lappet_blender/model/a.py:{len(text.splitlines())}: ")


def test_a_circle_of_relative_imports_is_found(tmp_path: Path) -> None:
    write(tmp_path, "addon/lappet_blender/model/a.py", "from .b import f\n")
    write(tmp_path, "addon/lappet_blender/model/b.py", "def f():\n    from . import a\n")
    (found,) = breaches(tmp_path)
    assert "lappet_blender.model.a -> lappet_blender.model.b -> lappet_blender.model.a" in found.sentence


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("from lappet.solve.b import f\n", "geometry/ imports lappet.solve.b, but solve/ comes after it"),
        ("def g():\n    from lappet.solve.b import f\n", "geometry/ imports lappet.solve.b"),
        ("from lappet.solve import b\n", "geometry/ imports lappet.solve.b"),
    ],
)
def test_a_folder_may_not_import_from_one_below_it(tmp_path: Path, text: str, said: str) -> None:
    write(tmp_path, "shared/lappet/solve/b.py", "f = 1\n")
    write(tmp_path, "shared/lappet/geometry/a.py", text)
    assert [said in breach.sentence for breach in breaches(tmp_path)] == [True]


def test_a_folder_that_has_no_place_in_the_order_is_named(tmp_path: Path) -> None:
    write(tmp_path, "shared/lappet/core/b.py", "f = 1\n")
    write(tmp_path, "shared/lappet/odd/a.py", "from lappet.core.b import f\n")
    (found,) = breaches(tmp_path)
    assert "odd/ is none of the folders" in found.sentence


def test_a_circle_is_found_also_where_an_import_inside_a_function_hides_it(tmp_path: Path) -> None:
    write(tmp_path, "shared/lappet/geometry/a.py", "from lappet.geometry.b import f\n")
    write(tmp_path, "shared/lappet/geometry/b.py", "from lappet.geometry.c import f\n")
    write(tmp_path, "shared/lappet/geometry/c.py", "def f():\n    from lappet.geometry import a\n")
    (found,) = breaches(tmp_path)
    assert "lappet.geometry.a -> lappet.geometry.b -> lappet.geometry.c -> lappet.geometry.a" in found.sentence


def test_what_only_a_type_checker_imports_closes_no_circle(tmp_path: Path) -> None:
    write(tmp_path, "shared/lappet/geometry/a.py", "from lappet.geometry.b import f\n")
    guarded = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from lappet.geometry.a import g\n"
    write(tmp_path, "shared/lappet/geometry/b.py", guarded)
    assert breaches(tmp_path) == []
