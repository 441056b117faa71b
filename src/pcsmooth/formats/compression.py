"""Files that are compressed as a whole: by gzip, or by Zstandard with its library."""

from __future__ import annotations

import gzip
import io
import os
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any, BinaryIO, cast

from pcsmooth.errors import CloudFileError, PcsmoothError
from pcsmooth.optional_libraries import optional_library

_BLOCK = 1 << 20

#: Bytes that are unpacked whatever they come from, and how many times the packed ones they may be
#: beyond that. Text of points is packed 3 to 5 times; a run of zeros 1,000 or 20,000 times.
_HARMLESS = 1 << 26
_MOST_TIMES = 200

#: Packed bytes of Zstandard that are unpacked at once: blocks of 4 bytes may hold 128 kB each.
_MORSEL = 1 << 8


@dataclass(frozen=True)
class Compression:
    """How files are compressed.

    Attributes
    ----------
    name : str
        What it is called.
    suffix : str
        How the names of files end.
    magic : bytes
        How files begin.
    read : callable
        Takes a packed file and gives what it holds, in blocks of bounded size.
    damage : callable
        Gives the errors that this raises of a damaged file.
    pack : callable
        Takes a file and gives one that packs what is written into it.
    check : callable
        Raises `PcsmoothError` where a library is missing.
    """

    name: str
    suffix: str
    magic: bytes
    read: Callable[[BinaryIO], Iterator[bytes]]
    damage: Callable[[], tuple[type[Exception], ...]]
    pack: Callable[[BinaryIO], Any]
    check: Callable[[], object]


def _read_gzip(packed: BinaryIO) -> Iterator[bytes]:
    with gzip.GzipFile(fileobj=packed, mode="rb") as file:
        while block := file.read(_BLOCK):
            yield block


def _pack_gzip(file: BinaryIO) -> gzip.GzipFile:
    return gzip.GzipFile("", "wb", 6, file, mtime=0)  # of neither name nor time: the same bytes


def _zstandard() -> Any:
    return optional_library("zstandard", "zst", ".zst files")


def _read_zstd(packed: BinaryIO) -> Iterator[bytes]:
    library = _zstandard()
    frame = None
    while morsel := packed.read(_MORSEL):
        while morsel:
            if frame is None:
                frame = library.ZstdDecompressor().decompressobj()
            yield frame.decompress(morsel)
            morsel = frame.unused_data
            if frame.eof:
                frame = None
    if frame is not None:
        raise EOFError("the last frame has no end")


def _pack_zstd(file: BinaryIO) -> Any:
    return _zstandard().ZstdCompressor(level=3).stream_writer(file, closefd=False)


_ALL = (
    Compression(
        "gzip", ".gz", b"\x1f\x8b", _read_gzip, lambda: (EOFError, gzip.BadGzipFile, zlib.error),
        _pack_gzip, lambda: None,
    ),
    Compression(
        "zstd", ".zst", b"\x28\xb5\x2f\xfd", _read_zstd,
        lambda: (EOFError, _zstandard().ZstdError), _pack_zstd, _zstandard,
    ),
)  # fmt: skip

_MAGIC_BYTES = max(len(compression.magic) for compression in _ALL)

SUFFIXES = tuple(compression.suffix for compression in _ALL)
"""How the names of compressed files end."""


def without_compression(path: str) -> tuple[str, str]:
    """Part a file's name from the suffix that says that it is compressed.

    Examples
    --------
    >>> without_compression("a.ply.GZ"), without_compression("a.ply")
    (('a.ply', '.GZ'), ('a.ply', ''))
    """
    name, suffix = os.path.splitext(path)
    return (name, suffix) if suffix.lower() in SUFFIXES else (path, "")


def compression_of(head: bytes) -> str:
    """Say how a file that begins so is compressed; nothing if it is not."""
    found = _compression(head)
    return "" if found is None else found.name


def beginning(head: bytes) -> bytes:
    """Unpack the beginning of what may be compressed, as far as that goes without its rest."""
    found = _compression(head)
    if found is None:
        return head
    unpacked = b""
    # Cut off where the head ends, damaged, or without library: reading will say so.
    with suppress(PcsmoothError, *_damage(found)):
        for block in found.read(io.BytesIO(head)):
            unpacked += block
            if len(unpacked) >= _BLOCK:
                break
    return unpacked


def unpack(packed: BinaryIO, into: BinaryIO, path: str) -> None:
    """Unpack a compressed file.

    Parameters
    ----------
    packed : binary file
        Open for reading, at its beginning, and seekable; see `compression_of`.
    into : binary file
        Gets what it holds.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        It is damaged, cut short, or holds what no cloud is packed to.
    PcsmoothError
        The library that it needs is not installed.
    """
    found = _compression(packed.read(_MAGIC_BYTES))
    assert found is not None
    size = packed.seek(0, os.SEEK_END)
    packed.seek(0)
    found.check()
    written = 0
    try:
        for block in found.read(packed):
            written += len(block)
            if written > max(_HARMLESS, _MOST_TIMES * size):
                raise CloudFileError(
                    path,
                    f"what it holds is more than {_MOST_TIMES} times as large, which is no cloud",
                    f"if it is one, unpack it by {found.name} first",
                )
            into.write(block)
    except _damage(found) as error:
        raise CloudFileError(
            path,
            f"the {found.name} file is damaged or cut short ({error})",
            "copy or download it again",
        ) from error


def check_compression(path: str) -> None:
    """Raise `PcsmoothError` if a file of this name needs a library that is not installed."""
    found = _named(path)
    if found is not None:
        found.check()


@contextmanager
def packing(file: BinaryIO, path: str) -> Iterator[BinaryIO]:
    """Give the file to write into: one that packs if its name says so, and cannot be sought in."""
    found = _named(path)
    if found is None:
        yield file
        return
    packed = found.pack(file)
    try:
        yield cast(BinaryIO, Forward(packed))
    finally:
        packed.close()


@dataclass(frozen=True)
class Forward:
    """A stream in which nobody goes back: it may have held something before, or is packed."""

    stream: BinaryIO | io.BufferedWriter

    def seekable(self) -> bool:
        """Return false."""
        return False

    def write(self, data: Any) -> int:
        """Write all of it."""
        return self.stream.write(data)


def _compression(head: bytes) -> Compression | None:
    return next((found for found in _ALL if head.startswith(found.magic)), None)


def _named(path: str) -> Compression | None:
    suffix = without_compression(path)[1].lower()
    return next((found for found in _ALL if found.suffix == suffix), None)


def _damage(found: Compression) -> tuple[type[Exception], ...]:
    """Errors of a damaged file; none where the library that would raise them is missing."""
    try:
        return found.damage()
    except PcsmoothError:
        return ()
