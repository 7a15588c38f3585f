"""The error that a report refuses with."""

from __future__ import annotations

from lappet.core.problem import RefusedError


class ReportError(RefusedError):
    """A report cannot be made; the message is a sentence."""
