"""A convex polyhedron in the hands of a kernel, and how a plane cuts it.

A vertex is where three planes meet; where more do, there are several vertices at one place. Of
vertex t the planes a, b, c stand counter-clockwise as seen from outside in planes[:, t]; on the
edge between planes[e, t] and the one after it in that round lies the vertex across[e, t]. Seen
from facet a, its boundary runs counter-clockwise along the edge (a, b) towards t. So whatever is
summed over facets and edges is a sum over the pairs (t, e).
"""

import math

import numpy as np

from pcsmooth.kernels.compiled import inner

#: What follows e in the round of the three planes of a vertex.
AFTER = (1, 2, 0)

#: The cut passes a facet more than once: rounding contradicts itself on which vertices to cut off.
TORN = -1


@inner
def polyhedron_arrays(n_labels):
    """Make room for a polyhedron with so many facets while it is cut.

    Returns vertices, planes, across, excess, and `first`, a place for every facet. With F facets
    and three planes at each vertex it has 2 F - 4 vertices; a cut adds its own before it drops
    others.
    """
    room = 6 * n_labels
    return (
        np.empty((3, room)),
        np.empty((3, room), np.int64),
        np.empty((3, room), np.int64),
        np.empty(room),
        np.empty(n_labels, np.int64),
    )


@inner
def copy_polyhedron(source, source_planes, source_across, vertices, planes, across):
    """Copy all n vertices into arrays with room for more; returns n."""
    n = source.shape[1]
    for row in range(3):
        for t in range(n):
            vertices[row, t] = source[row, t]
            planes[row, t] = source_planes[row, t]
            across[row, t] = source_across[row, t]
    return n


@inner
def measure_excess(vertices, n, nx, ny, nz, offset, excess):
    """How far every vertex is beyond the plane (nx, ny, nz) . x = offset; returns the largest."""
    largest = -np.inf
    for t in range(n):
        e = nx * vertices[0, t] + ny * vertices[1, t] + nz * vertices[2, t] - offset
        excess[t] = e
        largest = max(largest, e)
    return largest


@inner
def cut_off(vertices, planes, across, n, excess, tolerance, label, first):
    """Cut off the vertices whose excess is beyond the tolerance; the new facet is called `label`.

    Returns the number of vertices left, or TORN, with nothing changed. The arrays are those of
    `polyhedron_arrays`; `first` has a place for every label, and needs no preparation; excess
    gets used up.
    """
    new = n
    for t in range(n):
        if excess[t] > tolerance:
            for e in range(3):
                if excess[across[e, t]] <= tolerance:
                    first[planes[e, t]] = -1
                    first[planes[AFTER[e], t]] = -1
    for t in range(n):
        if excess[t] <= tolerance:
            continue
        for e in range(3):
            q = across[e, t]
            if excess[q] > tolerance:
                continue
            if first[planes[e, t]] >= 0:
                return TORN
            first[planes[e, t]] = new
            planes[0, new] = planes[e, t]
            planes[1, new] = planes[AFTER[e], t]
            planes[2, new] = label
            across[0, new] = q
            inside = min(excess[q], 0.0)
            share = inside / (inside - excess[t])
            for row in range(3):
                here = vertices[row, q]
                vertices[row, new] = here + share * (vertices[row, t] - here)
            new += 1
    for t in range(n, new):
        follower = first[planes[1, t]]
        if follower < 0:
            return TORN
        across[1, t] = follower
        across[2, follower] = t
    for t in range(n, new):
        _relink(planes, across, across[0, t], planes[1, t], planes[0, t], t)
    return _close_ranks(vertices, planes, across, n, new, excess, tolerance)


@inner
def cut_off_leniently(vertices, planes, across, n, excess, tolerance, label, first):
    """Cut off as `cut_off`, with a larger tolerance if need be; returns the vertices left."""
    left = cut_off(vertices, planes, across, n, excess, tolerance, label, first)
    while left == TORN:
        tolerance *= 2.0
        left = cut_off(vertices, planes, across, n, excess, tolerance, label, first)
    return left


@inner
def place_vertex(vertices, planes, t, table, unclear):
    """Move a vertex to where its three planes meet, which is clearer than where cuts have put it.

    table: normals of any length and offsets (4, ...). Nothing is done, and False returned, if the
    determinant of the planes' unit normals is not above `unclear`.
    """
    a = planes[0, t]
    b = planes[1, t]
    c = planes[2, t]
    ax, ay, az = table[0, a], table[1, a], table[2, a]
    bx, by, bz = table[0, b], table[1, b], table[2, b]
    cx, cy, cz = table[0, c], table[1, c], table[2, c]
    bcx = by * cz - bz * cy
    bcy = bz * cx - bx * cz
    bcz = bx * cy - by * cx
    volume = ax * bcx + ay * bcy + az * bcz
    lengths2 = (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)
    lengths2 *= cx * cx + cy * cy + cz * cz
    if abs(volume) <= unclear * math.sqrt(lengths2):
        return False
    scale = 1.0 / volume
    ha = table[3, a] * scale
    hb = table[3, b] * scale
    hc = table[3, c] * scale
    vertices[0, t] = ha * bcx + hb * (cy * az - cz * ay) + hc * (ay * bz - az * by)
    vertices[1, t] = ha * bcy + hb * (cz * ax - cx * az) + hc * (az * bx - ax * bz)
    vertices[2, t] = ha * bcz + hb * (cx * ay - cy * ax) + hc * (ax * by - ay * bx)
    return True


@inner
def _relink(planes, across, q, a, b, t):
    """Let t be the vertex across the edge (a, b) of q."""
    for e in range(3):
        if planes[e, q] == a and planes[AFTER[e], q] == b:
            across[e, q] = t


@inner
def _close_ranks(vertices, planes, across, n, stop, excess, tolerance):
    """Move the last vertices into the places of those cut off among the first n."""
    for t in range(n):
        if t >= stop:
            break
        if excess[t] <= tolerance:
            continue
        stop -= 1
        while stop < n and stop > t and excess[stop] > tolerance:
            stop -= 1
        if stop == t:
            break
        for row in range(3):
            vertices[row, t] = vertices[row, stop]
            planes[row, t] = planes[row, stop]
            across[row, t] = across[row, stop]
        for e in range(3):
            _relink(planes, across, across[e, t], planes[AFTER[e], t], planes[e, t], t)
    return stop
