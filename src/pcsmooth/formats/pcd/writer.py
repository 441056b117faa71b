"""PCD, in the layout of the PCD file that a cloud came from, if any."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS, NORMALS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.cloud_file import check_alike
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_columns import (
    NO_TYPES,
    Types,
    ValueRanges,
    lost_columns,
    number_columns,
    plain_ascii,
)
from pcsmooth.formats.pcd.header import PcdField, PcdHeader
from pcsmooth.formats.pcd.layout import PACKED, PcdLayout, bytes_of
from pcsmooth.formats.pcd.points import write_fields
from pcsmooth.formats.position_type import written_position_type

Columns = dict[str, npt.NDArray[Any]]
Described = list[tuple[PcdField, npt.NDArray[Any]]]

#: What normals are called in a new file.
_NORMAL_FIELDS = dict(zip(NORMALS, ("normal_x", "normal_y", "normal_z"), strict=True))

_NEW_COLOR = PcdField("rgb", np.dtype("<f4"))


def pcd_template(template: PointCloud, chunks: Iterable[PointCloud], path: str) -> PointCloud:
    """Type columns of words as all of them together are.

    See `MakeTemplate`: the chunks are iterated only if there are words.
    """
    return ValueRanges(template, lambda kind: kind.kind == "U", path, "PCD").template(chunks)


def write_pcd(
    template: PointCloud, count: int, chunks: Iterable[PointCloud], file: BinaryIO, path: str
) -> None:
    """Write a PCD file. What was compressed becomes binary.

    Parameters
    ----------
    template, count, chunks, file, path
        See `WriteChunks`.

    Raises
    ------
    CloudFileError
        A column holds words, or two columns would get the same name.
    InvalidInputError
        The chunks hold something else than the template.
    """
    layout = template.layout if isinstance(template.layout, PcdLayout) else _NEW
    described = _described(template, layout, path)
    fields = tuple(field for field, _ in described)
    header = layout.header
    as_text = header.encoding == "ascii"
    shape = (header.width, header.height) if header.n_points == count else (count, 1)
    header = replace(
        header,
        fields=fields,
        width=shape[0],
        height=shape[1],
        encoding="ascii" if as_text else "binary",
        comments=template.comments,
    )
    file.write(bytes(header))
    old = [field.name for field in layout.header.fields]
    is_alike = [field.name for field in fields[: len(old)]] == old
    types = {name: values.dtype for name, values in number_columns(template, path, "PCD").items()}
    for chunk in chunks:
        own = chunk.layout if isinstance(chunk.layout, PcdLayout) else _NEW
        part = described
        if chunk is not template:
            verbatim = own.verbatim if own.columns == layout.columns else {}
            same = replace(chunk, position_type=template.position_type)
            part = _described(same, replace(layout, verbatim=verbatim), path, types)
            check_alike(template, _in_words(described), chunk, _in_words(part))
        odd_words = own.odd_words if is_alike else {}
        write_fields(file, fields, [values for _, values in part], as_text, odd_words)


def lost_in_pcd(cloud: PointCloud) -> list[str]:
    """Say what of a cloud a PCD file would not keep."""
    return lost_besides(cloud, PcdLayout) + lost_columns(cloud)


_NEW = PcdLayout(
    PcdHeader(tuple(PcdField(name, np.dtype("<f8")) for name in "xyz"), width=0),
    (("x",), ("y",), ("z",)),
    {},
    {},
)
"""Layout of a cloud that did not come from a PCD file: its positions come first."""


def _described(
    cloud: PointCloud, layout: PcdLayout, path: str, types: Types = NO_TYPES
) -> Described:
    """Fields of a file and their values, (n, count): those that it had, then new ones."""
    columns = number_columns(cloud, path, "PCD", types)
    position_type = written_position_type(cloud)
    columns |= zip("xyz", cloud.points.T.astype(position_type), strict=False)
    if any("z" in held for held in layout.columns):
        columns.setdefault("z", np.zeros(len(cloud), position_type))
    described = list(_old_fields(layout, columns, len(cloud)))
    return described + list(_new_fields(columns, [field.name for field, _ in described], path))


def _in_words(described: Described) -> list[str]:
    return [f"{field.name} ({field.count} {field.dtype})" for field, _ in described]


def _old_fields(
    layout: PcdLayout, columns: Columns, n_points: int
) -> Iterator[tuple[PcdField, npt.NDArray[Any]]]:
    """Fields of the file whose columns are all there still; these are taken out of the columns."""
    for rank, (field, held) in enumerate(zip(layout.header.fields, layout.columns, strict=True)):
        verbatim = layout.verbatim.get(rank)
        if verbatim is not None and len(verbatim) != n_points:
            verbatim = None
        if not held:
            if verbatim is not None:
                yield field, verbatim
            continue
        found = [columns[name] for name in held if name in columns]
        if len(found) < len(held):
            continue
        if field.name in PACKED and len(held) > 1:
            if any(values.dtype != np.uint8 for values in found):
                continue
            values = _packed(found, verbatim).view(field.dtype)
        else:
            values = np.stack(found, axis=1)
            if field.dtype.kind == "f" and held[0] not in ("x", "y", "z"):
                values = values.astype(field.dtype)
        for name in held:
            del columns[name]
        yield PcdField(field.name, values.dtype.newbyteorder("<"), field.count), values


def _packed(
    parts: Sequence[npt.NDArray[Any]], verbatim: npt.NDArray[Any] | None = None
) -> npt.NDArray[np.uint8]:
    """Bytes of a packed color, (n, 4), blue first; what has no column is as it was, or 0."""
    packed = np.zeros((len(parts[0]), 4), np.uint8) if verbatim is None else bytes_of(verbatim)
    for rank, part in enumerate(parts):
        packed[:, rank] = part
    return packed


def _new_fields(
    columns: Columns, taken: Sequence[str], path: str
) -> Iterator[tuple[PcdField, npt.NDArray[Any]]]:
    """Fields for columns that the file did not have; colors of bytes are packed into one."""
    used = set(taken)
    colors = [columns[name] for name in COLORS if name in columns]
    if len(colors) == len(COLORS) and all(values.dtype == np.uint8 for values in colors):
        yield _NEW_COLOR, _packed(colors[::-1]).view(_NEW_COLOR.dtype)
        columns = {name: values for name, values in columns.items() if name not in COLORS}
    for name, values in columns.items():
        field = plain_ascii(_NORMAL_FIELDS.get(name, name))
        if field in used:
            raise CloudFileError(
                path, f"two columns would be called '{field}'", "rename one of them"
            )
        used.add(field)
        yield PcdField(field, values.dtype.newbyteorder("<")), values[:, None]
