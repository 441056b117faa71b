"""LAS and LAZ files that are read and written piece by piece, in bounded memory."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import replace
from shutil import copyfileobj
from types import TracebackType
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import InvalidInputError
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.las.checks import las_library
from pcsmooth.formats.las.positions import LasLayout, layout_for, new_layout
from pcsmooth.formats.las.reader import find_points, no_points, read_clouds
from pcsmooth.formats.las.writer import Dimensions, dimensions_of, write_points


class LasChunks:
    """The points of a LAS or LAZ file, piece by piece; see `CloudChunks`.

    Parameters
    ----------
    file : binary file
        Open for reading, and seekable; closed with this object.
    path : str
        Name of the file in errors.
    dim : {2, 3} or None
        Number of coordinates; None is 3.

    Raises
    ------
    CloudFileError
        Not LAS, damaged, cut short, or of a version or point format that is not known.
    PcsmoothError
        laspy is not installed or, if the points are compressed, lazrs.
    """

    def __init__(self, file: BinaryIO, path: str, dim: int | None) -> None:
        self._file = file
        self._points = find_points(ByteSource(file, path), dim)
        self.name = path
        self.count = self._points.count
        self.template = no_points(self._points)
        self.dimension = self.template.dimension

    def read(self, rows: int, columns: bool = True) -> Iterator[PointCloud]:
        """Read all points from the first on, some at a time; see `CloudChunks.read`."""
        if rows < 1:
            raise InvalidInputError(f"a chunk must have 1 point or more, not {rows}")
        return read_clouds(self._points, rows, columns)

    def __enter__(self) -> LasChunks:
        """Return the object itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the file."""
        self._file.close()


def las_template(template: PointCloud, chunks: Iterable[PointCloud]) -> PointCloud:
    """Give a cloud that is not from a LAS file the steps that `write_las` would choose for it.

    Parameters
    ----------
    template : PointCloud
        Columns, types, comments and layout.
    chunks : iterable of PointCloud
        All points; iterated only if they are needed.

    Returns
    -------
    PointCloud
        The template, with the layout of a LAS file.
    """
    if isinstance(template.layout, LasLayout):
        return template
    return replace(template, layout=new_layout(chunks))


def write_las_chunks(
    template: PointCloud,
    count: int,
    chunks: Iterable[PointCloud],
    file: BinaryIO,
    path: str,
    *,
    packed: bool,
) -> None:
    """Write a LAS or LAZ file piece by piece, as `write_las` would write all at once.

    Parameters
    ----------
    template : PointCloud
        Columns, types, comments and layout of the file; its points are not written.
    count : int
        How many points there will be.
    chunks : iterable of PointCloud
        So many points, with the columns of the template.
    file : binary file
        Open for writing, at its beginning.
    path : str
        Name of the file in errors.
    packed : bool
        As LAZ.

    Raises
    ------
    CloudFileError
        A point that is not finite or beyond the integers of the file, a column of words, two
        columns of the same name, or more records or points than fit.
    InvalidInputError
        The chunks hold something else than the template, which may be a value that its dimension
        cannot; or nothing says in what steps the points are to be.
    PcsmoothError
        laspy is not installed or, if `packed`, lazrs.
    """
    las_library(packed=packed)
    if not isinstance(template.layout, LasLayout) and len(template) != count:
        raise InvalidInputError(
            "LAS files need to know their steps before their points; make the template by "
            "write_template"
        )
    layout = layout_for(template)
    dimensions = dimensions_of(template, layout, count, path)
    parts = _parts(template, count, layout, dimensions, chunks, path)
    if file.seekable():
        write_points(template, count, layout, dimensions, parts, file, path, packed=packed)
        return
    with tempfile.TemporaryFile() as whole:  # the header is written again at the end
        write_points(template, count, layout, dimensions, parts, whole, path, packed=packed)
        whole.seek(0)
        copyfileobj(whole, file)


def _parts(
    template: PointCloud,
    count: int,
    layout: LasLayout,
    dimensions: Dimensions,
    chunks: Iterable[PointCloud],
    path: str,
) -> Iterator[tuple[PointCloud, LasLayout, Dimensions]]:
    first = 0
    for chunk in chunks:
        own_layout = _layout_of(chunk, layout, first)
        own = dimensions_of(chunk, own_layout, count, path)
        if (own.number, own.names, chunk.dimension) != (
            dimensions.number,
            dimensions.names,
            template.dimension,
        ):
            raise InvalidInputError(
                f"a chunk in {chunk.dimension}D has {', '.join(own.names)}; "
                f"the file in {template.dimension}D has {', '.join(dimensions.names)}"
            )
        yield chunk, own_layout, own
        first += len(chunk)


def _layout_of(chunk: PointCloud, layout: LasLayout, first: int) -> LasLayout:
    """Layout of the file, with the integers and raw values that came with a chunk."""
    own = chunk.layout
    integers = np.empty((0, 3), np.int32)
    raws: list[npt.NDArray[Any] | None] = [None] * len(layout.extras)
    if isinstance(own, LasLayout) and len(own.integers) == len(chunk):
        integers = own.integers
        kinds, own_kinds = (
            [(extra.dtype, extra.count) for extra in each.extras] for each in (layout, own)
        )
        if own_kinds == kinds:
            raws = [extra.raw for extra in own.extras]
    extras = tuple(
        replace(extra, raw=None if extra.raw is None else raw)
        for extra, raw in zip(layout.extras, raws, strict=True)
    )
    return replace(layout, integers=integers, first=first, extras=extras)
