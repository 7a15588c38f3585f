"""Packages that come with an extra of the installation, asked for before work starts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode


@contextmanager
def extra(what: str, name: str) -> Iterator[None]:
    """Import what an extra brings; where it is missing, that is refused with how to get it.

    Parameters
    ----------
    what
        What needs it, as the sentence begins.
    name
        The extra, such as "plates"; several are separated by commas.

    Yields
    ------
    None
        The context in which modules are imported.

    Raises
    ------
    RefusedError
        If a module outside of Lappet is missing.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package in ("", "lappet"):
            raise
        raise refused(ProblemCode.REPORT_NEEDS, "", error, what=what, package=package, extra=name) from error
