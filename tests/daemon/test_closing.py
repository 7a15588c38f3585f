"""A client that closes while it is sending lives on, whatever becomes of the daemon just then."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.timeout(180)]
ROUNDS = 40

# Closes while messages of many parts are half sent, and kills the daemon at the same moment.
CLIENT = """
import os, random, signal, sys, threading, time
import numpy as np
from lappet.daemon.connection import DaemonConnection
from lappet.daemon.process import SolverDaemon

choose = random.Random(5)
large = {f"array_{k}": np.zeros(choose.choice([1_000, 100_000, 3_000_000]), np.uint8) for k in range(24)}
for _ in range(int(sys.argv[2])):
    daemon = SolverDaemon(sys.argv[1]).start()
    connection = DaemonConnection(daemon=daemon).connect()
    for identifier in range(choose.randint(1, 3)):
        connection._send("epoch", identifier, {}, large)
    time.sleep(choose.choice([0.0, 0.0, choose.uniform(0.0, 0.02)]))
    closing = threading.Thread(target=connection.close)
    first, second = choose.choice([(closing.start, lambda: None), (lambda: None, closing.start)])
    first()
    time.sleep(choose.uniform(0.0, 0.003))
    os.kill(daemon.pid, signal.SIGKILL)
    second()
    closing.join()
    daemon.stop()
print("lives")
"""


def test_closing_while_the_daemon_dies_does_not_end_the_client(binary: Path) -> None:
    """At a linger of 0 libzmq aborted one client in a hundred such rounds."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", CLIENT, str(binary), str(ROUNDS)],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "lives\n"), done.stderr[-600:]
