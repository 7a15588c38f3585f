"""A 3MF package with one colored mesh in millimetres (3MF Consortium, Core Specification 1.3: base materials)."""

from __future__ import annotations

import io
import zipfile
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from lappet.core.version import version
from lappet.drawing.surface_look import SurfaceLook

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
_MODEL = "3D/3dmodel.model"
_TYPES = (
    f'<?xml version="1.0" encoding="UTF-8"?>\n<Types xmlns="{_PACKAGE}/content-types">'
    f'<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    f'<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
_RELATIONS = (
    f'<?xml version="1.0" encoding="UTF-8"?>\n<Relationships xmlns="{_PACKAGE}/relationships">'
    f'<Relationship Target="/{_MODEL}" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
    f"</Relationships>"
)


def threemf_package(
    triangles: NDArray[np.int32], points: NDArray[np.float32], looks: list[SurfaceLook], of_face: NDArray[np.int64]
) -> bytes:
    """Make the package.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3), outward.
    points
        Vertices in mm, shape (n, 3).
    looks
        What faces look like.
    of_face
        For each face the index of its look, shape (m,).

    Returns
    -------
    bytes
        The file.
    """
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", _TYPES)
        archive.writestr("_rels/.rels", _RELATIONS)
        archive.writestr(_MODEL, _model(triangles, points, looks, of_face))
    return packed.getvalue()


def _model(
    triangles: NDArray[np.int32], points: NDArray[np.float32], looks: list[SurfaceLook], of_face: NDArray[np.int64]
) -> bytes:
    element, add = ElementTree.Element, ElementTree.SubElement
    model = element("model", {"xmlns": _CORE, "unit": "millimeter", "xml:lang": "en-US"})
    add(model, "metadata", name="Application").text = f"Lappet {version()}"
    resources = add(model, "resources")
    bases = add(resources, "basematerials", id="1")
    for look in looks:
        add(bases, "base", name=look.title, displaycolor="#{:02X}{:02X}{:02X}".format(*look.display_color))
    mesh = add(add(resources, "object", id="2", type="model", pid="1", pindex="0"), "mesh")
    vertices = add(mesh, "vertices")
    for x, y, z in points.tolist():
        add(vertices, "vertex", x=f"{x:.6g}", y=f"{y:.6g}", z=f"{z:.6g}")
    faces = add(mesh, "triangles")
    for (a, b, c), look in zip(triangles.tolist(), of_face.tolist(), strict=True):
        add(faces, "triangle", v1=str(a), v2=str(b), v3=str(c), pid="1", p1=str(look))
    add(add(model, "build"), "item", objectid="2")
    found: bytes = ElementTree.tostring(model, encoding="UTF-8", xml_declaration=True)
    return found
