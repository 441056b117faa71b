from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.plots.views import View, facing, seen, thinned

RNG = np.random.default_rng(2)


@pytest.mark.parametrize("angles", [(0, 0), (30, -60), (-90, -90), (90, 17), (-12, 200)])
class TestView:
    def test_axes_are_a_right_handed_frame(self, angles: tuple[float, float]) -> None:
        axes = View(*angles).axes
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(axes) == pytest.approx(1.0)
        assert axes[1, 2] >= -1e-12  # z is never down

    def test_the_viewer_is_where_the_angles_say(self, angles: tuple[float, float]) -> None:
        towards = View(*angles).axes[2]
        assert np.degrees(np.arcsin(np.clip(towards[2], -1, 1))) == pytest.approx(angles[0])
        if abs(angles[0]) < 90:
            turn = np.degrees(np.arctan2(towards[1], towards[0]))
            assert (turn - angles[1] + 180.0) % 360.0 == pytest.approx(180.0)

    def test_the_nearest_is_drawn_last(self, angles: tuple[float, float]) -> None:
        points = RNG.normal(size=(50, 3))
        view = View(*angles)
        projected, order = seen(points, view)
        assert (np.diff(points[order] @ view.axes[2]) >= 0.0).all()
        assert sorted(order) == list(range(50))
        between = np.linalg.norm(np.diff(projected, axis=0), axis=1)
        depth = np.diff(points @ view.axes[2])
        np.testing.assert_allclose(
            np.hypot(between, depth), np.linalg.norm(np.diff(points, axis=0), axis=1)
        )


def test_a_plane_curve_is_seen_as_it_is() -> None:
    points = RNG.normal(size=(9, 2))
    projected, order = seen(points, View())
    np.testing.assert_array_equal(projected, points)
    np.testing.assert_array_equal(order, np.arange(9))


class TestFacing:
    @pytest.mark.parametrize(
        ("normal", "expected"),
        [
            ((0.1, 0.0, 0.9), View(90.0, -90.0)),
            ((0.1, 0.2, -0.9), View(-90.0, -90.0)),
            ((1.0, 0.0, 0.0), View(0.0, 0.0)),
            ((0.0, -2.0, 0.0), View(0.0, -90.0)),
            ((1.0, 1.0, 0.0), View(0.0, 45.0)),
        ],
    )
    def test_one_sided(self, normal: tuple[float, float, float], expected: View) -> None:
        normals = np.tile(np.array(normal) / np.linalg.norm(normal), (20, 1))
        normals[3], normals[4] = 0.0, np.nan
        view = facing(normals)
        assert (view.elevation, view.azimuth) == pytest.approx(
            (expected.elevation, expected.azimuth)
        )

    def test_closed_or_unknown(self) -> None:
        around = RNG.normal(size=(500, 3))
        around /= np.linalg.norm(around, axis=1, keepdims=True)
        for normals in (around, np.zeros((5, 3)), np.full((5, 3), np.nan), None):
            assert facing(normals) == View()


@pytest.mark.parametrize(("n", "most"), [(1, 10), (10, 10), (11, 10), (1000, 7), (99_999, 40_000)])
def test_thinning_is_even(n: int, most: int) -> None:
    chosen = thinned(n, most)
    assert len(chosen) == min(n, most)
    assert chosen[0] == 0
    assert chosen[-1] < n
    steps = np.diff(chosen)
    assert len(steps) == 0 or 1 <= steps.min() <= steps.max() <= steps.min() + 1
