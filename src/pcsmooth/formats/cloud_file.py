"""A file of points that is open: all of them at once or, of most formats, some at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from types import TracebackType
from typing import BinaryIO, Protocol, Self

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import InvalidInputError
from pcsmooth.formats.byte_source import ByteSource


class CloudFile(ABC):
    """A file of points.

    Parameters
    ----------
    source : ByteSource
        The file; closed by a ``with`` block of this object.

    Attributes
    ----------
    name : str
        The file, as the user named it.
    source : ByteSource
        The same, open.
    what : str
        What it is, such as ``"a mesh"``, if that stands against reading it piece by piece.
    """

    what = ""

    def __init__(self, source: ByteSource) -> None:
        self.source = source
        self.name = source.path

    @abstractmethod
    def whole(self) -> PointCloud:
        """Read all of it into memory, so that the file may go.

        Raises
        ------
        CloudFileError
            A value is malformed, or the file has changed.
        """

    def __enter__(self) -> Self:
        """Return the object itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the file."""
        self.source.close()


class FileAtOnce(CloudFile):
    """A file that can only be read as a whole.

    Parameters
    ----------
    source : ByteSource
        The file.
    read : callable
        Makes a cloud of its bytes.
    what : str
        What it is that stands against pieces, such as ``"a mesh"``.
    """

    def __init__(self, source: ByteSource, read: Callable[[bytes], PointCloud], what: str) -> None:
        super().__init__(source)
        self._read = read
        self.what = what

    def whole(self) -> PointCloud:
        """Read it; see `CloudFile.whole`."""
        return self._read(self.source.read(0, self.source.size))


class CloudChunks(CloudFile):
    """A file of points that is read piece by piece, any number of times.

    It stays open, and must while what came from its template is written: the rest of the file is
    copied from there. Use it in a ``with`` block; not from several threads at once.

    Attributes
    ----------
    count : int
        Number of points.
    """

    count: int

    @cached_property
    @abstractmethod
    def template(self) -> PointCloud:
        """The cloud that `read_cloud` would give, without its points."""

    @property
    def dimension(self) -> int:
        """Number of coordinates, 2 or 3."""
        return self.template.dimension

    def read(self, rows: int, columns: bool = True) -> Iterator[PointCloud]:
        """Read all points from the first on, in the order of the file.

        Parameters
        ----------
        rows : int
            How many points a chunk has; the last one may have fewer. None is empty.
        columns : bool
            Whether the chunks get their columns too, or positions only.

        Returns
        -------
        iterator of PointCloud
            Rows of the cloud that `read_cloud` would give.

        Raises
        ------
        CloudFileError
            While iterating: a value is malformed, or the file has changed.
        InvalidInputError
            `rows` is not positive.
        """
        if rows < 1:
            raise InvalidInputError(f"a chunk must have 1 point or more, not {rows}")
        return self._clouds(rows, columns)

    def whole(self) -> PointCloud:
        """Read all points as one chunk; see `CloudFile.whole`."""
        return next(self.read(max(1, self.count)), self.template)

    @abstractmethod
    def _clouds(self, rows: int, columns: bool) -> Iterator[PointCloud]:
        """Read so many points at a time, with or without their columns."""


class WriteChunks(Protocol):
    """How the files of a format are written."""

    def __call__(
        self,
        template: PointCloud,
        count: int,
        chunks: Iterable[PointCloud],
        file: BinaryIO,
        path: str,
        /,
    ) -> None:
        """Write a file.

        Parameters
        ----------
        template : PointCloud
            Columns, types, comments and layout of the file; its points are not written.
        count : int
            How many points there will be.
        chunks : iterable of PointCloud
            So many points, with the columns of the template; all of them may be the template
            itself.
        file : binary file
            Open for writing; at its beginning, if it is seekable.
        path : str
            Name of the file in errors.

        Raises
        ------
        CloudFileError
            The format cannot hold it.
        InvalidInputError
            The chunks hold something else than the template.
        """


class MakeTemplate(Protocol):
    """How a template is completed by what must be known of all points before the first."""

    def __call__(
        self, template: PointCloud, chunks: Iterable[PointCloud], path: str, /
    ) -> PointCloud:
        """Complete a template.

        Parameters
        ----------
        template : PointCloud
            Columns, types, comments and layout.
        chunks : iterable of PointCloud
            All points; iterated only if they must be known.
        path : str
            Name of the file in errors.

        Raises
        ------
        CloudFileError
            A column holds words that are no numbers.
        InvalidInputError
            The chunks lack a column of the template.
        """


def check_alike(
    template: PointCloud, names: Sequence[str], chunk: PointCloud, own_names: Sequence[str]
) -> None:
    """Raise `InvalidInputError` unless a chunk has what the file that is written has.

    Parameters
    ----------
    template : PointCloud
        Template of the file.
    names : sequence of str
        What a point of it has, in words.
    chunk : PointCloud
        Some of its points.
    own_names : sequence of str
        What they have.
    """
    # A flat chunk would be given a third coordinate of zero.
    if (chunk.dimension, [*own_names]) != (template.dimension, [*names]):
        raise InvalidInputError(
            f"a chunk in {chunk.dimension}D has {', '.join(own_names)}; "
            f"the file in {template.dimension}D has {', '.join(names)}"
        )
