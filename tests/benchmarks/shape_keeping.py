"""What denoising does to a shape: its volume, its edges, and holes in the cloud."""

import numpy as np
import numpy.typing as npt
import trimesh
from mesh_shapes import Shape
from scipy.spatial import cKDTree
from surface_distances import Array, normals_of_mesh, signed_distances_to_mesh

SHARP = 30.0  #: degrees between faces, beyond which their edge is sharp
REACH = 2.0  #: spacings within which points are near an edge
_STEP = 0.1  #: spacings between the points of an edge
_WITHIN, _MOST_NEAR = 3.0, 64  #: spacings, and number of points, within which holes are looked for
_SAME_SIDE = 0.5  #: cosine between the normals of points on the same side of a sheet


def volume_change(points: Array, shape: Shape) -> float:
    """Change of the enclosed volume, to first order, relative to the shape's volume.

    The integral over the surface of the displacement along its normal: every point owns the same
    area, which is right for points that came from an even sample of the surface.
    """
    mesh = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    heights = signed_distances_to_mesh(points, shape.vertices, shape.faces)
    return float(mesh.area * heights.mean() / mesh.volume)


def largest_hole(points: Array, clean: Array) -> float:
    """Return the largest distance of a clean point to the nearest point."""
    distances, _ = cKDTree(points).query(clean)
    return float(distances.max())


def distances_along(points: Array, clean: Array, shape: Shape, spacing: float) -> Array:
    """Distance of each clean point to the nearest point, along the surface.

    That is the least component along the surface of the ways from the clean point to points that
    come from where normals are within 60 degrees of its own (row i of both clouds is the same
    point). A tip that has become shorter is no hole, nor does the other side of a sheet fill one.
    """
    normals = normals_of_mesh(clean, shape.vertices, shape.faces)
    reach = _WITHIN * spacing
    distances, near = cKDTree(points).query(clean, _MOST_NEAR, distance_upper_bound=reach)
    found = np.isfinite(distances)
    near = np.where(found, near, 0)
    heights = np.einsum("nkd,nd->nk", points[near] - clean[:, np.newaxis], normals)
    along = np.sqrt(np.maximum(np.where(found, distances, 0.0) ** 2 - heights**2, 0.0))
    found &= np.einsum("nkd,nd->nk", normals[near], normals) > _SAME_SIDE
    return np.asarray(np.where(found, along, reach).min(axis=1))


def near_sharp_edges(clean: Array, shape: Shape, spacing: float) -> npt.NDArray[np.bool_]:
    """Say which points are near an edge of the shape that is sharp."""
    mesh = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    sharp = np.degrees(mesh.face_adjacency_angles) > SHARP
    starts, ends = np.moveaxis(shape.vertices[mesh.face_adjacency_edges[sharp]], 1, 0)
    longest = np.linalg.norm(ends - starts, axis=1).max(initial=0.0)
    shares = np.linspace(0.0, 1.0, 2 + int(longest / (_STEP * spacing)))[:, np.newaxis, np.newaxis]
    edges = (starts + shares * (ends - starts)).reshape(-1, 3)
    distances, _ = cKDTree(edges).query(clean, distance_upper_bound=REACH * spacing)
    return np.asarray(np.isfinite(distances))
