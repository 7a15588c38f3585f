"""Check that imports run one way only: `check_imports.py [ROOT]`.

Python: addon -> lappet -> its dependencies. `lappet` imports neither bpy nor the add-on, only `lappet/usd_stage.py`
imports pxr, and only the add-on imports bpy. C++: server -> session -> solve -> force -> lattice -> math, inside solve
and force in the order of LAYERS; SIMD intrinsics and xsimd appear in `solverd/src/math` and in kernel files
(`*_kernel*`, `*_avx2.cpp`, ...) only; the daemon includes neither Python nor USD. Prints every breach with its line
and exits with 1 if there is one.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

# Folders of `solverd/src`: each includes only from itself and from those before it. The longest match counts.
LAYERS = (
    "math",
    "lattice",
    "force/materials",
    "force/kernels",
    "force/elastic",
    "force/constraints",
    "solve/system",
    "solve/subdomain",
    "solve/multigrid",
    "solve/newton",
    "session",
    "server",
)
BLENDER = {"bpy", "bmesh", "mathutils", "gpu", "gpu_extras", "bpy_extras", "bl_ui"}
ADDON = "lappet_blender"
PXR_MODULE = Path("shared/lappet/usd_stage.py")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
INTRINSICS = re.compile(r"^(xsimd/|[a-z0-9]*mmintrin\.h$|immintrin\.h$|x86intrin\.h$|arm_neon\.h$|arm_sve\.h$)")
FOREIGN = re.compile(r"^(Python\.h$|pybind11/|nanobind/|pxr/)")
KERNEL_FILE = re.compile(r"(_kernels?|_avx2|_avx512|_sse42|_neon)\.(h|cpp)$")


@dataclass(frozen=True)
class Breach:
    """One import that runs the wrong way."""

    path: Path
    line: int
    sentence: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.sentence}"


def imported_modules(tree: ast.AST, package: str) -> Iterator[tuple[int, str]]:
    """Line and absolute dotted name of every import, also of late ones inside functions.

    package: the dotted package that the file lies in, for relative imports. `importlib.import_module("x")` and
    `__import__("x")` with a constant name count as imports.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                above = package.split(".")
                base = ".".join([*above[: len(above) - node.level + 1], *filter(None, [base])])
            yield node.lineno, base
        elif isinstance(node, ast.Call) and node.args:
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            first = node.args[0]
            if name in ("import_module", "__import__") and isinstance(first, ast.Constant):
                yield node.lineno, str(first.value)


def python_breaches(root: Path) -> Iterator[Breach]:
    """Breaches in `shared/lappet` and `addon/lappet_blender` under `root`."""
    for folder, package in (("shared/lappet", "lappet"), ("addon/lappet_blender", ADDON)):
        for file in sorted((root / folder).rglob("*.py")):
            path = file.relative_to(root)
            inner = ".".join([package, *path.relative_to(folder).parent.parts])
            tree = ast.parse(file.read_text(encoding="utf-8"), filename=str(file))
            for line, name in imported_modules(tree, inner):
                top = name.split(".")[0]
                if package == "lappet" and top in BLENDER:
                    yield Breach(path, line, f"lappet imports {name}; only addon/ may know Blender.")
                elif package == "lappet" and top == ADDON:
                    yield Breach(path, line, f"lappet imports {name}; the add-on knows lappet, not the reverse.")
                elif package == "lappet" and top == "pxr" and path != PXR_MODULE:
                    yield Breach(path, line, f"{name} is imported outside {PXR_MODULE}; ask that module for it.")


def layer_of(path: str) -> str | None:
    """Return the layer that a file of `solverd/src` belongs to, by its path from there; None if to none."""
    found = [layer for layer in LAYERS if path.startswith(f"{layer}/")]
    return max(found, key=len, default=None)


def include_breaches(root: Path) -> Iterator[Breach]:
    """Breaches of the include direction under `root/solverd/src`."""
    source = root / "solverd" / "src"
    for file in sorted([*source.rglob("*.h"), *source.rglob("*.cpp")]):
        path = file.relative_to(root)
        folder = file.relative_to(source).parent.as_posix()
        layer = layer_of(f"{folder}/")
        if layer is None:
            yield Breach(path, 1, f"{folder}/ is none of the layers {', '.join(LAYERS)}.")
            continue
        for line, text in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
            match = INCLUDE.match(text)
            if not match:
                continue
            included = match.group(1)
            target = layer_of(included)
            if target is not None:
                if LAYERS.index(target) > LAYERS.index(layer):
                    yield Breach(path, line, f"{layer}/ includes {included}; includes run {' -> '.join(LAYERS[::-1])}.")
            elif INTRINSICS.match(included) and layer != "math" and not KERNEL_FILE.search(file.name):
                yield Breach(path, line, f"{included} belongs in solverd/src/math and kernel files only.")
            elif FOREIGN.match(included):
                yield Breach(path, line, f"{included}: the daemon knows nothing of Python, USD or Blender.")


def breaches(root: Path) -> list[Breach]:
    """Every breach under the repository root `root`."""
    return [*python_breaches(root), *include_breaches(root)]


def main(arguments: list[str]) -> int:
    """Print every breach; 1 if there is one."""
    root = Path(arguments[0]) if arguments else Path(__file__).resolve().parent.parent
    found = breaches(root)
    for breach in found:
        print(breach)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
