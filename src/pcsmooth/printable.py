"""Names and words of files, fit for a terminal."""

from __future__ import annotations


def printable(text: str) -> str:
    r"""Spell out what is not a visible character or a space.

    Parameters
    ----------
    text : str
        A name or a message that may hold anything.

    Returns
    -------
    str
        One line, without control characters and without bytes that are no UTF-8.

    Examples
    --------
    >>> printable("two\nlines"), printable("\x1b[2J"), printable("née")
    ('two\\nlines', '\\x1b[2J', 'née')
    """
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)
