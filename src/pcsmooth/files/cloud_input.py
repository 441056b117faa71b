"""A cloud of a file, in memory or cut into tiles, as a cloud in parts and piece by piece again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.orientation import Orientation
from pcsmooth.errors import CloudFileError, NoFinitePointError
from pcsmooth.estimating import given_normals
from pcsmooth.files.output_columns import normals_of
from pcsmooth.files.taking_part import PointCounts, TakingPart
from pcsmooth.formats import CloudChunks
from pcsmooth.formats.unchanged import Unchanged
from pcsmooth.methods.estimate import Estimate
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Parts
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import usable_rows
from pcsmooth.progress import Callback, ignore
from pcsmooth.tiling.column_store import FileColumn
from pcsmooth.tiling.cutting import Piece, Source, cut_cloud
from pcsmooth.tiling.input_order import in_input_order
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.tile_store import TileStore
from pcsmooth.tiling.tiled_cloud import TiledCloud

#: Rows that are read and written at a time.
ROWS = 1 << 20


@dataclass(frozen=True, eq=False)
class InputPiece:
    """Consecutive rows of the input.

    Attributes
    ----------
    cloud : PointCloud
        As they came.
    finite : ndarray of bool, shape (n,)
        Which of them took part.
    places : ndarray of int, shape (m,)
        These, in some order.
    rows : mapping of str to ndarray, or structured ndarray, shape (m,)
        What there is of each of these.
    """

    cloud: PointCloud
    finite: npt.NDArray[np.bool_]
    places: npt.NDArray[np.int64]
    rows: Mapping[str, npt.NDArray[Any]] | npt.NDArray[np.void]


def no_rows(template: PointCloud, columns: Mapping[str, Column]) -> InputPiece:
    """Make a piece without rows, of a template without its points."""
    none = np.empty(0, np.int64)
    rows = {name: column.read(0, 0) for name, column in columns.items()}
    return InputPiece(template, none != 0, none, rows)


class CloudInput(Protocol):
    """A cloud of a file."""

    @property
    def name(self) -> str:
        """The file, in messages."""

    @property
    def template(self) -> PointCloud:
        """The cloud, perhaps without its points."""

    @property
    def count(self) -> int:
        """Number of rows."""

    @property
    def dimension(self) -> int:
        """Number of coordinates."""

    @property
    def is_whole(self) -> bool:
        """Whether it is in memory."""

    def parts(self, estimate: Estimate, roles: TakingPart, callback: Callback = ignore) -> Parts:
        """Give the finite points in parts.

        Parameters
        ----------
        estimate : Estimate
            How normals are found, in which those of the file may have a say.
        roles : TakingPart
            Which points do not take part or stay.
        callback : callable
            Told how far each stage is, from now on.
        """

    def pieces(self, columns: Mapping[str, Column]) -> Iterator[InputPiece]:
        """Give all rows in their order, with what columns hold of their points; more than once.

        The columns are the same at each call.
        """

    @property
    def counts(self) -> PointCounts:
        """How many rows take part in what way, once there are parts, or there is no such row."""

    def check(self) -> None:
        """Raise `CloudFileError` if the file is no longer what it was."""


def parts_selected(
    source: CloudInput, estimate: Estimate, roles: TakingPart, callback: Callback
) -> Parts:
    """Give the finite points of a cloud in parts: see `CloudInput.parts`.

    Raises
    ------
    CloudFileError
        None takes part, as none is selected.
    """
    try:
        return source.parts(estimate, roles, callback)
    except NoFinitePointError:
        roles.check_selected(source.counts)
        raise


def input_normals(
    cloud: PointCloud, orientation: Orientation, name: str
) -> npt.NDArray[np.float64] | None:
    """Read the normals of the input, if it has any.

    Raises
    ------
    CloudFileError
        If it has none and normals are to be oriented by them.
    """
    normals = normals_of(cloud)
    if normals is None and orientation.rule == "input":
        columns = " ".join(("nx", "ny", "nz")[: cloud.dimension])
        raise CloudFileError(
            name, f"it has no normals {columns} to orient by", "choose another --orient"
        )
    return normals


@dataclass(eq=False)
class WholeInput:
    """A cloud in memory (see `CloudInput`), of which there is one piece.

    Attributes
    ----------
    name : str
        The file, in messages.
    template : PointCloud
        The cloud.
    """

    name: str
    template: PointCloud
    is_whole: bool = field(default=True, init=False)
    counts: PointCounts = field(default_factory=PointCounts, init=False)

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.template)

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return self.template.dimension

    def parts(
        self, estimate: Estimate, roles: TakingPart, callback: Callback = ignore
    ) -> WholeCloud:
        """Take the finite points in order."""
        cloud = self.template
        selected = roles.selected(cloud)
        self.counts = PointCounts()
        self.counts.add(cloud, selected, roles.ignores_others)
        fixed = roles.fixed(cloud, selected)
        normals = input_normals(cloud, estimate.orientation, self.name)
        positions = roles.positions(cloud, selected)
        given = given_normals(normals, positions.shape, estimate.orientation)
        self._finite = usable_rows(positions)
        self._cloud = WholeCloud.of(
            positions, self._finite, fixed=fixed, given=given, callback=callback
        )
        return self._cloud

    def pieces(self, columns: Mapping[str, Column]) -> Iterator[InputPiece]:
        """Give the cloud."""
        rows = {name: column.read(0, column.rows) for name, column in columns.items()}
        yield InputPiece(self.template, self._finite, self._cloud.input_rows, rows)

    def check(self) -> None:
        """Do nothing: it has been read."""


@dataclass(eq=False)
class TiledInput:
    """A cloud that is cut into tiles (see `CloudInput`), and read piece by piece.

    Attributes
    ----------
    name : str
        The file.
    chunks : CloudChunks
        The same, open.
    folder : Path
        Gets the tiles.
    tile_points : int
        Most points of a tile.
    runner : Runner
        Works on them.
    ignores_marks : bool
        Whether points that the file calls noise take part.
    """

    name: str
    chunks: CloudChunks
    folder: Path
    tile_points: int
    runner: Runner
    ignores_marks: bool
    is_whole: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        """Remember what the file is."""
        self._unchanged = Unchanged(self.name)
        self._callback: Callback = ignore
        self.counts = PointCounts()
        self._roles = TakingPart(self.name)
        self._ordered: FileColumn | None = None

    @property
    def template(self) -> PointCloud:
        """The cloud without its points."""
        return self.chunks.template

    @property
    def count(self) -> int:
        """Number of rows."""
        return self.chunks.count

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return self.chunks.dimension

    def read(self, columns: bool = True) -> Iterator[PointCloud]:
        """Read all rows, with or without their columns."""
        clouds = self.chunks.read(ROWS, columns)
        return map(PointCloud.without_marks, clouds) if self.ignores_marks else clouds

    def parts(
        self, estimate: Estimate, roles: TakingPart, callback: Callback = ignore
    ) -> TiledCloud:
        """Cut the finite points into tiles."""
        self._callback = callback
        self._roles = roles
        source = self._source(estimate.orientation)
        self._store: TileStore = cut_cloud(source, self.folder, self.tile_points, callback)
        return TiledCloud(self._store, self.runner, callback)

    def pieces(self, columns: Mapping[str, Column]) -> Iterator[InputPiece]:
        """Read the rows again, with what has been put in their order."""
        if self._ordered is None:
            self._ordered = in_input_order(self._store, columns, self._callback)
        return self._pieces(self._ordered)

    def _pieces(self, ordered: FileColumn) -> Iterator[InputPiece]:
        start = 0
        for cloud in self.read():
            finite = self._roles.usable(cloud)
            places = np.flatnonzero(finite)
            yield InputPiece(cloud, finite, places, ordered.read(start, start + len(places)))
            start += len(places)

    def check(self) -> None:
        """Raise `CloudFileError` if the file is no longer what it was."""
        self._unchanged.check()

    def _source(self, orientation: Orientation) -> Source:
        """Give positions, fixed points and normals of the file, piece by piece."""
        name, roles = self.name, self._roles
        # Columns that there are not become an error before any is read.
        roles.fixed(self.template, roles.selected(self.template))
        has_normals = input_normals(self.template, orientation, name) is not None
        has_normals &= orientation.rule in ("input", "auto")

        def positions() -> Iterator[npt.NDArray[np.float64]]:
            self.counts = PointCounts()
            for cloud in self.read(columns=roles.needs_columns):
                selected = roles.selected(cloud) if roles.ignores_others else None
                self.counts.add(cloud, selected, roles.ignores_others)
                yield roles.positions(cloud, selected)

        has_columns = has_normals or roles.fixed_column is not None or roles.selection is not None

        def pieces() -> Iterator[Piece]:
            self.counts = PointCounts()
            first = 0
            for cloud in self.read(columns=has_columns):
                selected = roles.selected(cloud)
                self.counts.add(cloud, selected, roles.ignores_others)
                normals = None
                if has_normals:
                    normals = given_normals(
                        input_normals(cloud, orientation, name),
                        cloud.points.shape,
                        orientation,
                    )
                active = roles.positions(cloud, selected)
                yield Piece(active, roles.fixed(cloud, selected, first), normals)
                first += len(cloud)

        return Source(self.count, self.dimension, has_normals, positions, pieces)
