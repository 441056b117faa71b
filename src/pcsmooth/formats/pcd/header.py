"""The header of a PCD file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import is_whole
from pcsmooth.formats.text.encoding import encoded

Encoding = Literal["ascii", "binary", "binary_compressed"]

PADDING = "_"
"""Name of the fields that hold nothing."""

_TITLE = "# .PCD v0.7 - Point Cloud Data file format"
_IS_TITLE = re.compile(r"#\s*\.PCD\b")
_VERSION = "0.7"
_VERSIONS = (".5", "0.5", ".6", "0.6", ".7", "0.7")
_ORIGIN = "0 0 0 1 0 0 0"
#: A point of more items than this is no point.
_MOST_ITEMS = 50_000

_ENCODINGS = ("ascii", "binary", "binary_compressed")
_CODES = {"I": "i", "U": "u", "F": "f"}
_SIZES = {"I": (1, 2, 4, 8), "U": (1, 2, 4, 8), "F": (4, 8)}

_FIRST_LOOK = 1 << 16
"""Bytes in which the end of a header is looked for at first."""

_FIRST_LINES = re.compile(rb"(\s*#[^\n]*\n)*\s*(#\s*\.PCD\b|VERSION[ \t]+0?\.\d)")
_DATA_LINE = re.compile(rb"^[ \t]*DATA[ \t]+(\S+)[ \t]*\r?(\n|\Z)", re.MULTILINE)


@dataclass(frozen=True)
class PcdField:
    """One field of a point.

    Attributes
    ----------
    name : str
        Its name.
    dtype : numpy.dtype
        Type of an item, little-endian.
    count : int
        Number of items.
    """

    name: str
    dtype: np.dtype[np.generic]
    count: int = 1

    @property
    def size(self) -> int:
        """Bytes in a point."""
        return self.dtype.itemsize * self.count


@dataclass(frozen=True)
class PcdHeader:
    """What stands before the points of a PCD file.

    Attributes
    ----------
    fields : tuple of PcdField
        The fields of a point, in order.
    width, height : int
        Points in a row of an organised cloud, and rows; other clouds have a height of 1.
    viewpoint : str
        Translation and quaternion of the sensor, as spelled in the file.
    encoding : {"ascii", "binary", "binary_compressed"}
        How the points are written.
    comments : tuple of str
        Lines of the header that begin with ``#``, without it; the first of every file apart.
    empty : tuple of str
        Names of fields without items, which are left out.
    """

    fields: tuple[PcdField, ...]
    width: int
    height: int = 1
    viewpoint: str = _ORIGIN
    encoding: Encoding = "binary"
    comments: tuple[str, ...] = ()
    empty: tuple[str, ...] = ()

    @property
    def n_points(self) -> int:
        """Number of points."""
        return self.width * self.height

    @property
    def point_size(self) -> int:
        """Bytes of a point."""
        return sum(field.size for field in self.fields)

    @property
    def is_plain(self) -> bool:
        """Whether the points are in no order of rows and seen from the origin."""
        return self.height == 1 and list(map(float, self.viewpoint.split())) == list(
            map(float, _ORIGIN.split())
        )

    def __bytes__(self) -> bytes:
        """Compose the header as it stands in a file."""
        lines = [_TITLE]
        lines += [f"# {line}" for text in self.comments for line in text.splitlines() or [""]]
        lines += [
            f"VERSION {_VERSION}",
            "FIELDS " + " ".join(field.name for field in self.fields),
            "SIZE " + " ".join(str(field.dtype.itemsize) for field in self.fields),
            "TYPE " + " ".join(field.dtype.kind.upper() for field in self.fields),
            "COUNT " + " ".join(str(field.count) for field in self.fields),
            f"WIDTH {self.width}",
            f"HEIGHT {self.height}",
            f"VIEWPOINT {self.viewpoint}",
            f"POINTS {self.n_points}",
            f"DATA {self.encoding}",
        ]
        return encoded("".join(f"{line}\n" for line in lines))


def is_pcd(head: bytes) -> bool:
    """Whether a file that begins with these bytes is PCD."""
    return _FIRST_LINES.match(head) is not None


def read_header(source: ByteSource) -> tuple[PcdHeader, int]:
    """Read the header of a PCD file without touching, or allocating, its points.

    Parameters
    ----------
    source : ByteSource
        The file.

    Returns
    -------
    header : PcdHeader
        The parsed header.
    size : int
        Bytes up to the first point.

    Raises
    ------
    CloudFileError
        Not PCD, of a version or with fields that are not known, or a header that is cut short,
        incomplete or contradicts itself.
    """
    path, size = source.path, _FIRST_LOOK
    data = source.read(0, min(size, source.size))
    # The end of a part of the file is no end of a line.
    while ((end := _DATA_LINE.search(data)) is None or end.end() == len(data)) and (
        len(data) < source.size
    ):
        size *= 2
        data = source.read(0, min(size, source.size))
    if not is_pcd(data):
        raise CloudFileError(
            path, "not a PCD file: it has no line VERSION", "check the file or its suffix"
        )
    if end is None:
        raise CloudFileError(
            path, "the PCD header has no DATA line", "the file is cut short; get it again"
        )
    entries: dict[str, list[str]] = {}
    comments = []
    for line in data[: end.start()].decode("utf-8", "surrogateescape").splitlines():
        if line.lstrip().startswith("#"):
            if not _IS_TITLE.match(line.lstrip()):
                comments.append(line.lstrip().removeprefix("#").strip())
        elif line.split():
            entries[line.split()[0]] = line.split()[1:]
    encoding = end[1].decode("ascii", "backslashreplace").lower()
    try:
        header = _header(entries, encoding, tuple(comments))
    except ValueError as error:
        raise CloudFileError(
            path,
            f"the PCD header is damaged ({excerpt(str(error))})",
            "correct the header or export again",
        ) from error
    return header, end.end()


def _header(entries: dict[str, list[str]], encoding: str, comments: tuple[str, ...]) -> PcdHeader:
    """Read the entries; a ValueError says what is wrong."""
    version = entries.get("VERSION", [_VERSION])
    if len(version) != 1 or version[0] not in _VERSIONS:
        raise ValueError(f"version {' '.join(version)} is not known")
    if encoding not in _ENCODINGS:
        raise ValueError(f"DATA {encoding} is not known")
    for name in ("FIELDS", "SIZE", "TYPE", "WIDTH"):
        if not entries.get(name):
            raise ValueError(f"there is no {name}")
    width = _whole("WIDTH", entries["WIDTH"])
    height = _whole("HEIGHT", entries.get("HEIGHT", ["1"]))
    n_points = _whole("POINTS", entries.get("POINTS", [str(width * height)]))
    if width * height != n_points:
        raise ValueError(f"WIDTH {width} times HEIGHT {height} is not POINTS {n_points}")
    viewpoint = entries.get("VIEWPOINT", _ORIGIN.split())
    if len(viewpoint) != 7 or not all(map(np.isfinite, map(float, viewpoint))):
        raise ValueError("VIEWPOINT is not 7 numbers")
    fields = _fields(entries)
    return PcdHeader(
        fields=tuple(field for field in fields if field.count),
        empty=tuple(field.name for field in fields if not field.count),
        width=width,
        height=height,
        viewpoint=" ".join(viewpoint),
        encoding=cast(Encoding, encoding),
        comments=comments,
    )


def _fields(entries: dict[str, list[str]]) -> tuple[PcdField, ...]:
    """Read what is said of all fields, those of no item too."""
    names = entries["FIELDS"]
    counts = entries.get("COUNT", ["1"] * len(names))
    for entry, values in (("SIZE", entries["SIZE"]), ("TYPE", entries["TYPE"]), ("COUNT", counts)):
        if len(values) != len(names):
            raise ValueError(f"{len(names)} FIELDS have {len(values)} entries of {entry}")
    fields, left = [], _MOST_ITEMS
    for name, size, letter, count in zip(
        names, entries["SIZE"], entries["TYPE"], counts, strict=True
    ):
        n_bytes, n_items = _whole("SIZE", [size]), _whole("COUNT", [count])
        if n_bytes not in _SIZES.get(letter, ()):
            raise ValueError(f"field '{name}' has TYPE {letter} of SIZE {size}")
        left -= n_items
        if left < 0:
            raise ValueError(f"a point has more than {_MOST_ITEMS} items")
        fields.append(PcdField(name, np.dtype(f"<{_CODES[letter]}{n_bytes}"), n_items))
    return tuple(fields)


def _whole(entry: str, words: list[str]) -> int:
    if len(words) != 1 or not is_whole(words[0]):
        raise ValueError(f"{entry} {' '.join(words)} is not a number")
    return int(words[0])
