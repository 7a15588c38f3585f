"""The formats of `lappet export`, a row each."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from lappet.core.output_place import check_place
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.export.export_request import Exporter, ExportFunction, ExportRequest
from lappet.plates.film_file import SUFFIXES as FILM_SUFFIXES


def _lesson() -> ExportFunction:
    from lappet.export.lesson_file import write_lesson

    return write_lesson


def _package() -> ExportFunction:
    from lappet.export.lesson_delivery import write_package

    return write_package


def _glb() -> ExportFunction:
    from lappet.export.glb_file import write_glb

    return write_glb


def _meshes() -> ExportFunction:
    from lappet.export.still_mesh import write_meshes

    return write_meshes


def _table() -> ExportFunction:
    from lappet.export.table_file import write_table_file

    return write_table_file


def _by_blender() -> ExportFunction:
    from lappet.export.blender_file import write_by_blender

    return write_by_blender


def _usd() -> ExportFunction:
    from lappet.export.usd_file import write_usd

    return write_usd


def _usdz() -> ExportFunction:
    from lappet.export.usdz_file import write_usdz

    return write_usdz


_STILL = frozenset({"frames", "step", "every_frame", "simplify"})
_LESSON = frozenset({"language", "title", "frames", "simplify", "max_size"})

EXPORTERS: tuple[Exporter, ...] = (
    Exporter(
        ".html",
        "a lesson in one file, for a browser: it turns, plays and explains the operation without a network",
        _lesson,
        options=_LESSON,
        most_caches=2,
    ),
    *(
        Exporter(suffix, what, _package, options=_LESSON, most_caches=2)
        for suffix, what in (
            (".zip", "the lesson as a package of SCORM 1.2, which reports the steps that were seen"),
            (".h5p", "the lesson as a package of H5P, which reports the steps that were seen"),
        )
    ),
    Exporter(
        ".glb",
        "glTF for viewers in three dimensions: every frame, the steps as animations, materials",
        _glb,
        options=frozenset({"frames", "simplify", "quantized", "meshopt", "max_size"}),
    ),
    Exporter(
        ".usdz",
        "for augmented reality: every frame by bones, at real size, with materials",
        _usdz,
        options=frozenset({"frames", "simplify", "tolerance_mm", "bones", "pause", "instruments", "max_size"}),
    ),
    *(
        Exporter(
            suffix,
            "USD without what is planned and measured, with its pictures, camera and lights beside it",
            _usd,
            options=frozenset({"one_file", "photo", "fps", "step_files"}),
        )
        for suffix in (".usdc", ".usda")
    ),
    Exporter(".stl", "the tissue's surface in one frame, for printing", _meshes, options=_STILL),
    Exporter(".obj", "the tissue's surface in one frame, with colors of its vertices", _meshes, options=_STILL),
    Exporter(".ply", "the tissue's surface in one frame, with colors of its faces", _meshes, options=_STILL),
    Exporter(".3mf", "the tissue's surface in one frame, for printing in colors", _meshes, options=_STILL),
    Exporter(".csv", "forces, landmarks and lengths, a row for each frame", _table, options=frozenset({"frames"})),
    Exporter(".abc", "Alembic, written by Blender", _by_blender, options=frozenset({"frames", "simplify"})),
    Exporter(".fbx", "FBX, written by Blender", _by_blender, options=frozenset({"frames", "simplify"})),
)
FILMS = tuple(each for each in FILM_SUFFIXES if each != ".png")  # in one file, as `lappet export` has them drawn


def exporter_of(path: Path) -> Exporter:
    """Find the format of a file by its suffix.

    Parameters
    ----------
    path
        The file to write.

    Returns
    -------
    Exporter
        The format.

    Raises
    ------
    RefusedError
        If no format has the suffix, or it is that of a film.
    """
    suffix = path.suffix.lower()
    for exporter in EXPORTERS:
        if exporter.suffix == suffix:
            return exporter
    if suffix in FILMS:
        raise refused(ProblemCode.EXPORT_FILM, path, path.suffix)
    known, films = (", ".join(each) for each in ([each.suffix for each in EXPORTERS], FILMS))
    raise refused(ProblemCode.EXPORT_SUFFIX, path, path.suffix, known=known, films=films)


def export(request: ExportRequest) -> list[Path]:
    """Write solved procedures in the format that the target's suffix names.

    Parameters
    ----------
    request
        What to export, and how.

    Returns
    -------
    list[Path]
        The files that were written.

    Raises
    ------
    RefusedError
        If the suffix is unknown, the place cannot be written, the format does not know an option or takes fewer
        caches, a cache cannot be read, or the file would be larger than it may be; nothing is written then.
    OSError
        If a file cannot be written.
    """
    exporter = exporter_of(request.target)
    check_place(request.target)
    if len(request.caches) > exporter.most_caches:
        count, most = len(request.caches), exporter.most_caches
        raise refused(ProblemCode.EXPORT_CACHES, request.target, count, most=most, suffix=exporter.suffix)
    check_options(request.target, request.options)
    write = exporter.load()
    if "max_size" not in request.options:
        return write(request)
    from lappet.export.size_limit import write_within  # which most exports do without

    return write_within(write, request)


def check_options(target: Path, names: Iterable[str]) -> None:
    """Refuse options that the format of a file does not have.

    Parameters
    ----------
    target
        The file to write.
    names
        Names of the options that were chosen.

    Raises
    ------
    RefusedError
        If no format has the file's suffix, or the format has no option of one of the names.
    """
    exporter = exporter_of(target)
    for name in names:
        if name not in exporter.options:
            known = ", ".join(f"--{_spelled(each)}" for each in sorted(exporter.options)) or "none"
            option = f"--{_spelled(name)}"
            raise refused(ProblemCode.EXPORT_OPTION, target, option, suffix=exporter.suffix, known=known)


def _spelled(name: str) -> str:
    return name.replace("_", "-")
