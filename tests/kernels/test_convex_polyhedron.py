from __future__ import annotations

from math import sqrt

import numpy as np
import numpy.typing as npt
import pytest

import oracles
import polyhedron_oracles as expect
from kernels.alone import alone
from oracles import Array
from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.bodies.generators import platonic, sphere
from pcsmooth.energies.polyhedra.body_tables import body_tables
from pcsmooth.kernels.cells.convex_polyhedron import (
    TORN,
    copy_polyhedron,
    cut_off,
    cut_off_leniently,
    measure_excess,
    polyhedron_arrays,
)
from polyhedron_structure import assert_consistent, assert_placed, facet_sums

copy_polyhedron = alone(copy_polyhedron)
cut_off = alone(cut_off)
cut_off_leniently = alone(cut_off_leniently)
measure_excess = alone(measure_excess)
polyhedron_arrays = alone(polyhedron_arrays)


CUBE, ICOSAHEDRON, SPHERE = platonic(6), platonic(20), sphere(50)

every_body = pytest.mark.parametrize("body", [CUBE, ICOSAHEDRON, SPHERE], ids=repr)


class Workpiece:
    """A body that planes are cut off from, with the planes so far."""

    def __init__(self, body: ConvexBody, cuts: int) -> None:
        tables = body_tables(body, 1.0)
        self.normals, self.offsets = tables.normals, tables.offsets
        self.arrays = polyhedron_arrays(len(self.offsets) + cuts)
        vertices, planes, across, _, _ = self.arrays
        self.n = int(copy_polyhedron(*tables.polyhedron, vertices, planes, across))

    def cut(self, normal: npt.ArrayLike, offset: float, tolerance: float = 0.0) -> int:
        """Cut by a plane with any normal; returns the number of vertices before."""
        length = float(np.linalg.norm(normal))
        unit = np.asarray(normal, float) / length
        vertices, planes, across, excess, first = self.arrays
        before, label = self.n, len(self.offsets)
        x, y, z = unit.tolist()
        largest = measure_excess(vertices, self.n, x, y, z, offset / length, excess)
        assert largest == pytest.approx((unit @ self.vertices - offset / length).max(), abs=1e-14)
        self.n = cut_off_leniently(
            vertices, planes, across, self.n, excess, max(tolerance, 1e-14), label, first
        )
        self.normals = np.c_[self.normals, unit]
        self.offsets = np.r_[self.offsets, offset / length]
        return before

    @property
    def vertices(self) -> Array:
        return np.asarray(self.arrays[0][:, : self.n])

    @property
    def planes(self) -> npt.NDArray[np.int64]:
        return np.asarray(self.arrays[1][:, : self.n])

    @property
    def across(self) -> npt.NDArray[np.int64]:
        return np.asarray(self.arrays[2][:, : self.n])

    def measure(self) -> tuple[float, Array]:
        """Volume and areas of the facets, of a polyhedron whose structure is right."""
        assert_consistent(self.planes, self.across)
        assert_placed(self.vertices, self.planes, self.normals, self.offsets, 1e-12)
        return facet_sums(self.vertices, self.planes, self.across, self.normals, self.offsets)


@pytest.mark.parametrize("seed", range(4))
@every_body
def test_random_planes_leave_the_polyhedron_of_qhull(body: ConvexBody, seed: int) -> None:
    rng = np.random.default_rng(seed)
    piece = Workpiece(body, 8)
    for normal in oracles.random_sphere(8, seed=seed):
        piece.cut(normal, rng.uniform(0.1, 1.1))
        expected = expect.intersect_half_spaces(piece.normals.T, piece.offsets)
        assert expected is not None
        volume, areas = piece.measure()
        assert volume == pytest.approx(expected.volume, rel=1e-12)
        oracles.assert_close(areas, expected.facet_areas, 1e-11)


@every_body
def test_many_planes_that_touch_a_ball(body: ConvexBody) -> None:
    """Each cuts off vertices that earlier ones have made; what they hide leaves no trace."""
    piece = Workpiece(body, 200)
    for normal in np.random.default_rng(7).permutation(oracles.even_sphere(200)):
        piece.cut(normal, 0.7)
    volume, areas = piece.measure()
    assert (areas[: len(body.offsets)] == 0).all()  # 0.7 hides all of the body's own facets
    assert volume == pytest.approx(0.7 * areas.sum() / 3, rel=1e-13)
    assert volume == pytest.approx(oracles.ball_volume(0.7, 3), rel=0.1)
    expected = expect.intersect_half_spaces(piece.normals.T, piece.offsets)
    assert expected is not None
    oracles.assert_close(areas, expected.facet_areas, 1e-10)


@pytest.mark.parametrize(
    ("normal", "offset", "volume", "area", "count"),
    [
        ((1, 1, 1), 1.0, 8 - 4 / 3, 2 * sqrt(3), 7 + 3),  # through three vertices
        ((1, 1, 1), -1.0, 4 / 3, 2 * sqrt(3), 4 + 6),  # the other three: they stay
        ((1, 1, 0), 0.0, 4.0, 4 * sqrt(2), 6 + 4),  # along two edges
        ((-1, 0, 1), 0.0, 4.0, 4 * sqrt(2), 6 + 4),
        ((2, 2, 1), 1.0, 8 - 7 / 3, 4.5, 6 + 4),  # along a diagonal of a facet
        ((0, 1, 0), -1.0, 0.0, 4.0, 4 + 4),  # along a facet, with nothing left but that
        ((1, -1, 0), -2.0, 0.0, 0.0, 2 + 4),  # an edge is left
        ((1, 1, -1), -3.0, 0.0, 0.0, 1 + 3),  # a vertex is left
    ],
)
def test_plane_through_vertices_of_a_cube(
    normal: tuple[int, ...], offset: float, volume: float, area: float, count: int
) -> None:
    piece = Workpiece(CUBE, 1)
    # The plane and the cube, in numbers that are exact: the sums are of whole numbers.
    vertices, planes, across, excess, first = piece.arrays
    x, y, z = map(float, normal)
    measure_excess(vertices, piece.n, x, y, z, offset, excess)
    piece.n = cut_off(vertices, planes, across, piece.n, excess, 0.0, 6, first)
    length = float(np.linalg.norm(normal))
    piece.normals = np.c_[piece.normals, np.divide(normal, length)]
    piece.offsets = np.r_[piece.offsets, offset / length]
    found, areas = piece.measure()
    assert found == pytest.approx(volume, rel=1e-14, abs=1e-15)
    assert areas[6] == pytest.approx(area, rel=1e-14, abs=1e-15)
    assert piece.n == count


@every_body
def test_plane_of_a_facet_or_beyond_cuts_nothing(body: ConvexBody) -> None:
    piece = Workpiece(body, 2 * len(body.offsets))
    volume, _ = piece.measure()
    before = [array[:, : piece.n].copy() for array in piece.arrays[:3]]
    for normal in body.normals:
        assert piece.cut(normal, 1.0, tolerance=1e-13) == piece.n
        assert piece.cut(normal, 1.5) == piece.n
    for array, expected in zip(piece.arrays, before, strict=False):
        np.testing.assert_array_equal(array[:, : piece.n], expected)
    assert volume == pytest.approx(body.volume, rel=1e-13)


@every_body
def test_planes_of_all_facets_again_change_no_measure(body: ConvexBody) -> None:
    """Which vertices each cuts off is up to rounding."""
    piece = Workpiece(body, len(body.offsets))
    for normal in body.normals:
        piece.cut(normal, 1.0)
    volume, areas = piece.measure()
    assert volume == pytest.approx(body.volume, rel=1e-13)
    own, again = areas.reshape(2, -1)
    oracles.assert_close(own + again, body.facet_areas, 1e-12)


@every_body
def test_plane_below_all_vertices_leaves_none(body: ConvexBody) -> None:
    for normal in oracles.random_sphere(10):
        piece = Workpiece(body, 1)
        piece.cut(normal, -2.5)
        assert piece.n == 0
        normals, offsets = piece.normals, piece.offsets
        volume, areas = facet_sums(piece.vertices, piece.planes, piece.across, normals, offsets)
        assert volume == 0
        assert (areas == 0).all()


@pytest.mark.parametrize("count", [1, 2, 3, 5, 7])
def test_vertices_within_the_tolerance_stay_where_they_are(count: int) -> None:
    """The new vertices are at those that stay, lest they leave the body."""
    piece = Workpiece(CUBE, 1)
    vertices, planes, across, excess, first = piece.arrays
    order = np.argsort(piece.vertices.T @ [1.0, 2.0, 4.0])
    staying = {tuple(place) for place in piece.vertices[:, order[:-count]].T}
    excess[order[:-count]] = 9.5
    excess[order[-count:]] = 10.5
    left = cut_off(vertices, planes, across, 8, excess, 10.0, 6, first)
    assert left > len(staying)
    assert_consistent(planes[:, :left], across[:, :left])
    assert {tuple(place) for place in vertices[:, :left].T} == staying


def opposite_corners_of_a_facet(body: ConvexBody) -> list[int]:
    tables = body_tables(body, 1.0)
    around = np.flatnonzero((tables.polyhedron[1] == 0).any(axis=0))
    neighbors = set(tables.polyhedron[2][:, around[0]].tolist())
    return [int(around[0]), next(int(t) for t in around[1:] if int(t) not in neighbors)]


@pytest.mark.parametrize("body", [CUBE, SPHERE], ids=repr)
def test_contradiction_changes_nothing(body: ConvexBody) -> None:
    """Two corners of a facet are beyond the plane, and those between them are not."""
    piece = Workpiece(body, 1)
    vertices, planes, across, excess, first = piece.arrays
    excess[: piece.n] = np.linspace(-1.0, -0.5, piece.n)
    excess[opposite_corners_of_a_facet(body)] = 1e-15, 2e-15
    before = [array[..., : piece.n].copy() for array in (vertices, planes, across, excess)]
    label = len(body.offsets)
    assert cut_off(vertices, planes, across, piece.n, excess, 0.0, label, first) == TORN
    for array, expected in zip((vertices, planes, across, excess), before, strict=True):
        np.testing.assert_array_equal(array[..., : piece.n], expected)
    # With a tolerance that settles it, which is 1.6e-15, the same excess is of use.
    left = cut_off_leniently(vertices, planes, across, piece.n, excess, 1e-16, label, first)
    assert left == piece.n + 2
    assert_consistent(planes[:, :left], across[:, :left])
