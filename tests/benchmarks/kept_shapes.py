"""How volumes, sharp edges and densities survive denoising, as Markdown tables."""

from collections.abc import Sequence

import numpy as np
import smoothers as ways
from mesh_shapes import NOISES, Shape
from peers import PeerError
from shape_keeping import (
    REACH,
    SHARP,
    distances_along,
    largest_hole,
    near_sharp_edges,
    volume_change,
)
from surface_distances import distances_to_mesh, root_mean_square
from tables import header, heading, percent, row

from pcsmooth.neighbors.spacing import mean_spacing

MOST = 0.999  #: share of the clean points below whose largest distance holes are rare


def kept_section(shapes: Sequence[Shape], n_points: int, seed: int) -> None:
    """Show how volumes, edges and densities change."""
    noise = NOISES[0]
    names = (*ways.INPUT, *ways.OURS, ways.JETS[24], ways.JETS[50])
    heading(
        f"Shape kept: {n_points:,} points, noise {percent(noise)}, seed {seed}",
        "Change of the volume: the area times the mean signed distance to the mesh, over the "
        "volume. Largest hole: the largest distance of a clean point to the cloud, in mean "
        "spacings of the clean cloud.",
    )
    header("shape", *(f"{kind}: {name}" for kind in ("volume", "hole") for name in names))
    try:
        for shape in shapes:
            clean, unit = shape.sample(n_points, seed)
            spacing = mean_spacing(clean)
            noisy = clean + noise * unit
            changes, holes = [], []
            for name in names:
                points = ways.SMOOTHERS[name](noisy, spacing)
                changes.append(f"{100 * volume_change(points, shape):+.2f} %")
                holes.append(f"{largest_hole(points, clean) / spacing:.2f}")
            row(shape.name, *changes, *holes)
        holes_along(shapes, n_points, seed, names)
        sphere_radii(shapes, n_points, seed, names)
        sharp_edges(shapes, n_points, seed, names)
    except PeerError as failure:
        print(f"\nStopped: a program {failure}.")


def holes_along(shapes: Sequence[Shape], n_points: int, seed: int, names: Sequence[str]) -> None:
    """Print holes where the surface may have moved but has no gap."""
    print(
        "\nDistances of the clean points to the cloud along the surface, in spacings: the largest, "
        f"and the largest but for {percent(1 - MOST)} of the points. Detail that has become lower "
        "is no hole.\n"
    )
    header("shape", *names)
    for shape in shapes:
        clean, unit = shape.sample(n_points, seed)
        spacing = mean_spacing(clean)
        cells = []
        for name in names:
            points = ways.SMOOTHERS[name](clean + NOISES[0] * unit, spacing)
            holes = distances_along(points, clean, shape, spacing) / spacing
            cells.append(f"{holes.max():.2f}, {np.quantile(holes, MOST):.2f}")
        row(shape.name, *cells)


def sphere_radii(shapes: Sequence[Shape], n_points: int, seed: int, names: Sequence[str]) -> None:
    """Print the mean radius of denoised spheres."""
    for shape in shapes:
        if shape.name == "sphere":
            clean, unit = shape.sample(n_points, seed)
            spacing = mean_spacing(clean)
            print(f"\nMean radius of the sphere ({np.linalg.norm(clean, axis=1).mean():.5f}):\n")
            header("noise", *names)
            for noise in NOISES:
                radii = (
                    np.linalg.norm(ways.SMOOTHERS[name](clean + noise * unit, spacing), axis=1)
                    for name in names
                )
                row(percent(noise), *(f"{found.mean():.5f}" for found in radii))


def sharp_edges(shapes: Sequence[Shape], n_points: int, seed: int, names: Sequence[str]) -> None:
    """Print distances to the mesh near the edges of the fandisk."""
    for shape in shapes:
        if shape.name == "fandisk":
            clean, unit = shape.sample(n_points, seed)
            spacing = mean_spacing(clean)
            near = near_sharp_edges(clean, shape, spacing)
            print(
                f"\nFandisk: RMS distance to the mesh, in spacings, of the {near.sum():,} points "
                f"within {REACH:g} spacings of an edge of more than {SHARP:g}°, and of the "
                "others:\n"
            )
            parts = {"edges": near, "rest": ~near}
            header("noise", *(f"{part}: {name}" for part in parts for name in names))
            for noise in NOISES:
                distances = [
                    distances_to_mesh(
                        ways.SMOOTHERS[name](clean + noise * unit, spacing),
                        shape.vertices,
                        shape.faces,
                    )
                    for name in names
                ]
                cells = (
                    root_mean_square(far[part]) / spacing
                    for part in parts.values()
                    for far in distances
                )
                row(percent(noise), *map("{:.3f}".format, cells))
