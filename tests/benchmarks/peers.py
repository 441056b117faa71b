"""Normals, curvatures, smooth and sampled points by other programs, each in its own process.

None of them needs to be installed, and none can take the benchmark down with it.
Usage: python peers.py PROGRAM FOLDER [PARAMETER ...], where the folder holds the question.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class PeerError(Exception):
    """A program is not there or did not answer."""


def ask_peer(name: str, arrays: Sequence[npt.NDArray[Any]], *parameters: float) -> Array:
    """Ask one of `PROGRAMS`.

    Raises
    ------
    PeerError
        With a few words why there is no answer.
    """
    with tempfile.TemporaryDirectory() as folder:
        np.savez(Path(folder) / "question.npz", *arrays)
        done = subprocess.run(
            [sys.executable, __file__, name, folder, *map(str, parameters)],
            capture_output=True,
            text=True,
        )
        if done.returncode != 0:
            raise PeerError((done.stderr.strip() or f"died ({done.returncode})").splitlines()[-1])
        return np.asarray(np.load(Path(folder) / "answer.npy"), dtype=np.float64)


def open3d_normals(points: Array, count: float) -> Array:
    """Normals by principal component analysis of the nearest points."""
    import open3d

    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(knn=int(count)))
    return np.asarray(cloud.normals)


def meshlab_normals(points: Array, count: float, smoothings: float) -> Array:
    """Normals of planes fitted to the nearest points, averaged with their neighbours'."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points))
    meshes.compute_normal_for_point_clouds(k=int(count), smoothiter=int(smoothings))
    return np.asarray(meshes.current_mesh().vertex_normal_matrix())


def meshlab_apss(points: Array, normals: Array, chosen: Array, scale: float) -> Array:
    """Mean and Gaussian curvature (n, 2) of algebraic point set surfaces; NaN where not chosen.

    MeshLab's mean is k1 + k2; its K1 and K2 are what these two give.
    """
    import pymeshlab

    fields = []
    for kind in ("Mean", "Gauss"):
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(
            pymeshlab.Mesh(points, v_normals_matrix=normals, v_scalar_array=chosen.astype(float))
        )
        meshes.compute_selection_by_condition_per_vertex(condselect="q > 0.5")
        meshes.compute_curvature_and_color_apss_per_vertex(
            filterscale=scale, curvaturetype=kind, selectiononly=True
        )
        fields.append(meshes.current_mesh().vertex_scalar_array())
    answer = np.stack(fields, axis=1) * [0.5, 1.0]
    answer[~chosen.astype(bool)] = np.nan
    return answer


def cgal_cloud(points: Array) -> Any:
    """Return a point set of CGAL."""
    from CGAL.CGAL_Kernel import Point_3
    from CGAL.CGAL_Point_set_3 import Point_set_3

    cloud = Point_set_3()
    for point in points.tolist():
        cloud.insert(Point_3(*point))
    return cloud


def triples(vectors: Iterable[Any]) -> Array:
    """Return the coordinates (n, 3) of points or vectors of CGAL."""
    return np.array([(vector.x(), vector.y(), vector.z()) for vector in vectors])


def cgal_normals(points: Array, method: str, *parameters: float) -> Array:
    """Normals by one of CGAL's methods."""
    from CGAL import CGAL_Point_set_processing_3 as processing

    cloud = cgal_cloud(points)
    cloud.add_normal_map()
    getattr(processing, f"{method}_estimate_normals")(cloud, *parameters)
    return triples(cloud.normal(index) for index in cloud.indices())


def cgal_pca(points: Array, count: float) -> Array:
    """Normals by principal component analysis."""
    return cgal_normals(points, "pca", int(count))


def cgal_jet(points: Array, count: float) -> Array:
    """Normals of quadratic jets."""
    return cgal_normals(points, "jet", int(count))


def cgal_vcm(points: Array, offset: float, convolution: float) -> Array:
    """Normals by Voronoi covariance measures of two radii."""
    return cgal_normals(points, "vcm", offset, convolution)


def cgal_smooth_jets(points: Array, count: float) -> Array:
    """Points projected on quadratic jets of the nearest points."""
    from CGAL import CGAL_Point_set_processing_3 as processing

    cloud = cgal_cloud(points)
    processing.jet_smooth_point_set(cloud, int(count))
    return triples(map(cloud.point, range(len(points))))


def cgal_smooth_bilateral(
    points: Array, count: float, sharpness_angle: float, iterations: float
) -> Array:
    """Points smoothed bilaterally, from normals of jets oriented along a spanning tree."""
    from CGAL import CGAL_Point_set_processing_3 as processing

    cloud = cgal_cloud(points)
    cloud.add_normal_map()
    processing.jet_estimate_normals(cloud, 24)
    processing.mst_orient_normals(cloud, 24)
    for _ in range(int(iterations)):
        processing.bilateral_smooth_point_set(cloud, int(count), 0.0, sharpness_angle)
    return triples(map(cloud.point, range(len(points))))  # the orientation permutes the rest


def open3d_smooth(points: Array, method: str, *parameters: Any, **options: float) -> Array:
    """Points smoothed by one of Open3D's methods."""
    import open3d

    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    return np.asarray(getattr(cloud, f"smooth_{method}")(*parameters, **options).points)


def open3d_smooth_mls(points: Array, count: float, radius: float) -> Array:
    """Points projected on planes fitted to the nearest points, with Gaussian weights."""
    return open3d_smooth(points, "mls", open3d_hybrid(count, radius))


def open3d_smooth_bilateral(
    points: Array, count: float, radius: float, sigma_space: float, sigma_range: float
) -> Array:
    """Points smoothed bilaterally."""
    return open3d_smooth(
        points, "bilateral", open3d_hybrid(count, radius), sigma_space, sigma_range
    )


def open3d_hybrid(count: float, radius: float) -> Any:
    """Return Open3D's search of at most so many points that are so near."""
    import open3d

    return open3d.geometry.KDTreeSearchParamHybrid(radius=radius, max_nn=int(count))


def open3d_smooth_laplacian(points: Array, iterations: float, rate: float, count: float) -> Array:
    """Points moved towards the mean of their nearest points."""
    return open3d_smooth(points, "laplacian", int(iterations), rate, int(count))


def open3d_smooth_taubin(
    points: Array, iterations: float, rate: float, inverse_rate: float, count: float
) -> Array:
    """Points moved towards the mean of their nearest points and back."""
    return open3d_smooth(points, "taubin", int(iterations), rate, inverse_rate, int(count))


def poisson_disk(vertices: Array, faces: npt.NDArray[np.int64], count: float, seed: float) -> Array:
    """At least so many points on a mesh, about evenly spaced."""
    import point_cloud_utils

    for excess in (1.06, 1.25):
        places = point_cloud_utils.sample_mesh_poisson_disk(
            vertices, faces, int(count * excess), random_seed=int(seed)
        )
        points = point_cloud_utils.interpolate_barycentric_coords(faces, *places, vertices)
        if len(points) >= count:
            break
    return np.asarray(points)


PROGRAMS: dict[str, Callable[..., Array]] = {
    program.__name__: program
    for program in (
        open3d_normals,
        meshlab_normals,
        meshlab_apss,
        cgal_pca,
        cgal_jet,
        cgal_vcm,
        cgal_smooth_jets,
        cgal_smooth_bilateral,
        open3d_smooth_mls,
        open3d_smooth_bilateral,
        open3d_smooth_laplacian,
        open3d_smooth_taubin,
        poisson_disk,
    )
}


def _answer(name: str, folder: Path, *parameters: str) -> None:
    with np.load(folder / "question.npz") as question:
        arrays = [question[key] for key in question.files]
    try:
        answer = PROGRAMS[name](*arrays, *map(float, parameters))
    except ModuleNotFoundError:
        sys.exit("not installed")
    except ImportError as error:
        sys.exit(f"does not load: {error}")
    np.save(folder / "answer.npy", answer)


if __name__ == "__main__":
    _answer(sys.argv[1], Path(sys.argv[2]), *sys.argv[3:])
