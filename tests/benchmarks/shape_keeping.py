"""What denoising does to a shape: its volume, its edges, and holes in the cloud."""

import numpy as np
import numpy.typing as npt
import trimesh
from mesh_shapes import Shape
from scipy.spatial import cKDTree
from surface_distances import Array, signed_distances_to_mesh

SHARP = 30.0  #: degrees between faces, beyond which their edge is sharp
REACH = 2.0  #: spacings within which points are near an edge
_STEP = 0.1  #: spacings between the points of an edge


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
