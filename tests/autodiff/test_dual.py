"""Dual numbers against derivatives by hand, complex steps and differences."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.autodiff import Dual, seed
from pcsmooth.autodiff.dual import as_dual, value_of

Array = npt.NDArray[Any]


def variable(*values: float) -> Any:
    """One variable at several values; NumPy's stubs do not know of number types like `Dual`."""
    return seed(np.array(values)[:, np.newaxis])[:, 0]


@pytest.mark.parametrize(
    "function",
    [
        np.negative, np.positive, np.square, np.sqrt, np.exp, np.log, np.sin, np.cos, np.tan,
        np.arcsin, np.arccos, np.arctan, lambda x: x**3, lambda x: x**-1.5, lambda x: 2.0 / x - x,
        lambda x: (1.0 + x) * (x - 3.0) / (x * x + 1.0),
    ],
)  # fmt: skip
def test_functions_of_one_variable_by_complex_steps(function: Callable[[Any], Any]) -> None:
    """f(x + ih) = f(x) + ih f'(x) without any difference."""
    x = np.array([0.1, 0.5, 0.9])
    actual = function(variable(*x))
    expected = function(x + 1e-30j)
    np.testing.assert_allclose(actual.value, expected.real, rtol=1e-15)
    np.testing.assert_allclose(actual.derivatives[:, 0], expected.imag / 1e-30, rtol=1e-14)


@pytest.mark.parametrize(
    "function",
    [np.add, np.subtract, np.multiply, np.divide, np.arctan2, np.hypot, np.maximum, np.minimum],
)
def test_functions_of_two_variables_by_differences(function: Callable[..., Any]) -> None:
    pairs = np.random.default_rng(1).normal(size=(20, 2))
    actual = function(*seed(pairs)[:, [0, 1]].value.T)
    dual = function(seed(pairs)[:, 0], seed(pairs)[:, 1])
    np.testing.assert_array_equal(dual.value, actual)
    step = 1e-6
    for k in range(2):
        move = step * np.eye(2)[k]
        slope = (function(*(pairs + move).T) - function(*(pairs - move).T)) / (2 * step)
        np.testing.assert_allclose(dual.derivatives[:, k], slope, rtol=1e-7, atol=1e-9)


def test_constants_on_either_side() -> None:
    x = variable(0.5, 2.0)
    np.testing.assert_allclose((3.0 - x).derivatives[:, 0], -1)
    np.testing.assert_allclose((3.0 / x).derivatives[:, 0], [-12, -0.75])
    np.testing.assert_allclose(np.arctan2(1.0, x).derivatives[:, 0], [-0.8, -0.2])
    np.testing.assert_allclose(np.arctan2(x, np.array([1.0, 2.0])).derivatives[:, 0], [0.8, 0.25])


def test_the_sign_of_absolute_values() -> None:
    x = variable(-2.0, 3.0)
    np.testing.assert_array_equal(abs(x).value, [2, 3])
    np.testing.assert_array_equal(abs(x).derivatives[:, 0], [-1, 1])


def test_broadcasting_adds_axes_in_front() -> None:
    x = variable(2.0, 3.0)  # (2,)
    grid = x * np.array([[1.0, 10.0], [2.0, 20.0], [3.0, 30.0]])
    assert grid.derivatives.shape == (3, 2, 1)
    np.testing.assert_array_equal(grid.value, [[2, 30], [4, 60], [6, 90]])
    np.testing.assert_array_equal(grid.derivatives[..., 0], [[1, 10], [2, 20], [3, 30]])
    whole = np.sum(grid)
    assert whole.value == 192
    assert whole.derivatives.tolist() == [66]
    columns = np.sum(grid, axis=0)
    np.testing.assert_array_equal(columns.value, [12, 180])
    np.testing.assert_array_equal(columns.derivatives[:, 0], [6, 60])


def test_decisions_look_at_values() -> None:
    x = variable(-1.0, 0.0, 2.0)
    assert (x > 0.0).tolist() == [False, False, True]
    assert (x <= 0.0).tolist() == [True, True, False]
    assert (x == 0.0).tolist() == [False, True, False]
    assert np.sign(x).tolist() == [-1, 0, 1]


def test_where_chooses_values_and_derivatives() -> None:
    x = variable(-1.0, 2.0)
    chosen: Any = np.where(x > 0.0, x * x, 5.0)
    np.testing.assert_array_equal(chosen.value, [5, 4])
    np.testing.assert_array_equal(chosen.derivatives[:, 0], [0, 4])
    both: Any = np.where([True, False], x, -x)
    np.testing.assert_array_equal(both.derivatives[:, 0], [1, -1])


def test_the_gradient_of_a_function_of_many_variables() -> None:
    """det(A) has the gradient det(A) A^-T (Jacobi)."""
    matrices = np.random.default_rng(2).normal(size=(5, 3, 3))
    (a, b, c), (d, e, f), (g, h, i) = (
        [seed(matrices)[:, row, column] for column in range(3)] for row in range(3)
    )
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    expected = np.linalg.det(matrices)[:, None, None] * np.linalg.inv(matrices).swapaxes(1, 2)
    np.testing.assert_allclose(determinant.derivatives.reshape(5, 3, 3), expected, rtol=1e-12)


def test_what_is_known_of_a_dual_number() -> None:
    x = variable(1.0, 2.0)
    assert len(x) == 2
    assert repr(x[1]) == "Dual(array(2.), array([1.]))"
    assert value_of(x).tolist() == [1, 2]
    assert value_of(3).tolist() == 3
    assert as_dual(x, like=x) is x
    assert as_dual([3.0], like=x).derivatives.tolist() == [[0.0]]


@pytest.mark.parametrize("derivatives", [1.0, [1.0, 2.0, 3.0], [[1.0]], [[[1.0]], [[2.0]]]])
def test_derivatives_of_another_shape(derivatives: Any) -> None:
    with pytest.raises(ValueError, match="they need one more axis"):
        Dual([1.0, 2.0], derivatives)


@pytest.mark.parametrize(
    "function",
    [
        np.floor, np.add.reduce, np.cumsum, lambda x: 2.0**x,
        lambda x: np.sum(x, axis=1),
        lambda x: np.add(x, 1.0, where=np.array([True, False])),
    ],
)  # fmt: skip
def test_functions_without_a_derivative_are_refused(function: Callable[[Any], Any]) -> None:
    with pytest.raises(TypeError):
        function(variable(1.0, 2.0))
