"""Sparse grid of cubic cells: the points in Morton order, and the points near a cell.

Cells are numbered along a Morton (Z-order) curve, so that points close in memory are close in
space: bit b of the cell's number along axis a is bit d b + a of its code.

The points of a cube of 2^l cells along each axis follow one another, too: it is a node of a
quadtree or octree. So points may look around in cubes of their own size: a cell of level l holds
those of one such cube that follow one another and are of that level. Its code is that of the cube's
first cell of level 0.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import types

from pcsmooth.kernels.compiled import inner, kernel
from pcsmooth.kernels.threads import MANY, shared_out

#: Cells an axis can tell apart (21 bits; the code of a cell in space has 63). Cell numbers are
#: clamped to this range; clamping keeps neighbours neighbours, so it can only cost time, never a
#: pair.
CELL_BITS = 21
CELLS_PER_AXIS = 1 << CELL_BITS

#: Number, on each axis, of the cell that begins at coordinate 0, or at a given corner. Cells have
#: the same place, and points the same order, in every part of a cloud. Its binary digits
#: alternate, so that the codes of points around 0 differ in few of them: quick to sort.
CELL_OF_ZERO = 0b010101010101010101010

#: Cubes around a cell, itself included, in space.
MOST_RANGES = 27

#: Bits of a code that belong to the first axis, in the plane and in space.
_PLANE_AXIS = 0x15555555555
_SPACE_AXIS = 0x1249249249249249


class Cells(NamedTuple):
    """The occupied cells of a grid.

    Attributes
    ----------
    codes : ndarray of int64, shape (m,)
        Morton codes.
    starts : ndarray of int64, shape (m + 1,)
        Where each cell's points begin in grid order.
    levels : ndarray of int8, shape (m,)
        Doublings of the cell size.
    fine_codes, fine_starts : ndarray of int64, shape (f,) and (f + 1,)
        The same of the cells of level 0 that hold all points, codes increasing; the same arrays if
        there is no other level.
    """

    codes: npt.NDArray[np.int64]
    starts: npt.NDArray[np.int64]
    levels: npt.NDArray[np.int8]
    fine_codes: npt.NDArray[np.int64]
    fine_starts: npt.NDArray[np.int64]


_INTEGERS = types.int64[::1]

#: What kernels take cells for.
CELLS = types.NamedTuple([_INTEGERS, _INTEGERS, types.int8[::1], _INTEGERS, _INTEGERS], Cells)


@inner
def _spread_bits(number, dimension):
    """Put d - 1 zero bits behind each of the 21 bits of a number."""
    if dimension == 3:
        number = (number | (number << 32)) & 0x1F00000000FFFF
        number = (number | (number << 16)) & 0x1F0000FF0000FF
        number = (number | (number << 8)) & 0x100F00F00F00F00F
        number = (number | (number << 4)) & 0x10C30C30C30C30C3
        return (number | (number << 2)) & _SPACE_AXIS
    number = (number | (number << 16)) & 0x1F0000FFFF
    number = (number | (number << 8)) & 0x1F00FF00FF
    number = (number | (number << 4)) & 0x10F0F0F0F0F
    number = (number | (number << 2)) & 0x13333333333
    return (number | (number << 1)) & _PLANE_AXIS


def bounding_box(
    points: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Least and greatest coordinates along the first, second and last axis of points (n, d)."""
    bounds = np.array(_bounding_boxes(points))
    return bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)


@shared_out("points", MANY)
@kernel("f2 i i")
def _bounding_boxes(points, first, last):
    """Do it for some of them."""
    dimension = points.shape[1]
    low_x = low_y = low_z = np.inf
    high_x = high_y = high_z = -np.inf
    for i in range(first, last):
        low_x = min(low_x, points[i, 0])
        high_x = max(high_x, points[i, 0])
        low_y = min(low_y, points[i, 1])
        high_y = max(high_y, points[i, 1])
        low_z = min(low_z, points[i, dimension - 1])
        high_z = max(high_z, points[i, dimension - 1])
    return (low_x, low_y, low_z), (high_x, high_y, high_z)


def code_points(
    points: npt.NDArray[np.float64],
    corner: npt.NDArray[np.float64],
    size: float,
    offsets: npt.NDArray[np.float64],
    pairs: npt.NDArray[np.int64],
) -> tuple[int, int]:
    """Pair the Morton code of each point's cell with its number.

    Points (n, d), a corner of cells (d,), size > 0, the cell's number on each axis (d,) -> pairs
    (n, 2); returns the lowest and the highest code.
    """
    extremes = np.array(_code_points(points, corner, size, offsets, pairs))
    return int(extremes[:, 0].min()), int(extremes[:, 1].max())


@shared_out("points", MANY)
@kernel("f2 f1 f f1 i2 i i")
def _code_points(points, corner, size, offsets, pairs, first, last):
    """Do it for some of them."""
    lowest = np.int64(2**63 - 1)
    highest = np.int64(0)
    for i in range(first, last):
        code = _code_point(points, i, corner, size, offsets)
        pairs[i, 0] = code
        pairs[i, 1] = i
        lowest = min(lowest, code)
        highest = max(highest, code)
    return lowest, highest


@inner
def _code_point(points, i, corner, size, offsets):
    """Morton code of the cell of point i."""
    dimension = points.shape[1]
    code = np.int64(0)
    for axis in range(dimension):
        number = np.floor((points[i, axis] - corner[axis]) / size) + offsets[axis]
        number = min(max(number, 0.0), CELLS_PER_AXIS - 1.0)
        code |= _spread_bits(np.int64(number), dimension) << axis
    return code


@shared_out("points", MANY)
@kernel("f2 i2 i1 f2 b1 i i")
def gather_points(points, pairs, order, coordinates, begins, first, last):
    """Lay out points (n, d) by their sorted pairs (n, 2) of code and number.

    Into order (n,) the numbers, into coordinates (3, n) the rows x, y, z (z = 0 in 2D), and into
    begins (n,) whether a cell begins with the point.
    """
    dimension = points.shape[1]
    for k in range(first, last):
        i = pairs[k, 1]
        order[k] = i
        begins[k] = k == 0 or pairs[k, 0] != pairs[k - 1, 0]
        coordinates[2, k] = 0.0
        for axis in range(dimension):
            coordinates[axis, k] = points[i, axis]


@shared_out("starts", MANY // 8)
@kernel("f2 i1 i1 i i1 i i")
def match_in_cells(coordinates, order, starts, largest, lowest, first, last):
    """Set `lowest` of each point to the lowest number at its position, if that is not its own.

    Cells of more than `largest` points are left out. Coordinates (3, n) and numbers (n,) in grid
    order, lowest (n,) by number.
    """
    for cell in range(first, last):
        start = starts[cell]
        stop = starts[cell + 1]
        if stop - start <= largest:
            for k in range(start + 1, stop):
                for j in range(start, k):
                    if (
                        coordinates[0, j] == coordinates[0, k]
                        and coordinates[1, j] == coordinates[1, k]
                        and coordinates[2, j] == coordinates[2, k]
                    ):
                        lowest[order[k]] = order[j]
                        break


@inner
def _first_cell(codes, code, near):
    """Position of the first of the sorted codes that is not below `code`.

    The search starts from position `near`, in growing steps: close in space is mostly close along
    the curve.
    """
    step = 1
    if codes[near] < code:
        low = near + 1
        high = low + step
        while high <= codes.size and codes[high - 1] < code:
            low = high
            step *= 2
            high += step
        high = min(high, codes.size)
    else:
        high = near
        low = high - step
        while low >= 0 and codes[low] >= code:
            high = low
            step *= 2
            low -= step
        low = max(low, 0)
    while low < high:
        middle = (low + high) >> 1
        if codes[middle] < code:
            low = middle + 1
        else:
            high = middle
    return low


@inner
def _across(code, axis_bits, child):
    """Along an axis, the next family of cells on the side where a cell is in its own.

    axis_bits: those of a code that belong to the axis; child: that in which a family's members
    differ. Returns these bits of the family's first code, or -1 where the range of cells ends.
    """
    mask = axis_bits & (-2 * child)
    family = code & mask
    if code & child:
        return ((family | ~mask) + 1) & mask if family != mask else -1
    return (family - 1) & mask if family != 0 else -1


@inner
def adjacent_ranges(cells, cell, dimension, ranges):
    """Points of a cell's cube and of the cubes of its size around it, as ranges in grid order.

    Fills ranges (2, MOST_RANGES) with their starts and stops; returns how many there are.

    Cubes come in families of 2^d whose codes follow one another: those that differ in the lowest
    bit of each axis. A cube's neighbours are in its own family and in the families on its side
    along one or more axes, of which only the cubes at the border count.
    """
    codes = cells.fine_codes
    starts = cells.fine_starts
    code = cells.codes[cell]
    shift = dimension * int(cells.levels[cell])
    near = cell
    if codes.size != cells.codes.size:
        near = np.searchsorted(codes, code)
        near = min(near, codes.size - 1)
    n_children = 1 << dimension
    family_size = n_children << shift
    x_bits = _SPACE_AXIS if dimension == 3 else _PLANE_AXIS
    y_bits = x_bits << 1
    z_bits = x_bits << 2 if dimension == 3 else 0
    own = code & -family_size
    across_x = _across(code, x_bits, 1 << shift)
    across_y = _across(code, y_bits, 2 << shift)
    across_z = _across(code, z_bits, 4 << shift)
    count = 0
    for crossed in range(n_children):  # bit a: across the family's border along axis a
        first = (
            (across_x if crossed & 1 else own & x_bits)
            | (across_y if crossed & 2 else own & y_bits)
            | (across_z if crossed & 4 else own & z_bits)
        )
        if first < 0:
            continue
        k = _first_cell(codes, first, near)
        while k < codes.size and codes[k] - first < family_size:
            if ((codes[k] ^ code) >> shift) & crossed == crossed:
                if count > 0 and ranges[1, count - 1] == starts[k]:
                    ranges[1, count - 1] = starts[k + 1]
                else:
                    ranges[0, count] = starts[k]
                    ranges[1, count] = starts[k + 1]
                    count += 1
            k += 1
    return count


@inner
def cell_of_point(cells, point):
    """Find the cell of a point."""
    return np.searchsorted(cells.starts, point, side="right") - 1


@shared_out("sources", MANY)
@kernel("i1 b1 i b1 i i")
def mark_adjacent(codes, sources, dimension, marks, first, last):
    """Mark the cubes (m,) of one size, by increasing codes, that are or adjoin one of the sources.

    Fills marks (m,).
    """
    ranges = np.empty((2, MOST_RANGES), np.int64)
    starts = np.arange(codes.size + 1)
    cubes = Cells(codes, starts, np.zeros(codes.size, np.int8), codes, starts)
    for cube in range(first, last):
        marks[cube] = sources[cube]
        n_ranges = 0 if sources[cube] else adjacent_ranges(cubes, cube, dimension, ranges)
        for r in range(n_ranges):
            for k in range(ranges[0, r], ranges[1, r]):
                marks[cube] |= sources[k]


@shared_out("cells.codes")
@kernel("f2 cells i f1 f1 b2 i i", cells=CELLS)
def look_back(coordinates, cells, dimension, radii, seen, marks, first, last):
    """Find out which points look too short for the larger balls that touch theirs.

    Parameters: coordinates (3, n) in grid order (cells of side >= 2 radii), cells, d, radii (n,),
    how far points look at each level (l,). Marks the levels (l, n) to which points have to rise.
    """
    ranges = np.empty((2, MOST_RANGES), np.int64)
    low = np.empty(3)
    high = np.empty(3)
    levels = cells.levels
    for cell in range(first, last):
        start = cells.starts[cell]
        stop = cells.starts[cell + 1]
        largest = 0.0
        low[:] = np.inf
        high[:] = -np.inf
        for i in range(start, stop):
            largest = max(largest, radii[i])
            for axis in range(3):
                low[axis] = min(low[axis], coordinates[axis, i])
                high[axis] = max(high[axis], coordinates[axis, i])
        n_ranges = adjacent_ranges(cells, cell, dimension, ranges)
        for r in range(n_ranges):
            other = cell_of_point(cells, ranges[0, r])
            for k in range(ranges[0, r], ranges[1, r]):
                while k >= cells.starts[other + 1]:
                    other += 1
                level = levels[other]
                reach = largest + radii[k]
                if reach <= seen[level]:
                    continue
                x = coordinates[0, k]
                y = coordinates[1, k]
                z = coordinates[2, k]
                # From the box around the cell's points, then from each of them.
                gap_x = max(low[0] - x, x - high[0], 0.0)
                gap_y = max(low[1] - y, y - high[1], 0.0)
                gap_z = max(low[2] - z, z - high[2], 0.0)
                if gap_x * gap_x + gap_y * gap_y + gap_z * gap_z >= reach * reach:
                    continue
                needed = 0.0
                for i in range(start, stop):
                    dx = coordinates[0, i] - x
                    dy = coordinates[1, i] - y
                    dz = coordinates[2, i] - z
                    reach = radii[i] + radii[k]
                    if dx * dx + dy * dy + dz * dz < reach * reach:
                        needed = max(needed, reach)
                if needed > seen[level]:
                    while level < seen.size - 1 and needed > seen[level]:
                        level += 1
                    marks[level, k] = True
