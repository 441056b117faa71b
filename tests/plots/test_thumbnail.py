"""Small pictures of denoised clouds."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest

from pcsmooth.files.denoise_file import Sample
from pcsmooth.plots.thumbnail import thumbnail

image = pytest.importorskip("matplotlib.image")

RNG = np.random.default_rng(2)
POINTS = RNG.normal(size=(4000, 3)) * [1.0, 2.0, 1.0]
UNIT = POINTS / np.linalg.norm(POINTS, axis=1, keepdims=True)
BALL = UNIT * [1.0, 2.0, 1.0]


def drawn(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    sample = Sample(points, points, normals, np.zeros(len(points)))
    first, again = thumbnail(sample), thumbnail(sample)
    assert first == again
    seen: np.ndarray = image.imread(BytesIO(first))
    return seen


def test_a_surface_is_lit_where_it_is_and_nothing_elsewhere() -> None:
    seen = drawn(BALL, UNIT)
    assert max(seen.shape[:2]) == 240
    height, width = seen.shape[:2]
    assert seen[height // 2, width // 2, 3] == 1.0
    assert seen[0, 0, 3] == 0.0
    assert np.ptp(seen[seen[..., 3] == 1.0][:, 0]) > 0.5


def test_points_without_normals_are_lit_by_planes() -> None:
    normals = UNIT.copy()
    normals[::2] = 0.0
    seen, whole = drawn(BALL, normals), drawn(BALL, UNIT)
    assert seen.shape[:2] == whole.shape[:2]
    known = (seen[..., 3] == 1.0) & (whole[..., 3] == 1.0)
    assert np.median(np.abs(seen - whole)[known][:, 0]) < 0.1


@pytest.mark.parametrize("n", [0, 1, 50])
def test_curves_and_next_to_nothing(n: int) -> None:
    assert drawn(BALL[:n, :2], UNIT[:n, :2]).size > 0
    assert drawn(BALL[:n], UNIT[:n]).size > 0
    assert drawn(np.full((n, 3), np.nan), UNIT[:n]).size > 0
