"""Normals and curvatures by other programs, each asked in a process of its own.

None of them needs to be installed, and none can take the benchmark down with it.
Usage: python peers.py PROGRAM FOLDER [PARAMETER ...], where the folder holds the question.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
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


def cgal_normals(points: Array, method: str, *parameters: float) -> Array:
    """Normals by one of CGAL's methods."""
    from CGAL import CGAL_Point_set_processing_3 as processing
    from CGAL.CGAL_Kernel import Point_3
    from CGAL.CGAL_Point_set_3 import Point_set_3

    cloud = Point_set_3()
    for point in points.tolist():
        cloud.insert(Point_3(*point))
    cloud.add_normal_map()
    getattr(processing, f"{method}_estimate_normals")(cloud, *parameters)
    vectors = (cloud.normal(index) for index in cloud.indices())
    return np.array([(vector.x(), vector.y(), vector.z()) for vector in vectors])


def cgal_pca(points: Array, count: float) -> Array:
    """Normals by principal component analysis."""
    return cgal_normals(points, "pca", int(count))


def cgal_jet(points: Array, count: float) -> Array:
    """Normals of quadratic jets."""
    return cgal_normals(points, "jet", int(count))


def cgal_vcm(points: Array, offset: float, convolution: float) -> Array:
    """Normals by Voronoi covariance measures of two radii."""
    return cgal_normals(points, "vcm", offset, convolution)


PROGRAMS: dict[str, Callable[..., Array]] = {
    program.__name__: program
    for program in (open3d_normals, meshlab_normals, meshlab_apss, cgal_pca, cgal_jet, cgal_vcm)
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
