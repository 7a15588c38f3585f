"""Types of the parameters of commands: ranges and lists of frames, sizes in pixels, files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

FILE = click.Path(path_type=Path)


class Picture(click.Path):
    """A picture to be written, of one of some kinds; another is refused before any work, with all that there are."""

    def __init__(self, *suffixes: str) -> None:
        """Take what is allowed.

        Parameters
        ----------
        *suffixes
            The kinds, such as ".png".
        """
        super().__init__(path_type=Path)
        self.suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the path.

        Parameters
        ----------
        value
            What the user typed.
        param
            The parameter, for messages.
        ctx
            The command's context, for messages.

        Returns
        -------
        Any
            The `Path`.
        """
        path = Path(str(super().convert(value, param, ctx)))
        if path.suffix.lower() not in self.suffixes:
            *first, last = self.suffixes
            known = f"{', '.join(first)} or {last}" if first else last
            self.fail(f"{path.name} is no {known} file; choose a name that ends in {known}.", param, ctx)
        return path


class FrameRange(click.ParamType):
    """A range of integer time codes, both included: `A:B`, `A:`, `:B` or `A`."""

    name = "A:B"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the range.

        Parameters
        ----------
        value
            What the user typed, or the pair itself.
        param
            The parameter, for messages.
        ctx
            The command's context, for messages.

        Returns
        -------
        Any
            The pair (first or None, last or None).
        """
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
    """A list of time codes: `1,20,45`."""

    name = "T,T,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the list.

        Parameters
        ----------
        value
            What the user typed, or the list itself.
        param
            The parameter, for messages.
        ctx
            The command's context, for messages.

        Returns
        -------
        Any
            The time codes as floats.
        """
        if isinstance(value, list):
            return value
        try:
            return [float(each) for each in str(value).split(",")]
        except ValueError:
            self.fail(f"{value!r} is no list of frames; give time codes with commas between them.", param, ctx)


class Simplification(click.ParamType):
    """How far a skin is to be simplified: a number of triangles, or an error in mm: `20000` or `0.2mm`."""

    name = "N|Xmm"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the target.

        Parameters
        ----------
        value
            What the user typed, or the target itself.
        param
            The parameter, for messages.
        ctx
            The command's context, for messages.

        Returns
        -------
        Any
            The `SimplifyTarget`.
        """
        from lappet.core.problem import RefusedError
        from lappet.export.simplify_target import SimplifyTarget

        if isinstance(value, SimplifyTarget):
            return value
        try:
            return SimplifyTarget.of(str(value))
        except RefusedError as error:
            (found,) = error.problems
            self.fail(f"{found.message} {found.remedy}", param, ctx)


class FileSize(click.ParamType):
    """How large a file may be: `5MB`, `800kB`."""

    name = "XMB"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the size.

        Parameters
        ----------
        value
            What the user typed, or the number of bytes itself.
        param
            The parameter, for messages.
        ctx
            The command's context, for messages.

        Returns
        -------
        Any
            The number of bytes.
        """
        from lappet.core.problem import RefusedError
        from lappet.export.size_limit import bytes_of

        if isinstance(value, int):
            return value
        try:
            return bytes_of(str(value))
        except RefusedError as error:
            (found,) = error.problems
            self.fail(f"{found.message} {found.remedy}", param, ctx)


class PlaneNumbers(click.ParamType):
    """A plane: a point in mm and a normal, `X,Y,Z,NX,NY,NZ`."""

    name = "X,Y,Z,NX,NY,NZ"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the plane.

        Parameters
        ----------
        value
            What the user typed, or the numbers themselves.
        param
            The parameter, for messages.
        ctx
            The command's context, for messages.

        Returns
        -------
        Any
            The six numbers as floats.
        """
        if isinstance(value, tuple):
            return value
        try:
            numbers = tuple(float(each) for each in str(value).split(","))
        except ValueError:
            numbers = ()
        if len(numbers) != 6:
            self.fail(f"{value!r} is no plane; give a point in mm and a normal, six numbers with commas.", param, ctx)
        return numbers


class Position(click.ParamType):
    """How the patient lies: the name of a position, or the direction of gravity as three numbers with commas."""

    name = "POSITION"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the position.

        Parameters
        ----------
        value
            What the user typed, or the direction itself.
        param
            The parameter, for messages.
        ctx
            The command's context, for messages.

        Returns
        -------
        Any
            The direction of gravity, three numbers.
        """
        from lappet.procedure.position import POSITIONS

        if isinstance(value, tuple):
            return value
        if str(value) in POSITIONS:
            return POSITIONS[str(value)]
        try:
            x, y, z = (float(each) for each in str(value).split(","))
        except ValueError:
            known = ", ".join(POSITIONS)
            self.fail(f"{value!r} is no position; give one of {known}, or three numbers X,Y,Z.", param, ctx)
        if not (math.isfinite(x + y + z) and math.hypot(x, y, z) > 0.0):
            self.fail(f"{value!r} has no direction; give three finite numbers that are not all zero.", param, ctx)
        return (x, y, z)


class Size(click.ParamType):
    """A size in pixels: `1280x960`."""

    name = "WxH"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the size.

        Parameters
        ----------
        value
            What the user typed, or the pair itself.
        param
            The parameter, for messages.
        ctx
            The command's context, for messages.

        Returns
        -------
        Any
            The pair (width, height).
        """
        if isinstance(value, tuple):
            return value
        width, _, height = str(value).lower().partition("x")
        if not (width.isdecimal() and height.isdecimal()):
            self.fail(f"{value!r} is no size; give WIDTHxHEIGHT in pixels, like 1280x960.", param, ctx)
        return (int(width), int(height))
