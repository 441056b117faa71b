"""Compiled kernels: arrays in, arrays out; the only importers of numba, no files, no raise."""

from pcsmooth.kernels.cache import use_own_cache

use_own_cache()  # before any kernel is declared
