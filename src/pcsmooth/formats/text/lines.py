"""The lines of a text file, any number of times: kept in memory, or read again each time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.text.encoding import decoded, has_controls, is_utf8


class TextLines(Iterable[str]):
    """All lines of a file, without their ends; the last one may be empty.

    Parameters
    ----------
    source : ByteSource
        The file. Lines of one that is in memory are kept, others are read from it every time.

    Raises
    ------
    CloudFileError
        UTF-16, or no text at all.
    """

    def __init__(self, source: ByteSource) -> None:
        self._source = source
        if source.read(0, min(2, source.size)) in (b"\xff\xfe", b"\xfe\xff"):
            raise CloudFileError(source.path, "it is UTF-16 text", "save it as UTF-8")
        self._kept: list[str] | None = None
        self._count = 0
        kept: list[str] = []
        self._is_utf8 = True
        for lines in self._blocks():
            self._count += len(lines)
            if source.in_memory:
                kept += lines
        if not self._is_utf8 and any(map(has_controls, self._texts())):
            raise _no_text(source.path)
        if source.in_memory:
            self._kept = kept

    def __iter__(self) -> Iterator[str]:
        """Give the lines from the first on."""
        return chain.from_iterable(self._blocks()) if self._kept is None else iter(self._kept)

    def __len__(self) -> int:
        """Return the number of lines."""
        return self._count

    def chosen(self, make: Callable[[], Iterator[str]]) -> Iterable[str]:
        """Keep what is made of the lines if they are kept; else make it again each time."""
        return _MadeAgain(make) if self._kept is None else list(make())

    def _blocks(self) -> Iterator[list[str]]:
        """Give the lines, some at a time."""
        rest = ""
        for text in self._texts():
            lines = text.split("\n")
            rest = lines.pop()  # nothing, unless the file ends without an end of a line
            yield lines
        yield [rest]

    def _texts(self) -> Iterator[str]:
        """Give the file in pieces that end where lines do, all of them by a line feed."""
        after_return = False
        for _, block in self._source.line_blocks(0, self._source.size):
            text = decoded(block[1:] if after_return and block.startswith(b"\n") else block)
            after_return = block.endswith(b"\r")
            if "\0" in text:
                raise _no_text(self._source.path)
            self._is_utf8 = self._is_utf8 and is_utf8(text)
            yield text.replace("\r\n", "\n").replace("\r", "\n")


@dataclass(frozen=True)
class _MadeAgain(Iterable[str]):
    make: Callable[[], Iterator[str]]

    def __iter__(self) -> Iterator[str]:
        return self.make()


def _no_text(path: str) -> CloudFileError:
    return CloudFileError(
        path, "not a point cloud: neither PLY nor text", "convert it to .ply, .xyz or .csv"
    )
