"""PCD, the format of the Point Cloud Library: every field of the file is kept."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS, NORMALS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.axis_names import normals_among
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_columns import lost_columns, number_columns, plain_ascii
from pcsmooth.formats.pcd.header import PADDING, PcdField, PcdHeader, parse_header
from pcsmooth.formats.pcd.points import read_fields, write_fields
from pcsmooth.formats.position_type import written_position_type
from pcsmooth.formats.typed_rows import OddWords

Columns = dict[str, npt.NDArray[Any]]

#: What normals are called in a new file.
_NORMAL_FIELDS = dict(zip(NORMALS, ("normal_x", "normal_y", "normal_z"), strict=True))

#: Fields that hold the bytes of a color in one number, and the columns for these, blue first.
_PACKED = {"rgb": COLORS[::-1], "rgba": (*COLORS[::-1], "alpha")}
_NEW_COLOR = PcdField("rgb", np.dtype("<f4"))


@dataclass(frozen=True)
class PcdLayout:
    """What a PCD file holds besides its points, and how its fields became columns.

    Attributes
    ----------
    header : PcdHeader
        The header as read.
    columns : tuple of tuple of str
        For each field the columns that hold it: one for each item or, of packed colors, for each
        byte; positions under ``x``, ``y``, ``z``; none for padding.
    verbatim : mapping of int to ndarray, each of shape (n, count)
        The values of fields that the columns do not hold in full, by the rank of the field:
        padding and packed colors.
    odd_words : dict
        Numbers that are not finite as text spells them, as `read_fields` gives them.
    """

    header: PcdHeader
    columns: tuple[tuple[str, ...], ...]
    verbatim: Mapping[int, npt.NDArray[Any]]
    odd_words: OddWords

    @property
    def format(self) -> str:
        """Name of the format."""
        return "pcd"

    @property
    def besides(self) -> list[str]:
        """The organisation in rows and the viewpoint, in words."""
        return [] if self.header.is_plain else ["width, height and viewpoint of the PCD file"]


def read_pcd(data: bytes, path: str, dim: int | None) -> PointCloud:
    """Read a PCD file.

    Parameters
    ----------
    data : bytes
        The whole file.
    path : str
        Name of the file in errors.
    dim : {2, 3} or None
        Number of coordinates; None takes three if the file has a ``z``.

    Returns
    -------
    PointCloud
        Row i is point i. Fields of several items become several columns, ``name_0`` and so on;
        normals are called ``nx ny nz``; packed colors become red, green and blue. Fields of no
        item are left out, with a warning.

    Raises
    ------
    CloudFileError
        Not PCD, damaged, cut short, or without positions.
    """
    header, size = parse_header(data, path)
    fields, odd_words = read_fields(data[size:], header, path)
    axes = _axes(header.fields, path, dim)
    packed = _packed_field(header.fields)
    names = _Names(header.fields, axes)

    columns: Columns = {}
    owners: list[tuple[str, ...]] = []
    verbatim: dict[int, npt.NDArray[Any]] = {}
    for rank, (field, values) in enumerate(zip(header.fields, fields, strict=True)):
        if field.name == PADDING:
            verbatim[rank] = values
            owners.append(())
        elif rank == packed:
            verbatim[rank] = values
            held = _PACKED[field.name]
            parts = dict(zip(held, _bytes_of(values).T, strict=False))
            columns.update((name, parts[name]) for name in (*COLORS, "alpha") if name in parts)
            names.taken.update(columns)
            owners.append(held)
        elif axes.get(field.name) == rank:
            owners.append((field.name,))
        else:
            held = names.of(field)
            columns.update(
                (name, np.ascontiguousarray(items))
                for name, items in zip(held, values.T, strict=True)
            )
            owners.append(held)
    positions = [fields[rank][:, 0] for rank in axes.values()]
    with np.errstate(invalid="ignore"):  # NaN of all kinds
        points = np.stack(positions, axis=1).astype(np.float64)
    return PointCloud(
        points=points,
        columns=columns,
        position_type=np.result_type(*positions),
        comments=header.comments,
        layout=PcdLayout(header, tuple(owners), verbatim, odd_words),
        warnings=tuple(
            f"field '{excerpt(name)}' has COUNT 0 and is left out" for name in header.empty
        ),
    )


def write_pcd(cloud: PointCloud, file: BinaryIO, path: str) -> None:
    """Write a PCD file, in the layout of the PCD file that the cloud came from, if any.

    Parameters
    ----------
    cloud : PointCloud
        What to write. What was compressed becomes binary.
    file : binary file
        Open for writing.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        A column holds words, or two columns would get the same name.
    """
    layout = cloud.layout if isinstance(cloud.layout, PcdLayout) else _new_layout(cloud)
    columns = number_columns(cloud, path, "PCD")
    position_type = written_position_type(cloud)
    columns |= zip("xyz", cloud.points.T.astype(position_type), strict=False)
    if any("z" in held for held in layout.columns):
        columns.setdefault("z", np.zeros(len(cloud), position_type))
    described = list(_old_fields(layout, columns, len(cloud)))
    described += _new_fields(columns, [field.name for field, _ in described], path)

    header = layout.header
    as_text = header.encoding == "ascii"
    shape = (header.width, header.height) if header.n_points == len(cloud) else (len(cloud), 1)
    fields = [field for field, _ in described]
    header = replace(
        header,
        fields=tuple(fields),
        width=shape[0],
        height=shape[1],
        encoding="ascii" if as_text else "binary",
        comments=cloud.comments,
    )
    file.write(bytes(header))
    old = [field.name for field in layout.header.fields]
    is_alike = [field.name for field in fields[: len(old)]] == old
    odd_words = layout.odd_words if is_alike else {}
    write_fields(file, fields, [values for _, values in described], as_text, odd_words)


def lost_in_pcd(cloud: PointCloud) -> list[str]:
    """Say what of a cloud a PCD file would not keep."""
    return lost_besides(cloud, PcdLayout) + lost_columns(cloud)


def _new_layout(cloud: PointCloud) -> PcdLayout:
    """Layout of a cloud that did not come from a PCD file: its positions come first."""
    axes = tuple(PcdField(name, np.dtype("<f8")) for name in "xyz")
    header = PcdHeader(axes, width=len(cloud))
    return PcdLayout(header, tuple((field.name,) for field in axes), {}, {})


def _axes(fields: Sequence[PcdField], path: str, dim: int | None) -> dict[str, int]:
    """Ranks of the fields that hold positions, by name."""
    ranks: dict[str, int] = {}
    for rank, field in enumerate(fields):
        if field.count == 1:
            ranks.setdefault(field.name, rank)
    for name in "xy":
        if name not in ranks:
            raise CloudFileError(path, f"it has no field '{name}'", "export it with x and y")
    if dim == 3 and "z" not in ranks:
        raise CloudFileError(path, "it has no field 'z'", "read it as a 2D cloud")
    return {name: ranks[name] for name in ("xy" if dim == 2 else "xyz") if name in ranks}


def _packed_field(fields: Sequence[PcdField]) -> int | None:
    """Rank of the field whose bytes are a color, unless fields have the names of its columns."""
    names = [field.name for field in fields]
    for rank, field in enumerate(fields):
        if field.name in _PACKED and field.size == 4 and field.count == 1:
            return None if set(_PACKED["rgba"]) & set(names) else rank
    return None


def _bytes_of(values: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """Parts of numbers of 4 bytes, lowest first: (n, 1) -> (n, 4)."""
    return np.ascontiguousarray(values).view(np.uint8).copy()


class _Names:
    """Gives the columns of fields names unlike those of any other column and field."""

    def __init__(self, fields: Sequence[PcdField], axes: Iterable[str]) -> None:
        self.taken = set(axes)
        self._fields = {field.name for field in fields}
        self._normals = normals_among(field.name for field in fields if field.count == 1)
        self._next = defaultdict[str, int](lambda: 2)

    def of(self, field: PcdField) -> tuple[str, ...]:
        name = field.name
        if field.count == 1:
            return (self._unlike(self._normals.get(name, name)),)
        return tuple(self._unlike(f"{name}_{item}", self._fields) for item in range(field.count))

    def _unlike(self, wanted: str, others: Set[str] = frozenset()) -> str:
        name = wanted
        while name in self.taken or name in others:
            name = f"{wanted}_{self._next[wanted]}"
            self._next[wanted] += 1
        self.taken.add(name)
        return name


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
        if field.name in _PACKED and len(held) > 1:
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
    packed = np.zeros((len(parts[0]), 4), np.uint8) if verbatim is None else _bytes_of(verbatim)
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
