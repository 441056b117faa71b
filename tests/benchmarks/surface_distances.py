"""How far a cloud is from a clean cloud and from a mesh, as papers on denoising measure it."""

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

Array = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]

#: Pairs of faces and points whose distances are computed at a time.
_PAIRS = 2_000_000


def unit_sphere(points: Array) -> tuple[Array, float]:
    """Return the centre of the bounding box and the largest distance to it."""
    center = 0.5 * (points.max(axis=0) + points.min(axis=0))
    return center, float(np.linalg.norm(points - center, axis=1).max())


def chamfer_distance(points: Array, clean: Array) -> float:
    """Chamfer distance (CD) in the unit sphere of the clean cloud.

    The mean squared distance of the points to the nearest clean ones, plus the same from the
    clean points.
    """
    center, radius = unit_sphere(clean)
    points, clean = (points - center) / radius, (clean - center) / radius
    there, _ = cKDTree(clean).query(points)
    back, _ = cKDTree(points).query(clean)
    return float(np.mean(there**2) + np.mean(back**2))


def point_to_mesh_distance(points: Array, vertices: Array, faces: Faces) -> float:
    """Point-to-mesh distance (P2M) in the unit sphere of the mesh.

    The mean squared distance of the points to the mesh, plus the mean over the faces, whatever
    their area, of the squared distance to the nearest point.
    """
    center, radius = unit_sphere(vertices)
    points, vertices = (points - center) / radius, (vertices - center) / radius
    there = distances_to_mesh(points, vertices, faces)
    return float(np.mean(there**2) + squared_distances_to_points(vertices[faces], points).mean())


def distances_to_mesh(points: Array, vertices: Array, faces: Faces) -> Array:
    """Distance of each point to the nearest face."""
    import point_cloud_utils

    distances, _, _ = point_cloud_utils.closest_points_on_mesh(
        np.ascontiguousarray(points), np.ascontiguousarray(vertices), faces
    )
    return np.asarray(distances, dtype=np.float64)


def signed_distances_to_mesh(points: Array, vertices: Array, faces: Faces) -> Array:
    """Distance of each point to the nearest face of a closed mesh, negative inside."""
    import point_cloud_utils

    by_winding, _, _ = point_cloud_utils.signed_distance_to_mesh(
        np.ascontiguousarray(points), np.ascontiguousarray(vertices), faces
    )  # right in sign only: a winding number that is not quite whole scales it
    return np.asarray(np.copysign(distances_to_mesh(points, vertices, faces), by_winding))


def normals_of_mesh(points: Array, vertices: Array, faces: Faces) -> Array:
    """Unit normal of the face nearest to each point."""
    import point_cloud_utils

    _, nearest, _ = point_cloud_utils.closest_points_on_mesh(
        np.ascontiguousarray(points), np.ascontiguousarray(vertices), faces
    )
    a, b, c = np.moveaxis(vertices[faces[nearest]], 1, 0)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.maximum(lengths, np.finfo(np.float64).tiny))


def root_mean_square(distances: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(distances**2)))


def squared_distances_to_points(triangles: Array, points: Array) -> Array:
    """Squared distance of each triangle (m, 3, 3) to the nearest point."""
    centers = triangles.mean(axis=1)
    reach = np.linalg.norm(triangles - centers[:, np.newaxis], axis=2).max(axis=1)
    tree = cKDTree(points)
    _, near = tree.query(centers)
    nearest = squared_distances(points[near], triangles)
    # A nearer point is within that distance of the triangle, hence within the sum of the centre.
    candidates = tree.query_ball_point(centers, np.sqrt(nearest) + reach + 1e-12)
    counts = np.array([len(found) for found in candidates])
    owners = np.repeat(np.arange(len(triangles)), counts)
    chosen = np.concatenate([np.asarray(found, dtype=np.int64) for found in candidates])
    for begin in range(0, len(owners), _PAIRS):
        part = slice(begin, begin + _PAIRS)
        pairs = squared_distances(points[chosen[part]], triangles[owners[part]])
        np.minimum.at(nearest, owners[part], pairs)
    return nearest


def squared_distances(points: Array, triangles: Array) -> Array:
    """Squared distance of each point (n, 3) to its own triangle (n, 3, 3)."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normals = np.cross(b - a, c - a)
    squared_norms = _dot(normals, normals)
    nearest = np.full(len(points), np.inf)
    above = squared_norms > 0.0
    for start, end in ((a, b), (b, c), (c, a)):
        edge = end - start
        along = _dot(points - start, edge) / np.maximum(_dot(edge, edge), 1e-300)
        rest = points - start - np.clip(along, 0.0, 1.0)[:, np.newaxis] * edge
        nearest = np.minimum(nearest, _dot(rest, rest))
        above &= _dot(np.cross(edge, points - start), normals) >= 0.0
    heights = _dot(points - a, normals)[above]
    nearest[above] = heights**2 / squared_norms[above]
    return nearest


def _dot(left: Array, right: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", left, right))
