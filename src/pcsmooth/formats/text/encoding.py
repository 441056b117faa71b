"""The bytes of text files: UTF-8, and what is none, kept byte for byte."""

from __future__ import annotations

import re

_KEPT = "surrogateescape"
"""How Python keeps bytes that are no UTF-8: as characters that no text has."""

_NO_UTF8 = re.compile("[\udc80-\udcff]")
_FIRST_MARKS = re.compile("(?:\\A|(?<=[\r\n]))(?:[ \t]*\ufeff)+")
_CONTROLS = re.compile(r"[\x00-\x08\x0e-\x1f]")


def decoded(data: bytes) -> str:
    """Decode lines; marks of the byte order that begin one become a space.

    They stand there in files that were put together; elsewhere they are part of a word.

    Parameters
    ----------
    data : bytes
        Whole lines of a file.

    Returns
    -------
    str
        The text, which `encoded` turns back into the same bytes; `readable` shows it.
    """
    text = data.decode(errors=_KEPT)
    return _FIRST_MARKS.sub(" ", text) if "\ufeff" in text else text


def is_utf8(text: str) -> bool:
    """Whether what was decoded was all UTF-8."""
    return text.isascii() or _NO_UTF8.search(text) is None


def has_controls(text: str) -> bool:
    """Whether there are characters that no text has, but binary data."""
    return _CONTROLS.search(text) is not None


def encoded(text: str) -> bytes:
    """Encode text as UTF-8, but for the bytes that were none when it was `decoded`."""
    return text.encode(errors=_KEPT)


def readable(text: str) -> str:
    r"""Read the bytes of a decoded text that are no UTF-8 as those of Windows and Latin-1.

    Examples
    --------
    >>> readable(b"H\xf6he in \x80".decode(errors="surrogateescape"))
    'Höhe in €'
    """
    return text if text.isascii() else _NO_UTF8.sub(_as_windows, text)


def _as_windows(found: re.Match[str]) -> str:
    code = ord(found[0]) - 0xDC00
    try:
        return bytes([code]).decode("cp1252")
    except UnicodeDecodeError:
        return chr(code)
