"""Check that imports run one way only: `check_imports.py [ROOT]`.

Python: addon -> lappet -> its dependencies. `lappet` imports neither bpy nor the add-on, only `lappet/usd/stage.py`
imports pxr, and only the add-on imports bpy. Inside each of the two a folder imports only from the folders above it in
`FOLDERS` and `ADDON_FOLDERS`; no modules import each other in a circle, also not by a late import inside a function.
C++: server -> session -> solve -> force -> lattice -> math -> platform, inside solve and force in the order of
`LAYERS`; SIMD intrinsics and xsimd appear in `solverd/src/math` and in kernel files (`*_kernel*`, `*_avx2.cpp`, ...)
only; the daemon includes neither Python nor USD. Prints every breach with its line and exits with 1 if there is one.
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
    "platform",
    "math",
    "lattice",
    "force/materials",
    "force/kernels",
    "force/elastic",
    "force/constraints",
    "force/self_contact",
    "solve/system",
    "solve/subdomain",
    "solve/multigrid",
    "solve/newton",
    "session",
    "server",
)
BLENDER = {"bpy", "bmesh", "mathutils", "gpu", "gpu_extras", "bpy_extras", "bl_ui", "bl_operators"}
ADDON = "lappet_blender"
PXR_MODULE = Path("shared/lappet/usd/stage.py")
# The folders of `shared/lappet` in the order in which data passes through them.
FOLDERS = (
    "core",
    "foreign",
    "procedure",
    "geometry",
    "usd",
    "tissue",
    "suturing",
    "checks",
    "designs",
    "models",
    "cutting",
    "anatomy",
    "program",
    "daemon",
    "solve",
    "background",
    "drawing",
    "output",
    "plates",
    "export",
    "lessons",
    "bench",
    "demo",
    "installation",
    "reports",
    "commands",
)
# The folders of `addon/lappet_blender`: the scene as data, what draws it, what solves it, what edits and shows it.
ADDON_FOLDERS = (
    "model",
    "interface",
    "look",
    "figure",
    "solving",
    "tissue",
    "events",
    "display",
    "tools",
    "strips",
    "files",
    "plates",
    "start",
    "translation",
)
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


def is_type_checking(node: ast.AST) -> bool:
    """Whether a statement is `if TYPE_CHECKING:`, whose imports no program runs."""
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


@dataclass(frozen=True)
class Package:
    """A Python package whose folders have an order. parent: the folder that holds it, from the repository's root."""

    name: str
    parent: Path
    folders: tuple[str, ...]

    def folder_of(self, module: str) -> str:
        """The folder that a module lies in; empty for modules beside the folders (`lappet.__main__`)."""
        parts = module.split(".")
        return parts[1] if len(parts) > 1 and not parts[1].startswith("__") else ""


PACKAGES = (Package("lappet", Path("shared"), FOLDERS), Package(ADDON, Path("addon"), ADDON_FOLDERS))


def package_imports(root: Path, package: Package) -> dict[str, dict[str, int]]:
    """For each module of a package by dotted name: the modules of the package that it imports, with the line.

    What is imported for type checkers alone is left out. `from lappet.procedure import Hook` is an import of the
    package `lappet.procedure`, `from lappet.daemon import client` and `from . import client` are of the module.
    """
    parent = root / package.parent
    files = {}
    for file in sorted((parent / package.name).rglob("*.py")):
        parts = file.relative_to(parent).with_suffix("").parts
        files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    found: dict[str, dict[str, int]] = {}
    for module, file in files.items():
        edges = found.setdefault(module, {})
        inner = module if file.name == "__init__.py" else module.rpartition(".")[0]
        pending: list[ast.AST] = [ast.parse(file.read_text(encoding="utf-8"), filename=str(file))]
        while pending:
            node = pending.pop()
            for name in imported_names(node, inner):
                target = name if name in files else name.rpartition(".")[0]
                if target in files and target != module:
                    edges.setdefault(target, node.lineno)  # type: ignore[attr-defined]
            pending += [each for each in ast.iter_child_nodes(node) if not is_type_checking(each)]
    return found


def imported_names(node: ast.AST, package: str) -> list[str]:
    """The absolute dotted names that a statement in a module of `package` imports."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if not isinstance(node, ast.ImportFrom):
        return []
    above = package.split(".")
    base = ".".join([*above[: len(above) - node.level + 1], *filter(None, [node.module])] if node.level else [])
    return [f"{base or node.module}.{alias.name}" for alias in node.names]


def folder_breaches(root: Path, package: Package) -> Iterator[Breach]:
    """Imports inside a package that run against the order of its folders, and modules that import each other."""
    imports, folders = package_imports(root, package), package.folders

    def breach(module: str, target: str, sentence: str) -> Breach:
        file = root / package.parent / Path(*module.split("."))
        path = file / "__init__.py" if file.is_dir() else file.with_suffix(".py")
        return Breach(path.relative_to(root), imports[module][target], sentence)

    for module, targets in imports.items():
        here = package.folder_of(module)
        for target in targets:
            there = package.folder_of(target)
            if here and here not in folders:
                yield breach(module, target, f"{here}/ is none of the folders {', '.join(folders)}.")
            elif here and there not in folders:
                yield breach(module, target, f"{target} lies in none of the folders {', '.join(folders)}.")
            elif here and folders.index(there) > folders.index(here):
                yield breach(module, target, f"{here}/ imports {target}, but {there}/ comes after it.")
    yield from (breach(*circle) for circle in circles(imports))


def circles(imports: dict[str, dict[str, int]]) -> Iterator[tuple[str, str, str]]:
    """One (module, target, sentence) for each import that closes a circle.

    A package and its own modules are one circle only where a module imports the package by name.
    """
    done: set[str] = set()
    for start in imports:
        path: list[str] = []
        stack = [(start, iter(imports[start]))]
        path.append(start)
        while stack:
            module, targets = stack[-1]
            target = next(targets, None)
            if target is None:
                done.add(module)
                stack.pop()
                path.pop()
            elif target in path:
                around = " -> ".join([*path[path.index(target) :], target])
                yield module, target, f"{around} is a circle; pass the service in, or move what both need."
            elif target not in done:
                path.append(target)
                stack.append((target, iter(imports.get(target, {}))))


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
    inside = [breach for package in PACKAGES for breach in folder_breaches(root, package)]
    return [*python_breaches(root), *inside, *include_breaches(root)]


def main(arguments: list[str]) -> int:
    """Print every breach; 1 if there is one."""
    root = Path(arguments[0]) if arguments else Path(__file__).resolve().parent.parent
    found = breaches(root)
    for breach in found:
        print(breach)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
