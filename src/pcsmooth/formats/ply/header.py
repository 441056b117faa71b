"""The header of a PLY file, parsed and composed by plyfile."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass

from plyfile import (
    PlyData,
    PlyElement,
    PlyHeaderParseError,
    PlyListProperty,
    PlyParseError,
    PlyProperty,
)

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.excerpt import excerpt

_FIRST_LINE = re.compile(rb"(?:\xef\xbb\xbf)?ply[ \t]*(\r\n|\n|\r)")

#: A property and its name, which to plyfile may have no blanks.
_PROPERTY = re.compile(r"\s*(property\s+(?:list\s+\S+\s+\S+|(?!list\s)\S+))\s+(\S.*)")
_IS_BLANK = re.compile(r"\s")
_BLANK = "\x7f"
"""What stands for a blank in the names of properties; no header that was read has it."""

_FIRST_LOOK = 1 << 16
_LONGEST = 1 << 26
"""Bytes in which the end of a header is looked for."""


@dataclass(frozen=True)
class PlyHeader:
    """What stands before the rows of a PLY file.

    Attributes
    ----------
    text : bool
        Rows are ASCII text rather than binary.
    byte_order : {'<', '>', '='}
        Byte order of binary rows; '=' for text.
    elements : tuple of plyfile.PlyElement
        Name, count, properties and comments of each element; no data.
    comments, obj_info : tuple of str
        Lines of the header, without their keyword.
    """

    text: bool
    byte_order: str
    elements: tuple[PlyElement, ...]
    comments: tuple[str, ...] = ()
    obj_info: tuple[str, ...] = ()

    def __bytes__(self) -> bytes:
        """Compose the header as it stands in a file."""
        header = PlyData(
            self.elements,
            text=self.text,
            byte_order=self.byte_order,
            comments=ascii_lines(self.comments),
            obj_info=ascii_lines(self.obj_info),
        ).header
        return f"{header}\n".replace(_BLANK, " ").encode("ascii")


def is_ply(head: bytes) -> bool:
    """Whether a file that begins with these bytes calls itself PLY."""
    return _FIRST_LINE.match(head) is not None


def read_header(source: ByteSource) -> tuple[PlyHeader, int]:
    """Read the header of a PLY file without touching, or allocating, its rows.

    Parameters
    ----------
    source : ByteSource
        The file.

    Returns
    -------
    header : PlyHeader
        The parsed header.
    size : int
        Bytes up to the first row.

    Raises
    ------
    CloudFileError
        Empty, not PLY, or a header that is cut short, malformed or contradicts itself.
    """
    size = _FIRST_LOOK
    while True:
        data = source.read(0, min(size, source.size))
        first = _FIRST_LINE.match(data)
        end = None if first is None else _end_of_header(data, first[1])
        # The end of a part of the file is no end of a line.
        if (
            first is None
            or (end is not None and end < len(data))
            or len(data) == source.size
            or size >= _LONGEST
        ):
            return _parsed(data, first, end, source.path)
        size *= 2


def _end_of_header(data: bytes, newline: bytes) -> int | None:
    end = re.search(rb"[\r\n]end_header[ \t]*(%b|\Z)" % newline, data)
    return None if end is None else end.end()


def _parsed(
    data: bytes, first: re.Match[bytes] | None, end: int | None, path: str
) -> tuple[PlyHeader, int]:
    if not data:
        raise CloudFileError(path, "the file is empty", "export it again")
    if first is None:
        raise CloudFileError(
            path, "not a PLY file: its first line is not 'ply'", "check the file or its suffix"
        )
    if end is None:
        raise CloudFileError(
            path, "the PLY header has no 'end_header' line", "the file is cut short; get it again"
        )

    # plyfile reads a header alone when the header promises no rows.
    lines, counts = [], []
    for line in _decoded(data[:end]).split(first[1].decode()):
        words = line.split()
        if words[:1] == ["element"] and len(words) == 3:
            counts.append(words[2])
            words[2] = "0"
            line = " ".join(words)
        # To plyfile a lone line feed would end the line, and what follows would count.
        line = line.rstrip().replace("\n", " ")
        if not line:
            continue
        if found := _PROPERTY.fullmatch(line):
            line = f"{found[1]} {_IS_BLANK.sub(_BLANK, found[2])}"
        lines.append(line + "\n")
    try:
        ply = PlyData.read(io.BytesIO("".join(lines).encode("ascii")), mmap=False)
        elements = tuple(
            PlyElement(
                element.name, element.properties, _count(text), ascii_lines(element.comments)
            )
            for element, text in zip(ply.elements, counts, strict=True)
        )
        for element in elements:
            _check_lengths(element)
    except (PlyParseError, ValueError) as error:
        raise CloudFileError(
            path,
            f"the PLY header is damaged ({excerpt(_with_line(error, lines))})",
            "correct the header or export again",
        ) from error
    header = PlyHeader(
        text=ply.text,
        byte_order=ply.byte_order,
        elements=elements,
        comments=tuple(ascii_lines(ply.comments)),
        obj_info=tuple(ascii_lines(ply.obj_info)),
    )
    return header, end


def name_in_header(prop: PlyProperty) -> str:
    """Name of a property as it stands in the header, with its blanks."""
    name: str = prop.name
    return name.replace(_BLANK, " ")


def ascii_lines(comments: Sequence[str]) -> list[str]:
    r"""Comments as PLY can hold them: one line each, other characters as ``\x`` escapes."""
    return [
        _ascii(line).rstrip() for comment in comments for line in re.split(r"\r\n|\r|\n", comment)
    ]


def has_lists(element: PlyElement) -> bool:
    """Whether a row of the element may vary in length."""
    return any(isinstance(prop, PlyListProperty) for prop in element.properties)


def _decoded(header: bytes) -> str:
    try:
        text = header.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = header.decode("latin-1")
    return _ascii(text)


def _ascii(text: str) -> str:
    ascii_text = text.encode("ascii", "backslashreplace").decode("ascii")
    return re.sub(r"[^\t\r\n -~]", lambda found: f"\\x{ord(found[0]):02x}", ascii_text)


def _count(text: str) -> int:
    if not (text.isdecimal() and int(text) < 2**63):
        raise ValueError(f"an element has {text} rows")
    return int(text)


def _with_line(error: Exception, lines: Sequence[str]) -> str:
    """Say what is wrong, and show the line that plyfile counts, blank ones left out."""
    if not isinstance(error, PlyHeaderParseError) or error.line > len(lines):
        return str(error)
    line = lines[error.line - 1].strip().replace(_BLANK, " ")
    return f"'{line}', {error.message}"


def _check_lengths(element: PlyElement) -> None:
    for prop in element.properties:
        if isinstance(prop, PlyListProperty) and prop.len_dtype[0] == "f":
            raise ValueError(f"the length of the lists '{prop.name}' is no whole number")
