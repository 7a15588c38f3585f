"""What is wrong with a procedure before anything is cut."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lappet.core.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from lappet.checks.validation import check, check_read

__all__ = ["check", "check_read"]

__getattr__, __dir__ = lazy_exports(__name__, {"validation": ("check", "check_read")})
