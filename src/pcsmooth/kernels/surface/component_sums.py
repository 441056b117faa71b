"""Sums over the connected components of a cloud, whose points may come in parts."""

import math

import numpy as np

from pcsmooth.kernels.compiled import kernel

#: A coordinate relative to a centroid below this share of the coordinate itself is rounding.
_ROUNDING = 1e-15


@kernel("f1 f1 j1 f1 f1", "f1 f1 i1 f1 f1")
def add_terms(terms, areas, labels, sums, sizes):
    """Add points' terms (n,), weighted by areas (n,), to their components' sums.

    Numbers of the points' components (n,), sums of a t and sizes, of a abs(t), (c,) each.
    """
    for i in range(terms.size):
        term = areas[i] * terms[i]
        sums[labels[i]] += term
        sizes[labels[i]] += abs(term)


@kernel("f2 f1 j1 f1 f2", "f2~ f1 i1 f1 f2")
def add_places(points, areas, labels, totals, moments):
    """Add points (d, n) of areas (n,) to their components' sums.

    Numbers of the points' components (n,), sums of a, (c,), and of a p, (d, c).
    """
    dimension, n = points.shape
    for i in range(n):
        totals[labels[i]] += areas[i]
        for axis in range(dimension):
            moments[axis, labels[i]] += areas[i] * points[axis, i]


@kernel("f2 f2 f1 j1 f2 f1 f1 f2", "f2~ f2~ f1 i1 f2 f1 f1 f2")
def add_fluxes(points, normals, areas, labels, centers, fluxes, most, sums):
    """Add to components' fluxes of the position, the most they could be, and sums of normals.

    Points and normals (d, n), areas (n,), number of each point's component (n,), centres (d, c);
    sums of a (p - c) . n and of a abs(p - c), (c,) each, and of a n, (d, c).
    """
    dimension, n = points.shape
    for i in range(n):
        component = labels[i]
        along = 0.0
        square = 0.0
        for axis in range(dimension):
            arm = points[axis, i] - centers[axis, component]
            if abs(arm) <= _ROUNDING * abs(points[axis, i]):
                arm = 0.0  # so that a point on its own is its own centroid
            square += arm * arm
            along += arm * normals[axis, i]
            sums[axis, component] += areas[i] * normals[axis, i]
        fluxes[component] += areas[i] * along
        most[component] += areas[i] * math.sqrt(square)


@kernel("f2~ f2~")
def products(vectors, others):
    """Scalar products (n,) of vectors (d, n), whatever parts they come in."""
    dimension, n = vectors.shape
    found = np.zeros(n)
    for axis in range(dimension):
        for i in range(n):
            found[i] += vectors[axis, i] * others[axis, i]
    return found


@kernel("f2 f1")
def turn(normals, signs):
    """Multiply normals (d, n) by signs (n,), in place."""
    dimension, n = normals.shape
    for axis in range(dimension):
        for i in range(n):
            normals[axis, i] *= signs[i]
