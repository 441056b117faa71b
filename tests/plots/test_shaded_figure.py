"""Surfaces shaded: what is seen, how bright it is, which part is shown."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.errors import InvalidInputError
from pcsmooth.plots.rough_normals import rough_normals
from pcsmooth.plots.shaded_figure import shaded_figure
from pcsmooth.plots.shading import lit, occlusion
from pcsmooth.plots.splats import Frame, splat
from pcsmooth.plots.views import View

pytest.importorskip("matplotlib")

Floats = npt.NDArray[np.float64]

RNG = np.random.default_rng(3)
TOP = View(90, -90)


def sphere(n: int, noise: float = 0.0) -> Floats:
    points = RNG.normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points * (1.0 + noise * RNG.normal(size=(n, 1)))


def test_the_nearest_point_is_seen() -> None:
    frame = Frame(np.zeros(2), np.array([4.0, 2.0]), 4, 2)
    points = np.array([[0.5, 0.5, 1.0], [0.6, 0.4, 3.0], [0.4, 0.6, 2.0], [3.5, 1.5, 0.0]])
    nearest, depth = splat(points, frame, 1.0)
    assert nearest.tolist() == [[1, -1, -1, -1], [-1, -1, -1, 3]]
    assert depth[0, 0] == 3.0
    assert np.isnan(depth[0, 1])


def test_disks_have_their_diameter_and_hide_what_is_behind() -> None:
    frame = Frame(np.zeros(2), np.full(2, 21.0), 21, 21)
    points = np.array([[10.5, 10.5, 0.0], [13.5, 10.5, 1.0]])
    nearest, _ = splat(points, frame, 9.0)
    seen = np.hypot(*(np.indices((21, 21)) - 10)) <= 4.5
    other = np.hypot(*(np.indices((21, 21)) - np.array([10, 13])[:, None, None])) <= 4.5
    np.testing.assert_array_equal(nearest == 1, other)
    np.testing.assert_array_equal(nearest == 0, seen & ~other)


def test_disks_that_reach_over_the_border_are_cut() -> None:
    frame = Frame(np.zeros(2), np.full(2, 4.0), 4, 4)
    nearest, _ = splat(np.array([[-0.5, 1.5, 0.0]]), frame, 5.0)
    assert (nearest[:, 0] == 0).any()
    assert (nearest[:, 3] == -1).all()


def test_light_falls_from_the_left_above_on_both_sides() -> None:
    left, right, up = [-1.0, 0.0, 0.2], [1.0, 0.0, 0.2], [0.0, 1.0, 0.2]
    normals = np.array([left, right, up, [0, -1.0, 0.2]])
    bright = lit(normals / np.linalg.norm(normals, axis=1, keepdims=True))
    assert bright[0] > bright[1]
    assert bright[2] > bright[3]
    np.testing.assert_array_equal(lit(-normals), lit(normals))
    assert ((bright >= 0.25) & (bright <= 1.0)).all()


def test_hollows_are_darker_and_single_points_throw_no_shadow() -> None:
    depth = np.zeros((60, 60))
    depth[:, 30:] = -20.0
    depth[10, 10] = 500.0
    light = occlusion(depth, 1.0, 4.0)
    assert light[40, 10] == pytest.approx(1.0, abs=1e-3)  # far from the step
    assert light[40, 31] < 0.6  # below it
    assert light[40, 29] == pytest.approx(1.0)  # above it
    assert light[12, 12] == pytest.approx(1.0, abs=1e-3)
    depth[5, 5] = np.nan
    assert np.isnan(occlusion(depth, 1.0, 4.0)[5, 5])
    assert np.isnan(occlusion(np.full((3, 3), np.nan), 1.0, 4.0)).all()


def test_rough_normals_are_those_of_planes_through_few_points() -> None:
    plane = np.c_[RNG.uniform(size=(300, 2)), np.zeros(300)]
    np.testing.assert_allclose(np.abs(rough_normals(plane)), [[0, 0, 1]] * 300, atol=1e-7)
    clean, noisy = sphere(2000), sphere(2000, 0.05)
    for points, most in ((clean, 0.05), (noisy, 1.0)):
        away = points / np.linalg.norm(points, axis=1, keepdims=True)
        off = 1.0 - np.abs(np.sum(away * rough_normals(points), axis=1))
        assert off.mean() < most
    assert off.mean() > 0.1  # noise is seen
    assert not rough_normals(plane[:2]).any()


def images(before: Floats, after: Floats, normals: Floats) -> list[Floats]:
    figure = shaded_figure(before, after, normals, TOP)
    shown: list[Any] = [axes.images[0].get_array() for axes in figure.axes[:4]]
    return [np.ma.filled(image, np.nan) for image in shown]


def test_after_is_even_where_before_is_rough() -> None:
    after = np.c_[RNG.uniform(size=(20_000, 2)), np.zeros(20_000)]
    before = after + [0.0, 0.0, 0.004] * RNG.normal(size=after.shape)
    rough, smooth, rough_part, smooth_part = images(before, after, np.tile([0, 0, 1], (20_000, 1)))
    assert rough.shape == smooth.shape  # from the same side, in the same frame
    for one, other in ((rough, smooth), (rough_part, smooth_part)):
        steps = [np.nanmean(np.abs(np.diff(image, axis=0))) for image in (one, other)]
        assert steps[0] > 10 * steps[1]


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((1, 3)),
        np.zeros((5, 3)),
        np.c_[np.arange(9.0), np.zeros((9, 2))],
        np.vstack([sphere(500) + np.array([5e5, 5e6, 0]), [[np.nan, 0, 0], [9e9, 0, 0]]]),
    ],
    ids=["one point", "one place", "a line", "far away with strays"],
)
def test_whatever_the_cloud(points: Floats) -> None:
    figure = shaded_figure(points, points, np.zeros_like(points), TOP)
    figure.canvas.draw()
    assert len(figure.axes) == 5


def test_strays_do_not_make_the_view_small() -> None:
    points = np.vstack([sphere(2000), [[1e4, 0, 0]]])
    whole = images(points, points, np.vstack([sphere(2000), [[0, 0, 1]]]))[1]
    assert np.isfinite(whole).mean() > 0.4  # one part in 50,000 if the stray were in it


@pytest.mark.parametrize(
    ("before", "after", "cause"),
    [
        (sphere(9), sphere(8), "only the same points"),
        (sphere(9)[:, :2], sphere(9)[:, :2], "only the same points"),
        (np.full((2, 3), np.nan), np.zeros((2, 3)), "no point with finite"),
    ],
)
def test_what_cannot_be_shaded(before: Floats, after: Floats, cause: str) -> None:
    with pytest.raises(InvalidInputError, match=cause):
        shaded_figure(before, after, after, TOP)
