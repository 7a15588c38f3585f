"""What can be told of a PDF/X-4 (ISO 15930-7) from its objects: keys, boxes, profile, fonts, colors, metadata.

These are the conditions that a plate could break. What is not looked at: the syntax of fonts and of content streams,
blending spaces of transparency groups, optional content, and whether the profile describes the press that prints it.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import pikepdf

from lappet.plates.print_pdf import COLORS, PDF_X, SPACES, VERSION, colored_streams

Check = Callable[[pikepdf.Pdf], bool]


def _boxed(pdf: pikepdf.Pdf) -> bool:
    """Each page has the box to which it is trimmed, inside the others, and no art box beside it."""

    def inside(inner: Any, outer: Any) -> bool:
        near, far = [float(each) for each in inner], [float(each) for each in outer]
        return near[0] >= far[0] and near[1] >= far[1] and near[2] <= far[2] and near[3] <= far[3]

    return all(
        "/TrimBox" in page.obj
        and "/ArtBox" not in page.obj
        and inside(page.obj.TrimBox, page.obj.get("/BleedBox", page.mediabox))
        and inside(page.obj.get("/BleedBox", page.mediabox), page.mediabox)
        for page in pdf.pages
    )


def _intended(pdf: pikepdf.Pdf) -> bool:
    """There is one output intent of PDF/X, which names its condition and has a profile of four inks."""
    own = [each for each in pdf.Root.get("/OutputIntents", []) if each.S == "/GTS_PDFX"]
    if len(own) != 1 or not str(own[0].get("/OutputConditionIdentifier", "")):
        return False
    profile = own[0].DestOutputProfile
    head = profile.read_bytes()[:40]
    return int(profile.N) == 4 and head[12:16] == b"prtr" and head[16:20] == b"CMYK" and head[36:40] == b"acsp"


def _told(pdf: pikepdf.Pdf) -> bool:
    """The metadata, whose stream is not compressed, name the version of PDF/X and what must go with it."""
    if "/Filter" in pdf.Root.Metadata:
        return False
    with pdf.open_metadata(update_docinfo=False) as told:
        dates = all(told.get(f"xmp:{key}") for key in ("CreateDate", "ModifyDate", "MetadataDate"))
        ids = all(told.get(f"xmpMM:{key}") for key in ("DocumentID", "VersionID", "RenditionClass"))
        named = told.get("pdfxid:GTS_PDFXVersion") == PDF_X and told.get("pdf:Trapped") in ("True", "False")
        return bool(dates and ids and named and told.get("dc:title"))


def _embedded(pdf: pikepdf.Pdf) -> bool:
    """Every font descriptor has its font's file."""
    fonts = [each for each in pdf.objects if isinstance(each, pikepdf.Dictionary) and each.get("/Type") == "/Font"]
    plain = [each for each in fonts if each.get("/Subtype") not in ("/Type0", "/Type3")]
    return all(
        "/FontDescriptor" in each
        and any(key in each.FontDescriptor for key in ("/FontFile", "/FontFile2", "/FontFile3"))
        for each in plain
    )


def _inked(pdf: pikepdf.Pdf) -> bool:
    """Pages, forms and images have no colors but tints of the four inks; masks have no color."""
    if not all(each.ColorSpace == "/DeviceCMYK" for each in colored_streams(pdf, "/Image")):
        return False
    contents = [*pdf.pages, *colored_streams(pdf, "/Form")]
    others = {*SPACES, *COLORS, "sh"}
    return not any(
        str(each.operator) in others for content in contents for each in pikepdf.parse_content_stream(content)
    )


def _still(pdf: pikepdf.Pdf) -> bool:
    """There is nothing that acts, nothing that is filled in, and no annotation; no stream lies in another file."""
    acts = ("/OpenAction", "/AA", "/AcroForm", "/Names", "/NeedsRendering")
    streams = [each for each in pdf.objects if isinstance(each, pikepdf.Stream)]
    return (
        not any(key in pdf.Root for key in acts)
        and not any("/Annots" in page.obj or "/AA" in page.obj for page in pdf.pages)
        and not any("/F" in each or each.get("/Filter") == "/LZWDecode" for each in streams)
        and not any(each.get("/Subtype") == "/PS" or "/OPI" in each or "/Alternates" in each for each in streams)
    )


def _plain_states(pdf: pikepdf.Pdf) -> bool:
    """No graphics state has a transfer function or a halftone."""
    states = [
        each for each in pdf.objects if isinstance(each, pikepdf.Dictionary) and each.get("/Type") == "/ExtGState"
    ]
    return not any("/TR" in each or "/HTP" in each or each.get("/TR2", "/Default") != "/Default" for each in states)


CHECKS: dict[str, Check] = {
    "is PDF 1.6, not encrypted, with an identifier": lambda pdf: (
        pdf.pdf_version == VERSION and not pdf.is_encrypted and "/ID" in pdf.trailer
    ),
    "has boxes": _boxed,
    "has an output intent": _intended,
    "has metadata": _told,
    "has its fonts embedded": _embedded,
    "has colors of the process only": _inked,
    "does nothing by itself": _still,
    "has plain graphics states": _plain_states,
}


def print_faults(data: bytes) -> list[str]:
    """Look for what keeps a PDF from being PDF/X-4 in the inks of a process.

    Parameters
    ----------
    data
        The PDF.

    Returns
    -------
    list[str]
        Names of the checks of `CHECKS` that it fails; what they do not look at may still be wrong.
    """
    with pikepdf.open(io.BytesIO(data)) as pdf:
        return [name for name, holds in CHECKS.items() if not holds(pdf)]
