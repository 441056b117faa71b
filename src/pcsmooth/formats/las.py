"""LAS and LAZ: every dimension, record and header entry of the file is kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS, PointCloud
from pcsmooth.colors import COLORS
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.coordinates import split_coordinates
from pcsmooth.formats.las_dimensions import (
    MOST_NAME_BYTES,
    WAVE_FORMATS,
    WITH_COLORS,
    ExtraDimension,
    bits_of,
    extra_bytes_record,
    fields_of,
    is_extra_bytes,
    is_known,
    new_extra,
    parse_extras,
    parts_of,
    point_type,
    put_bits,
    standard_names,
)
from pcsmooth.formats.las_header import (
    MOST_BYTES,
    LasHeader,
    LasRecord,
    composed,
    parse_header,
    with_extended_at,
)
from pcsmooth.formats.las_points import pack_points, packing_for, read_points
from pcsmooth.formats.las_positions import LasLayout, coordinates, in_steps, layout_for
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_columns import lost_columns, number_columns

Columns = dict[str, npt.NDArray[Any]]

#: What normals are called in the file; PDAL and CloudCompare know them by these names.
_NORMALS = dict(zip(("NormalX", "NormalY", "NormalZ"), NORMALS, strict=True))

#: The record that holds the comments.
_COMMENTS = (b"pcsmooth", 1)

#: An index of what is where in the file; it does not survive rewriting.
_INDEX = b"copc"

#: By which colors of 8 bits are multiplied to have 16.
_WIDER = 257


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
        The points are compressed and lazrs is not installed.
    """
    header, start = parse_header(data, path)
    point_format = header.point_format
    if not is_known(point_format):
        kind = "has waves, which are" if point_format in WAVE_FORMATS else "is"
        raise CloudFileError(
            path,
            f"its point format {point_format} {kind} not known",
            "export it in point format 0 to 3 or 6 to 8",
        )
    try:
        n_extra = header.point_size - point_type(point_format, ()).itemsize
        extras = parse_extras(header.records, n_extra)
    except ValueError as error:
        raise CloudFileError(path, f"its points are damaged: {error}", "export it again") from error
    points = read_points(data, start, header, path)
    table = np.frombuffer(points, point_type(point_format, extras), header.n_points)

    columns = dict(_standard_columns(table, point_format))
    owners: list[tuple[str, ...]] = []
    verbatim: dict[int, npt.NDArray[Any]] = {}
    for rank, extra in enumerate(extras):
        values = np.ascontiguousarray(table[str(rank)])
        if extra.is_opaque or extra.scales is not None:
            verbatim[rank] = values
        held = () if extra.is_opaque else tuple(_column_names(extra, columns))
        for item, name in enumerate(held):
            columns[name] = _scaled(values[:, item], extra, item)
        owners.append(held)
    integers = np.stack([table[name] for name in "XYZ"], axis=1)
    xyz = coordinates(integers, header)
    if not np.isfinite(xyz).all():
        raise CloudFileError(
            path,
            f"its scales are {header.scales.tolist()}, by which its points are not finite",
            "export it again",
        )
    positions, height = split_coordinates(xyz, dim)
    comments = [record for record in header.records if record.is_called(*_COMMENTS)]
    return PointCloud(
        points=positions,
        columns={**height, **columns},
        comments=tuple(line for record in comments for line in _lines(record)),
        layout=LasLayout(
            "las" if header.packing is None else "laz",
            replace(
                header,
                records=tuple(record for record in header.records if record not in comments),
            ),
            integers,
            tuple(extras),
            tuple(owners),
            verbatim,
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
        LAZ is to be written and lazrs is not installed.
    """
    layout = layout_for(cloud)
    columns = number_columns(cloud, path, "LAS")
    if cloud.dimension == 2:
        columns.pop("z", None)
    integers = in_steps(cloud, layout, path)
    point_format = layout.header.point_format
    if all(name in columns for name in COLORS):
        point_format = WITH_COLORS.get(point_format, point_format)
    standard = dict(_take_standard(columns, point_format))
    extras, values = _take_extras(columns, len(cloud), layout, point_format, path)

    table = np.zeros(len(cloud), point_type(point_format, extras))
    for axis, name in enumerate("XYZ"):
        table[name] = integers[:, axis]
    parts = parts_of(point_format)
    for name, column in standard.items():
        if name in parts:
            whole, first, count = parts[name]
            table[whole] = put_bits(table[whole], first, count, column)
        else:
            table[name] = column
    for rank, items in enumerate(values):
        table[str(rank)] = items

    n_extra = table.dtype.itemsize - point_type(point_format, ()).itemsize
    header = replace(
        _with_records(layout.header, extras, cloud.comments, path),
        packing=packing_for(point_format, n_extra) if packed else None,
    )
    head, tail = composed(
        header,
        point_format=point_format,
        point_size=table.dtype.itemsize,
        integers=integers,
        returns=bits_of(table["return bits"], *parts["return_number"][1:]),
    )
    if header.packing is not None:
        content = pack_points(head, table.tobytes(), header.packing)
        if tail:
            content = with_extended_at(content, len(content))
        file.write(content)
    else:
        size = len(head) + table.nbytes
        file.write(with_extended_at(head, size) if tail else head)
        file.write(table.view(np.uint8).data)
    file.write(tail)


def lost_in_las(cloud: PointCloud) -> list[str]:
    """Say what of a cloud a LAS file would not keep."""
    lost = lost_besides(cloud, LasLayout) + lost_columns(cloud)
    if isinstance(cloud.layout, LasLayout):
        header = cloud.layout.header
        if any(record.is_called(_INDEX) for record in header.records):
            lost.append("the COPC index")
    return lost


def _lines(record: LasRecord) -> list[str]:
    return record.data.rstrip(b"\0").decode("utf-8", "replace").splitlines()


def _standard_columns(
    table: npt.NDArray[Any], point_format: int
) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    parts = parts_of(point_format)
    for name in standard_names(point_format):
        if name in parts:
            whole, first, count = parts[name]
            yield name, bits_of(table[whole], first, count)
        else:
            yield name, np.ascontiguousarray(table[name])


def _column_names(extra: ExtraDimension, taken: Mapping[str, object]) -> Iterator[str]:
    """Names of the columns of an extra dimension, unlike any other column."""
    base = _NORMALS.get(extra.name, extra.name)
    used = {*taken, "x", "y", "z"}
    for item in range(extra.count):
        name = wanted = f"{base}_{item}" if extra.count > 1 else base
        again = 2
        while name in used or not name:
            name, again = f"{wanted}_{again}", again + 1
        used.add(name)
        yield name


def _scaled(values: npt.NDArray[Any], extra: ExtraDimension, item: int) -> npt.NDArray[Any]:
    if extra.scales is None:
        return np.ascontiguousarray(values)
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(values * extra.scales[item] + extra.offsets[item], np.float64)


def _take_standard(columns: Columns, point_format: int) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    """Take the columns that dimensions of the point format can hold."""
    types = dict(fields_of(point_format))
    parts = parts_of(point_format)
    for name in standard_names(point_format):
        values = columns.get(name)
        if values is None:
            if name in ("return_number", "number_of_returns"):
                yield name, np.ones(1, np.uint8)
            continue
        if name in COLORS and values.dtype == np.uint8:
            values = values.astype(np.uint16) * _WIDER
        if _fits(values, np.dtype(types.get(name, "u1")), parts.get(name, ("", 0, 64))[2]):
            del columns[name]
            yield name, values


def _fits(values: npt.NDArray[Any], dtype: np.dtype[Any], n_bits: int = 64) -> bool:
    """Whether a type, or so many bits of it, holds values as they are."""
    if dtype.kind == "f":
        return values.dtype.kind != "f" or values.dtype.itemsize <= dtype.itemsize
    if values.dtype.kind == "f":
        return False
    low, high = np.iinfo(dtype).min, min(np.iinfo(dtype).max, 2**n_bits - 1)
    return not len(values) or bool(int(values.min()) >= low and int(values.max()) <= high)


def _take_extras(
    columns: Columns, n_points: int, layout: LasLayout, point_format: int, path: str
) -> tuple[list[ExtraDimension], list[npt.NDArray[Any]]]:
    """Extra dimensions of the file whose columns are all there still, then new ones."""
    extras: list[ExtraDimension] = []
    values: list[npt.NDArray[Any]] = []
    for rank, (extra, held) in enumerate(zip(layout.extras, layout.columns, strict=True)):
        old = layout.verbatim.get(rank)
        if extra.is_opaque:
            if old is not None and len(old) == n_points:
                extras.append(extra)
                values.append(old)
            continue
        found = [columns[name] for name in held if name in columns]
        items = _items(found, extra, old) if len(found) == len(held) else None
        if items is not None:
            extras.append(extra)
            values.append(items)
            for name in held:
                del columns[name]
    taken = {extra.name for extra in extras} | set(standard_names(point_format))
    spelled = {name: dimension for dimension, name in _NORMALS.items()}
    for name, column in columns.items():
        dimension = spelled.get(name, name)
        if dimension in taken:
            dimension = f"{name}_value"
        dimension = dimension.encode()[:MOST_NAME_BYTES].decode("utf-8", "ignore")
        if dimension in taken:
            raise CloudFileError(
                path, f"two dimensions would be called '{dimension}'", "rename a column"
            )
        taken.add(dimension)
        extras.append(new_extra(dimension, column.dtype))
        values.append(column[:, None])
    return extras, values


def _items(
    found: Sequence[npt.NDArray[Any]], extra: ExtraDimension, old: npt.NDArray[Any] | None
) -> npt.NDArray[Any] | None:
    """Columns as items of the dimension they came from; None if it cannot hold them."""
    items = np.empty((len(found[0]), extra.count), extra.dtype)
    for item, column in enumerate(found):
        if extra.scales is None:
            if extra.dtype.kind != "f" and not _fits(column, extra.dtype):
                return None
            items[:, item] = column
            continue
        kept = np.zeros(len(column), np.bool_)
        if old is not None and len(old) == len(column):
            kept = _scaled(old[:, item], extra, item) == column
            items[kept, item] = old[kept, item]
        with np.errstate(invalid="ignore", divide="ignore"):
            steps = np.rint((column[~kept] - extra.offsets[item]) / extra.scales[item])
        if extra.dtype.kind != "f":
            limits = np.iinfo(extra.dtype)
            if not np.all((steps >= limits.min) & (steps <= limits.max)):
                return None
        items[~kept, item] = steps.astype(extra.dtype)
    return items


def _with_records(
    header: LasHeader, extras: Sequence[ExtraDimension], comments: Sequence[str], path: str
) -> LasHeader:
    """Describe the extra bytes and hold the comments; leave out what no longer holds."""
    records = [record for record in header.records if not record.is_called(_INDEX)]
    old = [rank for rank, record in enumerate(records) if is_extra_bytes(record)]
    described = extra_bytes_record(extras, records[old[0]] if old else None)
    place = old[0] if old else len(records)
    records = [record for record in records if not is_extra_bytes(record)]
    if described is not None:
        records.insert(place, described)
    if comments:
        user, number = _COMMENTS
        text = "\n".join(" ".join(comment.splitlines()) for comment in comments).encode()
        label = b"comments".ljust(32, b"\0")
        records.append(LasRecord(user.ljust(16, b"\0"), number, label, text))
    for record in records:
        if len(record.data) > MOST_BYTES:
            what = "comments" if record.is_called(*_COMMENTS) else "extra dimensions"
            raise CloudFileError(
                path,
                f"its {what} take {len(record.data)} bytes to describe, LAS has room for "
                f"{MOST_BYTES}",
                "write .ply instead",
            )
    extended = tuple(record for record in header.extended if not record.is_called(_INDEX))
    return replace(header, records=tuple(records), extended=extended)
