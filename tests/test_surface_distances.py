"""The measures of the quality benchmark, against hand-computed values and brute force."""

import numpy as np
import numpy.typing as npt
import pytest
from mesh_shapes import Shape
from shape_keeping import distances_along
from surface_distances import (
    chamfer_distance,
    distances_to_mesh,
    normals_of_mesh,
    point_to_mesh_distance,
    signed_distances_to_mesh,
    squared_distances,
    squared_distances_to_points,
)

Array = npt.NDArray[np.float64]

TRIANGLE = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]])

OCTAHEDRON = np.concatenate([np.eye(3), -np.eye(3)])
SIDES = np.array(
    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
)


def sampled_distance(point: Array, triangle: Array, steps: int = 400) -> float:
    """Least distance to a fine grid of points of the triangle."""
    first, second = np.meshgrid(*[np.linspace(0.0, 1.0, steps)] * 2)
    inside = first + second <= 1.0
    u, v = first[inside][:, np.newaxis], second[inside][:, np.newaxis]
    points = (1.0 - u - v) * triangle[0] + u * triangle[1] + v * triangle[2]
    return float(np.linalg.norm(points - point, axis=1).min())


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((1.0, 1.0, 2.0), 4.0),  # above the inside
        ((1.0, -2.0, 0.0), 4.0),  # beyond an edge, in the plane
        ((4.0, 4.0, 1.0), 9.0),  # beyond the longest edge, whose middle is (2, 2, 0)
        ((-1.0, -1.0, 1.0), 3.0),  # beyond a corner
        ((2.0, 2.0, 0.0), 0.0),  # on an edge
    ],
)
def test_squared_distance_to_a_triangle(point: tuple[float, ...], expected: float) -> None:
    found = squared_distances(np.array([point]), TRIANGLE[np.newaxis])
    assert found == pytest.approx([expected], abs=1e-12)


def test_squared_distances_to_random_triangles() -> None:
    rng = np.random.default_rng(0)
    points, triangles = rng.normal(size=(40, 3)), rng.normal(size=(40, 3, 3))
    expected = list(map(sampled_distance, points, triangles))
    found = np.sqrt(squared_distances(points, triangles))
    assert np.all(found <= np.array(expected) + 1e-12)
    assert found == pytest.approx(expected, abs=0.02)


def test_triangle_without_area_is_a_segment() -> None:
    segment = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]]])
    assert squared_distances(np.array([[3.0, 1.0, 0.0]]), segment) == pytest.approx([2.0])


def test_nearest_points_of_triangles() -> None:
    rng = np.random.default_rng(1)
    points = rng.normal(size=(300, 3))
    triangles = rng.normal(size=(50, 1, 3)) + rng.normal(scale=0.7, size=(50, 3, 3))
    every = [
        squared_distances(points, np.broadcast_to(triangle, (300, 3, 3))).min()
        for triangle in triangles
    ]
    assert squared_distances_to_points(triangles, points) == pytest.approx(every)


def test_chamfer_distance_by_hand() -> None:
    """In the unit sphere of the clean cloud, which has radius 2, all lengths are halved."""
    clean = np.array([[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    points = np.array([[-2.0, 1.0, 0.0], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0]])
    there, back = (0.5**2 + 0.0 + 1.5**2) / 3, (0.5**2 + 0.0) / 2
    assert chamfer_distance(points, clean) == pytest.approx(there + back)


def test_chamfer_distance_by_brute_force() -> None:
    rng = np.random.default_rng(2)
    clean, points = rng.normal(size=(60, 3)), 5.0 + rng.normal(size=(80, 3))
    center = 0.5 * (clean.min(axis=0) + clean.max(axis=0))
    radius = np.linalg.norm(clean - center, axis=1).max()
    squares = np.sum((points[:, np.newaxis] - clean) ** 2, axis=2) / radius**2
    expected = squares.min(axis=1).mean() + squares.min(axis=0).mean()
    assert chamfer_distance(points, clean) == pytest.approx(expected)


def test_distances_to_an_octahedron() -> None:
    pytest.importorskip("point_cloud_utils")
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    expected = [1.0 / np.sqrt(3.0), 1.0, 2.0 / np.sqrt(3.0)]
    assert distances_to_mesh(points, OCTAHEDRON, SIDES) == pytest.approx(expected, rel=1e-6)
    signed = [-expected[0], *expected[1:]]
    assert signed_distances_to_mesh(points, OCTAHEDRON, SIDES) == pytest.approx(signed, rel=1e-6)


def test_point_to_mesh_distance_by_brute_force() -> None:
    pytest.importorskip("point_cloud_utils")
    rng = np.random.default_rng(3)
    points = rng.normal(size=(30, 3))
    shift = np.array([3.0, -2.0, 7.0])
    pairs = np.array(
        [
            squared_distances(points, np.broadcast_to(triangle, (30, 3, 3)))
            for triangle in OCTAHEDRON[SIDES]
        ]
    )
    expected = pairs.min(axis=0).mean() + pairs.min(axis=1).mean()
    found = point_to_mesh_distance(2.0 * points + shift, 2.0 * OCTAHEDRON + shift, SIDES)
    assert found == pytest.approx(expected, rel=1e-6)


def test_normals_of_an_octahedron() -> None:
    pytest.importorskip("point_cloud_utils")
    outward = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, -1.0]])
    found = normals_of_mesh(0.4 * outward, OCTAHEDRON, SIDES)
    assert found == pytest.approx(outward / np.sqrt(3.0))


def test_holes_along_a_surface() -> None:
    """Lowering is no hole, sliding is, and the other side of the shape fills none."""
    pytest.importorskip("point_cloud_utils")
    pytest.importorskip("trimesh")
    shape = Shape("octahedron", OCTAHEDRON, SIDES)
    normal, along = np.ones(3) / np.sqrt(3.0), np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    sites = np.array([np.ones(3) / 3.0, -np.ones(3) / 3.0])
    clean = np.repeat(sites, 8, axis=0) + 1e-9 * np.arange(16.0)[:, np.newaxis] * along
    for lowered, slid in ((0.1, 0.0), (0.0, 0.1), (0.05, 0.1)):
        moved = clean - lowered * np.sign(clean[:, 2:]) * normal + slid * along
        found = distances_along(moved, clean, shape, spacing=0.5)
        assert found == pytest.approx(np.full(16, slid), abs=1e-7)
