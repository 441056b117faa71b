"""Names, words and numbers, fit for a terminal."""

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


def counted(count: int, noun: str) -> str:
    """Say how many there are of what a noun names, in the singular or the plural.

    Examples
    --------
    >>> counted(1, "point"), counted(2, "point")
    ('1 point', '2 points')
    """
    return f"{count} {noun}{'s' * (count != 1)}"


def shortened(name: str, most: int) -> str:
    """Take letters out of the middle of a name that has too many.

    Examples
    --------
    >>> shortened("folder/of/scans.ply", 13)
    'folde...s.ply'
    """
    if len(name) <= most:
        return name
    end = (most - 3) // 2
    return f"{name[: most - 3 - end]}...{name[len(name) - end :]}"
