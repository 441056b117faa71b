"""Clouds that are read and written piece by piece, compared with all at once."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.files.output_columns import with_estimates
from pcsmooth.formats import Naming, open_chunks, read_cloud, write_chunks, write_cloud

Dim = Literal["auto", 2, 3]
Change = Callable[[PointCloud], PointCloud]


def saved(folder: Path, data: bytes, suffix: str = "ply") -> Path:
    path = folder / f"in.{suffix}"
    path.write_bytes(data)
    return path


def part_of(cloud: PointCloud, rows: slice) -> PointCloud:
    """Some points of a cloud."""
    return replace(
        cloud,
        points=cloud.points[rows],
        columns={name: values[rows] for name, values in cloud.columns.items()},
        fixed_marks=None if cloud.fixed_marks is None else cloud.fixed_marks[rows],
    )


def pieces(cloud: PointCloud, rows: int) -> Iterator[PointCloud]:
    """Cut a cloud."""
    return (part_of(cloud, slice(row, row + rows)) for row in range(0, len(cloud), rows))


def joined(chunks: Iterator[PointCloud], template: PointCloud) -> PointCloud:
    parts = [template, *chunks]
    return replace(
        template,
        points=np.concatenate([part.points for part in parts]),
        columns={
            name: np.concatenate([part.columns[name] for part in parts])
            for name in template.columns
        },
        fixed_marks=None
        if template.fixed_marks is None
        else np.concatenate([part.fixed_marks for part in parts if part.fixed_marks is not None]),
    )


def assert_same(actual: PointCloud, expected: PointCloud) -> None:
    np.testing.assert_array_equal(actual.points, expected.points)
    assert actual.points.dtype == expected.points.dtype
    assert list(actual.columns) == list(expected.columns)
    for name, column in expected.columns.items():
        found = actual.columns[name]
        assert found.dtype == column.dtype
        if column.dtype != object:
            np.testing.assert_array_equal(found, column)
            continue
        for mine, theirs in zip(found, column, strict=True):
            np.testing.assert_array_equal(mine, theirs)
            assert mine.dtype == theirs.dtype
    assert actual.position_type == expected.position_type
    assert actual.comments == expected.comments
    assert actual.warnings == expected.warnings
    np.testing.assert_array_equal(actual.fixed_marks, expected.fixed_marks)


def unchanged(cloud: PointCloud) -> PointCloud:
    return cloud


def modified(cloud: PointCloud) -> PointCloud:
    """Move the points, drop a column and add others, row by row."""
    with np.errstate(all="ignore"):
        return replace(
            cloud,
            points=cloud.points * 0.9 + 0.3,
            columns={
                **dict(list(cloud.columns.items())[1:]),
                "quality": cloud.points.sum(axis=1).astype(np.float32),
                "marked": cloud.points[:, 0] > 1,
            },
            comments=(*cloud.comments, "modified"),
        )


def estimated(cloud: PointCloud, naming: Naming = "ply") -> PointCloud:
    """Add all columns of estimates, as the commands do."""
    n = len(cloud)
    normals = np.zeros((n, 3))
    normals[:, 2] = 1
    first = cloud.points[:, 0]
    estimate = CurvatureEstimate(
        normals, first, first**2, np.stack([first, -first], axis=1), np.ones(n),
        1.0, 1.0, 9.0, 9.0, {}, np.ones(n, bool),
    )  # fmt: skip
    return with_estimates(
        replace(cloud, position_type=np.dtype(np.float32)),
        cloud.points + 0.1,
        estimate,
        displacement=first / 3,
        outliers=first > 2,
        colors=np.full((n, 3), 7, np.uint8),
        naming=naming,
        provenance="0.1 test",
        color_note="mean",
    ).cloud


def check_reading(path: Path, rows: int, dim: Dim = "auto") -> None:
    """Compare both ways to read a file."""
    expected = read_cloud(path, dim=dim)
    with open_chunks(path, dim) as chunks:
        assert (chunks.name, chunks.count) == (str(path), len(expected))
        assert chunks.dimension == expected.dimension
        assert_same(joined(chunks.read(rows), chunks.template), expected)
        parts = list(chunks.read(rows, columns=False))
        assert all(part.columns == {} for part in parts)
        assert all(len(part) == rows for part in parts[:-1])
        empty = replace(chunks.template, columns={})
        assert_same(joined(iter(parts), empty), replace(expected, columns={}))


def check(path: Path, rows: int, dim: Dim, change: Change = modified) -> None:
    """Compare both ways to read a file, and to write it again."""
    check_reading(path, rows, dim)
    whole, target = io.BytesIO(), path.with_name(f"chunks{path.suffix}")
    write_cloud(change(read_cloud(path, dim=dim)), whole, format=path.suffix[1:])
    with open_chunks(path, dim) as chunks:
        write_chunks(target, change(chunks.template), chunks.count, map(change, chunks.read(rows)))
    assert target.read_bytes() == whole.getvalue()
