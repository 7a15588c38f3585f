"""Print the requirements of pyproject.toml, one per line: `requirements.py [EXTRA ...]`.

For packaging/setup.sh, which installs them before the package itself. Needs nothing but Python 3.11.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

PYPROJECT = Path(__file__).resolve().parent.parent / "pyproject.toml"


def requirements(extras: list[str], pyproject: Path = PYPROJECT) -> list[str]:
    """Requirement specifiers of the project and of the named extras, in the file's order.

    Raises ValueError for an extra that the file does not have.
    """
    project = tomllib.loads(pyproject.read_text(encoding="utf-8"))["project"]
    optional: dict[str, list[str]] = project["optional-dependencies"]
    found: list[str] = list(project["dependencies"])
    for extra in extras:
        if extra not in optional:
            raise ValueError(f"{pyproject} has no extra '{extra}'; it has {', '.join(sorted(optional))}.")
        found += optional[extra]
    return found


if __name__ == "__main__":
    try:
        print("\n".join(requirements(sys.argv[1:])))
    except ValueError as error:
        sys.exit(str(error))
