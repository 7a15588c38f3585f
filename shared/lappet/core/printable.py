"""Text of others as a terminal may show it."""

from __future__ import annotations


def printable(text: str) -> str:
    """Replace what is no printable character: a terminal obeys some of the others.

    Parameters
    ----------
    text
        Text from a file, a daemon or a client.

    Returns
    -------
    str
        The text with `?` for each of them; lines stay.
    """
    return "".join(each if each.isprintable() or each == "\n" else "?" for each in text)
