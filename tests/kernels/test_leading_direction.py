from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kernels.alone import alone
from oracles import Array, random_rotation
from pcsmooth.kernels.arithmetic.leading_direction import leading_direction

leading_direction = alone(leading_direction)


def direction_of(tensor: Array) -> Array:
    return np.array(leading_direction(*tensor[np.triu_indices(3)]))


def turned(eigenvalues: Array, rng: np.random.Generator) -> Array:
    frame = random_rotation(3, rng)
    tensor = (frame * eigenvalues) @ frame.T
    return np.asarray((tensor + tensor.T) / 2)


#: Eigenvalues with one largest, of all kinds, none negative.
SPECTRA: dict[str, Callable[[np.random.Generator], Array]] = {
    "any": lambda rng: rng.random(3),
    "rank one": lambda rng: np.array([1.0, 0.0, 0.0]),
    "rank two": lambda rng: np.array([1.0, rng.random(), 0.0]),
    "two lower ones equal": lambda rng: np.array([1.0, 0.5, 0.5]),
    "many scales": lambda rng: 10.0 ** rng.uniform(-12, 0, 3),
}


@pytest.mark.parametrize("scale", [1e-100, 1e-40, 1.0, 1e40, 1e100])
@pytest.mark.parametrize("spectrum", SPECTRA)
def test_direction_is_that_of_eigh(spectrum: str, scale: float) -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        tensor = turned(SPECTRA[spectrum](rng), rng)
        values, vectors = np.linalg.eigh(tensor)
        gap = (values[2] - values[1]) / np.abs(values).max()
        actual = direction_of(scale * tensor)
        assert np.linalg.norm(actual) == pytest.approx(1, abs=1e-15)
        if gap > 1e-6:
            across = np.linalg.norm(np.cross(actual, vectors[:, 2]))
            assert across < 1e-14 / gap**2


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("others", [(0.0, 0.0), (0.3, 0.3), (0.3, 0.1), (0.999, 0.0)])
def test_diagonal_tensors_lead_along_their_axis(axis: int, others: tuple[float, float]) -> None:
    expected = np.eye(3)[axis]
    tensor = np.diag(np.insert(others, axis, 1.0))
    np.testing.assert_allclose(np.abs(direction_of(tensor)), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("scale", [1e-40, 1.0, 1e40])
def test_of_two_equal_largest_some_direction_of_their_plane(scale: float) -> None:
    rng = np.random.default_rng(1)
    for _ in range(200):
        tensor = turned(np.array([1.0, 1.0, rng.uniform(0, 0.9)]), rng)
        least = np.linalg.eigh(tensor)[1][:, 0]
        actual = direction_of(scale * tensor)
        assert np.linalg.norm(actual) == pytest.approx(1, abs=1e-15)
        assert abs(actual @ least) < 1e-6  # the root of the rounding, as for any double root


@pytest.mark.parametrize("scale", [1e-100, 1.0, 1e100])
@pytest.mark.parametrize(("ripple", "length"), [(0.0, 0), (1e-15, 0), (1e-9, 1)])
def test_of_three_equal_ones_none_leads(scale: float, ripple: float, length: float) -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        tensor = scale * (np.eye(3) + ripple * turned(rng.normal(size=3), rng))
        assert np.linalg.norm(direction_of(tensor)) == pytest.approx(length, abs=1e-15)


def test_nothing_leads_nowhere() -> None:
    assert not direction_of(np.zeros((3, 3))).any()
