"""What a file says, as a message can quote it."""

from __future__ import annotations

from pcsmooth.printable import printable

_LONGEST = 160


def excerpt(text: str) -> str:
    r"""Shorten a text that comes from a file, and spell out what is not printable.

    Parameters
    ----------
    text : str
        A word of a file, or a message that quotes one.

    Returns
    -------
    str
        One line of at most 160 characters.

    Examples
    --------
    >>> excerpt("4\x1b[2J"), len(excerpt("9" * 5000))
    ('4\\x1b[2J', 160)
    """
    line = printable(text[: 2 * _LONGEST])
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST - 4]} ..."
