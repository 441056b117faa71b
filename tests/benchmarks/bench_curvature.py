"""Errors of normals and curvatures beside other programs', and their time, as Markdown tables.

Errors are medians over the points. Ways with a parameter that the cloud does not choose for them
show the least error over several values, and that value: they are told the truth. pcsmooth is not.
Usage: python bench_curvature.py [--data DIR] [--scale SHARE] [SECTION ...]
"""

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import estimates as est
import numpy as np
import trimesh
from clouds import noisy_torus
from curvature_shapes import Surface, ellipse, ellipsoid, sphere, torus
from estimates import COUNT, COUNTS, Case, Way, describe
from machine import machine_line
from measuring import median_seconds
from peers import PeerError
from tables import header, heading, percent, row

from pcsmooth import estimate_curvature, measure_balls
from pcsmooth.kernels.threads import thread_limit

THREADS = 2
NOISES = (0.0, 0.1, 0.3, 0.7)  #: spacings

REPORT_WAYS: Mapping[str, Way] = {
    "thesis, volume": est.by_options(estimator="gradient"),
    "thesis, area": est.by_options(estimator="gradient", energy="area"),
}
JET_WAYS: Mapping[str, Way] = {
    f"osculating jets, degree {degree}, best k": est.by_jets(degree) for degree in (2, 3, 4)
}
APSS = "MeshLab APSS, best scale"
JETS_NOTE = (
    "The Python package of CGAL lacks Monge_via_jet_fitting; the osculating jets are the "
    f"benchmark's own, which do the same. They and APSS are tried at {est.SAMPLES:,} of the "
    "points, and for each noise and quantity the best parameter is shown. APSS gets normals of "
    f"principal component analysis over {COUNT} points, with the true signs."
)


def ellipse_section() -> None:
    """Compare the estimators on the ellipse of the thesis, section 2.3.2."""
    heading(
        "Ellipse a = 180, b = 120, 200 points at equal steps of t, radius 15",
        "Relative error of the curvature a b / (a² sin² t + b² cos² t)^(3/2).",
    )
    surface, _ = ellipse(200, 180.0, 120.0)
    header("estimator", "max", "median", "target of max")
    for name, target, estimate in (
        ("thesis, area of the union", "", partial(estimate_curvature, estimator="gradient")),
        (
            "thesis, perimeter",
            "",
            partial(estimate_curvature, estimator="gradient", energy="area"),
        ),
        ("default", "2 %", estimate_curvature),
    ):
        found = estimate(surface.points, radius=15.0).mean_curvature
        errors = np.abs(found - surface.mean) / surface.mean
        row(name, percent(errors.max()), percent(float(np.median(errors))), target)


def sphere_section() -> None:
    """Show all curvatures of spheres."""
    heading("Spheres of 10,000 points", "Median relative errors; right sign: share of points.")
    header("points", "radius", "estimator", "H", "target", "right sign", "K", "k1", "k2", "normal")
    for even in (True, False):
        for seed, radius in enumerate((0.5, 1.0, 2.0)):
            case = Case(sphere(10_000, radius, even, seed=seed))
            ways = {"default": est.by_default, **(REPORT_WAYS if radius == 1.0 else {})}
            for name, way in ways.items():
                fields = way(case)[""]
                assert fields.mean is not None
                errors = [
                    error(case.surface, fields)
                    for error in (est.gauss_error, *map(est.principal_error, (0, 1)))
                ]
                row(
                    "even" if even else "random",
                    f"{radius:g}",
                    name,
                    percent(est.mean_error(case.surface, fields)),
                    ("1 %" if even else "2 %") if name == "default" else "",
                    percent(float(np.mean(fields.mean > 0.0))),
                    *("" if np.isnan(error) else percent(error) for error in errors),
                    f"{est.normal_error(case.surface, fields):.3g}°",
                )


def torus_section() -> None:
    """Compare normals and curvatures on tori with noise."""
    ours = {
        "cell normals alone, 30 points": est.cells_alone,
        "pcsmooth, support 30": est.by_options(support=COUNT),
        "pcsmooth, support auto": est.by_default,
    }
    normal_ways: dict[str, Way] = {
        **ours,
        "Open3D, k 30": est.by_peer("open3d_normals", COUNT),
        "CGAL PCA, k 30": est.by_peer("cgal_pca", COUNT),
        "CGAL jets, k 30": est.by_peer("cgal_jet", COUNT),
        "CGAL jets, best k": est.by_peer("cgal_jet", *COUNTS[:10]),
        "CGAL VCM, best radius": est.by_voronoi_covariance,
        "MeshLab planes, best k and smoothing": est.by_meshlab,
        "osculating jets of degree 2 to 4, best k": est.by_jets(2, 3, 4),
    }
    mean_ways: dict[str, Way] = {
        "pcsmooth, support 30": ours["pcsmooth, support 30"],
        "pcsmooth, support auto": est.by_default,
        **REPORT_WAYS,
        "gradients over cell volumes, 30 points": est.by_cell_measures(COUNT),
        **JET_WAYS,
        APSS: est.by_apss,
    }
    for isotropic in (False, True):
        kind = "in all directions" if isotropic else "along the normals"
        cases = [Case(torus(20_000, noise, isotropic)) for noise in NOISES]
        heading(f"Torus (1, 0.4), 20,000 random points, noise {kind}", JETS_NOTE)
        print("Median error of normals, degrees:\n")
        targets = {"cell normals alone, 30 points": "0.5 / 0.9 / 2.0 / 4.4"}
        targets["pcsmooth, support 30"] = targets["cell normals alone, 30 points"]
        noise_table(normal_ways, cases, est.normal_error, "{:.3f}".format, targets)
        print("\nMedian relative error of the mean curvature:\n")
        targets = {"pcsmooth, support auto": "2 % where clean"}
        noise_table(mean_ways, cases, est.mean_error, percent, targets)
        if isotropic:
            continue
        ways = {name: mean_ways[name] for name in mean_ways if name not in REPORT_WAYS}
        del ways["gradients over cell volumes, 30 points"]
        for name, error in (
            ("Gaussian curvature", est.gauss_error),
            ("principal curvature k1", est.principal_error(0)),
            ("principal curvature k2", est.principal_error(1)),
        ):
            print(f"\nMedian relative error of the {name}:\n")
            noise_table(ways, cases, error, percent, {})


def noise_table(
    ways: Mapping[str, Way],
    cases: Sequence[Case],
    error: est.Error,
    form: est.Form,
    targets: Mapping[str, str],
) -> None:
    """Print one table: a row for each way, a column for each noise."""
    header("noise, spacings", *(f"{noise:g}" for noise in NOISES), *(["target"] if targets else []))
    for name, way in ways.items():
        cells = [describe(way, case, error, form) for case in cases]
        row(name, *cells, *([targets.get(name, "")] if targets else []))


def gauss_section() -> None:
    """Compare ideas for Gaussian and principal curvatures."""
    heading(
        "Ideas for Gaussian and principal curvatures, 20,000 random points",
        "From cell measures: K = 1.5 (r sum S / sum C - 1) / r² with visible areas S and cell "
        "volumes C, and H = sum of gradients along the normals / (2 sum C). " + JETS_NOTE,
    )
    ways: dict[str, Way] = {
        "shape operator, support auto": est.by_default,
        "shape operator, support 30": est.by_options(support=COUNT),
        "cell measures, 30 points": est.by_cell_measures(COUNT),
        "cell measures, 200 points": est.by_cell_measures(200),
        **JET_WAYS,
        APSS: est.by_apss,
    }
    noises = (0.0, 0.1)
    names = ("K", "k1", "k2")
    header("surface", "idea", *(f"{name}, noise {noise:g}" for noise in noises for name in names))
    shapes = {
        "sphere": partial(sphere, 20_000, 1.0, False),
        "torus (1, 0.4)": partial(torus, 20_000),
        "ellipsoid (1, 0.7, 0.5)": partial(ellipsoid, 20_000),
    }
    for shape, make in shapes.items():
        cases = [Case(make(noise=noise)) for noise in noises]
        for name, way in ways.items():
            errors = (est.gauss_error, *map(est.principal_error, (0, 1)))
            cells = [describe(way, case, error, percent) for case in cases for error in errors]
            row(shape, name, *cells)


def fandisk_section(data: Path | None) -> None:
    """Compare normals on the model of the thesis' Figure 37."""
    heading("Fandisk")
    if data is None:
        print("Skipped: --data names no folder with report/fandisk_simplified.xyz.")
        return
    clouds = {"the thesis'": np.loadtxt(data / "report" / "fandisk_simplified.xyz")}
    mesh = data / "meshes" / "fandisk.ply"
    if mesh.exists():
        clouds["20,000 random on the mesh"] = sample_mesh(mesh, 20_000)
    print(
        "Angles to the given normals in degrees, whatever the sign; turned: share of points whose "
        "normal is against them.\n"
    )
    header("points", "normals", "median", "90 %", "turned")
    for name, cloud in clouds.items():
        unknown = np.full(len(cloud), np.nan)
        case = Case(Surface(cloud[:, :3], cloud[:, 3:], unknown, unknown, np.nan))
        ways: dict[str, Way] = {"default": est.by_default}
        for radius in ("1.5x", "3x", "4x"):
            ways[f"radius {radius}"] = est.by_options(radius=radius)
        for support in (6, 12, COUNT):
            ways[f"support {support}"] = est.by_options(support=support)
        ways["cell normals alone, 30 points"] = est.cells_alone
        ways["gradients of the volume, as in the thesis"] = est.gradients_alone
        for peer, program in (("Open3D", "open3d_normals"), ("CGAL jets", "cgal_jet")):
            for count in (8, 12, COUNT):
                ways[f"{peer}, k {count}"] = est.by_peer(program, count)
        for label, way in ways.items():
            row(name, label, *fandisk_cells(way, case))


def fandisk_cells(way: Way, case: Case) -> tuple[str, str, str]:
    """Median and 90th percentile of the angles, and the share of turned normals."""
    try:
        fields = way(case)[""]
    except PeerError as failure:
        return str(failure), "", ""
    assert fields.normals is not None
    angles = est.normal_angles(case.surface, fields)
    against = np.sum(fields.normals * case.surface.normals, axis=1) < 0.0
    turned = percent(float(against.mean())) if fields.has_signs else ""
    return f"{np.median(angles):.3g}", f"{np.percentile(angles, 90):.3g}", turned


def sample_mesh(path: Path, n_points: int) -> est.Array:
    """Sample a mesh uniformly by area: points and normals of their faces, (n, 6)."""
    mesh = trimesh.load_mesh(path)
    points, faces = trimesh.sample.sample_surface(mesh, n_points, seed=0)
    return np.concatenate([points, mesh.face_normals[faces]], axis=1)


def speed_section(scale: float) -> None:
    """Time the estimate beside the measures it is made of."""
    n_points = round(1_000_000 * scale)
    heading(f"Time on a torus of {n_points:,} random points, noise 0.1 spacings, {THREADS} threads")
    header("radius, spacings", "measure_balls, s", "estimate_curvature, s", "ratio", "target")
    points, spacing = noisy_torus(n_points, 0.1)
    with thread_limit(THREADS):
        for multiple in (2, 3):
            radius = multiple * spacing
            measured, estimated = median_seconds(
                partial(measure_balls, points, radius),
                partial(estimate_curvature, points, radius=radius),
            )
            cells = (f"{measured:.3g}", f"{estimated:.3g}", f"{estimated / measured:.2f}")
            row(str(multiple), *cells, "2.0")


def main() -> None:
    """Print the sections asked for."""
    parser = argparse.ArgumentParser(description="Print tables of errors and times.")
    parser.add_argument("--data", type=Path, help="folder with the fandisk files [none]")
    parser.add_argument("--scale", type=float, default=1.0, help="share of the timed points [1]")
    parser.add_argument("section", nargs="*", help="ellipse, spheres, torus, gauss, fandisk, speed")
    options = parser.parse_args()
    sections: dict[str, Callable[[], None]] = {
        "ellipse": ellipse_section,
        "spheres": sphere_section,
        "torus": torus_section,
        "gauss": gauss_section,
        "fandisk": partial(fandisk_section, options.data),
        "speed": partial(speed_section, options.scale),
    }
    unknown = set(options.section) - set(sections)
    if unknown:
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {', '.join(sections)}")
    print(machine_line())
    for name in options.section or sections:
        sections[name]()


if __name__ == "__main__":
    main()
