"""Compiled kernels: arrays in, arrays out, no raise; the only importers of numba."""
