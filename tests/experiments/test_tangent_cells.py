"""Voronoi cells in tangent planes."""

from __future__ import annotations

import numpy as np
import pytest

from pcsmooth_experiments.sampled_shapes import SampledShape, torus
from pcsmooth_experiments.theory.tangent_cells import tangent_cells


def almost_flat(flat: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> SampledShape:
    """Points of a vertical plane far from the axis, whose meridians are vertical."""
    points = np.c_[np.full(len(flat), 1e6), flat]
    normals = np.tile([1.0, 0.0, 0.0], (len(flat), 1))
    return SampledShape(points, normals, np.zeros((len(flat), 2)))


@pytest.mark.parametrize("angle", [0.0, 0.4])
@pytest.mark.parametrize("basis", [[[1.0, 0], [0, 1.6]], [[1.0, 0], [0.5, np.sqrt(3) / 2]]])
def test_cells_of_lattices(basis: list[list[float]], angle: float) -> None:
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    flat = (np.indices((15, 15)).reshape(2, -1).T - 7) @ np.array(basis) @ turn
    found = tangent_cells(almost_flat(flat), np.array([7 * 15 + 7]))
    assert abs(found.centroids).max() < 1e-6
    assert found.edge_shares[0] == pytest.approx([1.0, 1.0], abs=1e-6)


def test_a_cell_by_hand() -> None:
    """Neighbours at 1 and 2 along each axis: a rectangle of 1.5 by 1.5, not around its point."""
    near = [[0, 0], [1, 0], [-2, 0], [0, 1], [0, -2]]
    far = [[4 * x, 4 * y] for x in range(-3, 4) for y in range(-3, 4) if x and y]
    flat = np.array(near + far, dtype=float)
    found = tangent_cells(almost_flat(flat), np.array([0]))
    assert found.centroids[0] == pytest.approx([0.0, -0.25, -0.25], abs=1e-6)
    assert found.edge_shares[0] == pytest.approx([1.0, 1.0], abs=1e-6)


def test_shares_add_up_to_two() -> None:
    """The edges' lengths times distances are twice the area, by the divergence theorem."""
    sample = torus(0.4).sample(5000, "random")
    found = tangent_cells(sample, np.arange(100))
    assert found.edge_shares.sum(axis=1) == pytest.approx(np.full(100, 2.0), abs=1e-9)
    assert found.edge_shares[:, 0].std() > 0.05
    assert found.edge_shares[:, 0].mean() == pytest.approx(1.0, abs=0.06)
    across = np.einsum("ij,ij->i", found.centroids, sample.normals[:100])
    assert abs(across).max() < 1e-12
