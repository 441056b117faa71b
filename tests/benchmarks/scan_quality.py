"""What denoising makes of real scans, as Markdown tables."""

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import smoothers as ways
import trimesh
from peers import PeerError
from planes import find_planes, flatness
from surface_distances import distances_to_mesh, root_mean_square
from tables import header, heading, percent, row

from pcsmooth import read_cloud
from pcsmooth.neighbors.spacing import mean_spacing

FAR = 10.0  #: spacings from the mesh beyond which a scanned point has no counterpart on it
FACES, FACE_REACH = 3, 2.0  #: faces of the scanned box, and spacings to which their points reach


def scans_section(data: Path, shipped: Path) -> None:
    """Show what becomes of real scans."""
    heading("Scans")
    names = (*ways.INPUT, *ways.OURS, ways.JETS[24], ways.JETS[100])
    scan, mesh = data / "scans" / "bunny_raw_all10.ply", data / "meshes" / "bunny_zipper.ply"
    if find_spec("point_cloud_utils") is None:
        print("Bunny skipped: point_cloud_utils is not installed.")
    elif scan.exists() and mesh.exists():
        bunny(scan, mesh, names)
    else:
        print(f"Bunny skipped: the folder has no scans/{scan.name} or meshes/{mesh.name}.")
    milk(shipped / "scans" / "kinect_milk.ply", names)


def bunny(scan: Path, mesh: Path, names: Sequence[str]) -> None:
    """Compare a scan of many layers with the mesh that was made of it."""
    points = read_cloud(scan).points
    spacing = mean_spacing(points)
    surface = trimesh.load_mesh(mesh, process=False)
    vertices = np.asarray(surface.vertices, dtype=np.float64)
    faces = np.asarray(surface.faces, dtype=np.int64)
    near = distances_to_mesh(points, vertices, faces) < FAR * spacing
    print(
        f"Bunny, ten range images, {len(points):,} points: distances to the merged mesh in mean "
        f"spacings ({spacing:.4g}). Of the points {percent(1 - near.mean())} are left out, which "
        f"are farther than {FAR:g} spacings before: the mesh has holes.\n"
    )
    header("way", "median", "RMS")
    for name in names:
        try:
            found = ways.SMOOTHERS[name](points, spacing)[near]
        except PeerError as failure:
            row(name, str(failure), "")
            continue
        far = distances_to_mesh(found, vertices, faces) / spacing
        row(name, f"{np.median(far):.4f}", f"{root_mean_square(far):.4f}")


def milk(scan: Path, names: Sequence[str]) -> None:
    """Measure how flat the faces of the scanned carton are."""
    points = read_cloud(scan).points
    spacing = mean_spacing(points)
    planes = list(find_planes(points, FACES, FACE_REACH * spacing))
    print(
        "\nMilk carton, Kinect: RMS distance in mm of the points of each face to the plane fitted "
        f"to them. They are the points within {FACE_REACH:g} mean spacings ({1e3 * spacing:.2f} "
        "mm) of a plane in the scan. The depths have steps, and bend over centimetres.\n"
    )
    header("way", *(f"{len(plane):,} points" for plane in planes))
    for name in names:
        try:
            found = ways.SMOOTHERS[name](points, spacing)
        except PeerError as failure:
            row(name, str(failure), *[""] * (len(planes) - 1))
            continue
        row(name, *(f"{1e3 * flatness(found[plane]):.3f}" for plane in planes))
