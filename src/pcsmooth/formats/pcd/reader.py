"""PCD, the format of the Point Cloud Library: every field of the file is kept."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence, Set
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.axis_names import normals_among
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.cloud_file import CloudChunks, CloudFile, FileAtOnce
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.pcd.header import PADDING, PcdField, PcdHeader, read_header
from pcsmooth.formats.pcd.layout import PACKED, PcdLayout, bytes_of
from pcsmooth.formats.pcd.points import FieldValues, PcdRows, no_fields, unpacked_fields
from pcsmooth.formats.typed_rows import OddWords


def open_pcd(source: ByteSource, dim: int | None) -> CloudFile:
    """Open a PCD file.

    Row i is point i. Fields of several items become several columns, ``name_0`` and so on; normals
    are called ``nx ny nz``; packed colors become red, green and blue. Fields of no item are left
    out, with a warning.

    Parameters
    ----------
    source : ByteSource
        The file.
    dim : {2, 3} or None
        Number of coordinates; None takes three if the file has a ``z``.

    Raises
    ------
    CloudFileError
        Not PCD, damaged, cut short, or without positions.
    """
    header, size = read_header(source)
    if header.encoding != "binary_compressed":
        return PcdChunks(source, header, size, dim)

    def read(data: bytes) -> PointCloud:
        fields = unpacked_fields(data[size:], header, source.path)
        return _Columns(header, source.path, dim).cloud(fields, {})

    return FileAtOnce(source, read, "one compressed stream")


class PcdChunks(CloudChunks):
    """The points of a PCD file that is not compressed; see `open_pcd`."""

    def __init__(self, source: ByteSource, header: PcdHeader, size: int, dim: int | None) -> None:
        super().__init__(source)
        self._rows = PcdRows(source, size, header)
        self._columns = _Columns(header, self.name, dim)
        self.count = header.n_points

    @cached_property
    def template(self) -> PointCloud:
        """The cloud without its points."""
        return self._columns.cloud(no_fields(self._columns.header), {})

    def _clouds(self, rows: int, columns: bool) -> Iterator[PointCloud]:
        for fields, odd_words in self._rows.read(rows):
            yield self._columns.cloud(fields, odd_words, columns)


class _Columns:
    """The columns that the fields of a file become."""

    def __init__(self, header: PcdHeader, path: str, dim: int | None) -> None:
        self.header = header
        self._axes = _axes(header.fields, path, dim)
        self._packed = _packed_field(header.fields)
        self._owners = tuple(self._owners_of(header.fields))

    def _owners_of(self, fields: Sequence[PcdField]) -> Iterator[tuple[str, ...]]:
        """Columns that hold each field."""
        names = _Names(fields, self._axes)
        for rank, field in enumerate(fields):
            if field.name == PADDING:
                yield ()
            elif rank == self._packed:
                names.taken.update(PACKED[field.name])
                yield PACKED[field.name]
            elif self._axes.get(field.name) == rank:
                yield (field.name,)
            else:
                yield names.of(field)

    def cloud(self, fields: FieldValues, odd_words: OddWords, columns: bool = True) -> PointCloud:
        """Make a cloud of the fields of some points, with its columns or without."""
        found: dict[str, npt.NDArray[Any]] = {}
        verbatim: dict[int, npt.NDArray[Any]] = {}
        for rank, (held, values) in enumerate(zip(self._owners, fields, strict=True)):
            if not columns or rank in self._axes.values():
                continue
            if not held or rank == self._packed:
                verbatim[rank] = values
            if rank == self._packed:
                parts = dict(zip(held, bytes_of(values).T, strict=False))
                found.update((name, parts[name]) for name in (*COLORS, "alpha") if name in parts)
            elif held:
                items = map(np.ascontiguousarray, values.T)
                found.update(zip(held, items, strict=True))
        positions = [fields[rank][:, 0] for rank in self._axes.values()]
        with np.errstate(invalid="ignore"):  # NaN of all kinds
            points = np.stack(positions, axis=1).astype(np.float64)
        return PointCloud(
            points=points,
            columns=found,
            position_type=np.result_type(*positions),
            comments=self.header.comments,
            layout=PcdLayout(self.header, self._owners, verbatim, odd_words),
            warnings=tuple(
                f"field '{excerpt(name)}' has COUNT 0 and is left out" for name in self.header.empty
            ),
        )


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
        if field.name in PACKED and field.size == 4 and field.count == 1:
            return None if set(PACKED["rgba"]) & set(names) else rank
    return None


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
