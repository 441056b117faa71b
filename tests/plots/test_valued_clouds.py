from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.errors import InvalidInputError
from pcsmooth.plots.valued_clouds import (
    ValuedClouds,
    along_normals,
    by_curvature,
    by_displacement,
    by_distance,
    magnitudes,
    with_values,
)

Points = npt.NDArray[np.float64]


def pair(dimension: int, n: int = 300) -> tuple[Points, Points]:
    rng = np.random.default_rng(dimension)
    before = rng.normal(size=(n, dimension))
    return before, before + rng.normal(scale=0.1, size=before.shape)


def nearest(points: Points, others: Points) -> Points:
    return np.asarray(np.linalg.norm(points[:, None] - others, axis=2).min(axis=1))


def broken(points: Points, *rows: int) -> Points:
    damaged = points.copy()
    damaged[list(rows), 0] = np.nan
    return damaged


@pytest.mark.parametrize("dimension", [2, 3])
class TestDisplacement:
    def test_both_clouds_have_the_lengths_of_the_moves(self, dimension: int) -> None:
        before, after = pair(dimension)
        shown = by_displacement(before, after, ["a", "b"])
        moved = np.sqrt(((after - before) ** 2).sum(axis=1))
        assert [cloud.title for cloud in shown.clouds] == ["a", "b"]
        for cloud, points in zip(shown.clouds, (before, after), strict=True):
            np.testing.assert_allclose(cloud.values, moved)
            np.testing.assert_array_equal(cloud.points, points)
        assert list(shown.distributions) == ["displacement"]
        np.testing.assert_allclose(shown.distributions["displacement"], moved)
        assert shown.limits == pytest.approx((0.0, np.percentile(moved, 98)))
        assert shown.label == "displacement, coordinate units"
        assert (shown.dimension, shown.symbol, shown.colormap) == (dimension, "", "viridis")

    def test_rows_that_are_not_finite_in_both_are_left_out(self, dimension: int) -> None:
        before, after = pair(dimension)
        shown = by_displacement(broken(before, 3, 7), broken(after, 7, 11))
        kept = np.delete(np.arange(300), [3, 7, 11])
        for cloud, points in zip(shown.clouds, (before, after), strict=True):
            assert cloud.left_out == 3
            np.testing.assert_array_equal(cloud.points, points[kept])
        np.testing.assert_allclose(
            shown.distributions["displacement"],
            np.linalg.norm(after - before, axis=1)[kept],
        )

    def test_other_rows_need_distances(self, dimension: int) -> None:
        before, after = pair(dimension)
        with pytest.raises(InvalidInputError, match=r"299 points .* 300 .*--color-by distance"):
            by_displacement(before, after[1:])

    def test_nothing_finite(self, dimension: int) -> None:
        before, after = pair(dimension, 2)
        with pytest.raises(InvalidInputError, match="no point with finite"):
            by_displacement(broken(before, 0), broken(after, 1))

    def test_no_move_has_a_scale_too(self, dimension: int) -> None:
        before, _ = pair(dimension)
        assert by_displacement(before, before).limits == (0.0, 1.0)
        after = before.copy()
        after[5, 0] += 2.0
        assert by_displacement(before, after).limits == pytest.approx((0.0, 2.0))


@pytest.mark.parametrize("dimension", [2, 3])
class TestDistance:
    def test_to_each_other(self, dimension: int) -> None:
        before, after = pair(dimension)
        after = after[:120]
        shown = by_distance(broken(before, 4), after)
        kept = np.delete(before, 4, axis=0)
        np.testing.assert_allclose(shown.clouds[0].values, nearest(kept, after))
        np.testing.assert_allclose(shown.clouds[1].values, nearest(after, kept))
        assert [cloud.left_out for cloud in shown.clouds] == [1, 0]
        assert shown.label == "distance to the other cloud, coordinate units"
        assert list(shown.distributions) == ["before", "after"]

    def test_to_a_reference(self, dimension: int) -> None:
        before, after = pair(dimension)
        reference, _ = pair(dimension, 77)
        shown = by_distance(before, after, broken(reference, 0))
        for cloud, points in zip(shown.clouds, (before, after), strict=True):
            np.testing.assert_allclose(cloud.values, nearest(points, reference[1:]))
        assert shown.label == "distance to the reference, coordinate units"

    def test_one_scale_for_both(self, dimension: int) -> None:
        before, after = pair(dimension)
        shown = by_distance(before, after, before)
        values = np.concatenate([np.zeros(300), nearest(after, before)])
        assert shown.limits == pytest.approx((0.0, np.percentile(values, 98)))

    @pytest.mark.parametrize("which", range(3))
    def test_nothing_finite(self, dimension: int, which: int) -> None:
        clouds = [pair(dimension)[0] for _ in range(3)]
        clouds[which] = np.full((4, dimension), np.inf)
        with pytest.raises(InvalidInputError, match="no point with finite"):
            by_distance(clouds[0], clouds[1], clouds[2])


@pytest.mark.parametrize("dimension", [2, 3])
class TestCurvature:
    def shown(self, dimension: int) -> tuple[ValuedClouds, list[Points]]:
        before, after = pair(dimension)
        values = [np.linspace(-3.0, 1.0, 300), np.linspace(-1.0, 5.0, 300)]
        values[0][10] = np.nan
        clouds = {"before": (broken(before, 20), values[0]), "after": (after, values[1])}
        return by_curvature(clouds, ["a", "b"]), values

    def test_values(self, dimension: int) -> None:
        shown, values = self.shown(dimension)
        np.testing.assert_array_equal(shown.clouds[0].values, np.delete(values[0], 20))
        np.testing.assert_array_equal(shown.clouds[1].values, values[1])
        assert [cloud.left_out for cloud in shown.clouds] == [1, 0]
        known = np.delete(values[0], [10, 20])
        np.testing.assert_array_equal(shown.distributions["before"], known)
        np.testing.assert_array_equal(shown.distributions["after"], values[1])

    def test_one_symmetric_scale(self, dimension: int) -> None:
        shown, _ = self.shown(dimension)
        sizes = np.abs(np.concatenate(list(shown.distributions.values())))
        assert shown.limits[1] == pytest.approx(np.percentile(sizes, 98))
        assert shown.limits[0] == -shown.limits[1]
        assert (shown.is_signed, shown.colormap) == (True, "coolwarm")
        assert shown.symbol == {2: "|k|", 3: "|H|"}[dimension]
        assert shown.label.endswith(", 1/unit")

    def test_a_shape_that_bends_one_way_uses_the_whole_scale(self, dimension: int) -> None:
        points, _ = pair(dimension)
        shown = by_curvature({"after": (points, np.linspace(-3.0, -1.0, 300))}, ["after"])
        assert shown.limits == pytest.approx((-2.96, -1.04))
        assert (shown.is_signed, shown.colormap, shown.reaches_beyond) == (False, "viridis", "both")

    def test_nothing_known(self, dimension: int) -> None:
        points, _ = pair(dimension)
        shown = by_curvature({"after": (points, np.full(300, np.inf))}, ["after"])
        assert np.isnan(shown.clouds[0].values).all()
        assert shown.limits == (0.0, 1.0)
        assert len(shown.distributions["after"]) == 0

    def test_nothing_finite(self, dimension: int) -> None:
        with pytest.raises(InvalidInputError, match="no point with finite"):
            by_curvature({"a": (np.full((3, dimension), np.nan), np.zeros(3))}, ["a"])


def test_the_box_holds_all_clouds() -> None:
    shown = by_displacement(np.array([[0.0, 5.0], [1.0, 2.0]]), np.array([[9.0, 3.0], [-1.0, 2.5]]))
    low, high = shown.box
    assert (low.tolist(), high.tolist()) == ([-1.0, 2.0], [9.0, 5.0])


class TestMagnitudes:
    def test_numbers(self) -> None:
        values = np.random.default_rng(1).normal(size=101)
        found = magnitudes(values)
        sizes = sorted(abs(value) for value in values)
        assert found.mean == pytest.approx(sum(sizes) / 101)
        assert found.median == sizes[50]
        assert found.root_mean_square == pytest.approx((sum(v * v for v in sizes) / 101) ** 0.5)
        assert found.largest == sizes[-1]
        assert found.in_words("|H|") == (
            f"mean |H| {found.mean:.4g}, median {sizes[50]:.4g}, "
            f"RMS {found.root_mean_square:.4g}, max {sizes[-1]:.4g}"
        )

    def test_of_nothing(self) -> None:
        assert magnitudes(np.empty(0)).in_words() == "mean nan, median nan, RMS nan, max nan"


class TestOtherValues:
    def test_pairs(self) -> None:
        points = np.arange(12.0).reshape(4, 3)
        damaged = broken(points, 1)
        assert by_displacement(damaged, points).is_paired
        assert by_distance(points, points + 1.0).is_paired
        assert not by_distance(points, points[:3]).is_paired
        assert not by_distance(points, damaged).is_paired
        assert not by_curvature({"it": (points, np.ones(4))}, ["it"]).is_paired
        assert by_displacement(damaged, points).clouds[0].rows.tolist() == [0, 2, 3]

    def test_a_scale_of_both_signs_and_of_one(self) -> None:
        shown = by_displacement(np.zeros((101, 3)), np.ones((101, 3)))
        rising = np.linspace(0.0, 100.0, 101)
        both = with_values(shown, "v, m", [rising - 20.0] * 2)
        assert both.is_signed
        assert both.limits[1] == pytest.approx(78.0)
        assert list(both.distributions) == ["v"]
        one = with_values(shown, "v, m", [rising + 5.0, rising])
        assert not one.is_signed
        assert one.limits == pytest.approx((4.02, 100.98))
        assert list(one.distributions) == ["before", "after"]
        told = with_values(shown, "z", [rising - 50.0] * 2, is_signed=False)
        assert told.limits == pytest.approx((-48.0, 48.0))

    def test_what_is_not_finite_is_unknown(self) -> None:
        shown = by_displacement(np.zeros((3, 3)), np.ones((3, 3)))
        found = with_values(shown, "v", [np.array([np.inf, np.nan, 2.0])] * 2)
        assert np.isnan(found.clouds[0].values).tolist() == [True, True, False]
        assert found.limits[0] < 2.0 < found.limits[1]
        nothing = with_values(shown, "v", [np.full(3, np.nan)] * 2)
        assert nothing.limits == (0.0, 1.0)

    def test_along_normals(self) -> None:
        before = np.zeros((4, 3))
        before[0] = np.nan
        after = before + np.array([0.0, 3.0, -2.0])
        normals = np.array([[1.0, 0, 0], [0, 5.0, 0], [0, 0, 1.0], [0, 0, 0]])
        found = along_normals(by_displacement(before, after), normals)
        np.testing.assert_allclose(found.clouds[1].values, [3.0, -2.0, np.nan])
        assert found.limits[0] == -found.limits[1]
        assert (found.symbol, found.reaches_beyond) == ("|d|", "both")
