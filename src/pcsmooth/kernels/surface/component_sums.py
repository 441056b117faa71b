"""Sums over the connected components of a cloud, whose points may come in parts."""

import math

import numpy as np

from pcsmooth.kernels.compiled import kernel

#: A coordinate relative to a centroid below this share of the coordinate itself is rounding.
_ROUNDING = 1e-15


@kernel("f1 f1 i1 f1 f1")
def add_terms(terms, areas, labels, sums, sizes):
    """Add points' terms (n,), weighted by areas (n,), to their components' sums.

    Numbers of the points' components (n,), sums of a t and sizes, of a abs(t), (c,) each.
    """
    for i in range(terms.size):
        term = areas[i] * terms[i]
        sums[labels[i]] += term
        sizes[labels[i]] += abs(term)


@kernel("f2 f1 i1 f1 f2")
def add_places(points, areas, labels, totals, moments):
    """Add points (n, d) of areas (n,) to their components' sums.

    Numbers of the points' components (n,), sums of a, (c,), and of a p, (d, c).
    """
    n, dimension = points.shape
    for i in range(n):
        totals[labels[i]] += areas[i]
        for axis in range(dimension):
            moments[axis, labels[i]] += areas[i] * points[i, axis]


@kernel("f2 f2 f1 i1 f2 f1 f1 f2")
def add_fluxes(points, normals, areas, labels, centers, fluxes, most, sums):
    """Add to components' fluxes of the position, the most they could be, and sums of normals.

    Points and normals (n, d), areas (n,), number of each point's component (n,), centres (d, c);
    sums of a (p - c) . n and of a abs(p - c), (c,) each, and of a n, (d, c).
    """
    n, dimension = points.shape
    for i in range(n):
        component = labels[i]
        along = 0.0
        square = 0.0
        for axis in range(dimension):
            arm = points[i, axis] - centers[axis, component]
            if abs(arm) <= _ROUNDING * abs(points[i, axis]):
                arm = 0.0  # so that a point on its own is its own centroid
            square += arm * arm
            along += arm * normals[i, axis]
            sums[axis, component] += areas[i] * normals[i, axis]
        fluxes[component] += areas[i] * along
        most[component] += areas[i] * math.sqrt(square)


@kernel("f2 f2")
def products(vectors, others):
    """Scalar products (n,) of vectors (n, d), whatever parts they come in."""
    n, dimension = vectors.shape
    found = np.zeros(n)
    for i in range(n):
        for axis in range(dimension):
            found[i] += vectors[i, axis] * others[i, axis]
    return found
