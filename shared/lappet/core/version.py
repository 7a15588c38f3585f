"""Which version of Lappet this is."""

from __future__ import annotations


def version() -> str:
    """Look up the version of the installed package.

    Returns
    -------
    str
        The version; "0+unknown" in a checkout that is not installed.
    """
    from importlib.metadata import PackageNotFoundError  # 60 ms that `import lappet` shall not take
    from importlib.metadata import version as installed_version

    try:
        return installed_version("lappet")
    except PackageNotFoundError:
        return "0+unknown"
