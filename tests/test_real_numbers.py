from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth import BallEnergy, ConvexBody, denoise, estimate_curvature, measure_balls
from pcsmooth.errors import InvalidInputError
from pcsmooth.real_numbers import real_array

CIRCLE = np.stack([np.cos(np.arange(40) * np.pi / 20), np.sin(np.arange(40) * np.pi / 20)], axis=1)
SQUARE = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])

NO_NUMBERS: dict[str, Any] = {
    "complex": CIRCLE + 0j,
    "object": CIRCLE.astype(object),
    "decimal": [[Decimal(1), Decimal(2)]],
    "none": [[1.0, None]],
    "str": CIRCLE.astype(str),
    "bytes": CIRCLE.astype(bytes),
    "date": CIRCLE.astype("M8[s]"),
    "bool": CIRCLE > 0.0,
}


@pytest.mark.parametrize("kind", ["u1", "i2", "i8", "u8", "f2", "f4", ">f8", "g"])
def test_real_numbers_of_any_type_are_copied(kind: str) -> None:
    values = np.array([[1, 2], [3, 4]], kind)
    numbers = real_array(values, "points")
    assert numbers.dtype == np.float64
    assert numbers.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    numbers[0, 0] = 9.0
    assert values[0, 0] == 1


@pytest.mark.parametrize("values", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_everything_else_is_refused(values: npt.ArrayLike) -> None:
    with pytest.raises(InvalidInputError, match=r"^points are not an array .*, but of .*;"):
        real_array(values, "points")


def test_rows_of_different_lengths_are_refused() -> None:
    with pytest.raises(InvalidInputError, match=r"^points are not an array of real"):
        real_array([[0.0, 1.0], [2.0]], "points")


def test_truth_values_where_they_may_be() -> None:
    assert real_array([True, False], "marks", may_be_bool=True).tolist() == [1.0, 0.0]


def test_a_mask_that_hides_nothing() -> None:
    assert real_array(np.ma.array([1, 2]), "points").tolist() == [1.0, 2.0]


class TestPublicArguments:
    """Every function that takes an array."""

    @pytest.mark.parametrize("kind", ["complex", "object", "str", "bool"])
    def test_points(self, kind: str) -> None:
        for call in (
            denoise,
            estimate_curvature,
            lambda points: measure_balls(points, 0.3),
            lambda points: BallEnergy(0.3).evaluate(points),
        ):
            with pytest.raises(InvalidInputError, match=r"^points are not an array of real"):
                call(NO_NUMBERS[kind])

    @pytest.mark.parametrize("kind", ["complex", "object", "str"])
    def test_fixed(self, kind: str) -> None:
        with pytest.raises(InvalidInputError, match=r"^fixed marks are not an array of real"):
            denoise(CIRCLE, fixed=np.asarray(NO_NUMBERS[kind])[:, 0])

    @pytest.mark.parametrize("kind", ["complex", "object", "str", "bool"])
    def test_normals(self, kind: str) -> None:
        for function in (denoise, estimate_curvature):
            with pytest.raises(InvalidInputError, match=r"^normals are not an array of real"):
                function(CIRCLE, normals=NO_NUMBERS[kind])

    def test_bodies(self) -> None:
        body = ConvexBody(SQUARE)
        calls: dict[str, Callable[[], Any]] = {
            "normals": lambda: ConvexBody(SQUARE + 0j),
            "offsets": lambda: ConvexBody(SQUARE, np.ones(4, object)),
            "vertices": lambda: ConvexBody.from_vertices(SQUARE + 0j),
            "vectors": lambda: body.norm(SQUARE + 0j),
            "entries of the rotation": lambda: body.rotated(np.eye(2) + 0j),
        }
        for name, call in calls.items():
            with pytest.raises(InvalidInputError, match=rf"^{name} are not an array of real"):
                call()
        with pytest.raises(InvalidInputError, match=r"^scale is "):
            body.scaled(1 + 0j)


class TestMasks:
    def test_a_masked_row_is_not_finite(self) -> None:
        masked = np.ma.array(CIRCLE)
        masked[3] = np.ma.masked
        masked[7, 1] = np.ma.masked
        without = np.delete(CIRCLE, [3, 7], axis=0)
        result = denoise(masked, scheme="euler")
        assert np.flatnonzero(~result.finite).tolist() == [3, 7]
        assert np.isnan(result.points[3]).all()
        assert result.points[7, 0] == CIRCLE[7, 0]
        assert np.isnan(result.points[7, 1])
        expected = denoise(without, scheme="euler")
        assert result.points[result.finite].tobytes() == expected.points.tobytes()
        estimate = estimate_curvature(masked)
        assert np.flatnonzero(~estimate.finite).tolist() == [3, 7]
        assert not estimate.normals[[3, 7]].any()

    def test_a_union_has_no_masked_centre(self) -> None:
        masked = np.ma.array(CIRCLE, mask=False)
        masked[5, 0] = np.ma.masked
        with pytest.raises(InvalidInputError, match="point 5 is not finite"):
            measure_balls(masked, 0.3)

    def test_a_masked_mark_fixes_nothing(self) -> None:
        fixed = np.ma.array(np.ones(len(CIRCLE), bool), mask=np.arange(len(CIRCLE)) >= 10)
        result = denoise(CIRCLE, scheme="euler", fixed=fixed)
        assert not result.displacement[:10].any()
        assert result.displacement[10:].all()

    def test_a_masked_normal_is_none(self) -> None:
        normals = np.ma.array(-CIRCLE)
        normals[:, 1] = np.ma.masked
        estimate = estimate_curvature(CIRCLE, normals=normals)
        assert "input" not in estimate.orientation
        assert "input" in estimate_curvature(CIRCLE, normals=-CIRCLE).orientation


@pytest.mark.parametrize("threads", [0, -1, True, 1.5, "2"])
def test_threads_that_make_no_sense(threads: object) -> None:
    message = f"^threads is {threads!r}; it must be a whole number, 1 or more$"
    for function in (denoise, estimate_curvature):
        with pytest.raises(InvalidInputError, match=message):
            function(CIRCLE, threads=threads)  # type: ignore[arg-type]


def test_threads_may_be_a_number_of_numpys() -> None:
    assert len(denoise(CIRCLE, threads=np.int64(1)).points) == 40  # type: ignore[arg-type]
