"""The package meshoptimizer, which compresses and simplifies meshes, where it is installed."""

from __future__ import annotations

from typing import Any

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode


def meshopt(option: str = "--meshopt") -> Any:
    """Load the package.

    Parameters
    ----------
    option
        What asks for it.

    Returns
    -------
    Any
        The module.

    Raises
    ------
    RefusedError
        If it is not installed.
    """
    try:
        import meshoptimizer
    except ImportError as error:
        raise refused(ProblemCode.EXPORT_NO_MESHOPT, option, "meshoptimizer") from error
    meshoptimizer.encode_vertex_version(0)  # that of the extension
    return meshoptimizer
