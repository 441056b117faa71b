"""Other programs that open and write point clouds, each in a process of its own.

Some bring compiled libraries that this one must not meet.
"""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

_OPEN3D_OPENS = """
import sys, numpy as np, open3d
cloud = open3d.io.read_point_cloud(sys.argv[2])
more = open3d.t.io.read_point_cloud(sys.argv[2]).point if sys.argv[2].endswith("pcd") else {}
found = {"points": cloud.points, "normals": cloud.normals, "colors": cloud.colors}
found |= {name: more[name].numpy()[:, 0] for name in more if name not in ("positions", *found)}
np.savez(sys.argv[1], **{name: np.asarray(values) for name, values in found.items()})
"""

_OPEN3D_WRITES = """
import sys, numpy as np, open3d
points = np.random.default_rng(9).normal(size=(500, 3))
cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
cloud.normals = open3d.utility.Vector3dVector(points / 3)
cloud.colors = open3d.utility.Vector3dVector(np.linspace(0, 1, 1500).reshape(-1, 3))
kinds = {"write_ascii": "ascii" in sys.argv, "compressed": "compressed" in sys.argv}
assert open3d.io.write_point_cloud(sys.argv[2], cloud, **kinds)
np.savez(sys.argv[1])
"""

_PYMESHLAB_OPENS = """
import sys, numpy as np, pymeshlab
meshes = pymeshlab.MeshSet()
meshes.load_new_mesh(sys.argv[2])
mesh = meshes.current_mesh()
np.savez(
    sys.argv[1], points=mesh.vertex_matrix(), faces=mesh.face_matrix(),
    normals=mesh.vertex_normal_matrix(),
    colors=mesh.vertex_color_matrix() if mesh.has_vertex_color() else np.empty(0),
)
"""


def opened_by_open3d(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Points, normals and colors, and all other columns of PCD, as Open3D has them."""
    return _run("open3d", _OPEN3D_OPENS, path)


def written_by_open3d(path: Path, *kinds: str) -> None:
    """Have Open3D write 500 points with normals and colors: ascii, compressed, or neither."""
    _run("open3d", _OPEN3D_WRITES, path, *kinds)


def opened_by_pymeshlab(path: Path) -> dict[str, npt.NDArray[Any]]:
    """Points, faces, normals and colors as MeshLab has them."""
    return _run("pymeshlab", _PYMESHLAB_OPENS, path)


def _run(library: str, program: str, path: Path, *arguments: str) -> dict[str, npt.NDArray[Any]]:
    if find_spec(library) is None:
        pytest.skip(f"{library} is not installed")
    found = path.with_suffix(".npz")
    subprocess.run(
        [sys.executable, "-c", program, str(found), str(path), *arguments],
        check=True,
        capture_output=True,
        timeout=120,
    )
    with np.load(found) as arrays:
        return dict(arrays)
