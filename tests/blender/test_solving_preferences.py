"""The preferences name the daemon that solves: it is asked on a thread, and its workers are told of it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import pytest

import fake_worker
from curve_server import CurveServer
from fake_worker import Script
from lappet.core.problem_code import ProblemCode
from lappet.daemon.key_files import KeyPair, new_pair, read_pair
from lappet.daemon.key_writing import new_own
from lappet.daemon.keys_folder import KeysFolder, Role, User
from lappet.daemon.running_daemon import RunningDaemon
from lappet_blender.solving import chosen_daemon, frames, reconcile
from lappet_blender.solving.controller import controller_of
from lappet_blender.solving.preferences import LappetPreferences
from lappet_blender.solving.solve_timer import run_timer
from patch_scene import make_patch_scene
from refusals import refusal_code
from solving_steps import QUIET

pytest_plugins = ("solving_fixtures",)


@pytest.fixture
def preferences(scene: bpy.types.Scene) -> Iterator[Any]:
    """Those of the add-on, empty."""
    addons = bpy.context.preferences.addons
    entry = addons.new()
    entry.module = chosen_daemon.ADDON
    chosen_daemon._answers.clear()
    yield entry.preferences
    addons.remove(entry)


@pytest.fixture
def patch(scene: bpy.types.Scene, script: Script, preferences: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The patch scene; its worker works by formulas, but who the daemon is is asked in earnest."""
    own = reconcile.identity
    monkeypatch.setattr(
        reconcile,
        "identity",
        lambda: own() if chosen_daemon.chosen_daemon() is None else _asked(chosen_daemon.chosen_daemon()),
    )
    return make_patch_scene(scene)


def _asked(daemon: RunningDaemon | None) -> str:
    assert daemon is not None
    chosen_daemon.identity_of(daemon)
    return fake_worker.IDENTITY  # what the worker of formulas calls itself


class Place:
    """A folder of keys with one user, and the files that the preferences name."""

    def __init__(self, folder: Path) -> None:
        self.folder = KeysFolder(folder / "keys")
        self.pair: KeyPair = self.folder.make_server()
        self.key, _, own = new_own(folder / "own", "anna")
        self.folder.allow(User("anna", own.public, Role.AUTHOR))

    def choose(self, preferences: Any, address: str) -> None:
        preferences.server_key = str(self.folder.server_public)
        preferences.key = str(self.key)
        preferences.daemon = address


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return Place(tmp_path)


def test_without_a_choice_a_daemon_is_started_here(preferences: Any) -> None:
    assert chosen_daemon.chosen_daemon() is None
    preferences.daemon = "  "
    assert chosen_daemon.chosen_daemon() is None


def test_a_key_may_be_pasted_in_place_of_its_file(preferences: Any, place: Place) -> None:
    preferences.daemon, preferences.key = " tcp://192.0.2.7:5570 ", str(place.key)
    preferences.server_key = place.pair.public
    chosen = chosen_daemon.chosen_daemon()
    assert chosen is not None
    assert chosen.address == "tcp://192.0.2.7:5570"
    keys = chosen.keys()
    assert keys is not None
    assert keys.server == place.pair.public


def test_the_workers_of_the_scene_get_the_chosen_daemon_and_another_choice_gets_others(
    patch: bpy.types.Scene, preferences: Any, script: Script, place: Place
) -> None:
    bpy.ops.lappet.solve(wait=True)
    assert [worker.daemon for worker in script.workers] == [None]
    with CurveServer(read_pair(place.folder.server_key), place.folder) as server:
        place.choose(preferences, server.address)
        bpy.ops.lappet.solve(wait=True)
        assert controller_of(patch).daemon == script.workers[-1].daemon == chosen_daemon.chosen_daemon()
        assert "9.9" in chosen_daemon.said()
        assert server.messages[0].type == "hello"
    preferences.daemon = ""
    run_timer(QUIET)
    assert controller_of(patch).daemon is None


def test_a_daemon_that_refuses_is_a_problem_of_the_scene_and_asked_again_later(
    patch: bpy.types.Scene, preferences: Any, place: Place
) -> None:
    with CurveServer(new_pair(), place.folder) as stranger:
        place.choose(preferences, stranger.address)
        assert refusal_code(bpy.ops.lappet.solve) is ProblemCode.DAEMON_OTHER_KEY
        assert [each.code for each in frames.problems_of(patch)] == [ProblemCode.DAEMON_OTHER_KEY]
        assert "server.pub" in chosen_daemon.said()
        assert stranger.messages == []
    with CurveServer(place.pair, place.folder, port=int(stranger.address.rpartition(":")[2])):
        bpy.ops.lappet.solve(wait=True)
    assert frames.problems_of(patch) == ()


def test_the_window_waits_a_moment_at_most_for_a_daemon_that_is_silent(
    patch: bpy.types.Scene, preferences: Any, place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bpy, "app", SimpleNamespace(**{**_app(), "background": False}))
    monkeypatch.setattr(chosen_daemon, "_SILENCE", 1.5)
    place.choose(preferences, "tcp://127.0.0.1:9")  # where nobody listens
    begun = time.monotonic()
    assert refusal_code(bpy.ops.lappet.solve) is ProblemCode.DAEMON_ASKED
    assert time.monotonic() - begun < 1.2
    end = time.monotonic() + 10.0
    while frames.problems_of(patch)[0].code is not ProblemCode.DAEMON_SILENT:
        assert time.monotonic() < end, frames.problems_of(patch)
        run_timer()
        time.sleep(0.02)


def _app() -> dict[str, Any]:
    return {name: getattr(bpy.app, name) for name in ("handlers", "timers", "version", "is_job_running")}


def test_the_preferences_draw_their_fields_and_what_the_daemon_said(preferences: Any) -> None:
    drawn: list[str] = []

    class Layout:
        enabled = True
        scale_y = 1.0

        def prop(self, owner: Any, name: str, **_: Any) -> None:
            getattr(owner, name)
            drawn.append(name)

        def label(self, text: str = "", icon: str = "NONE") -> None:
            drawn.append(text)

        def column(self, **_: Any) -> Layout:
            return Layout()

        row = column

        def operator(self, name: str, **_: Any) -> None:
            getattr(bpy.ops.lappet, name.partition(".")[2]).get_rna_type()
            drawn.append(name)

    owner = SimpleNamespace(layout=Layout(), daemon="", server_key="", key="", command="")
    LappetPreferences.draw(owner, bpy.context)
    assert drawn[:3] == ["daemon", "server_key", "key"]
    assert "started on this computer" in " ".join(drawn[3:])
    assert {"lappet.template_install", "lappet.assets_install"} <= set(drawn)
