"""Meshes in text: the lines of the vertices are points, every other line stays as it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS, NORMALS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.coordinates import split_coordinates, three_coordinates
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_text import is_value, parsed, spelled
from pcsmooth.formats.position_type import written_position_type

Words = npt.NDArray[np.str_]

#: No number needs more characters; in a column every word takes the place of the longest.
_LONGEST_WORD = 32


@dataclass(frozen=True)
class VertexLines:
    """A mesh in text, line by line.

    Attributes
    ----------
    format : str
        Name of the format.
    lines : tuple of bytes
        Every line of the file, without its newline.
    rows : tuple of int
        Indices of the lines that hold the vertices.
    names : tuple of str or None
        Columns that follow the coordinates in these lines; None if they are not alike, so that
        what follows stays as it is.
    normal_rows : tuple of int
        Indices of the lines that hold the normals of the vertices, if there are such.
    n_frame : int
        Number of lines that any file of the format has.
    """

    format: str
    lines: tuple[bytes, ...]
    rows: tuple[int, ...]
    names: tuple[str, ...] | None
    normal_rows: tuple[int, ...] = ()
    n_frame: int = 0

    @property
    def besides(self) -> list[str]:
        """The lines that are no vertices, in words."""
        used = sum(bool(line.strip()) for line in self.lines) - self.n_frame
        faces = f"faces and all but the vertices of the {self.format.upper()} file"
        return [faces] if used > len(self.rows) + len(self.normal_rows) else []


def read_vertices(
    lines: Sequence[bytes],
    rows: Sequence[int],
    first: int,
    names_of: Callable[[int], tuple[str, ...] | None],
    path: str,
) -> tuple[npt.NDArray[np.float64], dict[str, Words], tuple[str, ...] | None]:
    """Read the lines of vertices.

    Parameters
    ----------
    lines : sequence of bytes
        Every line of the file.
    rows : sequence of int
        Indices of those of the vertices.
    first : int
        Words before the coordinates.
    names_of : callable
        Names of so many numbers after the coordinates; None if they mean nothing known.
    path : str
        Name of the file in errors.

    Returns
    -------
    xyz : ndarray, shape (n, 3)
        Coordinates.
    columns : dict of str to ndarray of str, each of shape (n,)
        The words after them, by name.
    names : tuple of str or None
        Their names; None if the lines are not alike, or without known meaning.

    Raises
    ------
    CloudFileError
        A line has fewer than three coordinates, or one that is not a number; names the line.
    """
    fields = [words_of(lines[row])[first:] for row in rows]
    widths = {len(words) - 3 for words in fields}
    try:
        axes = [[words[axis] for words in fields] for axis in range(3)]
        xyz = np.stack([parsed(words) for words in axes], axis=1)
    except (ValueError, IndexError) as error:
        row, words = next(
            (row, words[:3])
            for row, words in zip(rows, fields, strict=True)
            if len(words) < 3 or not all(map(is_value, words[:3]))
        )
        raise CloudFileError(
            path,
            f"line {row + 1}: '{excerpt(' '.join(words))}' is not three coordinates",
            "correct the line or export it again",
        ) from error
    names = names_of(widths.pop()) if len(widths) == 1 else (None if widths else ())
    columns = word_columns(names, [words[3:] for words in fields]) if names else {}
    return xyz, columns or {}, None if columns is None else names


def word_columns(names: Sequence[str], rows: Sequence[Sequence[str]]) -> dict[str, Words] | None:
    """Words of each row as columns; None if a word is not held as it is, or by all for one."""
    words = [word for row in rows for word in row]
    if any(len(word) > _LONGEST_WORD or "\0" in word for word in words):
        return None
    return {name: np.array(words[rank :: len(names)]) for rank, name in enumerate(names)}


def vertex_cloud(
    xyz: npt.NDArray[np.float64],
    columns: Mapping[str, npt.NDArray[Any]],
    dim: int | None,
    layout: object,
) -> PointCloud:
    """Make a cloud of the vertices of a mesh; in 2D the third coordinate is a column."""
    points, height = split_coordinates(xyz, dim)
    return PointCloud(points, {**height, **columns}, layout=layout)


def own_lines(cloud: PointCloud, format_name: str) -> VertexLines | None:
    """Layout of the file of this format that the cloud came from, if it has as many points."""
    layout = cloud.layout
    if isinstance(layout, VertexLines) and layout.format == format_name:
        return layout if len(layout.rows) == len(cloud) else None
    return None


def names_after(cloud: PointCloud, layout: VertexLines | None) -> tuple[str, ...]:
    """Names of the columns that a line gets after the coordinates: those it had, or a color."""
    colors = COLORS if all(name in cloud.columns for name in COLORS) else ()
    if layout is None or layout.names == ():
        return colors
    return tuple(name for name in layout.names or () if name in cloud.columns)


def columns_after(
    cloud: PointCloud,
    layout: VertexLines | None,
    as_numbers: Callable[[str, npt.NDArray[Any]], npt.NDArray[Any]],
) -> list[npt.NDArray[Any]]:
    """Columns that stand behind the positions: words of the file's own as they are spelled."""
    names = names_after(cloud, layout)
    own = layout is not None and layout.names == names
    return [
        column if own and column.dtype.kind == "U" else as_numbers(name, column)
        for name, column in ((name, cloud.columns[name]) for name in names)
    ]


def lost_in_lines(cloud: PointCloud, format_name: str) -> list[str]:
    """Say what of a cloud a mesh of this format would not keep.

    Parameters
    ----------
    cloud : PointCloud
        What would be written.
    format_name : str
        Name of the format.

    Returns
    -------
    list of str
        Phrases; empty if all is kept.
    """
    layout = own_lines(cloud, format_name)
    kept = {"z", *names_after(cloud, layout)}
    lost = lost_besides(cloud, VertexLines)
    if layout is not None:
        kept.update(NORMALS if layout.normal_rows else ())
    elif isinstance(cloud.layout, VertexLines):
        lost += cloud.layout.besides
    lost += [f"column '{name}'" for name in cloud.columns if name not in kept]
    if cloud.comments:
        lost.append("the comments")
    if cloud.fixed_marks is not None:
        lost.append("the marks of fixed points")
    return lost


def with_vertices(
    layout: VertexLines, cloud: PointCloud, head: str, columns: Sequence[npt.NDArray[Any]]
) -> list[bytes]:
    """Every line of the file, those of the vertices from a cloud.

    Parameters
    ----------
    layout : VertexLines
        The file.
    cloud : PointCloud
        As many points as it has vertices.
    head : str
        What stands before the coordinates, with a space after it.
    columns : sequence of ndarray, shape (n,)
        Numbers and words to stand after them. Where the lines of the file are not alike, what
        stood there stays.

    Returns
    -------
    list of bytes
    """
    lines = list(layout.lines)
    first = len(head.split()) + 3
    xyz = three_coordinates(cloud)
    odd_points = {*np.flatnonzero(~np.isfinite(xyz).all(axis=1)).tolist()}
    for point, (row, words) in enumerate(
        zip(layout.rows, vertex_words(cloud, columns), strict=True)
    ):
        old = lines[row]
        if point in odd_points:
            words = _as_spelled(words, words_of(old)[first - 3 :], xyz[point].tolist())
        new = [f"{head}{words}".encode(), *(old.split()[first:] if layout.names is None else ())]
        margin = old[: len(old) - len(old.lstrip())]
        lines[row] = margin + b" ".join(new) + end_of(old)
    return lines


def _as_spelled(words: str, old: Sequence[str], xyz: Sequence[float]) -> str:
    """Spell coordinates that are not finite as they were, where they still are what they were."""
    spelling = words.split(" ")
    for axis, (word, value) in enumerate(zip(old, xyz, strict=False)):
        if not math.isfinite(value) and np.array_equal(parsed([word]), [value], equal_nan=True):
            spelling[axis] = word
    return " ".join(spelling)


def words_of(line: bytes) -> list[str]:
    """Split a line at ASCII blanks alone, where lines that are kept are split too."""
    return [word.decode("utf-8", "replace") for word in line.split()]


def end_of(line: bytes) -> bytes:
    """Return what stands between a line and its newline in files of Windows."""
    return b"\r" if line.endswith(b"\r") else b""


def vertex_words(cloud: PointCloud, columns: Sequence[npt.NDArray[Any]]) -> list[str]:
    """Coordinates and columns of each point, as they stand in a line."""
    xyz = three_coordinates(cloud).astype(written_position_type(cloud))
    return list(map(" ".join, zip(*map(spelled, [*xyz.T, *columns]), strict=True)))
