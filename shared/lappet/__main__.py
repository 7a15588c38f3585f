"""`python -m lappet` is the command `lappet`."""

from lappet.cli import main

main()
