"""A lesson as a package of SCORM 1.2, which learning platforms import."""

from __future__ import annotations

import hashlib
import io
import re
import zipfile
from collections.abc import Mapping
from xml.etree import ElementTree

PAGE = "lesson.html"
_PACKAGING = "http://www.imsproject.org/xsd/imscp_rootv1p1p2"
_SCORM = "http://www.adlnet.org/xsd/adlcp_rootv1p2"
_INSTANCE = "http://www.w3.org/2001/XMLSchema-instance"
_FIRST = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip can hold: the same lesson makes the same file


def scorm_package(page: str, title: str, mastery: int | None) -> bytes:
    """Pack a lesson.

    Parameters
    ----------
    page
        The lesson's page, which reports by SCORM 1.2.
    title
        Its title.
    mastery
        Percentage of right answers with which it is passed, or None where it is only completed.

    Returns
    -------
    bytes
        The zip, with the page and its manifest.
    """
    return zip_of({"imsmanifest.xml": manifest(title, mastery), PAGE: page.encode("utf-8")})


def manifest(title: str, mastery: int | None) -> bytes:
    """Write the manifest of a package with one page.

    Parameters
    ----------
    title
        The lesson's title.
    mastery
        Percentage of right answers with which it is passed, or None.

    Returns
    -------
    bytes
        The file imsmanifest.xml.
    """
    for prefix, namespace in (("", _PACKAGING), ("adlcp", _SCORM), ("xsi", _INSTANCE)):
        ElementTree.register_namespace(prefix, namespace)

    def element(parent: ElementTree.Element, name: str, text: str = "", **attributes: str) -> ElementTree.Element:
        made = ElementTree.SubElement(parent, f"{{{_PACKAGING}}}{name}", attributes)
        made.text = text or None
        return made

    places = f"{_PACKAGING} imscp_rootv1p1p2.xsd {_SCORM} adlcp_rootv1p2.xsd"
    root = ElementTree.Element(
        f"{{{_PACKAGING}}}manifest",
        {"identifier": f"lappet-{_identifier(title)}", "version": "1.0", f"{{{_INSTANCE}}}schemaLocation": places},
    )
    metadata = element(root, "metadata")
    element(metadata, "schema", "ADL SCORM")
    element(metadata, "schemaversion", "1.2")
    organizations = element(root, "organizations", default="lesson")
    organization = element(organizations, "organization", identifier="lesson")
    element(organization, "title", title)
    item = element(organization, "item", identifier="page", identifierref="files", isvisible="true")
    element(item, "title", title)
    if mastery is not None:
        ElementTree.SubElement(item, f"{{{_SCORM}}}masteryscore").text = str(mastery)
    resources = element(root, "resources")
    resource = element(resources, "resource", identifier="files", type="webcontent", href=PAGE)
    resource.set(f"{{{_SCORM}}}scormtype", "sco")
    element(resource, "file", href=PAGE)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def zip_of(files: Mapping[str, bytes]) -> bytes:
    """Pack files into a zip that depends on nothing but them.

    Parameters
    ----------
    files
        The files by their paths.

    Returns
    -------
    bytes
        The zip.
    """
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as package:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, _FIRST)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            package.writestr(entry, data)
    return made.getvalue()


def _identifier(title: str) -> str:
    """Letters, digits and hyphens, for an XML identifier that no other title has."""
    plain = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")
    return f"{plain or 'lesson'}-{hashlib.blake2b(title.encode('utf-8'), digest_size=4).hexdigest()}"
