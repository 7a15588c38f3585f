"""Open a model in players that others wrote, in a real browser without a network (`model_players.js`)."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import viewer
from lesson_browser import Opened, opened

_PAGE = """<!doctype html><meta charset="utf-8"><title>Players</title>
<link rel="icon" href="data:,"><body>{scripts}<script src="players.js"></script></body>
"""
_SCRIPTS = {
    "babylon": ("babylonjs/babylon.js", "babylonjs-loaders/babylonjs.loaders.min.js"),
    "model-viewer": ("@google/model-viewer/dist/model-viewer-umd.min.js",),
}


def player_site(folder: Path, player: str, *models: Path) -> Path:
    """A page with a player, and the models beside it."""
    for model in models:
        shutil.copyfile(model, folder / model.name)
    names = _SCRIPTS.get(player, ())
    for name in (*names, "meshoptimizer/meshopt_decoder.cjs"):
        shutil.copyfile(viewer.MODULES / name, folder / Path(name).name)
    scripts = "".join(f'<script src="{Path(name).name}"></script>' for name in names)
    (folder / "index.html").write_text(_PAGE.format(scripts=scripts), encoding="utf-8")
    node, _ = viewer.node()
    source, bundle = Path(__file__).with_suffix(".js"), folder / "players.js"
    build = [node, viewer.MODULES / "esbuild" / "bin" / "esbuild", source, "--bundle", f"--outfile={bundle}"]
    paths = f"--alias:three={viewer.MODULES / 'three'}"
    subprocess.run([*build, "--log-level=error", paths], check=True, cwd=viewer.VIEWER)
    return folder


def played(site: Path, player: str, model: Path, poses: Sequence[tuple[str, float]], *more: tuple[str, Any]) -> Opened:
    """What a player says of a model: its animations, then what it shows in each pose, then the results of `more`."""
    actions = [("evaluate", f"players.open({player!r}, '/{model.name}')")]
    actions += [("evaluate", f"players.pose({name!r}, {seconds!r})") for name, seconds in poses]
    return opened(site, *actions, *more)


def places(shown: Sequence[dict[str, Any]]) -> np.ndarray:
    """The vertices of what a player shows of a thing, in metres with Y up, as millimetres with Z up."""
    points = np.concatenate([np.reshape(each["points"], (-1, 3)) for each in shown]) * 1000.0
    return np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)
