"""`lappet completion`: the script that has a shell complete commands, options and their values."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

VARIABLE = "_LAPPET_COMPLETE"
QUOTED_SPACE = "\\\\ "  # twice: the script of click reads away one
SHELLS = ("bash", "zsh", "fish", "powershell")
_POWERSHELL = """\
Register-ArgumentCompleter -Native -CommandName %(prog_name)s -ScriptBlock {
    param($word, $line, $cursor)
    $env:COMP_LINE = $line.ToString()
    $env:COMP_WORD = $word
    $env:%(complete_var)s = "powershell_complete"
    try {
        %(prog_name)s | ForEach-Object {
            $value, $help = $_ -split "`t", 2
            if (-not $help) { $help = $value }
            [System.Management.Automation.CompletionResult]::new($value, $value, "ParameterValue", $help)
        }
    } finally {
        Remove-Item Env:COMP_LINE, Env:COMP_WORD, Env:%(complete_var)s -ErrorAction SilentlyContinue
    }
}
"""
_HOW = {
    "bash": 'In ~/.bashrc:  eval "$(lappet completion bash)"',
    "zsh": 'In ~/.zshrc:  eval "$(lappet completion zsh)"',
    "fish": "lappet completion fish > ~/.config/fish/completions/lappet.fish",
    "powershell": "In $PROFILE:  lappet completion powershell | Out-String | Invoke-Expression",
}


def add_shells() -> None:
    """Have click answer PowerShell too, which it does not know, and quote what has a space in it for bash."""
    from click.shell_completion import BashComplete, ShellComplete, add_completion_class, split_arg_string

    class Bash(BashComplete):
        def format_completion(self, item: CompletionItem) -> str:
            return f"{item.type},{str(item.value).replace(' ', QUOTED_SPACE)}"

    class PowerShell(ShellComplete):
        name = "powershell"
        source_template = _POWERSHELL

        def get_completion_args(self) -> tuple[list[str], str]:
            words = split_arg_string(os.environ["COMP_LINE"])
            word = os.environ["COMP_WORD"]
            return words[1:-1] if word and len(words) > 1 else words[1:], word

        def format_completion(self, item: CompletionItem) -> str:
            help_text = (item.help or "").replace("\n", " ")
            value = f"'{item.value}'" if " " in str(item.value) else str(item.value)
            return f"{value}\t{help_text}" if help_text else value

    add_completion_class(Bash)
    add_completion_class(PowerShell)


@click.command(epilog="  ".join(("\b\n", *(f"{line}\n" for line in _HOW.values()))))
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def completion(context: click.Context, /, shell: str) -> None:
    """Print the script with which a SHELL completes commands, options and their values."""
    from click.shell_completion import get_completion_class

    add_shells()
    kind = get_completion_class(shell)
    assert kind is not None
    click.echo(kind(context.find_root().command, {}, "lappet", VARIABLE).source())
