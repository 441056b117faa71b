"""Noise that is told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pcsmooth
from pcsmooth import InvalidInputError

RNG = np.random.default_rng(11)
SHEET = np.c_[RNG.uniform(0, 4, (500, 2)), RNG.normal(0, 0.05, 500)]


@pytest.mark.parametrize("scheme", ["filter", "implicit"])
@pytest.mark.parametrize("noise", [6.0, "120%"])
def test_noise_is_not_larger_than_the_cloud(scheme: Any, noise: float | str) -> None:
    with pytest.raises(InvalidInputError, match=r"larger than the cloud, whose diagonal is 5\.6"):
        pcsmooth.denoise(SHEET, scheme=scheme, noise=noise)
