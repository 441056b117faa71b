"""LAS and LAZ by laspy: every dimension and record of the file is kept."""

from __future__ import annotations

import io
import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.axis_names import normals_among
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.cloud_file import CloudChunks
from pcsmooth.formats.coordinates import split_coordinates
from pcsmooth.formats.las.checks import (
    check_header,
    check_points,
    named_failures,
    records_of,
)
from pcsmooth.formats.las.extras import (
    add_dimensions,
    described_extras,
    descriptions_of,
    has_type,
    hidden,
    items_of,
    name_of,
    scaled,
    scales_and_offsets,
)
from pcsmooth.formats.las.positions import (
    MADE_AT,
    ExtraDimension,
    LasLayout,
    coordinates,
    is_comments,
)
from pcsmooth.formats.las.streams import SourceFile

Table = npt.NDArray[Any]

#: Bytes of points read at a time: memory is taken as the data call for it, not the header.
_AT_A_TIME = 8 << 20

#: Low noise, and high noise.
_NOISE_CLASSES = (7, 18)

# What laspy logs is raised too, or of no matter.
logging.getLogger("laspy").addHandler(logging.NullHandler())


class LasChunks(CloudChunks):
    """The points of a LAS or LAZ file; row i is point i.

    Each dimension of the point format is a column, and each item of an extra dimension; scaled
    ones as the numbers that they stand for. Normals are called ``nx ny nz``. Points of the classes
    7 and 18, and withheld ones, are marked as noise.

    Parameters
    ----------
    source : ByteSource
        The file.
    dim : {2, 3} or None
        Number of coordinates; with 2 the third is a column.

    Raises
    ------
    CloudFileError
        Not LAS, damaged, cut short, or of a version or point format that is not known.
    """

    def __init__(self, source: ByteSource, dim: int | None) -> None:
        import laspy

        super().__init__(source)
        self._dim = dim
        path = source.path
        with _reading(path):
            checked = check_header(source)
            descriptions: list[Any] = []
            shown = checked.head
            if checked.descriptions is not None:
                descriptions = descriptions_of(checked.descriptions.contents)
                shown = hidden(shown, checked.descriptions.position, descriptions)
            header = laspy.LasHeader.read_from(io.BytesIO(shown))
            header.point_count = header.point_count or checked.n_points
            extended: tuple[Any, ...] = ()
            if header.version.minor >= 4:
                place = header.start_of_first_evlr, header.number_of_evlrs
                extended = records_of(source, *place, extended=True)
            steps = header.scales
            if not (np.isfinite(steps) & (steps != 0.0) & np.isfinite(header.offsets)).all():
                raise CloudFileError(
                    path, f"its scales are {steps.tolist()}, which are no steps", "export it again"
                )
            check_points(source, header)
            point_format = header.point_format
            extras = tuple(_extras(descriptions, point_format))
            point_format.dimensions = list(point_format.standard_dimensions)
            add_dimensions(point_format, extras)
        comments = [record for record in checked.records if is_comments(record)]
        layout = LasLayout(
            "laz" if header.are_points_compressed else "las",
            header,
            np.empty((0, 3), np.int32),
            checked.head[MADE_AT],
            tuple(record for record in checked.records if record not in comments),
            extended,
            extras,
        )
        self._layout = layout
        self._comments = tuple(line for each in comments for line in _lines(each))
        self.count = int(header.point_count)

    @cached_property
    def template(self) -> PointCloud:
        """The cloud without its points."""
        return self._cloud_of(np.empty(0, self._layout.header.point_format.dtype()), 0, True)

    def _clouds(self, rows: int, columns: bool) -> Iterator[PointCloud]:
        first = 0
        for table in self._tables(rows, positions_only=not columns):
            yield self._cloud_of(table, first, columns)
            first += len(table)

    def _tables(self, rows: int, *, positions_only: bool) -> Iterator[Table]:
        dtype = self._layout.header.point_format.dtype()
        at_a_time = max(1, _AT_A_TIME // dtype.itemsize)
        read = self._unpacker(positions_only) if self._layout.format == "laz" else self._reader()
        for first in range(0, self.count, rows):
            end = min(first + rows, self.count)
            blocks = [
                np.frombuffer(read(row, min(at_a_time, end - row)), dtype)
                for row in range(first, end, at_a_time)
            ]
            yield blocks[0] if len(blocks) == 1 else np.concatenate(blocks)

    def _reader(self) -> Callable[[int, int], bytes]:
        """Make a function that reads so many points from one on."""
        header = self._layout.header
        start, size = header.offset_to_point_data, header.point_format.size
        return lambda first, count: self.source.read(start + first * size, count * size)

    def _unpacker(self, positions_only: bool) -> Callable[[int, int], bytearray]:
        """Make a function that unpacks the next points, as many as are wanted."""
        import laspy
        import lazrs

        header, path = self._layout.header, self.name
        wanted = laspy.DecompressionSelection.all()
        if positions_only:  # of layered points the others are not even unpacked
            parts = laspy.DecompressionSelection
            wanted = parts.XY_RETURNS_CHANNEL | parts.Z | parts.CLASSIFICATION | parts.FLAGS
        file = SourceFile(self.source, header.offset_to_point_data)
        with file.own_errors(), _reading(path):
            packing = header.vlrs.get("LasZipVlr")[0].record_data
            unpacking = lazrs.LasZipDecompressor(file, packing, wanted.to_lazrs())

        def unpack(_first: int, count: int) -> bytearray:
            data = bytearray(count * header.point_format.size)
            with file.own_errors(), _reading(path):
                unpacking.decompress_many(data)
            return data

        return unpack

    def _cloud_of(self, table: Table, first: int, columns: bool) -> PointCloud:
        """Cloud of a block of points, of which the first is that of a row."""
        layout = self._layout
        integers = np.stack([table[name] for name in "XYZ"], axis=1)
        xyz = coordinates(integers, layout.header)
        if not np.isfinite(xyz).all():
            raise CloudFileError(
                self.name,
                f"its scales are {layout.header.scales.tolist()}, by which its points are not "
                "finite",
                "export it again",
            )
        positions, height = split_coordinates(xyz, self._dim)
        extras = tuple(
            replace(extra, raw=items_of(table, rank, extra).copy())
            if columns and (extra.scales is not None or not extra.columns)
            else extra
            for rank, extra in enumerate(layout.extras)
        )
        return PointCloud(
            points=positions,
            columns={**height, **_columns_of(table, layout)} if columns else {},
            comments=self._comments,
            noise_marks=_noise_marks(table, layout),
            layout=replace(layout, integers=integers, first=first, extras=extras),
        )


def _extras(descriptions: Sequence[Any], point_format: Any) -> Iterator[ExtraDimension]:
    """Extra dimensions of a file, and the columns that they become."""
    taken = {*point_format.standard_dimension_names, "x", "y", "z"}
    n_bytes = point_format.num_extra_bytes
    normals = normals_among(map(name_of, filter(has_type, descriptions)))
    for description, dtype, count in described_extras(descriptions, n_bytes):
        names: tuple[str, ...] = ()
        if has_type(description):
            name = name_of(description)
            names = tuple(_unlike(taken, normals.get(name, name), count))
            taken.update(names)
        yield ExtraDimension(description, dtype, count, names, *scales_and_offsets(description))


def _unlike(taken: set[str], base: str, count: int) -> Iterator[str]:
    """Names of the columns of an extra dimension, unlike any other column."""
    for item in range(count):
        name = wanted = f"{base}_{item}" if count > 1 else base
        again = 2
        while name in taken or not name:
            name, again = f"{wanted}_{again}", again + 1
        yield name


def _columns_of(table: Table, layout: LasLayout) -> dict[str, npt.NDArray[Any]]:
    """Columns of a block of points, but for the coordinates."""
    points = _record(table, layout)
    names = layout.header.point_format.standard_dimension_names
    columns = {name: np.array(points[name]) for name in names if name not in "XYZ"}
    for rank, extra in enumerate(layout.extras):
        values = items_of(table, rank, extra)
        for item, name in enumerate(extra.columns):
            columns[name] = scaled(values[:, item], extra, item)
    return columns


def _noise_marks(table: Table, layout: LasLayout) -> npt.NDArray[np.bool_] | None:
    """Points of a block that are of a noise class or withheld; None if there is none."""
    points = _record(table, layout)
    classes = np.array(points["classification"])
    marks = np.isin(classes, _NOISE_CLASSES) | (np.array(points["withheld"]) != 0)
    return marks if marks.any() else None


def _record(table: Table, layout: LasLayout) -> Any:
    import laspy

    return laspy.PackedPointRecord(table, layout.header.point_format)


def _lines(record: Any) -> list[str]:
    text: str = record.record_data.rstrip(b"\0").decode("utf-8", "replace")
    return text.splitlines()


def _reading(path: str) -> AbstractContextManager[None]:
    return named_failures(path, "cannot be read as LAS", "get the whole file or export it again")
