"""Which version of Lappet this is."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version


def version() -> str:
    """Look up the version of the installed package.

    Returns
    -------
    str
        The version; "0+unknown" in a checkout that is not installed.
    """
    try:
        return installed_version("lappet")
    except PackageNotFoundError:  # a checkout that is not installed
        return "0+unknown"
