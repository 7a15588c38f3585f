"""Types of the parameters of commands: ranges and lists of frames, sizes in pixels, files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

FILE = click.Path(path_type=Path)


class FrameRange(click.ParamType):
    """`A:B`, `A:`, `:B` or `A`: integer time codes, both included."""

    name = "A:B"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The pair (first or None, last or None)."""
        if isinstance(value, tuple):
            return value
        first, colon, last = str(value).partition(":")
        try:
            a = int(first) if first.strip() else None
            b = int(last) if last.strip() else None
        except ValueError:
            self.fail(f"{value!r} is no range of frames; give A:B, two whole time codes.", param, ctx)
        if not colon:
            b = a
        if a is None and b is None:
            self.fail(f"{value!r} names no frame; give A:B, two whole time codes.", param, ctx)
        if a is not None and b is not None and a > b:
            self.fail(f"{value!r} ends before it begins; give the first frame first.", param, ctx)
        return (a, b)


class FrameList(click.ParamType):
    """`1,20,45`: time codes."""

    name = "T,T,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The time codes as a list of floats."""
        if isinstance(value, list):
            return value
        try:
            return [float(each) for each in str(value).split(",")]
        except ValueError:
            self.fail(f"{value!r} is no list of frames; give time codes with commas between them.", param, ctx)


class Size(click.ParamType):
    """`1280x960`: pixels."""

    name = "WxH"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The pair (width, height)."""
        if isinstance(value, tuple):
            return value
        width, _, height = str(value).lower().partition("x")
        if not (width.isdecimal() and height.isdecimal()):
            self.fail(f"{value!r} is no size; give WIDTHxHEIGHT in pixels, like 1280x960.", param, ctx)
        return (int(width), int(height))
