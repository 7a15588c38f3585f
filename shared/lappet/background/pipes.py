"""The pipes between owner and worker: one-way connections whose far ends a program started with `-m` inherits.

A message is a value as `lappet.core.value_codec` packs it.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import subprocess
import sys
from multiprocessing.connection import Connection
from typing import Any

MAX_BYTES = (1 << 31) - 1  # of a message
_BUFFER_BYTES = 1 << 20  # a frame of 20 000 vertices; where the system lets us


class WorkerPipes:
    """The pipes of a worker that is to be started.

    `requests` is for its owner to write to and `events` to read from. `handles` tells the worker its ends as text, and
    `inherit` has the arguments of `subprocess.Popen` that hand them down.
    """

    def __init__(self) -> None:
        self._requests, self.requests = multiprocessing.Pipe(duplex=False)
        self.events, self._events = multiprocessing.Pipe(duplex=False)
        theirs = [self._requests.fileno(), self._events.fileno()]
        self.handles = [str(handle) for handle in theirs]
        self.inherit: dict[str, Any]
        if sys.platform == "win32":
            for handle in theirs:
                os.set_handle_inheritable(handle, True)
            self.inherit = {"startupinfo": subprocess.STARTUPINFO(lpAttributeList={"handle_list": theirs})}
        else:
            self.inherit = {"pass_fds": theirs}
            _enlarge(self._events.fileno())

    def close_theirs(self) -> None:
        """Close the worker's ends here, once it has been started: their other ends then see that it has ended."""
        self._requests.close()
        self._events.close()

    def close(self) -> None:
        """Close all ends: the worker was not started."""
        self.close_theirs()
        self.requests.close()
        self.events.close()


def inherited(requests: str, events: str) -> tuple[Connection, Connection]:
    """Open the worker's ends.

    Parameters
    ----------
    requests
        First of `WorkerPipes.handles`.
    events
        Second of them.

    Returns
    -------
    tuple[Connection, Connection]
        Requests to read, events to write.
    """
    if sys.platform == "win32":
        from multiprocessing.connection import PipeConnection as End
    else:
        End = Connection
    for handle in (requests, events):
        if sys.platform == "win32":
            os.set_handle_inheritable(int(handle), False)
        else:
            os.set_inheritable(int(handle), False)
    return End(int(requests), writable=False), End(int(events), readable=False)


def _enlarge(descriptor: int) -> None:
    if sys.platform == "linux":
        import fcntl

        with contextlib.suppress(OSError):
            fcntl.fcntl(descriptor, fcntl.F_SETPIPE_SZ, _BUFFER_BYTES)
