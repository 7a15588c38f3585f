"""Open fonts with Chinese characters, where one is installed: the plates' own font has none."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

# Under the SIL Open Font License, in this order; files of several faces have one for simplified Chinese.
_CHINESE = (
    *("NotoSansCJK-Regular.ttc", "NotoSansCJKsc-Regular.otf", "NotoSansSC-Regular.otf", "NotoSansSC-Regular.ttf"),
    *("SourceHanSansSC-Regular.otf", "SourceHanSansCN-Regular.otf", "SourceHanSans-Regular.ttc"),
)


def font_folders() -> list[Path]:
    """List where this machine keeps fonts.

    Returns
    -------
    list[Path]
        The folders, those of the user first; not all of them need to be there.
    """
    home = Path.home()
    if os.name == "nt":
        own = os.environ.get("LOCALAPPDATA", str(home / "AppData" / "Local"))
        return [Path(own) / "Microsoft/Windows/Fonts", Path(os.environ.get("SYSTEMROOT", "C:/Windows")) / "Fonts"]
    data = Path(os.environ.get("XDG_DATA_HOME") or home / ".local/share") / "fonts"
    linux = [data, home / ".fonts", Path("/usr/local/share/fonts"), Path("/usr/share/fonts")]
    return [*linux, home / "Library/Fonts", Path("/Library/Fonts")]


def chinese_font(folders: Iterable[Path] | None = None, names: Sequence[str] = _CHINESE) -> Path | None:
    """Look for an open font with Chinese characters.

    Parameters
    ----------
    folders
        Where to look; None: where this machine keeps fonts.
    names
        Names of font files, the best first.

    Returns
    -------
    Path or None
        The file; None where there is none.
    """
    found: dict[str, Path] = {}
    for folder in font_folders() if folders is None else folders:
        for path in folder.rglob("*.[ot]t[fc]") if folder.is_dir() else ():
            found.setdefault(path.name, path)
    return next((found[name] for name in names if name in found), None)
