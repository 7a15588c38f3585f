"""Small files that ask for much: each function writes one into a folder and returns it."""

from __future__ import annotations

import json
import struct
import zipfile
import zlib
from pathlib import Path

import numpy as np

from lappet.procedure import Hook, Procedure
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import pxr, write_procedure

HEADER = """#usda 1.0
(
    startTimeCode = 0
    endTimeCode = 9
    metersPerUnit = 0.001
    upAxis = "Z"
    subLayers = [{layers}]
)
"""
CLIPS = """over "Procedure" (
    clips = {
        dictionary default = {
            string templateAssetPath = "TEMPLATE"
            string primPath = "/Procedure"
            double templateStartTime = 0
            double templateEndTime = 1000
            STRIDE
        }
    }
)
{
}
"""
CHILD = """    def "c{i}" (
        references = </l{below}>
    )
    {{
    }}
"""


def procedure(folder: Path, name: str = "sound.usda") -> Path:
    """Write a procedure of one small patch that nothing is wrong with but that nothing happens."""
    file = folder / name
    held = ((1.0, (0.0, 0.0, 2.0)), (5.0, (0.0, 1.0, 4.0)))
    patch = Procedure(flat_patch((10, 10, 2), 5.0), end_time=9.0)
    write_procedure(patch.with_events(Hook("hook", (0.0, 0.0, 2.0), held, 1.0, 6.0)), file)
    return file


def with_prims(folder: Path, prims: str, name: str = "over.usda") -> Path:
    """Write a layer over a sound procedure, with more prims."""
    procedure(folder)
    file = folder / name
    file.write_text(HEADER.format(layers="@./sound.usda@") + prims, encoding="utf-8")
    return file


def unfolding_crate(folder: Path, subsets: int) -> Path:
    """Write a .usdc whose face subsets are one array of 4 MB that the file holds once, in few bytes."""
    usd = pxr()
    procedure(folder)
    layer = usd.Sdf.Layer.FindOrOpen(str(folder / "sound.usda"))
    stage = usd.Usd.Stage.Open(layer)
    many = usd.Vt.IntArray.FromNumpy(np.zeros(1 << 20, np.int32))
    for i in range(subsets):
        subset = usd.UsdGeom.Subset.Define(stage, f"/Procedure/Tissue/s{i}")
        subset.CreateElementTypeAttr("face")
        subset.CreateFamilyNameAttr("lappet")
        subset.CreateIndicesAttr(many)
    file = folder / "unfolding.usdc"
    layer.Export(str(file))
    return file


def unfolding_cache(folder: Path, frames: int) -> Path:
    """Write a skin cache whose counts are one array of 12 MB at every frame, in few bytes."""
    usd = pxr()
    procedure(folder)
    layer = usd.Sdf.Layer.CreateAnonymous(".usda")
    stage = usd.Usd.Stage.Open(layer)
    mesh = usd.UsdGeom.Mesh.Define(stage, "/Procedure/Skin/epoch_00")
    same = usd.Vt.IntArray.FromNumpy(np.zeros(3 << 20, np.int32))
    mesh.CreateFaceVertexCountsAttr(same)
    for frame in range(frames):
        mesh.GetFaceVertexCountsAttr().Set(same, float(frame))
    layer.subLayerPaths.append("./sound.usda")
    file = folder / "skin.usdc"
    layer.Export(str(file))
    return file


def slow_crate(folder: Path, samples: int, depth: int) -> Path:
    """Write a .usdc whose hook moves at many times, each below many prims that move at as many."""
    usd = pxr()
    procedure(folder)
    layer = usd.Sdf.Layer.FindOrOpen(str(folder / "sound.usda"))
    above = "/Procedure/Timeline" + "".join(f"/a{i}" for i in range(depth))
    stage = usd.Usd.Stage.Open(layer)
    for path in usd.Sdf.Path(above).GetPrefixes()[2:]:
        usd.UsdGeom.Xform.Define(stage, path).AddTranslateOp().Set(usd.Gf.Vec3d(0, 0, 0))
    hook = usd.Sdf.Path(f"{above}/hook")
    usd.Sdf.CopySpec(layer, "/Procedure/Timeline/hook", layer, hook)
    move = layer.GetAttributeAtPath(hook.AppendProperty("xformOp:translate"))
    for time in range(samples):
        layer.SetTimeSample(move.path, float(time) / samples, usd.Gf.Vec3d(0, 0, 0))
    file = folder / "slow.usdc"
    layer.Export(str(file))
    return file


def nested_references(folder: Path, levels: int) -> Path:
    """Write a layer of 10 ** levels prims, each level ten references to the one below."""
    prims = ['def Xform "l0"\n{\n}\n']
    for level in range(1, levels + 1):
        tens = "".join(CHILD.format(i=i, below=level - 1) for i in range(10))
        prims.append(f'def Xform "l{level}"\n{{\n{tens}}}\n')
    return with_prims(folder, "".join(prims))


def clips(folder: Path, stride: str, template: str = "./clip.#.usda") -> Path:
    """Write a layer with a set of value clips."""
    return with_prims(folder, CLIPS.replace("TEMPLATE", template).replace("STRIDE", stride))


def zip_of_a_mesh(folder: Path, mib: int) -> Path:
    """Write a .zip in which a mesh file of many blanks is folded to a thousandth."""
    file = folder / "mesh.zip"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("mesh.obj", "w") as mesh:
        mesh.write(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        for _ in range(mib):
            mesh.write(b"\n" * (1 << 20))
    return file


def folded_package(folder: Path, mib: int) -> Path:
    """Write a .usdz whose layer is folded to a thousandth, which the format forbids."""
    file = folder / "folded.usdz"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("p.usda", "w") as layer:
        layer.write(HEADER.format(layers="").encode())
        for _ in range(mib):
            layer.write(b"\n" * (1 << 20))
    return file


def obj_with_a_large_picture(folder: Path, side: int) -> Path:
    """Write a triangle whose material has a PNG of side x side pixels in few bytes."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    packer = zlib.compressobj(9)
    rows = b"".join([*(packer.compress(bytes(1 + side)) for _ in range(side)), packer.flush()])
    picture = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", picture) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
    (folder / "large.png").write_bytes(png)
    (folder / "skin.mtl").write_text("newmtl skin\nmap_Kd large.png\n")
    file = folder / "skin.obj"
    corners = "v 0 0 0\nv 80 0 0\nv 0 80 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
    file.write_text(f"mtllib skin.mtl\n{corners}usemtl skin\nf 1/1 2/2 3/3\n")
    return file


def gltf(folder: Path, name: str = "mesh.gltf", **changed: object) -> Path:
    """Write a glTF of one triangle, with some of its lists changed."""
    points = np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)], np.float32).tobytes()
    (folder / "points.bin").write_bytes(points)
    tree: dict[str, object] = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "points.bin", "byteLength": len(points)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    file = folder / name
    file.write_text(json.dumps({**tree, **changed}))
    return file
