"""Compiled kernels: arrays in, arrays out; the only importers of numba, no files, no raise."""
