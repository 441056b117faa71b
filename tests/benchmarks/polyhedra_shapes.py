"""Shapes that flow towards a convex polyhedron, and how near they have come."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull, HalfspaceIntersection

from pcsmooth import ConvexBody, PolyhedronEnergy
from pcsmooth.energies.protocol import UnionName
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import run_flow

Array = npt.NDArray[np.float64]

#: Bodies of the thesis' Figure 38.
FIGURE_38 = ("cube", "bipyramid", "icosahedron")

#: Radius of the bodies in spacings of the points, and time step in spacings squared. Automatic
#: steps hold back single points that would overshoot, and with them the facets that they lead.
RATIO = 2.0
STEP = 0.25


@dataclass(frozen=True)
class Hull:
    """A cloud's convex hull beside a body K.

    Attributes
    ----------
    triangles : ndarray, shape (n, 3, 3)
        Corners of its triangles, L.
    normals : ndarray, shape (n, 3)
        Their outward normals.
    nearest : ndarray of int, shape (n,)
        Number of the facet of K whose normal is nearest to theirs.
    angles : ndarray, shape (n,)
        Angle to it, degrees.
    median_angle : float
        What half of the hull's area stays below, degrees.
    """

    triangles: Array
    normals: Array
    nearest: npt.NDArray[np.int64]
    angles: Array
    median_angle: float


def even_sphere(n_points: int, radius: float = 1.0) -> Array:
    """Sample a sphere along a Fibonacci spiral."""
    z = 1.0 - (2.0 * np.arange(n_points) + 1.0) / n_points
    angle = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(n_points)
    flat = np.sqrt(1.0 - z * z)
    return radius * np.stack([flat * np.cos(angle), flat * np.sin(angle), z], axis=1)


def flowing_sphere(
    n_points: int, body: ConvexBody, union: UnionName, iterations: int, *, automatic: bool = False
) -> Iterator[Array]:
    """Move an even unit sphere by equal or automatic steps on the volume, divided by the cells'.

    Yields the points of the states 0 to `iterations`.
    """
    points = even_sphere(n_points)
    spacing = float(np.sqrt(4.0 * np.pi / n_points))
    energy = PolyhedronEnergy(RATIO * spacing, body, union)
    step = None if automatic else STEP * spacing**2
    for state in run_flow(energy, points, Euler(step), iterations):
        yield state.points


def hull_beside(points: Array, body: ConvexBody) -> Hull:
    """Compare the hull's normals with those of a body."""
    hull = ConvexHull(points)
    normals = hull.equations[:, :3]
    cosines = normals @ body.normals.T
    angles = np.degrees(np.arccos(np.clip(cosines.max(axis=1), -1.0, 1.0)))
    triangles = points[hull.simplices]
    edges = np.diff(triangles, axis=1)
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    order = np.argsort(angles)
    covered = np.cumsum(areas[order])
    median = angles[order][np.searchsorted(covered, covered[-1] / 2.0)]
    return Hull(triangles, normals, cosines.argmax(axis=1), angles, float(median))


def least_of_radial(body: ConvexBody) -> Array:
    """Vertices of the shape of least integral of rho(n) + rho(-n) for its volume.

    That is the intersection of the half-spaces n x <= rho(n) + rho(-n) of all directions n (the
    Wulff shape): K itself with pillows on its facets.
    """
    normals = np.concatenate([even_sphere(20_000), body.normals])
    offsets = body.radial(normals) + body.radial(-normals)
    planes = np.concatenate([normals, -offsets[:, np.newaxis]], axis=1)
    return np.asarray(HalfspaceIntersection(planes, np.zeros(3)).intersections)
