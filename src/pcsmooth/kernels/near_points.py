"""The points within reach of a point, nearest first, from the cells of the grid around it."""

import numpy as np
from numba import njit

#: Distance classes that stand in for a sort of the neighbours.
DISTANCE_CLASSES = 32


@njit(cache=True)
def neighbor_arrays(capacity):
    """Make room for candidates and their numbers, a selection, neighbours and theirs, scratch."""
    return (
        np.empty((3, capacity)),
        np.empty(capacity, np.int64),
        np.empty(capacity, np.int64),
        np.empty((3, capacity)),
        np.empty(capacity, np.int64),
        np.empty((5, capacity)),
    )


@njit(cache=True)
def count_points(cell_starts, found, n_found):
    """Count the points of some cells."""
    count = 0
    for f in range(n_found):
        count += cell_starts[found[f] + 1] - cell_starts[found[f]]
    return count


@njit(cache=True)
def collect_points(coordinates, cell_starts, found, n_found, candidates, candidate_ids):
    """Copy the points of some cells into candidates (3, m) and their numbers into ids (m,)."""
    c = 0
    for f in range(n_found):
        for k in range(cell_starts[found[f]], cell_starts[found[f] + 1]):
            candidates[0, c] = coordinates[0, k]
            candidates[1, c] = coordinates[1, k]
            candidates[2, c] = coordinates[2, k]
            candidate_ids[c] = k
            c += 1


@njit(cache=True, error_model="numpy")
def select_nearest_first(
    candidates,
    candidate_ids,
    n_candidates,
    i,
    xi,
    yi,
    zi,
    reach,
    kept,
    scratch,
    class_ends,
    near,
    near_ids,
):
    """Copy the candidates nearer than `reach` to p_i, itself excluded, into near and near_ids.

    They come in order of distance up to the width of a class; kept, scratch and class_ends
    (DISTANCE_CLASSES + 1,) are work space. Returns how many there are. The loops are kept apart
    and free of branches so that they vectorise.
    """
    reach2 = reach * reach
    for c in range(n_candidates):
        dx = candidates[0, c] - xi
        dy = candidates[1, c] - yi
        dz = candidates[2, c] - zi
        scratch[0, c] = dx * dx + dy * dy + dz * dz
    count = 0
    for c in range(n_candidates):
        kept[count] = c
        count += 1 if (scratch[0, c] < reach2 and candidate_ids[c] != i) else 0
    class_ends[:] = 0
    to_class = DISTANCE_CLASSES / reach2
    for k in range(count):
        number = min(np.int64(scratch[0, kept[k]] * to_class), DISTANCE_CLASSES - 1)
        class_ends[number + 1] += 1
    for number in range(DISTANCE_CLASSES):
        class_ends[number + 1] += class_ends[number]
    for k in range(count):
        c = kept[k]
        number = min(np.int64(scratch[0, c] * to_class), DISTANCE_CLASSES - 1)
        place = class_ends[number]
        class_ends[number] += 1
        near[0, place] = candidates[0, c]
        near[1, place] = candidates[1, c]
        near[2, place] = candidates[2, c]
        near_ids[place] = candidate_ids[c]
    return count


@njit(cache=True)
def drop_neighbor(near, near_ids, count, j):
    """Drop neighbour j, the others keeping their order; returns how many are left."""
    for k in range(j, count - 1):
        near[0, k] = near[0, k + 1]
        near[1, k] = near[1, k + 1]
        near[2, k] = near[2, k + 1]
        near_ids[k] = near_ids[k + 1]
    return count - 1
