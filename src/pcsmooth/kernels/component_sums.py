"""Sums over the connected components of a cloud."""

import math

import numpy as np
from numba import njit


@njit(cache=True)
def centroids(points, areas, labels, count):
    """Centroid of each component and the sum of its areas.

    Points (d, n), areas (n,), number of each point's component (n,), number of components ->
    (d, count), (count,).
    """
    dimension, n = points.shape
    centers = np.zeros((dimension, count))
    totals = np.zeros(count)
    for i in range(n):
        totals[labels[i]] += areas[i]
        for axis in range(dimension):
            centers[axis, labels[i]] += areas[i] * points[axis, i]
    for component in range(count):
        for axis in range(dimension):
            if totals[component] > 0.0:
                centers[axis, component] /= totals[component]
    return centers, totals


@njit(cache=True)
def fluxes(points, normals, areas, labels, centers):
    """Flux of the position through each component, the most it could be, and the sum of normals.

    Points and normals (d, n), areas (n,), number of each point's component (n,), centres (d, c)
    -> sum a (p - c) . n, sum a abs(p - c), (c,) each, and sum a n, (d, c).
    """
    dimension, n = points.shape
    flux = np.zeros(centers.shape[1])
    most = np.zeros(centers.shape[1])
    sums = np.zeros(centers.shape)
    for i in range(n):
        component = labels[i]
        along = 0.0
        square = 0.0
        for axis in range(dimension):
            arm = points[axis, i] - centers[axis, component]
            square += arm * arm
            along += arm * normals[axis, i]
            sums[axis, component] += areas[i] * normals[axis, i]
        flux[component] += areas[i] * along
        most[component] += areas[i] * math.sqrt(square)
    return flux, most, sums


@njit(cache=True)
def turn(normals, signs):
    """Multiply normals (d, n) by signs (n,), in place."""
    dimension, n = normals.shape
    for axis in range(dimension):
        for i in range(n):
            normals[axis, i] *= signs[i]
