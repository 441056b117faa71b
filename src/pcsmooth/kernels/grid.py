"""Sparse grid of cubic cells: the points in Morton order, and the points near a cell.

Cells are numbered along a Morton (Z-order) curve, so that points close in memory are close in
space. A 2D cloud is a 3D one whose third coordinate is zero.
"""

import numpy as np
from numba import njit, prange

#: Cells an axis can tell apart (21 bits of a 63-bit Morton code). Cell numbers are clamped to
#: this range; clamping keeps neighbours neighbours, so it can only cost time, never a pair.
CELLS_PER_AXIS = 1 << 21


@njit(cache=True, inline="always")
def _spread_bits(number):
    """Put two zero bits behind each of the lowest 21 bits of a number."""
    number = number & 0x1FFFFF
    number = (number | (number << 32)) & 0x1F00000000FFFF
    number = (number | (number << 16)) & 0x1F0000FF0000FF
    number = (number | (number << 8)) & 0x100F00F00F00F00F
    number = (number | (number << 4)) & 0x10C30C30C30C30C3
    return (number | (number << 2)) & 0x1249249249249249


@njit(cache=True, inline="always")
def _gather_bits(code):
    """Undo `_spread_bits`."""
    code = code & 0x1249249249249249
    code = (code | (code >> 2)) & 0x10C30C30C30C30C3
    code = (code | (code >> 4)) & 0x100F00F00F00F00F
    code = (code | (code >> 8)) & 0x1F0000FF0000FF
    code = (code | (code >> 16)) & 0x1F00000000FFFF
    return (code | (code >> 32)) & 0x1FFFFF


@njit(cache=True, inline="always")
def _morton_code(ix, iy, iz):
    return _spread_bits(ix) | (_spread_bits(iy) << 1) | (_spread_bits(iz) << 2)


@njit(cache=True, inline="always")
def _cell_number(coordinate, origin, size):
    number = np.floor((coordinate - origin) / size)
    return np.int64(min(max(number, 0.0), CELLS_PER_AXIS - 1.0))


@njit(parallel=True, cache=True)
def morton_codes(points, origin, size):
    """Morton code of the cell of each point: points (n, d), origin (d,), size > 0 -> (n,)."""
    n, dimension = points.shape
    codes = np.empty(n, np.int64)
    for i in prange(n):
        ix = _cell_number(points[i, 0], origin[0], size)
        iy = _cell_number(points[i, 1], origin[1], size)
        iz = np.int64(0)
        if dimension == 3:
            iz = _cell_number(points[i, 2], origin[2], size)
        codes[i] = _morton_code(ix, iy, iz)
    return codes


@njit(parallel=True, cache=True)
def sorted_coordinates(points, order):
    """Coordinates in grid order as rows x, y, z (z = 0 in 2D): (n, d), (n,) -> (3, n)."""
    n, dimension = points.shape
    coordinates = np.zeros((3, n))
    for k in prange(n):
        for axis in range(dimension):
            coordinates[axis, k] = points[order[k], axis]
    return coordinates


@njit(cache=True)
def _find_cell(cell_codes, code):
    """Position of a code in the sorted cell codes, or -1."""
    low = 0
    high = cell_codes.size
    while low < high:
        middle = (low + high) >> 1
        if cell_codes[middle] < code:
            low = middle + 1
        else:
            high = middle
    if low < cell_codes.size and cell_codes[low] == code:
        return low
    return -1


@njit(cache=True)
def adjacent_cells(cell_codes, cell, dimension, found):
    """Occupied cells around a cell, itself included, into found (27,); returns how many."""
    code = cell_codes[cell]
    ix = _gather_bits(code)
    iy = _gather_bits(code >> 1)
    iz = _gather_bits(code >> 2)
    depth = 1 if dimension == 3 else 0
    count = 0
    for jz in range(max(iz - depth, 0), min(iz + depth, CELLS_PER_AXIS - 1) + 1):
        for jy in range(max(iy - 1, 0), min(iy + 1, CELLS_PER_AXIS - 1) + 1):
            for jx in range(max(ix - 1, 0), min(ix + 1, CELLS_PER_AXIS - 1) + 1):
                neighbor = _find_cell(cell_codes, _morton_code(jx, jy, jz))
                if neighbor >= 0:
                    found[count] = neighbor
                    count += 1
    return count
