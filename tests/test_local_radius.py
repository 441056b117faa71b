"""Shapes of local radius from end to end: as far apart as points are, so large are they."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from oracles import Array
from pcsmooth import (
    Balls,
    CloudFileError,
    EulerFlow,
    Filter,
    ImplicitFlow,
    InvalidInputError,
    PointCloud,
    Polyhedra,
    denoise,
    denoise_file,
    estimate_curvature,
    local_spacings,
    measure_polyhedra,
    write_cloud,
)
from pcsmooth.bodies.generators import platonic

ROUND = platonic(12)

METHODS: dict[str, Any] = {
    "filter": Filter(radius="local"),
    "euler": EulerFlow(shapes=Balls(radius="local"), iterations=2),
    "wide": EulerFlow(shapes=Balls(radius="local:3x"), iterations=2),
    "area": EulerFlow(shapes=Balls(radius="local", quantity="area"), iterations=4),
    "boundary": EulerFlow(shapes=Balls(radius="local", weight="boundary"), iterations=2),
    "plain": EulerFlow(shapes=Balls(radius="local", weight="none"), iterations=2),
    "order 1": ImplicitFlow(shapes=Balls(radius="local"), order=1),
    "order 2": ImplicitFlow(shapes=Balls(radius="local", weight="boundary")),
    "plain order 1": ImplicitFlow(shapes=Balls(radius="local", weight="none"), order=1),
    "exact": EulerFlow(shapes=Polyhedra(body=ROUND, radius="local"), iterations=2),
    "naive": EulerFlow(shapes=Polyhedra(body=ROUND, radius="local", union="naive"), iterations=2),
    "complex": EulerFlow(
        shapes=Polyhedra(body=ROUND, radius="local", union="inclusion-exclusion"), iterations=2
    ),
    "polyhedra, order 1": ImplicitFlow(shapes=Polyhedra(body=ROUND, radius="local", union="naive")),
}
every_method = pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)


def uneven_sphere(n: int, variation: float, seed: int = 0) -> tuple[Array, Array]:
    """Points on a unit sphere that are so many times farther apart at the bottom than at the top.

    Returns them and the true spacing of each, but for a factor.
    """
    rng = np.random.default_rng(seed)
    heights = np.linspace(-1, 1, 4001)
    spacings = variation ** (-0.5 * heights)
    below = np.cumsum(spacings**-2)
    z = np.interp((np.arange(n) + rng.random(n)) / n, below / below[-1], heights)
    angles = rng.uniform(0, 2 * np.pi, n)
    across = np.sqrt(1 - z * z)
    points = np.c_[across * np.cos(angles), across * np.sin(angles), z]
    return points, variation ** (-0.5 * z)


def noisy(points: Array, spacings: Array, share: float = 0.3) -> Array:
    """Move points of a unit sphere along its normal by a share of their spacing."""
    noise = np.random.default_rng(9).normal(size=len(points))
    return points * (1 + share * spacings * noise)[:, np.newaxis]


@pytest.fixture(scope="module")
def cloud() -> Array:
    points, _ = uneven_sphere(1500, 4.0)
    return noisy(points, local_spacings(points))


def roughness(points: Array, start: Array) -> Array:
    """Distance of each point to a surface of revolution that is near the unit sphere."""
    heights = start[:, 2]
    radii = np.linalg.norm(points, axis=1)
    return np.asarray(radii - np.polyval(np.polyfit(heights, radii, 3), heights))


def enclosed(points: Array, start: Array) -> float:
    """Volume in units of the unit ball's, each point having the square of its spacing."""
    return float(
        np.average(np.linalg.norm(points, axis=1) ** 3, weights=local_spacings(start) ** 2)
    )


@every_method
def test_noise_goes_where_points_are_near_and_where_they_are_far(method: Any, cloud: Array) -> None:
    result = denoise(cloud, method)
    assert result.radii is not None
    multiple = 3.0 if "3x" in str(method.shapes.radius) else 2.0
    np.testing.assert_allclose(result.radii, multiple * local_spacings(cloud), rtol=1e-12)
    assert result.radius == pytest.approx(np.median(result.radii), rel=1e-12)
    before, after = roughness(cloud, cloud), roughness(result.points, cloud)
    low, high = np.quantile(result.radii, (0.3, 0.7))
    near = after[result.radii < low].std() / before[result.radii < low].std()
    far = after[result.radii > high].std() / before[result.radii > high].std()
    assert max(near, far) < (0.95 if method.shapes.quantity == "area" else 0.75)
    assert 0.6 < near / far < 1.5


@every_method
@pytest.mark.parametrize("change", ["scale", "move", "permute"])
def test_result_goes_with_the_cloud(method: Any, change: str, cloud: Array) -> None:
    order = np.random.default_rng(3).permutation(len(cloud))
    act: Callable[[Array], Array] = {
        "scale": lambda points: 0.125 * points,
        "move": lambda points: points + np.array([300.0, -20.0, 7.0]),
        "permute": lambda points: points[order],
    }[change]
    found, expected = denoise(act(cloud), method), denoise(cloud, method)
    normals = expected.normals
    if change == "permute":
        assert found.points.tobytes() == act(expected.points).tobytes()
        assert found.normals.tobytes() == act(normals).tobytes()
        return
    size = 0.125 if change == "scale" else 1.0
    np.testing.assert_allclose(found.points, act(expected.points), rtol=0, atol=1e-8)
    np.testing.assert_allclose(found.radius, size * expected.radius, rtol=1e-9)
    agreement = np.abs(np.einsum("ij,ij->i", found.normals, normals))
    assert np.quantile(agreement, 0.01) > 1 - 1e-6


@every_method
def test_coincident_points_stay_together(method: Any, cloud: Array) -> None:
    doubled = np.concatenate([cloud, cloud[:200]])
    found = denoise(doubled, method)
    assert found.points[-200:].tobytes() == found.points[:200].tobytes()
    assert found.radii is not None
    assert np.all(found.radii[-200:] == found.radii[:200])
    if method.name == "euler":
        alone = denoise(cloud, method)
        np.testing.assert_allclose(found.points[:1500], alone.points, rtol=0, atol=1e-9)


def test_rows_that_are_not_finite_have_no_radius(cloud: Array) -> None:
    points = cloud.copy()
    points[7] = np.nan
    radii = denoise(points, METHODS["euler"]).radii
    assert radii is not None
    assert np.flatnonzero(radii == 0.0).tolist() == [7]


@pytest.mark.parametrize("keep", [{"keep_volume": True}, {"motion": "normal"}], ids=str)
def test_restrained_motion(keep: Any, cloud: Array) -> None:
    result = denoise(cloud, METHODS["euler"], **keep)
    free = denoise(cloud, METHODS["euler"])
    assert roughness(result.points, cloud).std() < 0.75 * roughness(cloud, cloud).std()
    before = enclosed(cloud, cloud)
    if "keep_volume" in keep:
        assert abs(enclosed(result.points, cloud) / before - 1) < 0.002
        assert enclosed(free.points, cloud) / before < 0.98


def test_curves() -> None:
    angle = np.cumsum(np.r_[np.full(100, 1.0), np.full(300, 0.2), np.full(100, 1.0)])
    angle *= 2 * np.pi / angle[-1]
    circle = np.c_[np.cos(angle), np.sin(angle)]
    estimate = estimate_curvature(circle, radius="local")
    assert np.quantile(np.abs(estimate.mean_curvature - 1), 0.95) < 0.02
    result = denoise(noisy(circle, local_spacings(circle)), METHODS["euler"])
    assert np.abs(np.linalg.norm(result.points, axis=1) - 1).mean() < 0.02


# --- normals and curvatures


def test_curvature_of_a_sphere_whose_points_are_twenty_times_as_far_apart() -> None:
    points, _ = uneven_sphere(20_000, 20.0)
    estimate = estimate_curvature(points, radius="local")
    errors = np.abs(estimate.mean_curvature - 1)
    assert np.median(errors) < 0.01
    # In each fifth of the height, where there are far fewer points at the bottom, too.
    for part in range(5):
        inside = np.floor(2.5 * (points[:, 2] + 1)) == part
        assert np.median(errors[inside]) < 0.02
    agreement = np.einsum("ij,ij->i", estimate.normals, points)
    assert np.quantile(agreement, 0.01) > np.cos(np.radians(3.0))
    spacings = local_spacings(points)
    assert estimate.radius == pytest.approx(2.0 * np.median(spacings))
    # Where the bands of radii meet nothing jumps: neighbours differ as little as elsewhere.
    bands = np.floor(2.0 * np.log2(spacings / spacings.min()))
    nearest = cKDTree(points).query(points, 2)[1][:, 1]
    steps = np.abs(estimate.mean_curvature - estimate.mean_curvature[nearest])
    across = bands != bands[nearest]
    assert np.median(steps[across]) < 3.0 * np.median(steps[~across])


def scan_lines(across: float, n: int = 4000, noise: float = 0.5) -> Array:
    """A plane in lines that are so many times farther apart than the points on them."""
    rng = np.random.default_rng(7)
    lines = int(np.sqrt(n / across))
    along = np.arange(n // lines)
    x, y = np.meshgrid(along, across * np.arange(lines))
    shifts = rng.uniform(-0.3, 0.3, x.size)
    return np.asarray(np.c_[x.ravel() + shifts, y.ravel(), noise * rng.normal(size=x.size)])


@pytest.mark.parametrize("across", [10.0, 20.0])
def test_normals_of_scan_lines(across: float) -> None:
    points = scan_lines(across)
    for found in (
        estimate_curvature(points, radius="local", orient="direction=0,0,1"),
        denoise(points, METHODS["euler"], orient="direction=0,0,1").curvature,
    ):
        assert np.mean(found.normals[:, 2] > np.cos(np.radians(5.0))) > 0.99
        assert np.median(np.abs(found.mean_curvature)) < 0.02 / across


def test_normals_of_the_ground_around_a_station() -> None:
    # A scanner 2 m above flat ground; noise of 0.5 mm and 0.05 % of the range, along the beam.
    angles = np.meshgrid(np.linspace(np.arctan(0.05), np.pi / 4, 80), np.linspace(0, 0.6, 80))
    down, around = (each.ravel() for each in angles)
    ranges = 2.0 / np.sin(down)
    ranges += (0.0005 + 0.0005 * ranges) * np.random.default_rng(7).normal(size=len(ranges))
    flat = ranges * np.cos(down)
    points = np.c_[flat * np.cos(around), flat * np.sin(around), 2.0 - ranges * np.sin(down)]
    spacings = local_spacings(points)
    assert spacings.max() > 50 * spacings.min()
    counts = cKDTree(points).query_ball_point(points, 3 * spacings, return_length=True) - 1
    estimate = estimate_curvature(points, radius="local", orient="direction=0,0,1")
    is_up = estimate.normals[:, 2] > np.cos(np.radians(10.0))
    assert np.mean(is_up[counts >= 8]) > 0.99


@pytest.mark.parametrize("union", ["naive", "inclusion-exclusion", "exact"])
def test_polyhedra_leave_normals_and_curvatures_to_balls_of_their_radii(
    union: Any, cloud: Array
) -> None:
    shapes = Polyhedra(body=ROUND, radius="local:3x", union=union)
    found = denoise(cloud, EulerFlow(shapes=shapes, iterations=0))
    expected = denoise(cloud, EulerFlow(shapes=Balls(radius="local:3x"), iterations=0))
    for name in ("normals", "mean_curvature", "confidence"):
        values = getattr(found.curvature, name)
        assert values.tobytes() == getattr(expected.curvature, name).tobytes()
    volume = measure_polyhedra(cloud, 3 * local_spacings(cloud), ROUND, union).volume
    assert found.history[0].volume == pytest.approx(volume, rel=1e-12)


# --- what cannot have it


def test_automatic_differentiation_has_one_radius() -> None:
    message = r"^gradient is 'autodiff', which is for shapes of one radius, and the radius is 'lo"
    with pytest.raises(InvalidInputError, match=message):
        Balls(radius="local", gradient="autodiff")


def test_implicit_steps_on_the_area_have_one_radius() -> None:
    message = r"^the energy is area and the scheme is implicit, for which shapes need one radius"
    with pytest.raises(InvalidInputError, match=message):
        ImplicitFlow(shapes=Balls(radius="local", quantity="area"))


def test_a_report_tells_of_all_radii(cloud: Array, tmp_path: Path) -> None:
    source = tmp_path / "cloud.ply"
    write_cloud(PointCloud(cloud), source)
    report = denoise_file(source, tmp_path / "out.ply", METHODS["euler"])
    assert report.radius_range is not None
    assert report.sparse_share is None
    assert report.radius_range[0] < report.radius < report.radius_range[1]
    assert (
        b"radius=%.9g,%.9g,%.9g " % (report.radius, *report.radius_range)
        in (tmp_path / "out.ply").read_bytes()
    )


@pytest.mark.parametrize(
    ("method", "what"), [("exact", "a local radius"), ("polyhedra, order 1", "an implicit step")]
)
def test_polyhedra_of_local_radius_need_the_whole_cloud(
    method: str, what: str, cloud: Array, tmp_path: Path
) -> None:
    source = tmp_path / "cloud.ply"
    write_cloud(PointCloud(cloud), source)
    with pytest.raises(CloudFileError, match=f"{what} .*needs the whole cloud"):
        denoise_file(source, tmp_path / "out.ply", METHODS[method], tile=200)


def test_an_automatic_radius_is_local_where_one_would_be_too_small(tmp_path: Path) -> None:
    points = scan_lines(10.0)
    found = denoise(points, Filter(), orient="direction=0,0,1")
    expected = denoise(points, METHODS["filter"], orient="direction=0,0,1")
    assert found.radii is not None
    assert found.normals.tobytes() == expected.normals.tobytes()
    assert denoise(points, EulerFlow(iterations=0)).radii is None
    write_cloud(PointCloud(points), tmp_path / "lines.ply")
    report = denoise_file(tmp_path / "lines.ply", tmp_path / "out.ply")
    assert report.sparse_share == 1.0
    assert report.as_json()["sparse_share"] == 1.0


def test_an_automatic_radius_is_one_where_it_is_large_enough() -> None:
    even, _ = uneven_sphere(4000, 1.0001)
    stray = np.r_[even, np.random.default_rng(1).uniform(-1.5, 1.5, (400, 3))]
    thick = even * (1 + 0.05 * np.random.default_rng(2).normal(size=(len(even), 1)))
    for points in (even, stray, thick, noisy(even, local_spacings(even))):
        assert denoise(points).radii is None
        one = estimate_curvature(points)
        assert one.radius == pytest.approx(2.0 * one.spacing)


@pytest.mark.parametrize("count", [1, 3])
def test_one_place_has_no_spacing(count: int) -> None:
    with pytest.raises(InvalidInputError, match="which has no spacing; give the radius as a leng"):
        denoise(np.ones((count, 3)), METHODS["euler"])
    with pytest.raises(InvalidInputError, match="which has no spacing; give the radius as a leng"):
        estimate_curvature(np.ones((count, 3)), radius="local")
