"""Neighbours whose bisector cannot reach a restricted cell, found before any facet is clipped."""

from numba import njit

#: Nearest neighbours that are tried as the ones that hide others.
_HIDERS = 16

#: A neighbour is dropped only if it is hidden by more than this, relative; rounding cannot
#: feign as much.
_MARGIN = 1e-12


@njit(cache=True, error_model="numpy")
def drop_hidden(near, ids, count, xi, yi, zi, radius, scratch):
    """Drop neighbours j of p_i whose facet a nearer neighbour k leaves nothing of.

    The bisector of p_j cuts the ball in a disk of radius rho, rho^2 = r^2 - |u_j|^2 / 4. All of
    it lies beyond the bisector of p_k if D > K and (D - K)^2 U / 4 >= rho^2 (K U - D^2), with
    D = u_j . u_k, K = |u_k|^2, U = |u_j|^2. Such a j bounds neither the cell nor any of its
    facets. Neighbours come nearest first in x, y, z, ids and are compacted there, in order;
    ux ... excess are scratch. Returns how many are left.
    """
    radius2 = radius * radius
    for j in range(count):
        scratch[0, j] = near[0, j] - xi
        scratch[1, j] = near[1, j] - yi
        scratch[2, j] = near[2, j] - zi
    for j in range(count):
        scratch[3, j] = (
            scratch[0, j] * scratch[0, j]
            + scratch[1, j] * scratch[1, j]
            + scratch[2, j] * scratch[2, j]
        )
        scratch[4, j] = -1.0
    for k in range(min(_HIDERS, count)):
        if scratch[4, k] >= 0.0:
            continue
        kx = scratch[0, k]
        ky = scratch[1, k]
        kz = scratch[2, k]
        k2 = scratch[3, k]
        margin = _MARGIN * radius2 * k2
        for j in range(count):
            product = scratch[0, j] * kx + scratch[1, j] * ky + scratch[2, j] * kz
            beyond = product - k2
            quarter = 0.25 * scratch[3, j]
            sine2 = k2 * scratch[3, j] - product * product
            value = beyond * beyond * quarter - (radius2 - quarter) * sine2 - margin * scratch[3, j]
            value = value if beyond > 0.0 else -1.0
            scratch[4, j] = value if value > scratch[4, j] else scratch[4, j]
    left = 0
    for j in range(count):
        near[0, left] = near[0, j]
        near[1, left] = near[1, j]
        near[2, left] = near[2, j]
        ids[left] = ids[j]
        left += 1 if scratch[4, j] < 0.0 else 0
    return left
