"""A plate as a file: SVG as it is; PDF, PNG and TIFF from it by Typst, whose PDF keeps lines and text."""

from __future__ import annotations

import io
import re
import tempfile
from pathlib import Path
from typing import Any

from lappet.core.durable import write_whole
from lappet.core.output_place import check_place
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.plates.plate_font import PlateFont
from lappet.plates.print_pdf import print_pdf
from lappet.plates.printing_colors import PrintingColors

_SIZE = re.compile(r'width="[^"]*" height="[^"]*" viewBox="[^"]*"')
_TRIFLE = 0.02  # pixels
SUFFIXES = (".svg", ".pdf", ".png", ".tif", ".tiff")


def check_format(path: Path, profile: Path | None = None) -> str:
    """Refuse a file that no plate can be written as.

    Parameters
    ----------
    path
        The file.
    profile
        An ICC profile of a printing process, or None.

    Returns
    -------
    str
        The suffix in lower case, one of `SUFFIXES`.

    Raises
    ------
    RefusedError
        If the suffix is none of these, the folder is missing, the format has no colors of printing, or the profile is
        none of a printing process.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise refused(ProblemCode.PLATE_SUFFIX, path, path.suffix, known=", ".join(SUFFIXES))
    if not path.absolute().parent.is_dir():
        raise refused(ProblemCode.PLATE_FOLDER, path, path.parent)
    check_place(path)
    if profile is not None and suffix not in (".tif", ".tiff", ".pdf"):
        raise refused(ProblemCode.PLATE_CMYK, path, path.suffix)
    if profile is not None:
        PrintingColors(profile)
    return suffix


def write_plate(
    svg: str,
    size: tuple[float, float],
    alt: str,
    font: PlateFont,
    path: Path,
    dpi: float,
    profile: Path | None = None,
    transparent: bool = False,
) -> None:
    """Write a plate; the file appears whole or not at all.

    Parameters
    ----------
    svg
        The plate.
    size
        Its width and height in mm.
    alt
        What it shows, for those who cannot see it; a PDF is tagged with it (PDF/UA-1).
    font
        Its font.
    path
        The file; its suffix, one of `SUFFIXES`, says what it becomes.
    dpi
        Pixels per inch of PNG and TIFF.
    profile
        An ICC profile of a printing process: a TIFF in its colors (CMYK), or a PDF/X-4.
    transparent
        Whether the paper of a PNG is transparent.

    Raises
    ------
    RefusedError
        If the suffix is none of these, the folder is missing, or the profile is none for CMYK.
    OSError
        If the file cannot be written.
    """
    suffix = check_format(path, profile)
    if suffix == ".svg":
        data = svg.encode()
    elif suffix == ".pdf":
        data = _typeset(svg, size, alt, font, format="pdf", pdf_standards=["ua-1"])
        data = data if profile is None else print_pdf(data, PrintingColors(profile))
    else:
        data = _rastered(svg, size, alt, font, transparent, dpi)
        if suffix != ".png":
            data = _tiff(data, dpi, profile)
        else:
            data = _resolved(data, dpi)
    write_whole(path, data)


def _rastered(svg: str, size: tuple[float, float], alt: str, font: PlateFont, transparent: bool, dpi: float) -> bytes:
    """A PNG whose pixels are those of the drawing.

    Typst draws an SVG onto as many pixels as it covers in part and then fits them to the page: a page that is not a
    whole number of pixels wide loses a column in its middle. So it gets a page of whole pixels, a trifle smaller.
    """
    counts = [max(round(side / 25.4 * dpi), 1) for side in size]
    width, height = (count * 25.4 / dpi for count in counts)
    head = f'width="{width:.6f}mm" height="{height:.6f}mm" viewBox="0 0 {width:.6f} {height:.6f}"'
    whole = _SIZE.sub(head, svg, count=1)
    page = ((counts[0] - _TRIFLE) * 25.4 / dpi, (counts[1] - _TRIFLE) * 25.4 / dpi)
    return _typeset(whole, page, alt, font, transparent, format="png", ppi=float(dpi))


def _typeset(
    svg: str, size: tuple[float, float], alt: str, font: PlateFont, transparent: bool = False, **options: Any
) -> bytes:
    import typst

    width, height = (f"{each:.6f}mm" for each in size)
    quoted = alt.replace("\\", "\\\\").replace('"', '\\"')
    page = (
        f'#set document(title: "{quoted}", date: none)\n'
        f"#set page(width: {width}, height: {height}, margin: 0pt{', fill: none' if transparent else ''})\n"
        f'#image("plate.svg", width: {width}, height: {height}, alt: "{quoted}")\n'
    )
    with tempfile.TemporaryDirectory(prefix="lappet_plate_") as folder:
        (Path(folder) / "plate.svg").write_text(svg, encoding="utf-8")
        (Path(folder) / "plate.typ").write_text(page, encoding="utf-8")
        return bytes(
            typst.compile(
                str(Path(folder) / "plate.typ"),
                font_paths=[str(font.path.parent)],
                ignore_system_fonts=True,
                **options,
            )
        )


def _resolved(png: bytes, dpi: float) -> bytes:
    """A PNG that says how many pixels it has per inch."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.open(io.BytesIO(png)).save(buffer, "PNG", dpi=(dpi, dpi))
    return buffer.getvalue()


def _tiff(png: bytes, dpi: float, profile: Path | None) -> bytes:
    from PIL import Image, ImageCms

    picture = Image.open(io.BytesIO(png)).convert("RGB")
    buffer = io.BytesIO()
    if profile is None:
        own = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
        picture.save(buffer, "TIFF", dpi=(dpi, dpi), compression="tiff_lzw", icc_profile=own)
        return buffer.getvalue()
    printing = PrintingColors(profile)
    printed = printing.of_picture(picture)
    printed.save(buffer, "TIFF", dpi=(dpi, dpi), compression="tiff_lzw", icc_profile=printing.data)
    return buffer.getvalue()
