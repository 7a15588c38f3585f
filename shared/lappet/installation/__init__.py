"""What of Lappet is installed and whether it works: `lappet doctor`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lappet.core.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from lappet.installation.finding import Finding
    from lappet.installation.packages import check_packages
    from lappet.installation.places import check_places
    from lappet.installation.solver import check_solver

__all__ = ["Finding", "check_packages", "check_places", "check_solver"]

__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "finding": ("Finding",),
        "packages": ("check_packages",),
        "places": ("check_places",),
        "solver": ("check_solver",),
    },
)
