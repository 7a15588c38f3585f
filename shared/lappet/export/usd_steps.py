"""What moves of an exported USD file in files of its own, one for each step of the operation, as value clips.

The file itself then holds what lasts, and a reader fetches a step's file when it first shows a frame of it. A step that
is too large for one file has several. They are written one after the other, so that no more than one is in memory.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import SkinEpoch
from lappet.output.preview_materials import SKIN_ROOT, shade_indices
from lappet.usd.stage import pxr, save_layer

_SHADES = "primvars:strainColor:indices"
_LASTING = ("extent", _SHADES)  # the extent is wanted before any frame is shown; shades are found from the strain
_MANIFEST = "moving.usda"
_MOST_BYTES = 2e8  # about, of a file


@dataclass(frozen=True)
class StepFiles:
    """Where the files of the steps are, and which frames each of them holds.

    Parameters
    ----------
    folder
        Their folder, beside the file.
    names
        Name of each file.
    spans
        Time codes of the cache's frames that each file holds, ascending, none of them empty.
    """

    folder: Path
    names: tuple[str, ...]
    spans: tuple[tuple[float, ...], ...]

    @staticmethod
    def of(target: Path, frames: Sequence[float], ends: Sequence[float], frame_bytes: float) -> StepFiles:
        """Divide frames into steps.

        Parameters
        ----------
        target
            The file that is exported.
        frames
            Time codes of all frames, ascending.
        ends
            Time codes at which the steps are done; the last step also has the frames behind it.
        frame_bytes
            What a frame takes, about.

        Returns
        -------
        StepFiles
            The files.
        """
        steps, begin = [], 0
        for end in ends[:-1]:
            own = sum(time <= end for time in frames)
            if own > begin:
                steps.append(frames[begin:own])
                begin = own
        if begin < len(frames):
            steps.append(frames[begin:])
        most = max(1, int(_MOST_BYTES / frame_bytes))
        names, spans = [], []
        for number, span in enumerate(steps, start=1):
            parts = [tuple(span[k : k + most]) for k in range(0, len(span), most)]
            spans += parts
            ways = [f"_{k}" for k in range(1, len(parts) + 1)] if len(parts) > 1 else [""]
            names += [f"step_{number:02d}{way}.usdc" for way in ways]
        return StepFiles(target.with_name(f"{target.stem}_steps"), tuple(names), tuple(spans))

    @property
    def lasting(self) -> Path:
        """The file of what lasts."""
        return self.folder / "lasting.usdc"

    @property
    def files(self) -> list[Path]:
        """All that lies in the folder: the files, what says which values they hold, and what lasts."""
        return [self.lasting, *(self.folder / name for name in (_MANIFEST, *self.names))]


def lasting(cache: SkinCache) -> Any:
    """Copy a cache's own layer without the values that move.

    Parameters
    ----------
    cache
        The cache.

    Returns
    -------
    Sdf.Layer
        The copy, in memory, above the layers that the cache's is above.
    """
    usd = pxr()
    source = cache.stage.GetRootLayer()
    layer = usd.Sdf.Layer.CreateAnonymous(".usda")
    moving = {each.GetPath() for epoch in cache.epochs for each in _moving(cache, epoch)}
    moving |= {usd.Sdf.Path(f"{SKIN_ROOT}/{epoch.name}.{_SHADES}") for epoch in cache.epochs}

    def wanted(_kind: Any, field: str, _from: Any, path: Any, *_more: Any) -> bool:
        return field != "timeSamples" or path.StripAllVariantSelections() not in moving

    _copy_metadata(source, layer)  # rates among it: USD moves samples by them
    usd.Sdf.CopySpec(source, "/Procedure", layer, "/Procedure", wanted, lambda *_: True)
    layer.subLayerPaths = [source.ComputeAbsolutePath(path) for path in source.subLayerPaths]
    return layer


def write_steps(cache: SkinCache, steps: StepFiles, times: float, strain_full: float | None) -> None:
    """Write the files of the steps, in place of those that were there.

    Parameters
    ----------
    cache
        The cache.
    steps
        The files.
    times
        Time codes of the export in one of the cache.
    strain_full
        Strain at the top of its colors; None where the export has none.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    usd = pxr()
    shutil.rmtree(steps.folder, ignore_errors=True)
    steps.folder.mkdir()
    shades = usd.Sdf.ValueTypeNames.IntArray
    manifest = usd.Sdf.Layer.CreateAnonymous(".usda")
    for span, name in zip(steps.spans, steps.names, strict=True):
        layer = usd.Sdf.Layer.CreateAnonymous(".usda")
        for epoch in cache.epochs:
            own = [time for time in epoch.frames if time in span]
            for each in _moving(cache, epoch) if own else ():
                path = _declared(each.GetPath(), each.GetTypeName(), layer, manifest)
                for time in own:
                    layer.SetTimeSample(path, time * times, each.Get(time))
            if own and strain_full is not None:
                path = _declared(usd.Sdf.Path(f"{SKIN_ROOT}/{epoch.name}.{_SHADES}"), shades, layer, manifest)
                for time in own:
                    values = cache.scalar(epoch, "strain", time)
                    if values is not None:
                        layer.SetTimeSample(path, time * times, shade_indices(values, strain_full))
        save_layer(layer, steps.folder / name)
    save_layer(manifest, steps.folder / _MANIFEST)


def refer_to_steps(lasts: Any, cache: SkinCache, steps: StepFiles, times: float) -> Any:
    """Make the layer through which the files are one stage.

    Parameters
    ----------
    lasts
        The layer of what lasts, which is below it: there its values are weaker than those of the clips.
    cache
        The cache.
    steps
        The files.
    times
        Time codes of the export in one of the cache.

    Returns
    -------
    Sdf.Layer
        The layer, in memory.
    """
    usd = pxr()
    layer = usd.Sdf.Layer.CreateAnonymous(".usda")
    _copy_metadata(lasts, layer)
    beside = f"./{steps.folder.name}"
    stage = usd.Usd.Stage.Open(layer)
    for epoch in cache.epochs:
        held = list(zip(steps.spans, steps.names, strict=True))
        shown = [(span, name) for span, name in held if set(span) & set(epoch.frames)]
        prim = stage.OverridePrim(f"{SKIN_ROOT}/{epoch.name}")
        clips = usd.Usd.ClipsAPI(prim)
        clips.SetClipAssetPaths([usd.Sdf.AssetPath(f"{beside}/{name}") for _, name in shown])
        clips.SetClipManifestAssetPath(usd.Sdf.AssetPath(f"{beside}/{_MANIFEST}"))
        clips.SetClipPrimPath(str(prim.GetPath()))
        firsts = [next(time for time in span if time in epoch.frames) for span, _ in shown]
        clips.SetClipActive([(time * times, float(k)) for k, time in enumerate(firsts)])
        ends = (epoch.frames[0] * times, epoch.frames[-1] * times)
        clips.SetClipTimes([(time, time) for time in dict.fromkeys(ends)])
    del stage, clips, prim  # the path means nothing to a layer in memory
    layer.subLayerPaths = [f"{beside}/{steps.lasting.name}"]
    return layer


def _copy_metadata(source: Any, layer: Any) -> None:
    """Give a layer the metadata of another's stage."""
    for field in source.pseudoRoot.ListInfoKeys():
        if not field.startswith("subLayer"):
            layer.pseudoRoot.SetInfo(field, source.pseudoRoot.GetInfo(field))


def _moving(cache: SkinCache, epoch: SkinEpoch) -> list[Any]:
    """The arrays of an epoch's mesh that move."""
    attributes = cache.stage.GetPrimAtPath(f"{SKIN_ROOT}/{epoch.name}").GetAttributes()
    arrays = [each for each in attributes if each.GetTypeName().isArray and each.GetName() not in _LASTING]
    return [each for each in arrays if each.GetNumTimeSamples()]


def _declared(path: Any, kind: Any, *layers: Any) -> Any:
    """The path of an attribute that layers have, on a prim that is only there for it."""
    usd = pxr()
    for layer in layers:
        if not layer.GetAttributeAtPath(path):
            usd.Sdf.AttributeSpec(usd.Sdf.CreatePrimInLayer(layer, path.GetPrimPath()), path.name, kind)
    return path
