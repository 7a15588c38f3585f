"""A daemon with keys as docs/sharing_a_daemon.md says: its administrator and its users have only the command line."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Self

from click.testing import CliRunner, Result

from lappet.commands.cli import cli
from lappet.daemon.running_daemon import RunningDaemon


class SharedDaemon:
    """Somebody's daemon in a folder: `address`, its folder of keys, and what its administrator does."""

    def __init__(self, binary: Path, folder: Path) -> None:
        self.folder, self.log = folder / "keys", folder / "log.txt"
        self.address = ""
        assert CliRunner().invoke(cli, ["keys", "new", "--server", "--keys", str(self.folder)]).exit_code == 0
        self._command = [str(binary), "--listen", "tcp://127.0.0.1:0", "--keys", str(self.folder), "--verbose"]
        self._process: subprocess.Popen[str] | None = None

    def __enter__(self) -> Self:
        environment = {name: value for name, value in os.environ.items() if name != "LAPPET_TOKEN"}
        with self.log.open("w") as log:
            self._process = subprocess.Popen(
                self._command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log, env=environment, text=True
            )
        assert self._process.stdout is not None
        word, _, self.address = self._process.stdout.readline().strip().partition(" ")
        assert word == "listening", self.log.read_text()
        return self

    def __exit__(self, *_: object) -> None:
        assert self._process is not None
        assert self._process.stdout is not None
        try:
            assert self._process.poll() is None, f"the daemon did not live through the test: {self.log.read_text()}"
            self._process.terminate()
            assert self._process.wait(10.0) == 0
        finally:
            self._process.kill()
            self._process.wait()
            self._process.stdout.close()

    def administer(self, *arguments: str) -> Result:
        done = CliRunner().invoke(cli, ["keys", *arguments, "--keys", str(self.folder)])
        assert done.exit_code == 0, done.output
        return done

    def user(self, name: str, role: str, *quotas: str) -> RunningDaemon:
        """Somebody who made keys and was let in."""
        own = self.folder.parent / "own"
        assert CliRunner().invoke(cli, ["keys", "new", name, "--keys", str(own)]).exit_code == 0
        self.administer("allow", name, "--key", str(own / f"{name}.pub"), "--role", role, *quotas)
        return RunningDaemon(self.address, str(self.folder / "server.pub"), str(own / f"{name}.key"))
