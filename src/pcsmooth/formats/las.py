"""LAS and LAZ by laspy: every dimension and record of the file is kept."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS, PointCloud
from pcsmooth.colors import COLORS
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.coordinates import split_coordinates
from pcsmooth.formats.las_checks import (
    MOST_PACKED_BYTES,
    check_header,
    check_points,
    is_laz,
    las_library,
    named_failures,
    records_of,
)
from pcsmooth.formats.las_extras import (
    described_extras,
    descriptions_of,
    has_type,
    hidden,
    name_of,
    records_for,
    scales_and_offsets,
)
from pcsmooth.formats.las_positions import (
    MADE_AT,
    ExtraDimension,
    LasLayout,
    coordinates,
    in_steps,
    layout_for,
)
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_columns import lost_columns, number_columns

Columns = dict[str, npt.NDArray[Any]]

#: What normals are called in the file; PDAL and CloudCompare know them by these names.
_NORMALS = dict(zip(("NormalX", "NormalY", "NormalZ"), NORMALS, strict=True))

#: Point formats without colors, and those that are the same with them.
_WITH_COLORS = {0: 2, 1: 3, 6: 7}

#: By which colors of 8 bits are multiplied to have 16.
_WIDER = 257

#: The record that holds the comments.
_COMMENTS = ("pcsmooth", 1)

#: An index of what is where in the file; it does not survive rewriting.
_INDEX = "copc"

#: Bytes of points read at a time: memory is taken as the data call for it, not the header.
_AT_A_TIME = 8 << 20

#: Bytes of the longest name of an extra dimension, and of the longest record.
_MOST_NAME_BYTES = 32
_MOST_BYTES = 2**16 - 1

# What laspy logs is raised too, or of no matter.
logging.getLogger("laspy").addHandler(logging.NullHandler())


def read_las(data: bytes, path: str, dim: int | None) -> PointCloud:
    """Read a LAS or LAZ file.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors.
    dim : {2, 3} or None
        Number of coordinates; with 2 the third is a column.

    Returns
    -------
    PointCloud
        Row i is point i. Each dimension of the point format is a column, and each item of an
        extra dimension; scaled ones as the numbers that they stand for. Normals are called
        ``nx ny nz``.

    Raises
    ------
    CloudFileError
        Not LAS, damaged, cut short, or of a version or point format that is not known.
    PcsmoothError
        laspy is not installed or, if the points are compressed, lazrs.
    """
    las_library(packed=is_laz(data))
    with named_failures(path, "cannot be read as LAS", "get the whole file or export it again"):
        reader, layout = _opened(data, path)
        at_a_time = max(1, _AT_A_TIME // layout.header.point_format.size)
        blocks = [block.array for block in reader.chunk_iterator(at_a_time)]
        table = np.concatenate([np.empty(0, layout.header.point_format.dtype()), *blocks])
        if len(table) != layout.header.point_count:
            raise ValueError(f"{len(table)} points of {layout.header.point_count} are there")
    integers = _integers_of(table)
    xyz = coordinates(integers, layout.header)
    if not np.isfinite(xyz).all():
        raise CloudFileError(
            path,
            f"its scales are {layout.header.scales.tolist()}, by which its points are not finite",
            "export it again",
        )
    positions, height = split_coordinates(xyz, dim)
    comments = [record for record in layout.records if _is_comments(record)]
    return PointCloud(
        points=positions,
        columns={**height, **_columns_of(table, layout)},
        comments=tuple(line for record in comments for line in _lines(record)),
        layout=replace(
            layout,
            integers=integers,
            records=tuple(record for record in layout.records if record not in comments),
            extras=tuple(
                replace(extra, raw=_items_of(table, rank, extra).copy())
                if extra.scales is not None or not extra.columns
                else extra
                for rank, extra in enumerate(layout.extras)
            ),
        ),
    )


def write_las(cloud: PointCloud, file: BinaryIO, path: str, *, packed: bool) -> None:
    """Write a LAS or LAZ file, in the layout of the LAS file that the cloud came from, if any.

    Other clouds become LAS 1.4, in steps that are a small part of the spacing. Columns with the
    name of a dimension of the point format, and values that it holds, go there, all others into
    the extra bytes; for colors the point format becomes the one that has them.

    Parameters
    ----------
    cloud : PointCloud
        What to write.
    file : binary file
        Open for writing.
    path : str
        Name of the file in errors.
    packed : bool
        As LAZ.

    Raises
    ------
    CloudFileError
        A point that is not finite or beyond the integers of the file, a column of words, two
        columns of the same name, or more records than fit.
    PcsmoothError
        laspy is not installed or, if `packed`, lazrs.
    """
    laspy = las_library(packed=packed)
    layout = layout_for(cloud)
    columns = number_columns(cloud, path, "LAS")
    if cloud.dimension == 2:
        columns.pop("z", None)
    integers = in_steps(cloud, layout, path)
    number = layout.header.point_format.id
    if all(name in columns for name in COLORS):
        number = _WITH_COLORS.get(number, number)
    with named_failures(path, "cannot be written as LAS", "write .ply instead"):
        point_format = laspy.PointFormat(number)
        standard = dict(_take_standard(columns, point_format))
        extras, values = _take_extras(columns, len(cloud), layout, point_format, path)
        header = _header_with(layout, point_format, extras, cloud.comments, path)
        point_size = header.point_format.size
        if packed and point_size > MOST_PACKED_BYTES:
            raise CloudFileError(
                path,
                f"points of {point_size} bytes are too long for LAZ, {MOST_PACKED_BYTES} at most",
                "write .las instead",
            )
        points = laspy.PackedPointRecord.zeros(len(cloud), header.point_format)
        for axis, name in enumerate("XYZ"):
            points.array[name] = integers[:, axis]
        for name, column in standard.items():
            points[name][:] = column
        for rank, items in enumerate(values):
            _items_of(points.array, rank, extras[rank])[:] = items

        buffer = io.BytesIO()  # the header is written again at the end, which pipes do not allow
        with laspy.open(
            buffer,
            mode="w",
            header=header,
            do_compress=packed,
            laz_backend=laspy.LazBackend.Lazrs,
            closefd=False,
            encoding_errors="ignore",  # keeps names in the header that are not ASCII as they are
        ) as writer:
            writer.write_points(points)
            extended = [record for record in layout.extended if record.user_id != _INDEX]
            if extended:
                writer.write_evlrs(laspy.vlrs.vlrlist.VLRList(extended))
    whole = buffer.getbuffer()
    whole[MADE_AT] = layout.made  # laspy would date what has no date
    file.write(whole)


def lost_in_las(cloud: PointCloud) -> list[str]:
    """Say what of a cloud a LAS file would not keep."""
    lost = lost_besides(cloud, LasLayout) + lost_columns(cloud)
    records = cloud.layout.records if isinstance(cloud.layout, LasLayout) else ()
    return lost + ["the COPC index"] * any(record.user_id == _INDEX for record in records)


# ------------------------------------------------------------------------------------- reading


def _opened(data: bytes, path: str) -> tuple[Any, LasLayout]:
    """Open a file, whose header then is as it says, and describe it; no point is read yet."""
    laspy = las_library(packed=False)
    checked = check_header(data, path)
    descriptions: list[Any] = []
    shown = data
    if checked.descriptions is not None:
        descriptions = descriptions_of(checked.descriptions.contents)
        shown = hidden(data, checked.descriptions.position, descriptions)
    reader = laspy.open(io.BytesIO(shown), laz_backend=laspy.LazBackend.Lazrs, read_evlrs=False)
    header = reader.header
    header.point_count = header.point_count or checked.n_points
    extended: tuple[Any, ...] = ()
    if header.version.minor >= 4:
        place = header.start_of_first_evlr, header.number_of_evlrs
        extended = records_of(data, *place, path, extended=True)
    steps = header.scales
    if not (np.isfinite(steps) & (steps != 0.0) & np.isfinite(header.offsets)).all():
        raise CloudFileError(
            path, f"its scales are {steps.tolist()}, which are no steps", "export it again"
        )
    check_points(data, header, path)
    point_format = header.point_format
    extras = tuple(_extras(descriptions, point_format))
    point_format.dimensions = list(point_format.standard_dimensions)
    _add_dimensions(point_format, extras)
    format = "laz" if header.are_points_compressed else "las"
    nothing = np.empty((0, 3), np.int32)
    made = data[MADE_AT]
    return reader, LasLayout(format, header, nothing, made, checked.records, extended, extras)


def _extras(descriptions: Sequence[Any], point_format: Any) -> Iterator[ExtraDimension]:
    """Extra dimensions of a file, and the columns that they become."""
    taken = {*point_format.standard_dimension_names, "x", "y", "z"}
    n_bytes = point_format.num_extra_bytes
    for description, dtype, count in described_extras(descriptions, n_bytes):
        names: tuple[str, ...] = ()
        if has_type(description):
            name = name_of(description)
            names = tuple(_unlike(taken, _NORMALS.get(name, name), count))
            taken.update(names)
        yield ExtraDimension(description, dtype, count, names, *scales_and_offsets(description))


def _add_dimensions(point_format: Any, extras: Sequence[ExtraDimension]) -> None:
    """Add extra dimensions; they are named by rank, for names in a file may be there twice."""
    laspy = las_library(packed=False)
    for rank, extra in enumerate(extras):
        kind = (extra.dtype, (extra.count,)) if extra.count > 1 else extra.dtype
        point_format.add_extra_dimension(laspy.ExtraBytesParams(str(rank), np.dtype(kind)))


def _unlike(taken: set[str], base: str, count: int) -> Iterator[str]:
    """Names of the columns of an extra dimension, unlike any other column."""
    for item in range(count):
        name = wanted = f"{base}_{item}" if count > 1 else base
        again = 2
        while name in taken or not name:
            name, again = f"{wanted}_{again}", again + 1
        yield name


def _columns_of(table: npt.NDArray[Any], layout: LasLayout) -> Columns:
    """Columns of a block of points, but for the coordinates."""
    point_format = layout.header.point_format
    points = las_library(packed=False).PackedPointRecord(table, point_format)
    names = [name for name in point_format.standard_dimension_names if name not in "XYZ"]
    columns = {name: np.array(points[name]) for name in names}
    for rank, extra in enumerate(layout.extras):
        values = _items_of(table, rank, extra)
        for item, name in enumerate(extra.columns):
            columns[name] = _scaled(values[:, item], extra, item)
    return columns


def _integers_of(table: npt.NDArray[Any]) -> npt.NDArray[np.int32]:
    """Coordinates of a block of points in steps, (n, 3)."""
    return np.stack([table[name] for name in "XYZ"], axis=1)


def _items_of(table: npt.NDArray[Any], rank: int, extra: ExtraDimension) -> npt.NDArray[Any]:
    """View of the items of an extra dimension, (n, count), in a block of points."""
    return table[str(rank)].reshape(len(table), extra.count)


def _scaled(values: npt.NDArray[Any], extra: ExtraDimension, item: int) -> npt.NDArray[Any]:
    if extra.scales is None or extra.offsets is None:
        return np.ascontiguousarray(values)
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(values * extra.scales[item] + extra.offsets[item], np.float64)


def _is_comments(record: Any) -> bool:
    return (record.user_id, record.record_id) == _COMMENTS


def _lines(record: Any) -> list[str]:
    text: str = record.record_data.rstrip(b"\0").decode("utf-8", "replace")
    return text.splitlines()


# ------------------------------------------------------------------------------------- writing


def _take_standard(columns: Columns, point_format: Any) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    """Take the columns that dimensions of the point format can hold."""
    for dimension in list(point_format.standard_dimensions)[3:]:
        values = columns.get(dimension.name)
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
    spelled = {name: dimension for dimension, name in _NORMALS.items()}
    for name, column in left.items():
        dimension = spelled.get(name, name)
        if dimension in taken:
            dimension = f"{name}_value"
        dimension = dimension.encode()[:_MOST_NAME_BYTES].decode("utf-8", "ignore")
        if dimension in taken:
            raise CloudFileError(
                path, f"two dimensions would be called '{dimension}'", "rename a column"
            )
        taken.add(dimension)
        kept.append((_new_extra(dimension, column.dtype), column.reshape(n_points, 1)))
    extras = [extra for extra, _ in kept + last]
    return extras, [items for _, items in kept + last]


def _new_extra(name: str, dtype: np.dtype[Any]) -> ExtraDimension:
    laspy = las_library(packed=False)
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
            as_read = _scaled(extra.raw[:, item], extra, item)
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
    layout: LasLayout,
    point_format: Any,
    extras: Sequence[ExtraDimension],
    comments: Sequence[str],
    path: str,
) -> Any:
    """Header of the file to be written: of a version that has the format, with all records."""
    laspy = las_library(packed=False)
    known = sorted(
        version
        for version in laspy.supported_versions()
        if laspy.point.dims.is_point_fmt_compatible_with_version(point_format.id, version)
    )
    header = layout.header.copy()
    version = next((each for each in known if each >= str(header.version)), known[-1])
    _add_dimensions(point_format, extras)
    header.set_version_and_point_format(laspy.header.Version.from_str(version), point_format)
    header.start_of_waveform_data_packet_record = 0
    records = [record for record in layout.records if record.user_id != _INDEX]
    if comments:
        text = "\n".join(" ".join(comment.splitlines()) for comment in comments).encode()
        records.append(laspy.VLR(*_COMMENTS, "comments", text))
    header.vlrs = records
    header.vlrs.extract("ExtraBytesVlr")  # which laspy has just made
    header.vlrs.extend(records_for(extras))
    for record in header.vlrs:
        size = len(record.record_data_bytes())
        if size > _MOST_BYTES:
            what = "comments" if _is_comments(record) else "extra dimensions"
            raise CloudFileError(
                path,
                f"its {what} take {size} bytes to describe, LAS has room for {_MOST_BYTES}",
                "write .ply instead",
            )
    return header
