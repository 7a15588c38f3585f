"""In Blender's module alone: installs a zip, uses Lappet from it, takes it away: `extension_life.py ZIP ARRAYS RESULT`.

ARRAYS: an .npz with a surface, which is solved with a hook. RESULT: the .npz of the frame that this writes. Prints one
line of JSON with what was seen. Run by test_extension_zip.py, in an environment whose only packages are bpy's.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import pkgutil
import re
import sys
from pathlib import Path
from typing import Any

PACKAGE = "lappet_blender"
MODULE = f"bl_ext.user_default.{PACKAGE}"


def main(zip_file: str, arrays: str, result: str) -> None:
    strangers = [name for name in ("lappet", "lappet_blender", "zmq", "manifold3d") if importlib.util.find_spec(name)]
    import bpy  # isort: skip - it brings addon_utils
    import addon_utils

    seen: dict[str, Any] = {"strangers": strangers, "blender": bpy.app.version_string}
    seen["installed"] = list(
        bpy.ops.extensions.package_install_files(filepath=zip_file, repo="user_default", enable_on_install=True)
    )
    seen["enabled"] = addon_utils.check(MODULE)
    seen["scene has lappet"] = hasattr(bpy.types.Scene, "lappet")

    extensions = Path(os.environ["BLENDER_USER_RESOURCES"]) / "extensions"
    import lappet

    seen["lappet"] = str(Path(lappet.__file__).relative_to(extensions))
    seen["version"] = lappet.__version__
    seen["mode before"] = oct((Path(lappet.__file__).parent / "bin" / "lappet-solverd").stat().st_mode & 0o777)
    seen["imported"] = import_all()
    seen["cannot be imported"] = [*not_importable("lappet"), *not_importable(MODULE)]
    solve(Path(arrays), Path(result), seen)

    bpy.ops.preferences.addon_disable(module=MODULE)
    seen["disabled"] = addon_utils.check(MODULE)
    seen["scene has lappet when disabled"] = hasattr(bpy.types.Scene, "lappet")
    repos = [repo.module for repo in bpy.context.preferences.extensions.repos]
    seen["uninstalled"] = list(
        bpy.ops.extensions.package_uninstall(repo_index=repos.index("user_default"), pkg_id=PACKAGE)
    )
    seen["left"] = sorted(
        str(path.relative_to(extensions))
        for path in extensions.rglob("*")
        if path.is_file() and any(name in path.parts for name in (PACKAGE, "lappet", "lappet.libs"))
    )
    print(json.dumps(seen))


def import_all() -> list[str]:
    """Imports what the add-on's solve needs from the wheels; returns the folders that the packages came from."""
    import manifold3d
    import msgpack
    import platformdirs
    import zmq

    assert manifold3d.Manifold.cube((1, 1, 1)).volume() == 1.0
    modules = (manifold3d, msgpack, platformdirs, zmq)
    return sorted({module.__file__.partition("site-packages")[0] for module in modules})


def not_importable(package: str) -> list[str]:
    """The modules of a package that ask for something which is not there; but for those of the command line."""
    failed = []
    names = (module.name for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."))
    for name in names:
        if re.search(r"\.__main__$|^lappet\.(commands|bench|reports|plates|export)\b", name):
            continue
        try:
            importlib.import_module(name)
        except ImportError as error:
            failed.append(f"{name}: {error}")
    return failed


def solve(arrays: Path, result: Path, seen: dict[str, Any]) -> None:
    """One frame of the surface with a hook, through the daemon that the extension brought."""
    import numpy as np

    from lappet.cutting.epoch import Epoch
    from lappet.daemon.client import SolverClient
    from lappet.daemon.process import SolverDaemon, find_daemon
    from lappet.geometry.labeled_surface import Surface
    from lappet.program.program import FrameConstraints
    from lappet.program.settings import SolverSettings

    seen["daemon"] = str(find_daemon())
    given = np.load(arrays)
    surface = Surface(*(given[f"surface{i}"] for i in range(6)))
    hook = FrameConstraints(1.0, 0, **{name: given[name] for name in given.files if name.startswith("hook_")})
    with SolverDaemon() as daemon, SolverClient(daemon=daemon) as client:
        maps = Path(f"/proc/{daemon.pid}/maps").read_text(encoding="utf-8")
        seen["libraries"] = sorted({line.split()[5] for line in maps.splitlines() if ".so" in line})
        client.open(SolverSettings(spacing=1.0, threads=1))
        client.set_epoch(Epoch(0, 1.0, surface, 1))
        frame = client.solve(hook)
        seen["converged"] = bool(frame.converged)
        np.savez(result, **frame.arrays())
    seen["alive after"] = daemon.alive()


if __name__ == "__main__":
    main(*sys.argv[1:])
