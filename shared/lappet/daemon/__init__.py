"""The daemon as a process, its connection, wire format and client."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lappet.core.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from lappet.daemon.client import SolverClient
    from lappet.daemon.process import SolverDaemon, find_daemon

__all__ = ["SolverClient", "SolverDaemon", "find_daemon"]

__getattr__, __dir__ = lazy_exports(__name__, {"client": ("SolverClient",), "process": ("SolverDaemon", "find_daemon")})
