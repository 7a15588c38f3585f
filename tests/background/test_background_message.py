"""What owner and worker tell each other comes out as it went in, to the bit."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import procedure_strategies
from lappet.background.manifest import EpochShape, ListedFrame, Manifest
from lappet.background.manifest_key import manifest_key
from lappet.background.pipes import MAX_BYTES, WorkerPipes
from lappet.background.worker_events import Finished, FrameReady, Listed, LiveFrame, Note, Refused, WorkerEvent
from lappet.background.worker_requests import Aim, Ask, Cancel, WorkerRequest
from lappet.core.array_codec import CodecError
from lappet.core.problem import Place, Problem
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack, unpack
from lappet.daemon.frame_diagnostics import Diagnostics
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Bone, Hook, Incision, Landmark, Procedure, Suture, pose_at
from lappet.program.settings import SolverSettings
from small_procedure import small_procedure

numbers = st.floats(allow_nan=False, width=64)
choices = st.builds(
    SolverSettings,
    spacing=numbers,
    tolerance=numbers,
    quadrature=st.sampled_from([1, 4, 8]),
    precision=st.sampled_from(["float", "double"]),
    threads=st.integers(0, 64),
)

TISSUE = "/Procedure/Tissue"
LARGE = Problem(
    ProblemCode.TISSUE_LARGE,
    TISSUE,
    "Größe",
    "Größer als «1 mm».",
    "Verkleinere es.",
    "warning",
    Place((3, 4), ((0.1, -0.0, 1e308),)),
)


def same_bits(a: Any, b: Any) -> bool:
    """Whether two values are of the same classes and hold the same bits."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if is_dataclass(a):
        return all(same_bits(getattr(a, item.name), getattr(b, item.name)) for item in fields(a))
    if isinstance(a, dict):
        return list(a) == list(b) and all(same_bits(a[name], b[name]) for name in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same_bits, a, b))
    if isinstance(a, float):
        return np.float64(a).tobytes() == np.float64(b).tobytes()
    return bool(a == b)


@settings(max_examples=150, deadline=None)
@given(procedure_strategies.procedures())
def test_every_procedure_comes_back_with_every_bit(procedure: Procedure) -> None:
    back = unpack(pack(procedure), Procedure)
    assert back == procedure
    assert same_bits(back, procedure)


@settings(max_examples=50, deadline=None)
@given(choices)
def test_settings_come_back_with_every_bit(choice: SolverSettings) -> None:
    assert same_bits(unpack(pack(choice), SolverSettings), choice)


def a_manifest(seed: int = 0) -> Manifest:
    random = np.random.default_rng(seed)
    shape = EpochShape(
        f"{seed:064x}",
        1.5,
        random.normal(size=(5, 3)).astype(np.float32),
        random.integers(0, 5, (4, 3)).astype(np.int32),
        np.array([0, 1, 2, 3], np.uint8),
        random.normal(size=(4, 3, 2)).astype(np.float32),
        random.normal(size=5).astype(np.float32),
        np.array([3, -1, 0, 1], np.int32),
    )
    frames = (ListedFrame(1, 0, "ab" * 32), ListedFrame(2, 0, "cd" * 32, (0,), (0, 1)))
    return Manifest("ef" * 32, (shape,), frames, ("hook",), ("a", "b"), ("mark 1",), ((0,),), (LARGE,))


def test_plans_and_events_come_back_with_every_bit() -> None:
    shown = SolvedFrame(
        7.0,
        np.zeros((3, 3), np.float32),
        hook_index=np.array([2], np.int32),
        hook_points=np.full((1, 3), np.nan),
        diagnostics=Diagnostics(converged=False, reason="why", newton=3, residual=1e-300),
        lattice=LatticeCounts(64, 1, 1, 0, 8, 1, 1, 0, 3, 1.0, 1000.0, 0.1),
    )
    for value in (
        Listed(1, a_manifest(), (True, False)),
        Refused(2, (Problem(ProblemCode.MESH_OPEN, TISSUE, "1", "It is wrong.", "Repair it.", "warning"),)),
        FrameReady(3, 7, "00" * 32, False, shown),
        FrameReady(3, 7, "00" * 32, True, None),
        LiveFrame(4, 7, pose_at((0.1, -0.0, 1e308)), shown, LARGE, 0.25),
        LiveFrame(4, 7, pose_at((0.1, -0.0, 1e308)), shown, None, 0.25),
        Note(5, LARGE),
    ):
        assert same_bits(unpack(pack(value), WorkerEvent), value)


def test_requests_come_back_with_every_bit() -> None:
    ask = Ask(
        1, "live", small_procedure(), SolverSettings(), time=5, held="hook", before=small_procedure(), identity="solver"
    )
    for value in (ask, Aim(2, pose_at((0.1, -0.0, 1e308))), Cancel(3)):
        assert same_bits(unpack(pack(value), WorkerRequest), value)
    with pytest.raises(CodecError, match="not known"):
        unpack(pack(ask), WorkerEvent)


@pytest.mark.parametrize("dtype", ["u1", "<i4", "<i8", "<f4", "<f8", ">f4"])
def test_an_array_is_read_in_place_and_aligned(dtype: str) -> None:
    for length in range(20):
        array = np.arange(2 * length).reshape(length, 2).astype(dtype)
        back = unpack(pack((length * "x", array)), tuple)[1]
        np.testing.assert_array_equal(back, array)
        assert back.flags.aligned
        assert not back.flags.writeable


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=60), st.integers(0, 200), st.integers(0, 255))
def test_bytes_that_are_no_message_are_refused_and_nothing_else_happens(data: bytes, at: int, byte: int) -> None:
    with contextlib.suppress(CodecError):
        unpack(data, WorkerEvent)
    damaged = bytearray(pack(Finished(1, 2, 0.5)))
    damaged[at % len(damaged)] = byte
    for bad in (damaged, damaged[: at % len(damaged)]):
        with contextlib.suppress(CodecError):
            unpack(bytes(bad), WorkerEvent)


def test_only_known_classes_are_made() -> None:
    with pytest.raises(CodecError, match="'Finished' that is not known"):
        unpack(pack(Finished(1, 2, 0.5)), Procedure)
    with pytest.raises(CodecError, match="not what is read here"):
        unpack(pack(small_procedure().tissue), Procedure)
    with pytest.raises(CodecError, match="cannot be written"):
        pack(object())


def test_the_pipes_of_a_worker_carry_messages_and_end_with_it() -> None:
    pipes = WorkerPipes()
    program = (
        "import sys\n"
        "from lappet.background.pipes import MAX_BYTES, inherited\n"
        "requests, events = inherited(sys.argv[1], sys.argv[2])\n"
        "events.send_bytes(requests.recv_bytes(MAX_BYTES)[::-1])\n"
    )
    with subprocess.Popen([sys.executable, "-c", program, *pipes.handles], **pipes.inherit) as worker:
        pipes.close_theirs()
        pipes.requests.send_bytes(bytes(range(256)) * 4096)
        assert pipes.events.recv_bytes(MAX_BYTES) == bytes(range(255, -1, -1)) * 4096
        with pytest.raises(EOFError):
            pipes.events.recv_bytes(MAX_BYTES)
        assert worker.wait(10.0) == 0
    pipes.close()


@settings(max_examples=60, deadline=None)
@given(procedure_strategies.procedures(), procedure_strategies.procedures())
def test_the_key_of_a_manifest_tells_procedures_apart_as_equality_does(a: Procedure, b: Procedure) -> None:
    key = manifest_key(a, SolverSettings(), "solver")
    assert manifest_key(unpack(pack(a), Procedure), SolverSettings(), "solver") == key
    assert (manifest_key(b, SolverSettings(), "solver") == key) == (a == b)


def test_every_value_of_a_procedure_and_what_changes_a_frame_is_in_the_key() -> None:
    base = small_procedure()
    slit, hook, stitch, mark = base.events
    assert isinstance(slit, Incision)
    assert isinstance(hook, Hook)
    assert isinstance(stitch, Suture)
    assert isinstance(mark, Landmark)
    tissue = base.tissue
    bone = Bone("skull", tissue.points, tissue.face_vertex_counts, tissue.face_vertex_indices)
    renamed = {f"{name}_2": faces for name, faces in tissue.subsets.items()}
    others = [
        *(replace(base, **change) for change in ({"fps": 25.0}, {"end_time": 9.0}, {"start_time": 0.0})),
        replace(base, events=(hook, slit, stitch, mark)),
        replace(base, events=(replace(slit, name="cut"), hook, stitch, mark)),
        replace(base, events=(slit, hook, stitch, replace(mark, label="other"))),
        replace(base, events=(slit, replace(hook, stiffness=np.nextafter(hook.stiffness, 0.0)), stitch, mark)),
        replace(base, tissue=replace(tissue, subsets=renamed)),
        replace(base, tissue=replace(tissue, uv=None)),
        replace(base, tissue=replace(tissue, gravity=3.7)),
        replace(base, tissue=replace(tissue, self_contact=True)),
        replace(base, bones=(bone,)),
    ]
    keys = {manifest_key(each, SolverSettings(), "s") for each in (base, *others)}
    assert len(keys) == 1 + len(others)
    changes: list[dict[str, Any]] = [{"spacing": 0.5}, {"tolerance": 1e-4}, {"quadrature": 8}, {"precision": "double"}]
    choices = [SolverSettings(**change) for change in changes]
    assert len({manifest_key(base, choice, "s") for choice in (SolverSettings(), *choices)}) == 5
    assert manifest_key(base, SolverSettings(), "s") != manifest_key(base, SolverSettings(), "t")


def test_what_changes_no_frame_changes_no_key() -> None:
    base = small_procedure()
    key = manifest_key(base, SolverSettings(), "s")
    assert manifest_key(base, SolverSettings(threads=3), "s") == key
    assert manifest_key(base, SolverSettings(spacing=base.tissue.spacing), "s") == key
    assert manifest_key(replace(base, start_time=1, fps=24), SolverSettings(), "s") == key
    (slit, *others) = base.events
    assert isinstance(slit, Incision)
    assert manifest_key(replace(base, events=(replace(slit, time=3), *others)), SolverSettings(), "s") == key
