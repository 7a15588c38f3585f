"""Hypothesis strategies for procedures: every kind of event, odd numbers, polygons, subsets, bones."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from lappet.procedure import (
    MODELS,
    VESSEL_KINDS,
    Bone,
    Event,
    Excision,
    Hook,
    Incision,
    Landmark,
    Material,
    Pressure,
    Procedure,
    Region,
    Retractor,
    Roller,
    Section,
    Suture,
    SutureLayer,
    SutureRun,
    Thin,
    Tissue,
    Traction,
    Undermine,
    Vessel,
)
from lappet.tissue.patch import flat_patch

numbers = st.floats(allow_nan=False, allow_infinity=False, width=64, min_value=-1e9, max_value=1e9)
points = st.tuples(numbers, numbers, numbers)
directions = points.filter(any)
curves = st.lists(points, min_size=1, max_size=5).map(tuple)
bases = st.sampled_from(["linear", "bspline", "catmullRom", "bezier"])
sample_times = st.lists(numbers, min_size=1, max_size=4, unique=True).map(sorted)
matrices = st.lists(numbers, min_size=15, max_size=15).map(lambda m: (*m, 1.0))
labels = st.text(st.characters(codec="utf-8", exclude_categories=["C"]), min_size=1, max_size=12)


def _samples(values: st.SearchStrategy[tuple[float, ...]]) -> st.SearchStrategy[tuple[tuple[float, object], ...]]:
    return sample_times.flatmap(
        lambda times: st.tuples(*(values for _ in times)).map(lambda found: tuple(zip(times, found, strict=True)))
    )


def vessels(name: str) -> st.SearchStrategy[Vessel]:
    """A vessel with that name; its kind may be any word."""
    return st.builds(
        Vessel, st.just(name), curves, st.sampled_from([*VESSEL_KINDS, "duct"]), numbers, labels, st.booleans(), bases
    )


def suture_runs(name: str) -> st.SearchStrategy[SutureRun]:
    """A suture run with that name."""
    layer = st.builds(SutureLayer, st.sampled_from(["skin", "deep", "dermal"]), numbers, st.booleans())
    return st.builds(
        SutureRun,
        st.just(name),
        st.tuples(curves, curves),
        numbers,
        st.sampled_from([(1, -1), (-1, 1), (1, 1)]),
        st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4)), max_size=3).map(tuple),
        numbers,
        numbers,
        st.none() | numbers,
        st.none() | numbers,
        st.lists(layer, min_size=1, max_size=3, unique_by=lambda each: each.name).map(tuple),
        st.sampled_from(["interrupted", "running", "verticalMattress"]),
        numbers,
        st.sampled_from(["halving", "forward", "together"]),
        st.sampled_from(["exact", "thread"]),
        st.sampled_from(["", "nylon 5-0"]),
        *([numbers] * 4),
        st.lists(st.tuples(points, points), max_size=2).map(tuple),
    )


def events(name: str) -> st.SearchStrategy[Event]:
    """An event of any kind with that name."""
    named = st.just(name)
    directions = points.filter(any)  # zero in a file is none
    return st.one_of(
        st.builds(
            Incision, named, numbers, curves, st.none() | numbers, numbers, bases, st.booleans(), st.none() | directions
        ),
        st.builds(Excision, named, numbers, curves),
        st.builds(Undermine, named, numbers, curves, bases),
        st.builds(Thin, named, numbers, curves, numbers, bases, numbers, numbers),
        st.builds(Hook, named, points, _samples(points), numbers, numbers, numbers),
        st.builds(Retractor, named, st.sampled_from(["fixed", "handle"]), _samples(matrices), numbers, numbers),
        st.builds(Suture, named, st.tuples(points, points), numbers, numbers, numbers),
        st.builds(
            Suture,
            named,
            st.lists(points, min_size=2, max_size=6).map(tuple),
            numbers,
            numbers,
            numbers,
            st.just("thread"),
            st.sampled_from(["", "nylon 5-0"]),
            numbers,
            numbers,
            numbers,
        ),
        suture_runs(name),
        st.builds(Traction, named, st.sampled_from(["fixed", "handle"]), _samples(points), numbers, numbers),
        st.builds(Pressure, named, st.sampled_from(["fixed", "handle"]), _samples(numbers), numbers, numbers),
        st.builds(Section, named, points, points, labels),
        st.builds(Landmark, named, curves, labels),
    )


materials = st.builds(
    Material,
    st.sampled_from(["skin", "fat", "scar_1"]),
    st.sampled_from(MODELS),
    *([numbers] * 8),
    points,
    st.tuples(numbers, numbers),
    numbers,
    numbers,
    st.just(()) | _samples(numbers),
)
depths = numbers | st.just(float("inf"))


@st.composite
def tissues(draw: st.DrawFn) -> Tissue:
    """A patch of quads or triangles, moved about, with and without UVs and gravity, and with an odd polygon."""
    patch = flat_patch((6.0, 4.0, 2.0), 2.0, triangles=draw(st.booleans()))
    shake = np.random.default_rng(draw(st.integers(0, 1000))).normal(0.0, 0.3, patch.points.shape)
    counts, indices, uv = patch.face_vertex_counts, patch.face_vertex_indices, patch.uv
    if draw(st.booleans()):  # the first two faces as one polygon of all their corners
        counts = np.concatenate([[counts[0] + counts[1]], counts[2:]])
    faces = st.lists(st.integers(0, len(counts) - 1), max_size=6, unique=True)
    painted = draw(st.lists(st.sampled_from(["fixed", "bed", "handle"]), unique=True))
    rolling = [name for name in ("fixed", "bed", "handle") if name not in painted and draw(st.booleans())]
    named = st.sampled_from(["skin", "fat", "scar_1"])
    return Tissue(
        patch.points + shake,
        counts,
        indices,
        draw(st.sampled_from([uv, None])),
        {name: np.array(draw(faces), np.int32) for name in draw(st.permutations(["fixed", "bed", "handle"]))},
        draw(st.sampled_from(["skin", "fat"])),
        draw(numbers),
        draw(numbers),
        draw(points),
        draw(numbers),
        draw(numbers),
        tuple(Region(name, draw(named), draw(numbers), draw(depths)) for name in painted),
        tuple(Roller(name, draw(st.none() | directions)) for name in rolling),
        draw(st.booleans()),
    )


@st.composite
def procedures(draw: st.DrawFn) -> Procedure:
    """A procedure that can be written; its values need make no sense."""
    names = draw(st.lists(st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,6}", fullmatch=True), max_size=6, unique=True))
    tissue = draw(tissues())
    bone = flat_patch((3.0, 3.0, 3.0), 3.0)
    bones = [Bone(name, bone.points, bone.face_vertex_counts, bone.face_vertex_indices) for name in ("skull", "orbit")]
    start = draw(st.integers(-50, 50))
    return Procedure(
        tissue,
        tuple(draw(st.lists(materials, max_size=3, unique_by=lambda material: material.name))),
        tuple(draw(events(name)) for name in names),
        tuple(bones[: draw(st.integers(0, 2))]),
        float(start),
        float(start + draw(st.integers(0, 100))),
        draw(st.sampled_from([24.0, 25.0, 29.97])),
        vessels=tuple(draw(vessels(name)) for name in names[:2]),
    )
