"""What the real daemon answers: PROTOCOL.md, message by message."""

from __future__ import annotations

import contextlib
import socket
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest

from box_scene import box, epoch_arrays, open_fields, pull
from lappet.cutting.epoch import Epoch, Regions
from lappet.daemon.client import SolverClient, SolverRefused
from lappet.daemon.frame_solver import Iteration
from lappet.daemon.process import SolverDaemon
from lappet.daemon.wire import Message, WireError, encode
from lappet.geometry.labeled_surface import Surface
from lappet.program.payloads import solve_payload
from lappet.program.program import FrameConstraints
from lappet.program.settings import MaterialParameters, SolverSettings
from raw_peer import Raw

pytestmark = [pytest.mark.slow, pytest.mark.timeout(120)]


def test_a_frame_is_solved_and_its_state_goes_on(daemon: SolverDaemon) -> None:
    with SolverClient(daemon=daemon) as client:
        assert client.welcome["threads"] >= 1
        assert client.welcome["max_message_bytes"] == 4_000_000
        assert client.welcome["isa"] in {"scalar", "sse42", "avx2", "avx512", "neon"}
        assert client.open(SolverSettings(spacing=1.0, sutures=2, threads=1)) >= 1
        counts = client.set_epoch(Epoch(0, 1.0, box(), 1))
        assert counts.cells > 0
        seen: list[Iteration] = []
        first = client.solve(pull(1.0, 0.2), seen.append)
        assert first.converged
        assert first.points.shape == (8, 3)
        assert first.points.dtype == np.float32
        assert first.time == 1.0
        assert first.hook_forces.shape == (1, 3)
        work = first.diagnostics.work
        assert work.evaluations > first.diagnostics.newton  # the start, and each step
        assert work.linearizations >= first.diagnostics.newton
        assert work.products > first.diagnostics.pcg  # smoothing takes some more
        spent = work.evaluation_seconds + work.linearization_seconds + work.product_seconds
        assert 0.0 < spent < first.diagnostics.seconds.total
        assert first.state.suture_separations.shape == (2, 3)
        assert all(iteration.time == 1.0 for iteration in seen)
        second = client.solve(pull(2.0, 0.4))
        client.set_state(first.state)
        again = client.solve(pull(2.0, 0.4))
        for name, array in second.arrays().items():
            np.testing.assert_array_equal(again.arrays()[name], array, err_msg=name)


def test_a_wrong_token_is_refused_and_nothing_is_served_before_hello(daemon: SolverDaemon) -> None:
    peer = Raw(daemon, greet=False)
    with contextlib.closing(peer):
        for kind in ("ping", "open", "epoch", "state", "solve", "cancel", "close", "bye", "shutdown"):
            assert peer.ask(kind).fields["code"] == "out_of_order"
        reply = peer.ask("hello", {"token": daemon.token[:-1], "client": "raw"})
        assert reply.fields["code"] == "unauthorized"
        assert peer.ask("ping").fields["code"] == "out_of_order"
    with pytest.raises(SolverRefused, match="token is wrong") as error, SolverClient(daemon.address, "guess"):
        pass
    assert error.value.code == "unauthorized"


def test_bones_come_with_open_and_are_checked(raw: Raw) -> None:
    surface = box()

    def opened(**changes: Any) -> Message:
        arrays = {"bone_points": 3.0 * surface.points - [4.0, 4.0, 9.0], "bone_triangles": surface.triangles}
        kept = {name: array for name, array in {**arrays, **changes}.items() if array is not None}
        return raw.ask("open", open_fields(), kept)

    for changes, code, sentence in (
        ({"bone_triangles": surface.triangles[1:]}, "invalid_input", "the bones are not closed"),
        ({"bone_triangles": surface.triangles + 1}, "invalid_input", "there are 8 points of bones"),
        ({"bone_points": np.full((8, 3), np.nan)}, "invalid_input", "must be finite"),
        ({"bone_points": None}, "malformed", "no array 'bone_points'"),
        ({"bone_triangles": None}, "malformed", "no array 'bone_triangles'"),
        ({"bone_points": surface.points.astype(np.float32)}, "malformed", "must be f8"),
        ({"bone_color": np.zeros(3)}, "malformed", "bone_color"),
    ):
        reply = opened(**changes)
        assert reply.fields["code"] == code, (changes, reply.fields)
        assert sentence in reply.fields["message"], reply.fields["message"]
    assert opened().type == "opened"
    free = np.zeros(len(surface.triangles), np.uint8)
    deep = raw.ask("epoch", {"index": 0}, epoch_arrays(points=surface.points - [0.0, 0.0, 4.0], fixed=free))
    assert deep.fields["code"] == "invalid_input"
    assert "1 mm deep in bone near" in deep.fields["message"]
    assert raw.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"


def test_a_daemon_gives_no_client_more_than_it_was_told(binary: Path) -> None:
    with (
        SolverDaemon(binary, arguments=("--memory-gib", "0.125", "--seconds", "0.02", "--threads", "1")) as running,
        contextlib.closing(Raw(running)) as peer,
    ):
        assert peer.ask("open", open_fields(memory_budget=1 << 50, time_budget=1e6)).type == "opened"
        large = epoch_arrays(points=box((240.0, 240.0, 20.0)).points)
        assert peer.ask("epoch", {"index": 0}, large).fields["code"] in {"memory_budget", "time_budget"}
        assert peer.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"
        for kind in ("follow", "share"):
            assert peer.ask(kind).fields["code"] == "out_of_order"


def test_large_messages_are_not_read_before_hello(daemon: SolverDaemon) -> None:
    with contextlib.closing(Raw(daemon, greet=False)) as peer:
        reply = peer.ask("epoch", {"index": 0}, {"points": np.zeros((40_000, 3))})
        assert reply.fields["code"] == "malformed"
        assert "before 'hello'" in reply.fields["message"]


@pytest.mark.parametrize(
    "frame",
    [b"", b"\x00", b"\xc1", b"not msgpack", b"\xff" * 1000, b"\x91" * 60_000, b"\xdf\xff\xff\xff\xff", b"x" * 100_000],
)
def test_malformed_headers_are_answered(raw: Raw, frame: bytes) -> None:
    code, sentence = raw.refused(frame)
    assert code == "malformed"
    assert sentence.endswith(".")
    assert raw.ask("ping").type == "pong"


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ({"v": 1, "type": "ping", "id": 5}, "no list 'arrays'"),
        ({"v": 7, "type": "ping", "id": 5, "arrays": []}, "version 7"),
        ({"v": 1, "type": "dance", "id": 5, "arrays": []}, "'dance' is not known"),
        ({"v": 1, "type": "frame", "id": 5, "arrays": []}, "'frame' is not known"),
        ({"v": 1, "type": 5, "id": 5, "arrays": []}, "'type'"),
        ({"v": 1, "type": "ping", "id": -5, "arrays": []}, "'id'"),
        ({"v": 1, "type": "ping", "id": "5", "arrays": []}, "'id'"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [], "x": b"\x00"}, "neither number"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [], "x": 1}, "does not know"),
        ({"v": 1, "type": "ping", "id": 5, "session": -1, "arrays": []}, "'session'"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [{"name": "a", "dtype": "O", "shape": [1]}]}, "dtype 'O'"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [{"name": "a", "dtype": "f8", "shape": [2**60]}]}, "too large"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [{"name": "a", "dtype": "f8", "shape": [2**20]}]}, "4000000"),
    ],
)
def test_headers_that_break_the_protocol_are_answered(raw: Raw, header: dict[str, Any], says: str) -> None:
    code, sentence = raw.refused(msgpack.packb(header))
    assert code == "malformed"
    assert says in sentence
    assert raw.ask("ping").type == "pong"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"points": np.zeros((8, 2))}, "shape (8, 2)"),
        ({"points": np.zeros((8, 3), np.float32)}, "dtype f4"),
        ({"points": np.full((8, 3), np.nan)}, "holds nan"),
        ({"points": None}, "no array 'points'"),
        ({"triangles": np.full((12, 3), 8, np.int32)}, "there are 8 surface points"),
        ({"triangles": np.full((12, 3), -1, np.int32)}, "holds -1"),
        ({"fixed": np.zeros(11, np.uint8)}, "shape (11)"),
        ({"support": np.full(12, 3, np.uint8)}, "bed label 3"),
        ({"grip": np.zeros(12, np.int32)}, "'grip' holds 0"),
        ({"landmarks": np.zeros((2, 3))}, "'landmark_triangles'"),
        ({"color": np.zeros(3)}, "'color'"),
    ],
)
def test_epochs_that_make_no_sense_are_named(raw: Raw, changes: dict[str, Any], says: str) -> None:
    assert raw.ask("open", open_fields()).type == "opened"
    reply = raw.ask("epoch", {"index": 0}, epoch_arrays(**changes))
    assert reply.fields["code"] in ("malformed", "invalid_input")
    assert says in reply.fields["message"]
    assert raw.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"


RICH = {
    "model": "mooneyRivlin", "youngs_modulus": 20.0, "poissons_ratio": 0.4, "density": 900.0, "mooney_ratio": 0.5,
    "fiber_direction": [0.0, 0.6, 0.8], "fiber_k1": 10.0, "fiber_k2": 2.0, "fiber_dispersion": 0.1,
    "muscle_stress": 300.0, "prestretch": [1.1, 0.95],
}  # fmt: skip
BELOW = {"material": 1, "depth_from": 0.5, "depth_to": 1.5}


def region_arrays(**changes: Any) -> dict[str, Any]:
    surface = box()
    skin = {"skin_points": surface.points, "skin_triangles": surface.triangles, "region_faces": np.ones((1, 12), "u1")}
    return epoch_arrays(**{**skin, **changes})


@pytest.mark.parametrize(
    ("materials", "says"),
    [
        ([], "0 materials"),
        (RICH, "a list of maps"),
        ([RICH, {**RICH, "model": "jelly"}], "material 1 is 'jelly'"),
        ([{**RICH, "poissons_ratio": 0.49995}], "it must be 0 to 0.4999"),
        ([{**RICH, "poissons_ratio": -0.1}], "it must be 0 to 0.4999"),
        ([{**RICH, "mooney_ratio": -1.0}], "Mooney ratio"),
        ([{**RICH, "fiber_k1": -1.0}], "k1"),
        ([{**RICH, "fiber_k2": float("inf")}], "'fiber_k2' of 'materials[0]'"),
        ([{**RICH, "fiber_dispersion": 0.34}], "1/3"),
        ([{**RICH, "fiber_direction": [1.0, 1.0, 0.0]}], "length 1"),
        ([{**RICH, "fiber_direction": [1.0, 0.0]}], "list of three numbers"),
        ([{**RICH, "muscle_stress": -1.0}], "muscle stress"),
        ([{**RICH, "prestretch": [2.5, 1.0]}], "it must be 0.5 to 2"),
        ([{**RICH, "fiber_k3": 1.0}], "'fiber_k3'"),
        ([{"model": "neoHookean"}], "no field 'youngs_modulus'"),
    ],
)
def test_materials_that_make_no_sense_are_named(raw: Raw, materials: Any, says: str) -> None:
    reply = raw.ask("open", {**open_fields(), "materials": materials})
    assert reply.fields["code"] in ("malformed", "invalid_input")
    assert says in reply.fields["message"]
    assert raw.ask("open", {**open_fields(), "materials": [RICH] * 64}).type == "opened"


@pytest.mark.parametrize(
    ("region", "changes", "says"),
    [
        ({"material": 2}, {}, "'material' of 'regions[0]' is 2"),
        ({"material": -1}, {}, "'material' of 'regions[0]' is -1"),
        ({"depth_from": -0.5}, {}, "-0.5 to 1.5 mm"),
        ({"depth_to": 0.5}, {}, "0.5 to 0.5 mm"),
        ({"depth_to": float("inf")}, {}, "'depth_to'"),
        ({"faces": 3}, {}, "'faces'"),
        ({}, {"region_faces": np.ones((2, 12), "u1")}, "'region_faces'"),
        ({}, {"region_faces": np.ones((1, 11), "u1")}, "'region_faces'"),
        ({}, {"region_faces": None}, "no array 'region_faces'"),
        ({}, {"skin_triangles": np.full((12, 3), 8, np.int32)}, "there are 8 skin points"),
        ({}, {"skin_points": np.full((8, 3), np.inf)}, "holds inf"),
        ({}, {"skin_points": None}, "no array 'skin_points'"),
        ({}, {"skin_triangles": np.zeros((0, 3), np.int32), "region_faces": np.ones((1, 0), "u1")}, "no skin"),
    ],
)
def test_regions_that_make_no_sense_are_named(
    raw: Raw, region: dict[str, Any], changes: dict[str, Any], says: str
) -> None:
    assert raw.ask("open", {**open_fields(), "materials": [RICH, RICH]}).type == "opened"
    reply = raw.ask("epoch", {"index": 0, "regions": [{**BELOW, **region}]}, region_arrays(**changes))
    assert reply.fields["code"] in ("malformed", "invalid_input")
    assert says in reply.fields["message"]
    assert raw.ask("epoch", {"index": 0, "regions": [BELOW]}, region_arrays()).type == "lattice"
    assert "region_faces" in raw.ask("epoch", {"index": 0}, region_arrays()).fields["message"]  # without regions


def test_the_client_sends_materials_regions_and_activation_and_the_state_keeps_it(daemon: SolverDaemon) -> None:
    surface = box()
    muscle = MaterialParameters(muscle_stress=0.5, fiber_direction=(0.0, 0.0, 1.0), prestretch=(1.0, 1.0))
    regions = Regions(
        surface.points,
        surface.triangles,
        np.ones((2, 12), bool),
        np.array([1, 0], np.int32),
        np.array([0.0, 1.0]),
        np.array([np.inf, 2.0]),
    )
    with SolverClient(daemon=daemon) as client:
        client.open(SolverSettings(spacing=1.0, threads=1, materials=(MaterialParameters(), muscle)))
        client.set_epoch(Epoch(0, 1.0, surface, 1, regions))
        slack = client.solve(pull(1.0))
        np.testing.assert_array_equal(slack.state.activation, [0.0, 0.0])
        tense = replace(pull(2.0), activation=np.array([0.0, 0.5]))
        first = client.solve(tense)
        np.testing.assert_array_equal(first.state.activation, [0.0, 0.5])
        client.set_state(slack.state)
        again = client.solve(tense)
        for name, array in first.arrays().items():
            np.testing.assert_array_equal(again.arrays()[name], array, err_msg=name)
        with pytest.raises(SolverRefused, match="'activation'"):
            client.solve(replace(tense, activation=np.array([0.5])))
        with pytest.raises(SolverRefused, match=r"activates material 1 by 1\.5"):
            client.solve(replace(tense, activation=np.array([0.0, 1.5])))
        with pytest.raises(SolverRefused, match="'activation'"):
            client.set_state(replace(slack.state, activation=np.zeros(3)))


def test_truncated_and_missing_array_frames_are_answered(raw: Raw) -> None:
    raw.ask("open", open_fields())
    frames = encode(Message("epoch", 500, None, {"index": 0}, epoch_arrays()))
    assert raw.refused(frames[0], frames[1][:-1], *frames[2:])[0] == "malformed"
    assert raw.refused(frames[0], frames[1] + b"\x00", *frames[2:])[0] == "malformed"
    assert raw.refused(*frames[:-1])[0] == "malformed"
    assert raw.refused(*frames, b"")[0] == "malformed"
    assert raw.refused(frames[0], *[b""] * 500)[0] == "malformed"
    assert raw.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"


@pytest.mark.parametrize(
    ("changes", "code", "says"),
    [
        ({"spacing": "1"}, "malformed", "'spacing' of 'settings' is a text"),
        ({"spacing": 0.0}, "invalid_input", "spacing"),
        ({"spacing": float("nan")}, "invalid_input", "finite"),
        ({"origin": [0.0, 0.0]}, "malformed", "three numbers"),
        ({"threads": 2**40}, "invalid_input", "threads"),
        ({"sutures": -1}, "invalid_input", "sutures"),
        ({"fine_ratio": 4.5}, "malformed", "whole number"),
        ({"precision": "half"}, "invalid_input", "half"),
        ({"quadrature": 3}, "invalid_input", "quadrature"),
        ({"color": 1}, "malformed", "'color'"),
    ],
)
def test_settings_that_make_no_sense_are_named(raw: Raw, changes: dict[str, Any], code: str, says: str) -> None:
    reply = raw.ask("open", open_fields(**changes))
    assert (reply.fields["code"], says in reply.fields["message"]) == (code, True), reply.fields
    assert raw.ask("open", open_fields()).type == "opened"


def test_what_comes_out_of_order_is_refused_and_the_session_goes_on(raw: Raw) -> None:
    solve = solve_payload(pull()).arrays
    assert raw.ask("epoch", {"index": 0}, epoch_arrays()).fields["code"] == "out_of_order"
    assert raw.ask("close").fields["code"] == "out_of_order"
    assert raw.ask("open", open_fields()).type == "opened"
    assert raw.ask("solve", {"time": 1.0}, solve).fields["code"] == "out_of_order"
    assert raw.ask("open", open_fields()).fields["code"] == "out_of_order"
    assert raw.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"
    far = {**solve, "hook_triangles": np.array([12], np.int32)}
    assert "there are 12 triangles" in raw.ask("solve", {"time": 1.0}, far).fields["message"]
    short = {**solve, "hook_targets": np.zeros((2, 3))}
    assert raw.ask("solve", {"time": 1.0}, short).fields["code"] == "malformed"
    assert raw.ask("solve", {"time": float("inf")}, solve).fields["code"] == "invalid_input"
    assert raw.ask("solve", {"time": 1.0}, solve).type == "frame"
    state = {
        "nodes": np.zeros((1, 3), np.float32),
        "suture_separations": np.zeros((2, 3)),
        "suture_multipliers": np.zeros((2, 3)),
        "grip_multipliers": np.zeros(0),
        "stability": np.zeros(0),
        "activation": np.zeros(1),
    }
    assert raw.ask("state", {"precision": "float"}, state).fields["code"] == "invalid_input"
    assert raw.ask("state", {"precision": "double"}, state).fields["code"] == "malformed"
    assert raw.ask("close").type == "accepted"
    assert raw.ask("open", open_fields()).type == "opened"


@pytest.mark.parametrize("listens", [(), ("--address", "tcp://127.0.0.1:*")], ids=["own", "tcp"])
def test_garbage_from_a_raw_socket_does_not_kill_it(binary: Path, listens: tuple[str, ...]) -> None:
    rng = np.random.default_rng(7)
    with SolverDaemon(binary, arguments=listens) as daemon, contextlib.closing(Raw(daemon)) as raw:
        for start in (b"", b"GET / HTTP/1.1\r\n\r\n", b"\xff" + bytes(8) + b"\x7f\x03", b"\x01\x00"):
            with connected(daemon) as connection, contextlib.suppress(OSError):
                connection.sendall(start + rng.bytes(200_000))
        assert raw.ask("ping").type == "pong"


@pytest.mark.parametrize("listens", [(), ("--address", "tcp://127.0.0.1:*")], ids=["own", "tcp"])
def test_a_connection_that_does_not_greet_is_closed(binary: Path, listens: tuple[str, ...]) -> None:
    with SolverDaemon(binary, arguments=listens) as daemon, connected(daemon) as silent:
        silent.settimeout(10.0)
        begun = time.monotonic()
        while silent.recv(4096):  # the daemon's own greeting, then the end
            pass
        assert time.monotonic() - begun < 8.0


def connected(daemon: SolverDaemon) -> socket.socket:
    """A plain connection to the daemon."""
    scheme, _, place = daemon.address.partition("://")
    if scheme == "ipc":
        connection = socket.socket(socket.AF_UNIX)
        connection.settimeout(5.0)
        connection.connect(place)
        return connection
    host, port = place.split(":")
    return socket.create_connection((host, int(port)), timeout=5.0)


def test_two_clients_have_sessions_of_their_own(daemon: SolverDaemon) -> None:
    with SolverClient(daemon=daemon) as first, SolverClient(daemon.address, daemon.token) as second:
        numbers = {client.open(SolverSettings(spacing=1.0, threads=1)) for client in (first, second)}
        assert len(numbers) == 2
        first.set_epoch(Epoch(0, 1.0, box(), 1))
        with pytest.raises(SolverRefused, match="'epoch' first"):
            second.solve(pull())
        second.set_epoch(Epoch(0, 1.0, box((4.0, 4.0, 3.0)), 1))
        assert first.solve(FrameConstraints(1.0, 0)).points[:, 2].max() == pytest.approx(2.0, abs=1e-3)
        assert second.solve(FrameConstraints(1.0, 0)).points[:, 2].max() == pytest.approx(3.0, abs=1e-3)


def test_clients_that_leave_make_room(daemon: SolverDaemon) -> None:
    for _ in range(3):
        with contextlib.ExitStack() as stack:
            end = time.monotonic() + 10.0
            clients = 0
            while clients < 4:  # those of the turn before may still be leaving
                try:
                    stack.enter_context(SolverClient(daemon.address, daemon.token))
                    clients += 1
                except SolverRefused:
                    assert time.monotonic() < end
                    time.sleep(0.05)
            with pytest.raises(SolverRefused, match="4 clients already"):
                stack.enter_context(SolverClient(daemon.address, daemon.token))


def test_a_frame_of_another_epoch_and_a_message_too_large_are_not_sent(daemon: SolverDaemon) -> None:
    with SolverClient(daemon=daemon) as client:
        client.open(SolverSettings(spacing=1.0, threads=1))
        client.set_epoch(Epoch(0, 1.0, box(), 1))
        with pytest.raises(ValueError, match="belongs to epoch 3"):
            client.solve(FrameConstraints(1.0, 3))
        many = Surface(
            np.zeros((200_000, 3)),
            np.zeros((1, 3), np.int32),
            np.zeros((1, 3, 2), np.float32),
            np.zeros(1, np.uint8),
            np.zeros(1, np.bool_),
            np.zeros(1, np.bool_),
        )
        with pytest.raises(WireError, match="coarser surface"):
            client.set_epoch(Epoch(1, 2.0, many, 1))
        assert client.ping() < 1.0
