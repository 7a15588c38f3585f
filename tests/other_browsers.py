"""Firefox and WebKitGTK, driven by what they come with: Marionette, and WebKit's own WebDriver in a screen of Xvfb."""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")
WEBKIT = shutil.which("WebKitWebDriver")
XVFB = shutil.which("Xvfb")
_MINI = sorted(Path("/usr/lib").glob("*/webkit2gtk-4.*/MiniBrowser"))
_PATIENCE = 120.0  # seconds
# WebGL by the processor, no first-run pages, no network.
_PREFERENCES = {
    "webgl.force-enabled": True,
    "gfx.x11-egl.force-enabled": True,
    "browser.shell.checkDefaultBrowser": False,
    "datareporting.policy.dataSubmissionEnabled": False,
    "network.proxy.type": 1,
    "network.proxy.http": "127.0.0.1",
    "network.proxy.http_port": 9,
    "network.proxy.ssl": "127.0.0.1",
    "network.proxy.ssl_port": 9,
}


class Browser:
    """A page in a browser."""

    def open(self, page: Path) -> None:
        """Open a file."""
        raise NotImplementedError

    def run(self, script: str) -> Any:
        """Run the body of a function in the page and return what it returns."""
        raise NotImplementedError

    def until(self, script: str) -> None:
        """Wait until a script returns something true. Raises TimeoutError."""
        end = time.monotonic() + _PATIENCE
        while not self.run(script):
            if time.monotonic() > end:
                raise TimeoutError(f"never true: {script}")
            time.sleep(0.2)


class Firefox(Browser):
    """Firefox by Marionette: messages [0, number, command, parameters], each with its length before it."""

    def __init__(self, port: int) -> None:
        self._line = _connected(port)
        self._number = 0
        self._read()  # what it says of itself
        self._ask("WebDriver:NewSession", {"capabilities": {"alwaysMatch": {"timeouts": {"script": 100_000}}}})

    def open(self, page: Path) -> None:
        self._ask("WebDriver:Navigate", {"url": page.as_uri()})

    def run(self, script: str) -> Any:
        return self._ask("WebDriver:ExecuteScript", {"script": script, "args": [], "sandbox": None})["value"]

    def close(self) -> None:
        self._line.close()

    def _ask(self, command: str, parameters: dict[str, Any]) -> Any:
        self._number += 1
        data = json.dumps([0, self._number, command, parameters]).encode()
        self._line.sendall(b"%d:%s" % (len(data), data))
        _, _, error, result = self._read()
        if error:
            raise RuntimeError(f"{command}: {error['error']}: {error['message']}")
        return result

    def _read(self) -> Any:
        head = b""
        while not head.endswith(b":"):
            head += self._some(1)
        length, data = int(head[:-1]), b""
        while len(data) < length:
            data += self._some(length - len(data))
        return json.loads(data)

    def _some(self, count: int) -> bytes:
        found = self._line.recv(min(count, 1 << 20))
        if not found:
            raise ConnectionError("Firefox has gone")
        return found


class WebKit(Browser):
    """WebKitGTK's small browser by WebDriver."""

    def __init__(self, port: int) -> None:
        self._base = f"http://127.0.0.1:{port}"
        _connected(port).close()
        browser = {"binary": str(_MINI[-1]), "args": ["--automation"]}
        asked = {"capabilities": {"alwaysMatch": {"webkitgtk:browserOptions": browser}}}
        self._base += f"/session/{self._ask('/session', asked)['sessionId']}"

    def open(self, page: Path) -> None:
        self._ask("/url", {"url": page.as_uri()})

    def run(self, script: str) -> Any:
        return self._ask("/execute/sync", {"script": script, "args": []})

    def close(self) -> None:
        request = urllib.request.Request(self._base, method="DELETE")
        urllib.request.urlopen(request, timeout=_PATIENCE).close()

    def _ask(self, path: str, parameters: dict[str, Any]) -> Any:
        data = json.dumps(parameters).encode()
        request = urllib.request.Request(self._base + path, data, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=_PATIENCE) as answer:
            return json.loads(answer.read())["value"]


@contextmanager
def firefox() -> Iterator[Browser]:
    """Start Firefox without a screen and with a profile of its own."""
    assert FIREFOX is not None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as home, ExitStack() as stack:
        port = _free_port()
        values = {**_PREFERENCES, "marionette.port": port}
        lines = [f'user_pref("{name}", {json.dumps(value)});\n' for name, value in values.items()]
        (Path(home) / "user.js").write_text("".join(lines), encoding="utf-8")
        command = [FIREFOX, "--headless", "--no-remote", "--marionette", "--profile", home]
        # Without a screen Firefox finds no GLX; EGL draws without one.
        drawing = {"MOZ_WEBGL_FORCE_EGL": "1", "LIBGL_ALWAYS_SOFTWARE": "1", "MOZ_HEADLESS_WIDTH": "1000"}
        environment = {**os.environ, "HOME": home, **drawing}
        stack.enter_context(_process(command, environment))
        browser = Firefox(port)
        stack.callback(browser.close)
        yield browser


@contextmanager
def webkit() -> Iterator[Browser]:
    """Start WebKitGTK in a screen that nobody sees."""
    assert WEBKIT is not None
    assert XVFB is not None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as home, ExitStack() as stack:
        number = _free_display()
        screen = [XVFB, f":{number}", "-screen", "0", "1200x800x24", "-nolisten", "tcp"]
        stack.enter_context(_process(screen, dict(os.environ)))
        port = _free_port()
        folders = {f"XDG_{each}_HOME": home for each in ("CACHE", "CONFIG", "DATA")}
        own = {"HOME": home, **folders, "DISPLAY": f":{number}", "LIBGL_ALWAYS_SOFTWARE": "1"}
        stack.enter_context(_process([WEBKIT, f"--port={port}"], {**os.environ, **own}))
        browser = WebKit(port)
        stack.callback(browser.close)
        yield browser


@contextmanager
def _process(command: list[str], environment: dict[str, str]) -> Iterator[None]:
    silent: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(command, env=environment, **silent)
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _connected(port: int) -> socket.socket:
    end = time.monotonic() + _PATIENCE
    while True:
        try:
            line = socket.create_connection(("127.0.0.1", port), timeout=_PATIENCE)
        except OSError:
            if time.monotonic() > end:
                raise
            time.sleep(0.2)
        else:
            return line


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _free_display() -> int:
    return next(number for number in range(90, 200) if not Path(f"/tmp/.X11-unix/X{number}").exists())
