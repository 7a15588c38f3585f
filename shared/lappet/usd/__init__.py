"""Procedures as USD files; the only importer of pxr."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lappet.core.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from lappet.usd.stage import open_stage, pxr, read_procedure, save_layer, write_procedure

__all__ = ["open_stage", "pxr", "read_procedure", "save_layer", "write_procedure"]

__getattr__, __dir__ = lazy_exports(
    __name__, {"stage": ("open_stage", "pxr", "read_procedure", "save_layer", "write_procedure")}
)
