"""The import directions of the design hold, and the check sees every way to break them."""

from __future__ import annotations

from pathlib import Path

import pytest

from check_imports import breaches

ROOT = Path(__file__).resolve().parent.parent


def write(root: Path, path: str, text: str) -> None:
    file = root / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def test_the_repository_keeps_the_import_directions() -> None:
    assert (ROOT / "shared/lappet/procedure.py").is_file()
    assert (ROOT / "solverd/src/session/session.h").is_file()
    assert [str(breach) for breach in breaches(ROOT)] == []


@pytest.mark.parametrize(
    ("path", "text", "said"),
    [
        ("shared/lappet/a.py", "import bpy\n", "only addon/ may know Blender"),
        ("shared/lappet/a.py", "def f():\n    from mathutils import Vector\n", "only addon/ may know Blender"),
        ("shared/lappet/a.py", "import importlib\nimportlib.import_module('bpy')\n", "only addon/ may know Blender"),
        ("shared/lappet/a.py", "from lappet_blender.figure import draw\n", "not the reverse"),
        ("shared/lappet/a.py", "from pxr import Usd\n", "usd_stage.py"),
        ("shared/lappet/inner/usd_stage.py", "import pxr.Usd\n", "usd_stage.py"),
        ("solverd/src/lattice/a.h", '#include "solve/newton/a.h"\n', "includes solve/newton/a.h"),
        ("solverd/src/force/materials/a.h", '#include "force/kernels/a.h"\n', "includes force/kernels/a.h"),
        ("solverd/src/solve/system/a.h", '#include "solve/multigrid/a.h"\n', "includes solve/multigrid/a.h"),
        ("solverd/src/solve/subdomain/inner/a.h", '#include "solve/newton/a.h"\n', "includes solve/newton/a.h"),
        ("solverd/src/solve/a.h", "#include <vector>\n", "solve/ is none of the layers"),
        ("solverd/src/session/a.cpp", "#include <server/codec.h>\n", "includes server/codec.h"),
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
        ("shared/lappet/usd_stage.py", "from pxr import Usd\n"),
        ("shared/lappet/inner/a.py", "from . import pxr\nfrom ..procedure import Hook\n"),
        ("addon/lappet_blender/a.py", "import bpy\nfrom lappet.procedure import Hook\nfrom pxr import Usd\n"),
        ("solverd/src/server/a.cpp", '#include "math/svd3.h"\n#include "server/codec.h"\n#include <vector>\n'),
        ("solverd/src/solve/newton/a.h", '#include "solve/newton/b.h"\n#include "force/elastic/elastic.h"\n'),
        ("solverd/src/math/simd.h", "#include <immintrin.h>\n"),
        ("solverd/src/force/kernels/product_avx2.cpp", "#include <xsimd/xsimd.hpp>\n"),
    ],
)
def test_a_right_import_passes(tmp_path: Path, path: str, text: str) -> None:
    write(tmp_path, path, text)
    assert breaches(tmp_path) == []
