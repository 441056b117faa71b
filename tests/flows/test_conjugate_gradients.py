from __future__ import annotations

import numpy as np
import pytest

import oracles
from flows.dense import weight_matrix
from pcsmooth.energies.balls import measure_balls
from pcsmooth.energies.facet_laplacian import FacetLaplacian, facet_laplacian
from pcsmooth.errors import InvalidInputError
from pcsmooth.flows.conjugate_gradients import TOLERANCE, solve
from pcsmooth.kernels.threads import thread_limit

N = 300
FACTORS = pytest.mark.parametrize("factor", [0.3, -0.3j, 0.2 - 0.3j])


def system(n: int = N) -> tuple[FacetLaplacian, oracles.Array, oracles.Array]:
    """L, masses over four decades and right-hand sides over twelve."""
    rng = np.random.default_rng(3)
    union = measure_balls(oracles.uniform_cloud(n, 3), 2 / n ** (1 / 3))
    laplacian = facet_laplacian(union, "volume")
    masses = 10.0 ** rng.uniform(-3, 1, n)
    return laplacian, masses, rng.normal(size=(n, 3)) * [1.0, 1e-6, 1e6]


@FACTORS
@pytest.mark.parametrize("is_held", [False, True])
def test_dense_solution(factor: complex, is_held: bool) -> None:
    laplacian, masses, right_side = system()
    held = np.arange(N) % 7 == 0 if is_held else np.zeros(N, bool)
    solution = solve(laplacian, masses, factor, right_side * factor, held, 1e-13)
    weights = weight_matrix(laplacian)
    matrix = np.diag(masses + factor * weights.sum(axis=1)) - factor * weights
    free = ~held
    expected = np.zeros((N, 3))
    expected[free] = np.linalg.solve(matrix[np.ix_(free, free)], factor * right_side[free]).real
    assert not solution.values[held].any()
    largest = np.abs(expected).max(axis=0)
    assert (np.abs(solution.values - expected).max(axis=0) < [1e-6, 1, 1e-11] * largest).all()
    assert 0 < solution.iterations < N
    assert solution.error < 1e-13


@FACTORS
def test_error_is_a_bound(factor: complex) -> None:
    laplacian, masses, right_side = system()
    held = np.zeros(N, bool)
    exact, solution = (
        solve(laplacian, masses, factor, right_side + 0 * factor, held, tolerance)
        for tolerance in (1e-13, TOLERANCE)
    )
    left, size = (
        np.sqrt((masses[:, np.newaxis] * values**2).sum())
        for values in (solution.values - exact.values, solution.values)
    )
    assert 0 < left / size <= solution.error < TOLERANCE
    assert solution.iterations < exact.iterations


def test_limit_of_iterations_is_an_error() -> None:
    laplacian, masses, right_side = system()
    with pytest.raises(
        InvalidInputError, match=r"not been solved in 5 iterations.*a shorter step$"
    ):
        solve(laplacian, masses, 100.0, right_side, np.zeros(N, bool), 1e-9, 5)


def test_what_overflows_is_an_error() -> None:
    laplacian, masses, right_side = system()
    with (
        np.errstate(over="ignore", invalid="ignore"),
        pytest.raises(InvalidInputError, match="may be nan of the displacement"),
    ):
        solve(laplacian, masses, 1e300, right_side * 1e308, np.zeros(N, bool))


@FACTORS
def test_any_start_leads_to_the_same_solution(factor: complex) -> None:
    laplacian, masses, right_side = system()
    weights = weight_matrix(laplacian)
    matrix = np.diag(masses + factor * weights.sum(axis=1)) - factor * weights
    start = np.random.default_rng(0).normal(size=(N, 3)) * [1.0, 1e-6, 1e6]
    held = np.zeros(N, bool)
    expected = solve(laplacian, masses, factor, right_side + 0 * factor, held, 1e-12)
    actual = solve(laplacian, masses, factor, right_side - matrix @ start, held, 1e-12, start=start)
    largest = np.abs(expected.values).max(axis=0)
    np.testing.assert_allclose(actual.values / largest, expected.values / largest, atol=1e-5)


def test_what_is_wrong_on_the_right_side_counts() -> None:
    laplacian, masses, right_side = system()
    held = np.zeros(N, bool)
    exact = solve(laplacian, masses, 0.3, right_side, held, 1e-13)
    size, wrong = (
        np.sqrt((values**2).sum())
        for values in (
            np.sqrt(masses)[:, np.newaxis] * exact.values,
            right_side / np.sqrt(masses)[:, np.newaxis],
        )
    )
    found = solve(
        laplacian, masses, 0.3, right_side, held, 1e-3, right_side_error=1e-4 * size / wrong
    )
    assert found.error == pytest.approx(1e-4, abs=9e-4)
    with pytest.raises(InvalidInputError, match=r"may be 0\.01 of"):
        solve(
            laplacian, masses, 0.3, right_side, held, 1e-3, 99, right_side_error=1e-2 * size / wrong
        )


@pytest.mark.parametrize("is_held", [False, True])
def test_nothing_to_solve(is_held: bool) -> None:
    laplacian, masses, right_side = system()
    solution = solve(laplacian, masses, 1.0, right_side * is_held, np.full(N, is_held))
    assert (solution.iterations, solution.error) == (0, 0)
    assert not solution.values.any()


@pytest.mark.slow
@FACTORS
def test_same_bytes_on_any_number_of_threads(factor: complex) -> None:
    laplacian, masses, right_side = system(9000)
    found = []
    for threads in (1, 2):
        with thread_limit(threads):
            found.append(
                solve(laplacian, masses, factor, right_side + 0 * factor, np.zeros(9000, bool))
            )
    one, two = found
    assert one.values.tobytes() == two.values.tobytes()
    assert (one.iterations, one.error) == (two.iterations, two.error)
