"""LAS and LAZ by laspy, in the layout of the LAS file that a cloud came from, if any."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from shutil import copyfileobj
from tempfile import SpooledTemporaryFile
from typing import Any, BinaryIO, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS, PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats.cloud_file import check_alike
from pcsmooth.formats.las.checks import MOST_PACKED_BYTES, named_failures
from pcsmooth.formats.las.extras import (
    NORMAL_DIMENSIONS,
    add_dimensions,
    items_of,
    name_of,
    records_for,
    scaled,
)
from pcsmooth.formats.las.positions import (
    COMMENTS,
    MADE_AT,
    ExtraDimension,
    LasLayout,
    coordinates,
    in_steps,
    is_comments,
    layout_for,
    new_layout,
)
from pcsmooth.formats.las.streams import TargetFile
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_columns import (
    NO_TYPES,
    Types,
    ValueRanges,
    lost_columns,
    number_columns,
)

Columns = dict[str, npt.NDArray[Any]]

#: Point formats without colors, and those that are the same with them.
_WITH_COLORS = {0: 2, 1: 3, 6: 7}

#: By which colors of 8 bits are multiplied to have 16.
_WIDER = 257

#: An index of what is where in the file; it does not survive rewriting.
_INDEX = "copc"

#: Bytes of a file for a pipe that wait in memory rather than on the disk.
_MOST_IN_MEMORY = 1 << 28

#: Bytes of the longest name of an extra dimension, and of the longest record.
_MOST_NAME_BYTES = 32
_MOST_BYTES = 2**16 - 1


class Dimensions(NamedTuple):
    """Where the columns of a cloud go.

    Attributes
    ----------
    number : int
        The point format.
    standard : dict of str to ndarray, shape (n,)
        Values of its dimensions but for the coordinates, by name.
    extras : list of ExtraDimension
        The extra dimensions.
    items : list of ndarray, shape (n, count)
        Their values.
    types : mapping of str to numpy.dtype
        Types of the columns of numbers.
    """

    number: int
    standard: Columns
    extras: list[ExtraDimension]
    items: list[npt.NDArray[Any]]
    types: Types

    @property
    def names(self) -> list[str]:
        """What must agree where points are written piece by piece."""
        described = (
            f"{name_of(extra.description) or '?'} ({extra.count} {extra.dtype})"
            for extra in self.extras
        )
        return [*self.standard, *described]


def las_template(template: PointCloud, chunks: Iterable[PointCloud], path: str) -> PointCloud:
    """Decide in which steps, and dimensions, a cloud that is not from a LAS file is written.

    See `MakeTemplate`: the chunks are iterated only if the cloud is not from a LAS file.
    """
    if isinstance(template.layout, LasLayout):
        return template
    ranges = ValueRanges(template, lambda kind: kind.kind in "Uiu", path, "LAS")
    layout = new_layout(map(ranges.add, chunks))
    return replace(ranges.template(), layout=layout)


def write_las(
    template: PointCloud,
    count: int,
    chunks: Iterable[PointCloud],
    file: BinaryIO,
    path: str,
    *,
    packed: bool,
) -> None:
    """Write a LAS or LAZ file, in the layout of the LAS file that the cloud came from, if any.

    Other clouds become LAS 1.4, in steps that are a small part of the spacing. Columns with the
    name of a dimension of the point format, and values that it holds, go there, all others into
    the extra bytes; for colors the point format becomes the one that has them.

    Parameters
    ----------
    template, count, chunks, file, path
        See `WriteChunks`.
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
    """
    if not isinstance(template.layout, LasLayout) and len(template) != count:
        raise InvalidInputError(
            "LAS files need to know their steps before their points; make the template by "
            "write_template"
        )
    layout = layout_for(template)
    dimensions = _dimensions_of(template, layout, count, path)
    parts = _parts(template, count, layout, dimensions, chunks, path)
    if file.seekable():
        _write_points(template, count, layout, dimensions, parts, file, path, packed=packed)
        return
    with SpooledTemporaryFile(_MOST_IN_MEMORY) as whole:  # the header is written again at the end
        target = cast(BinaryIO, whole)
        _write_points(template, count, layout, dimensions, parts, target, path, packed=packed)
        whole.seek(0)
        copyfileobj(whole, file)


def lost_in_las(cloud: PointCloud) -> list[str]:
    """Say what of a cloud a LAS file would not keep."""
    lost = lost_besides(cloud, LasLayout) + lost_columns(cloud)
    records = cloud.layout.records if isinstance(cloud.layout, LasLayout) else ()
    return lost + ["the COPC index"] * any(record.user_id == _INDEX for record in records)


def _parts(
    template: PointCloud,
    count: int,
    layout: LasLayout,
    dimensions: Dimensions,
    chunks: Iterable[PointCloud],
    path: str,
) -> Iterator[tuple[PointCloud, LasLayout, Dimensions]]:
    """Each chunk with the layout of the file but its own integers, and where its columns go."""
    first = 0
    for chunk in chunks:
        if chunk is template:
            yield chunk, layout, dimensions
            continue
        own_layout = _layout_of(chunk, layout, first)
        own = _dimensions_of(chunk, own_layout, count, path, dimensions)
        check_alike(template, dimensions.names, chunk, own.names)
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


def _dimensions_of(
    cloud: PointCloud,
    layout: LasLayout,
    n_points: int,
    path: str,
    settled: Dimensions | None = None,
) -> Dimensions:
    """Decide where the columns of a cloud go.

    Parameters
    ----------
    cloud : PointCloud
        All points of a file, or some of them.
    layout : LasLayout
        Of the file; with the integers and raw values of these points, if they have any.
    n_points : int
        Number of points in the file.
    path : str
        Name of the file in errors.
    settled : Dimensions, optional
        Where the columns of the file go, if these are some of its points.

    Raises
    ------
    CloudFileError
        A column of words, or two columns of the same name.
    """
    import laspy

    types = NO_TYPES if settled is None else settled.types
    columns = number_columns(cloud, path, "LAS", types)
    if cloud.dimension == 2:
        columns.pop("z", None)
    types = {name: values.dtype for name, values in columns.items()}
    number = layout.header.point_format.id
    if all(name in columns for name in COLORS):
        number = _WITH_COLORS.get(number, number)
    with _writing(path):
        point_format = laspy.PointFormat(number)
        holding = None if settled is None else settled.standard.keys()
        standard = dict(_take_standard(columns, point_format, holding))
        extras, items = _take_extras(columns, n_points, len(cloud), layout, point_format, path)
    return Dimensions(number, standard, extras, items, types)


def _write_points(
    template: PointCloud,
    n_points: int,
    layout: LasLayout,
    dimensions: Dimensions,
    parts: Iterable[tuple[PointCloud, LasLayout, Dimensions]],
    file: BinaryIO,
    path: str,
    *,
    packed: bool,
) -> None:
    """Write a file whose parts are given with their own integers, raw values and columns."""
    import laspy

    target = TargetFile(file)
    with target.own_errors(), _writing(path):
        header = _header_with(layout, dimensions, template.comments, path)
        _check_fits(header, n_points, path, packed=packed)
        writer = laspy.open(
            target,
            mode="w",
            header=header,
            do_compress=packed,
            laz_backend=laspy.LazBackend.Lazrs,
            closefd=False,
            encoding_errors="ignore",  # keeps names in the header that are not ASCII as they are
        )
    extremes = _Extremes()
    for cloud, own_layout, own_dimensions in parts:  # which may fail in their own ways
        with target.own_errors(), _writing(path):
            points = laspy.PackedPointRecord.zeros(len(cloud), header.point_format)
            for axis, values in enumerate(in_steps(cloud, own_layout, path).T):
                points.array["XYZ"[axis]] = values
            for name, column in own_dimensions.standard.items():
                points[name][:] = column
            for rank, items in enumerate(own_dimensions.items):
                items_of(points.array, rank, own_dimensions.extras[rank])[:] = items
            extremes.add(points.array)
            writer.write_points(points)
    with target.own_errors(), _writing(path):
        extended = [record for record in layout.extended if record.user_id != _INDEX]
        if extended:
            writer.write_evlrs(laspy.vlrs.vlrlist.VLRList(extended))
        extremes.tell(writer.header)
        writer.close()
        target.seek(MADE_AT.start)
        target.write(layout.made)  # laspy would date what has no date


class _Extremes:
    """Least and largest values of all points; what laspy makes of NaN depends on their order."""

    def __init__(self) -> None:
        self._found: dict[str, list[Any]] = {}

    def add(self, table: npt.NDArray[Any]) -> None:
        """Take points into account."""
        for name in {"X", "Y", "Z", "gps_time"} & set(table.dtype.names or ()):
            if len(table):
                known = self._found.get(name, [])
                low, high = np.fmin.reduce(table[name]), np.fmax.reduce(table[name])
                self._found[name] = [np.fmin.reduce([low, *known]), np.fmax.reduce([high, *known])]

    def tell(self, header: Any) -> None:
        """Write them into a header."""
        if not self._found:
            return
        ends = coordinates(np.stack([self._found[axis] for axis in "XYZ"], axis=1), header)
        header.mins, header.maxs = ends.min(axis=0), ends.max(axis=0)  # a scale may be negative
        times = self._found.get("gps_time", [np.nan])
        if not np.isnan(times[0]):
            # Never -0.0, which would depend on the order of rows.
            header.min_gps_time, header.max_gps_time = (float(time) + 0.0 for time in times)


def _take_standard(
    columns: Columns, point_format: Any, holding: Collection[str] | None
) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    """Take the columns that dimensions of the point format can hold, or those that are to."""
    for dimension in list(point_format.standard_dimensions)[3:]:
        values = columns.get(dimension.name)
        if values is not None and holding is not None and dimension.name not in holding:
            continue
        if values is None:
            if dimension.name in ("return_number", "number_of_returns"):
                yield dimension.name, np.ones(1, np.uint8)
            continue
        if dimension.name in COLORS and values.dtype == np.uint8:
            values = values.astype(np.uint16) * _WIDER
        dtype = dimension.dtype or np.dtype(np.uint8)
        if _fits(values, dtype, dimension.num_bits):
            del columns[dimension.name]
            yield dimension.name, values.astype(dtype)


def _fits(values: npt.NDArray[Any], dtype: np.dtype[Any], n_bits: int = 64) -> bool:
    """Whether a type, or so many bits of it, holds values as they are."""
    if dtype.kind == "f":
        return values.dtype.kind != "f" or values.dtype.itemsize <= dtype.itemsize
    if values.dtype.kind == "f":
        return False
    low, high = np.iinfo(dtype).min, min(np.iinfo(dtype).max, 2**n_bits - 1)
    return not len(values) or bool(int(values.min()) >= low and int(values.max()) <= high)


def _take_extras(
    columns: Mapping[str, npt.NDArray[Any]],
    n_points: int,
    n_here: int,
    layout: LasLayout,
    point_format: Any,
    path: str,
) -> tuple[list[ExtraDimension], list[npt.NDArray[Any]]]:
    """Extra dimensions and their items: those of the file that hold their columns, then new ones.

    Bytes that the file does not describe stay the last.
    """
    kept: list[tuple[ExtraDimension, npt.NDArray[Any]]] = []
    last: list[tuple[ExtraDimension, npt.NDArray[Any]]] = []
    left = dict(columns)
    for extra in layout.extras:
        if not extra.columns:
            if extra.raw is None:
                continue
            if extra.description is not None:
                kept.append((extra, extra.raw))
            elif n_points:  # where there is none, they only make lazrs take memory for each
                last.append((extra, extra.raw))
            continue
        found = [left[name] for name in extra.columns if name in left]
        items = _items(found, extra) if len(found) == extra.count else None
        if items is not None:
            kept.append((extra, items))
            for name in extra.columns:
                del left[name]
    taken = {name_of(extra.description) for extra, _ in kept} | set(
        point_format.standard_dimension_names
    )
    taken.update(point_format.dtype().names)  # which laspy uses for some together
    for name, column in left.items():
        dimension = NORMAL_DIMENSIONS.get(name, name)
        if dimension in taken:
            dimension = f"{name}_value"
        dimension = dimension.encode()[:_MOST_NAME_BYTES].decode("utf-8", "ignore")
        if dimension in taken:
            raise CloudFileError(
                path, f"two dimensions would be called '{dimension}'", "rename a column"
            )
        taken.add(dimension)
        kept.append((_new_extra(dimension, column.dtype), column.reshape(n_here, 1)))
    extras = [extra for extra, _ in kept + last]
    return extras, [items for _, items in kept + last]


def _new_extra(name: str, dtype: np.dtype[Any]) -> ExtraDimension:
    import laspy

    kind = dtype.newbyteorder("=")
    number = laspy.extradims.get_id_for_extra_dim_type(kind)
    description = laspy.vlrs.known.ExtraBytesStruct(name=name.encode(), data_type=number)
    return ExtraDimension(description, kind, 1, (name,))


def _items(found: Sequence[npt.NDArray[Any]], extra: ExtraDimension) -> npt.NDArray[Any] | None:
    """Columns as items of the dimension they came from; None if it cannot hold them."""
    items = np.empty((len(found[0]), extra.count), extra.dtype)
    for item, column in enumerate(found):
        if extra.scales is None or extra.offsets is None:
            if extra.dtype.kind != "f" and not _fits(column, extra.dtype):
                return None
            items[:, item] = column
            continue
        kept = np.zeros(len(column), np.bool_)
        if extra.raw is not None:
            as_read = scaled(extra.raw[:, item], extra, item)
            kept = (as_read == column) | (np.isnan(as_read) & np.isnan(column))
            items[kept, item] = extra.raw[kept, item]
        with np.errstate(invalid="ignore", divide="ignore"):
            steps = np.rint((column[~kept] - extra.offsets[item]) / extra.scales[item])
        if extra.dtype.kind != "f":
            limits = np.iinfo(extra.dtype)
            if not np.all((steps >= limits.min) & (steps <= limits.max)):
                return None
        items[~kept, item] = steps.astype(extra.dtype)
    return items


def _header_with(
    layout: LasLayout, dimensions: Dimensions, comments: Sequence[str], path: str
) -> Any:
    """Header of the file to be written: of a version that has the format, with all records."""
    import laspy

    point_format = laspy.PointFormat(dimensions.number)
    known = sorted(
        version
        for version in laspy.supported_versions()
        if laspy.point.dims.is_point_fmt_compatible_with_version(point_format.id, version)
    )
    header = layout.header.copy()
    version = next((each for each in known if each >= str(header.version)), known[-1])
    add_dimensions(point_format, dimensions.extras)
    header.set_version_and_point_format(laspy.header.Version.from_str(version), point_format)
    header.start_of_waveform_data_packet_record = 0
    records = [record for record in layout.records if record.user_id != _INDEX]
    if comments:
        text = "\n".join(" ".join(comment.splitlines()) for comment in comments).encode()
        records.append(laspy.VLR(*COMMENTS, "comments", text))
    header.vlrs = records
    header.vlrs.extract("ExtraBytesVlr")  # which laspy has just made
    header.vlrs.extend(records_for(dimensions.extras))
    for record in header.vlrs:
        size = len(record.record_data_bytes())
        if size > _MOST_BYTES:
            what = "comments" if is_comments(record) else "extra dimensions"
            raise CloudFileError(
                path,
                f"its {what} take {size} bytes to describe, LAS has room for {_MOST_BYTES}",
                "write .ply instead",
            )
    return header


def _check_fits(header: Any, n_points: int, path: str, *, packed: bool) -> None:
    point_size = header.point_format.size
    if packed and point_size > MOST_PACKED_BYTES:
        raise CloudFileError(
            path,
            f"points of {point_size} bytes are too long for LAZ, {MOST_PACKED_BYTES} at most",
            "write .las instead",
        )
    if n_points > header.max_point_count():
        raise CloudFileError(
            path,
            f"LAS {header.version} has room for {header.max_point_count()} points, not {n_points}",
            "write .ply instead",
        )


def _writing(path: str) -> AbstractContextManager[None]:
    return named_failures(path, "cannot be written as LAS", "write .ply instead")
