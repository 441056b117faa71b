"""The header of a PLY file, parsed and composed by plyfile."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass

from plyfile import PlyData, PlyElement, PlyListProperty, PlyParseError

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt

_FIRST_LINE = re.compile(rb"ply[ \t]*(\r\n|\n|\r)")


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
        return f"{header}\n".encode("ascii")


def is_ply(head: bytes) -> bool:
    """Whether a file that begins with these bytes calls itself PLY."""
    return _FIRST_LINE.match(head) is not None


def parse_header(data: bytes, path: str) -> tuple[PlyHeader, int]:
    """Parse the header of a PLY file without touching, or allocating, its rows.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors.

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
    if not data:
        raise CloudFileError(path, "the file is empty", "export it again")
    first = _FIRST_LINE.match(data)
    if first is None:
        raise CloudFileError(
            path, "not a PLY file: its first line is not 'ply'", "check the file or its suffix"
        )
    end = re.search(rb"[\r\n]end_header[ \t]*(%b|\Z)" % first[1], data)
    if end is None:
        raise CloudFileError(
            path, "the PLY header has no 'end_header' line", "the file is cut short; get it again"
        )

    # plyfile reads a header alone when the header promises no rows.
    lines, counts = [], []
    for line in _decoded(data[: end.end()]).split(first[1].decode()):
        words = line.split()
        if words[:1] == ["element"] and len(words) == 3:
            counts.append(words[2])
            words[2] = "0"
            line = " ".join(words)
        # To plyfile a lone line feed would end the line, and what follows would count.
        lines.append(line.rstrip().replace("\n", " ") + "\n")
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
            f"the PLY header is damaged ({excerpt(str(error))})",
            "correct the header or export again",
        ) from error
    header = PlyHeader(
        text=ply.text,
        byte_order=ply.byte_order,
        elements=elements,
        comments=tuple(ascii_lines(ply.comments)),
        obj_info=tuple(ascii_lines(ply.obj_info)),
    )
    return header, end.end()


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
        text = header.decode("utf-8")
    except UnicodeDecodeError:
        text = header.decode("latin-1")
    return _ascii(text)


def _ascii(text: str) -> str:
    ascii_text = text.encode("ascii", "backslashreplace").decode("ascii")
    return re.sub(r"[^\t\r\n -~]", lambda found: f"\\x{ord(found[0]):02x}", ascii_text)


def _count(text: str) -> int:
    count = int(text)
    if not 0 <= count < 2**63:
        raise ValueError(f"an element has {text} rows")
    return count


def _check_lengths(element: PlyElement) -> None:
    for prop in element.properties:
        if isinstance(prop, PlyListProperty) and prop.len_dtype[0] == "f":
            raise ValueError(f"the length of the lists '{prop.name}' is no whole number")
