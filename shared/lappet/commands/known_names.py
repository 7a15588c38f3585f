"""Names that commands know: `--help` lists them, and a shell completes them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem


class KnownName(click.ParamType):
    """A name of a list that is loaded only where it is needed; the command itself refuses one that is not in it.

    Parameters
    ----------
    names
        Gives the list.
    """

    name = "name"

    def __init__(self, names: Callable[[], Iterable[str]]) -> None:
        self.names = names

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Take the name as it is.

        Parameters
        ----------
        value
            What the user typed.
        param
            The parameter.
        ctx
            The command's context.

        Returns
        -------
        Any
            The name.
        """
        return str(value)

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Complete a name that is being typed.

        Parameters
        ----------
        ctx
            The command's context.
        param
            The parameter.
        incomplete
            Its beginning.

        Returns
        -------
        list[CompletionItem]
            The names that begin so.
        """
        from click.shell_completion import CompletionItem

        return [CompletionItem(each) for each in self.names() if each.startswith(incomplete)]


class NamingCommand(click.Command):
    """A command whose help ends with the names that its arguments may have."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the names.

        Parameters
        ----------
        ctx
            The command's context.
        formatter
            Takes the text.
        """
        for each in self.params:
            if isinstance(each.type, KnownName):
                formatter.write_paragraph()
                formatter.write_text(f"{str(each.name).upper()}: {', '.join(each.type.names())}.")
        super().format_epilog(ctx, formatter)


def _designs() -> Iterable[str]:
    from lappet.designs.library import DESIGNS

    return DESIGNS


def _models() -> Iterable[str]:
    from lappet.models.new_model import MODELS, WHOLE_BODIES

    return (*MODELS, *WHOLE_BODIES)


def _operations() -> Iterable[str]:
    from lappet.models.regional_flaps import REGIONAL_FLAPS

    return REGIONAL_FLAPS


def _rows() -> Iterable[str]:
    from lappet.reports.literature.rows import ROWS

    return [row.name for row in ROWS]


DESIGN, MODEL, OPERATION, ROW = (KnownName(each) for each in (_designs, _models, _operations, _rows))
