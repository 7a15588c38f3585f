"""A PDF as printers want it: PDF/X-4 (ISO 15930-7), in the inks of a printing process.

The typesetter's PDF has its fonts embedded and its colors in sRGB and grey by ICC profiles. Here its colors become
inks, and it gets what PDF/X-4 asks for: an output intent with the process's profile, the box to which the page is
trimmed, and metadata that say so. Its tags stay, so that it remains PDF/UA-1.
"""

from __future__ import annotations

import io
import os
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import numpy as np
import pikepdf
from PIL import Image

from lappet.plates.printing_colors import PrintingColors

PDF_X = "PDF/X-4"
VERSION = "1.6"  # what PDF/X-4 is based on
_XMP = {
    "pdfxid:GTS_PDFXVersion": PDF_X,
    "pdf:Trapped": "False",
    "pdf:PDFVersion": VERSION,
    "xmpMM:VersionID": "1",
    "xmpMM:RenditionClass": "default",
}
# Operators of colors: which choose a space, and what those that set a color become.
SPACES = ("cs", "CS")
COLORS = {"sc": "k", "scn": "k", "SC": "K", "SCN": "K", "g": "k", "rg": "k", "G": "K", "RG": "K"}


def print_pdf(data: bytes, colors: PrintingColors) -> bytes:
    """Make a PDF/X-4 of a typeset PDF.

    Parameters
    ----------
    data
        The PDF.
    colors
        The printing process.

    Returns
    -------
    bytes
        The PDF/X-4.
    """
    with pikepdf.open(io.BytesIO(data)) as pdf:
        for page in pdf.pages:
            page.obj.TrimBox = page.obj.BleedBox = pikepdf.Array([float(each) for each in page.mediabox])
            _print(pdf, page, page.obj.get("/Resources"), colors)
        for form in colored_streams(pdf, "/Form"):
            _print(pdf, form, form.get("/Resources"), colors)
        for image in colored_streams(pdf, "/Image"):
            _print_image(image, colors)
        pdf.Root.OutputIntents = pikepdf.Array([_intent(pdf, colors)])
        _describe(pdf)
        buffer = io.BytesIO()
        pdf.remove_unreferenced_resources()
        pdf.save(buffer, force_version=VERSION, deterministic_id=True)
    return buffer.getvalue()


def colored_streams(pdf: pikepdf.Pdf, kind: str) -> Iterator[pikepdf.Stream]:
    """Find the streams that are drawn; masks, which have no color, are left out.

    Parameters
    ----------
    pdf
        The PDF.
    kind
        "/Form" or "/Image".

    Yields
    ------
    pikepdf.Stream
        The streams of that kind.
    """
    masks = {each.SMask.objgen for each in pdf.objects if isinstance(each, pikepdf.Stream) and "/SMask" in each}
    for each in pdf.objects:
        if isinstance(each, pikepdf.Stream) and each.get("/Subtype") == kind and each.objgen not in masks:
            yield each


def _print(pdf: pikepdf.Pdf, page: Any, resources: Any, colors: PrintingColors) -> None:
    """Write the colors of a page's or a form's content as inks."""
    found: list[Any] = []
    known: dict[tuple[float, ...], tuple[float, ...]] = {}

    def inks(operands: Any) -> list[float]:
        color = tuple(float(each) for each in operands)
        if color not in known:
            known[color] = colors.of_color(color)
        return list(known[color])

    for instruction in pikepdf.parse_content_stream(page):
        operator = str(instruction.operator)
        if operator in SPACES:
            continue
        becomes = COLORS.get(operator)
        if becomes is None:
            found.append(instruction)
        else:
            found.append(pikepdf.ContentStreamInstruction(inks(instruction.operands), pikepdf.Operator(becomes)))
    content = pikepdf.unparse_content_stream(found)
    if isinstance(page, pikepdf.Page):
        page.obj.Contents = pdf.make_stream(content)
    else:
        page.write(content)
    if resources is not None and "/ColorSpace" in resources:
        del resources["/ColorSpace"]


def _print_image(image: pikepdf.Stream, colors: PrintingColors) -> None:
    """Write an image's pixels as inks."""
    size = int(image.Width), int(image.Height)
    count = len(image.read_bytes()) // (size[0] * size[1])
    pixels = np.frombuffer(image.read_bytes(), np.uint8).reshape(size[1], size[0], count)
    picture = Image.fromarray(pixels if count == 3 else pixels[..., 0], "RGB" if count == 3 else "L")
    image.write(colors.of_picture(picture).tobytes())
    image.ColorSpace = pikepdf.Name.DeviceCMYK
    if "/DecodeParms" in image:
        del image["/DecodeParms"]


def _intent(pdf: pikepdf.Pdf, colors: PrintingColors) -> pikepdf.Object:
    profile = pdf.make_stream(colors.data)
    profile.N = 4
    return pdf.make_indirect(
        pikepdf.Dictionary(
            Type=pikepdf.Name.OutputIntent,
            S=pikepdf.Name.GTS_PDFX,
            OutputConditionIdentifier=pikepdf.String(colors.name),
            Info=pikepdf.String(colors.name),
            DestOutputProfile=profile,
        )
    )


def _describe(pdf: pikepdf.Pdf) -> None:
    """Write the metadata, in XMP and in the document's information alike."""
    now = datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())), UTC)
    with pdf.open_metadata(set_pikepdf_as_editor=False, update_docinfo=False) as told:
        told.register_xml_namespace("http://www.npes.org/pdfx/ns/id/", "pdfxid")
        for key, value in _XMP.items():
            told[key] = value
        for key in ("xmp:CreateDate", "xmp:ModifyDate", "xmp:MetadataDate"):
            told[key] = now.isoformat()
    stamp = now.strftime("D:%Y%m%d%H%M%SZ")
    pdf.docinfo["/CreationDate"] = pdf.docinfo["/ModDate"] = pikepdf.String(stamp)
    pdf.docinfo["/Trapped"] = pikepdf.Name("/False")
