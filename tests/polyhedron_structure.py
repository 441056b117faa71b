"""What holds of every polyhedron in the arrays of `pcsmooth.kernels.cells.convex_polyhedron`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from kernels.alone import alone
from oracles import Array, assert_close
from pcsmooth.kernels.polyhedra.facet_sums import AREA, MX, MZ, facet_table, sum_over_facets

facet_table, sum_over_facets = alone(facet_table), alone(sum_over_facets)


Numbers = npt.NDArray[np.int64]


def assert_consistent(planes: Numbers, across: Numbers) -> None:
    """Edges have two ends that agree, facets one closed boundary, and Euler's formula holds."""
    n = planes.shape[1]
    facets = np.unique(planes)
    assert n == 2 * len(facets) - 4
    ends = {}  # by directed edge: the vertex that it runs to, and the one it comes from
    for t in range(n):
        assert len(set(planes[:, t])) == 3
        for e in range(3):
            edge = int(planes[e, t]), int(planes[(e + 1) % 3, t])
            assert edge not in ends
            ends[edge] = t, int(across[e, t])
    assert len(ends) == 3 * n
    for (a, b), (t, q) in ends.items():
        assert ends[b, a] == (q, t)
    for facet in facets:
        leaves_for = {q: t for (a, _), (t, q) in ends.items() if a == facet}
        start = place = next(iter(leaves_for))
        for step in range(1, len(leaves_for) + 1):
            place = leaves_for[place]
            assert (place == start) == (step == len(leaves_for))


def assert_placed(
    vertices: Array, planes: Numbers, normals: Array, offsets: Array, tolerance: float
) -> None:
    """Every vertex lies on its planes, which are in counter-clockwise order, and beyond none.

    Normals are (3, F); planes that are nowhere in `planes` do not count.
    """
    excess = normals.T @ vertices - offsets[:, np.newaxis]
    on_planes = np.take_along_axis(excess, planes, axis=0)
    np.testing.assert_allclose(on_planes, 0, atol=tolerance)
    assert excess[np.unique(planes)].max() <= tolerance
    turns = np.linalg.det(normals[:, planes].transpose(2, 1, 0))
    assert turns.min() > -tolerance


def facet_sums(
    vertices: Array, planes: Numbers, across: Numbers, normals: Array, offsets: Array
) -> tuple[float, Array]:
    """Volume and areas of all facets; the first moments are checked on the way."""
    table = facet_table(normals, offsets, len(offsets))
    sum_over_facets(vertices, planes, across, vertices.shape[1], len(offsets), table)
    volume = float(table[AREA] @ offsets) / 3
    # The integral of n x^T over the boundary is the volume times the unit matrix.
    size = float(np.abs(vertices).max(initial=0.0)) ** 3
    assert_close(normals @ table[MX : MZ + 1].T, volume * np.eye(3), 1e-11, size)
    return volume, table[AREA]
