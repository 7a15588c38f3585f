"""The operators of the Blender extension, read from its sources without Blender."""

from __future__ import annotations

import ast
from pathlib import Path

ADDON = Path(__file__).resolve().parent.parent / "addon" / "lappet_blender"


def operators() -> dict[str, set[str]]:
    """The operators of the extension and their properties, of their classes and of those they are made from."""
    classes: dict[str, ast.ClassDef] = {}
    for file in ADDON.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                classes[f"{file.stem}.{node.name}"] = node

    def properties(stem: str, node: ast.ClassDef) -> set[str]:
        own = {n.target.id for n in node.body if isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name)}
        above = [f"{stem}.{base.id}" for base in node.bases if isinstance(base, ast.Name)]
        if any(isinstance(base, ast.Name) and base.id in ("ExportHelper", "ImportHelper") for base in node.bases):
            own.add("filepath")
        return own.union(*(properties(stem, classes[name]) for name in above if name in classes))

    found: dict[str, set[str]] = {}
    for name, node in classes.items():
        if any(ast.unparse(base) == "bpy.types.Operator" for base in node.bases):
            stem, _, kind = name.partition(".")
            found[kind.removeprefix("LAPPET_OT_")] = properties(stem, node)
    return found
