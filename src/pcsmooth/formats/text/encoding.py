"""The bytes of text files: UTF-8, and what is none, kept byte for byte."""

from __future__ import annotations

import re

from pcsmooth.errors import CloudFileError

_KEPT = "surrogateescape"
"""How Python keeps bytes that are no UTF-8: as characters that no text has."""

_NO_UTF8 = re.compile("[\udc80-\udcff]")
_FIRST_MARKS = re.compile("(?:\\A|(?<=[\r\n]))(?:[ \t]*\ufeff)+")
_CONTROLS = re.compile(r"[\x00-\x08\x0e-\x1f]")


def decoded(data: bytes, path: str) -> str:
    """Decode a text file; marks of the byte order that begin a line become a space.

    They stand there in files that were put together; elsewhere they are part of a word.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors.

    Returns
    -------
    str
        The text, which `encoded` turns back into the same bytes; `readable` shows it.

    Raises
    ------
    CloudFileError
        UTF-16, or no text at all.
    """
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise CloudFileError(path, "it is UTF-16 text", "save it as UTF-8")
    text = data.decode(errors=_KEPT)
    if "\ufeff" in text:
        text = _FIRST_MARKS.sub(" ", text)
    if "\0" in text or (_NO_UTF8.search(text) and _CONTROLS.search(text)):
        raise CloudFileError(
            path, "not a point cloud: neither PLY nor text", "convert it to .ply, .xyz or .csv"
        )
    return text


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
