"""Linear equations with a weighted graph Laplacian, by conjugate gradients."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.energies.facet_laplacian import FacetLaplacian
from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.flows.conjugate_directions import BLOCK, advance, multiply, turn_direction
from pcsmooth.unit_of_length import power_of_two_near

#: Error that is good enough, as a share of the solution.
TOLERANCE = 1e-3

#: Iterations after which the solver gives up. Long steps take some 0.6 for each point along the
#: cloud: about 600 for 100,000 points.
MOST_ITERATIONS = 10_000


@dataclass(frozen=True)
class Solution:
    """Solution of (M + f L) (x - start) = b.

    Attributes
    ----------
    values : ndarray, shape (n, 3)
        Real part of x.
    iterations : int
        Iterations taken.
    error : float
        Bound of the error's size as a share of the values', both as root of sum_i m_i abs(x_i)^2.
    """

    values: npt.NDArray[np.float64]
    iterations: int
    error: float


def solve(
    laplacian: FacetLaplacian,
    masses: npt.NDArray[np.float64],
    factor: complex,
    right_side: npt.NDArray[Any],
    held: npt.NDArray[np.bool_],
    tolerance: float = TOLERANCE,
    most_iterations: int = MOST_ITERATIONS,
    start: npt.NDArray[np.float64] | None = None,
    right_side_error: float = 0.0,
) -> Solution:
    """Solve (M + f L) (x - start) = b, three right-hand sides at once, x being 0 where it is held.

    Parameters
    ----------
    laplacian : FacetLaplacian
        L, symmetric and positive semi-definite.
    masses : ndarray, shape (n,)
        Diagonal of M, > 0.
    factor : float or complex
        f, with a real part >= 0.
    right_side : ndarray, shape (n, 3)
        b, of the type of f: what the start leaves of the equations.
    held : ndarray of bool, shape (n,)
        Rows whose x is 0; their equations are left out.
    tolerance : float
        Stop when `Solution.error` is below.
    most_iterations : int
        Give up after so many iterations.
    start : ndarray, shape (n, 3), optional
        Where to start, 0 where it is held; by default 0.
    right_side_error : float
        Share of b that may be wrong.

    Returns
    -------
    Solution

    Raises
    ------
    InvalidInputError
        The error is larger than the tolerance after the most iterations.

    Notes
    -----
    Conjugate gradients with Jacobi preconditioner; for complex f the same recurrences with
    x^T y in place of the inner product, which serve complex symmetric matrices (van der Vorst
    and Melissen 1990, COCG).

    No eigenvalue of 1 + f M^-1/2 L M^-1/2 is smaller than 1 in absolute value, so that the error
    is at most the residual, divided by the masses: abs(e)_M <= abs(r)_(1/M), which is what
    decides when to stop.
    """
    n = len(masses)
    # Products must neither overflow nor vanish: equations and solution are scaled.
    scale = float(np.median(masses))
    scale *= power_of_two_near(1.0 + abs(factor) * float(laplacian.diagonal.max()) / scale)
    masses = masses / scale
    factor = factor / scale
    residual = np.where(held[:, np.newaxis], 0.0, right_side / scale)
    inverse = 1.0 / (masses + factor * laplacian.diagonal)
    direction = inverse[:, np.newaxis] * residual
    solution, product = np.zeros_like(residual), np.empty_like(residual)
    if start is not None:
        solution += start
    size = power_of_two_near(float(max(np.abs(solution).max(), np.abs(direction).max())))
    for values in (residual, direction, solution):
        values /= size
    n_blocks = -(-n // BLOCK)
    sums = np.empty((n_blocks, 3), residual.dtype)
    errors, moves = np.empty(n_blocks), np.empty(n_blocks)
    descent = (residual * direction).sum(axis=0)
    wrong = right_side_error * float(np.linalg.norm(residual / np.sqrt(masses)[:, np.newaxis]))
    iterations = 0
    error = 1.0 if residual.any() else 0.0
    while error > tolerance and iterations < most_iterations:
        multiply(
            laplacian.starts, laplacian.columns, laplacian.weights, masses, factor, held,
            direction, product, sums,
        )  # fmt: skip
        advance(
            _ratios(descent, sums.sum(axis=0)), direction, product, inverse, masses, solution,
            residual, sums, errors, moves,
        )  # fmt: skip
        descent, before = sums.sum(axis=0), descent
        turn_direction(_ratios(descent, before), inverse, residual, direction)
        iterations += 1
        left, moved = math.sqrt(errors.sum()) + wrong, math.sqrt(moves.sum())
        error = left / moved if moved != 0.0 else 1.0
    if not (error <= tolerance and np.isfinite(solution).all()):
        raise InvalidInputError(
            f"an implicit step has not been solved in {iterations} iterations, the error may be "
            f"{error:.2g} of the displacement; choose a shorter step"
        )
    return Solution(np.ascontiguousarray(solution.real) * size, iterations, error)


def _ratios(above: npt.NDArray[Any], below: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Quotients; 0 where there is nothing left to do."""
    ratios = np.zeros_like(above)
    np.divide(above, below, out=ratios, where=below != 0.0)
    return ratios
