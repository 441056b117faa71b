"""Compiled kernels: arrays in, arrays out, no raise; the only importers of numba."""

from pcsmooth.kernels.cache import use_own_cache

use_own_cache()  # before any kernel is declared
