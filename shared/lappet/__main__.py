"""`python -m lappet` is the command `lappet`."""

from lappet.commands.cli import main

main()
