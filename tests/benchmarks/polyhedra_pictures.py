"""Draw what unions of convex polyhedra do: straight walls, and the report's Figure 38."""

from functools import partial
from typing import get_args

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from polyhedra_shapes import FIGURE_38, Hull, flowing_sphere, hull_beside
from readme_pictures import AFTER, BEFORE, save

from pcsmooth import denoise, load_presets
from pcsmooth.energies.protocol import UnionName

Array = npt.NDArray[np.float64]

#: Corners of a floor plan, m.
WALLS = np.array([[0, 0], [10, 0], [10, 4], [6, 4], [6, 7], [3, 7], [3, 5], [0, 5]], dtype=float)

STEPS = 40

#: Elevation and azimuth, degrees.
VIEW = (22.0, -62.0)


def noisy_walls(n_points: int, noise: float, seed: int = 0) -> tuple[Array, float]:
    """Sample the walls at random, with noise in both coordinates in units of the spacing."""
    rng = np.random.default_rng(seed)
    along = np.roll(WALLS, -1, axis=0) - WALLS
    ends = np.cumsum(np.linalg.norm(along, axis=1))
    spacing = float(ends[-1]) / n_points
    place = rng.uniform(0.0, ends[-1], n_points)
    wall = np.searchsorted(ends, place)
    share = 1.0 - (ends[wall] - place) / np.linalg.norm(along, axis=1)[wall]
    points = WALLS[wall] + share[:, np.newaxis] * along[wall]
    return points + noise * spacing * rng.standard_normal(points.shape), spacing


def distance_to_walls(points: Array) -> Array:
    """Distance of each point to the nearest wall."""
    distances = []
    for start, end in zip(WALLS, np.roll(WALLS, -1, axis=0), strict=True):
        along = end - start
        share = np.clip((points - start) @ along / (along @ along), 0.0, 1.0)
        nearest = start + share[:, np.newaxis] * along
        distances.append(np.linalg.norm(points - nearest, axis=1))
    return np.asarray(np.min(distances, axis=0))


def walls() -> None:
    """Show a noisy floor plan denoised with balls and with squares."""
    points, spacing = noisy_walls(400, 1.5)
    square = load_presets()["square"]
    flow = partial(denoise, points, scheme="euler", radius="5x", iterations=30)
    balls, squares = flow().points, flow(polyhedron=square).points
    figure, axes = plt.subplots(1, 3, figsize=(10, 3.1), sharex=True, sharey=True)
    titles = ("noisy", "balls", "squares, exact union")
    for axis, cloud, title in zip(axes, (points, balls, squares), titles, strict=True):
        rms = np.sqrt(np.mean(distance_to_walls(cloud) ** 2)) / spacing
        axis.plot(*np.append(WALLS, WALLS[:1], axis=0).T, color="0.75", lw=0.8, zorder=0)
        axis.plot(*cloud.T, ".", ms=2.5, color=BEFORE if cloud is points else AFTER)
        axis.set_title(f"{title}: RMS distance {rms:.2f} spacings", fontsize=9)
        axis.set_aspect("equal")
        axis.set_axis_off()
    figure.tight_layout(w_pad=0.5)
    save(figure, "walls.png")


def spheres() -> None:
    """Show K, and what a sphere of 1,000 points becomes with K in the three unions."""
    unions: tuple[UnionName, ...] = get_args(UnionName)
    figure = plt.figure(figsize=(11, 7))
    for line, name in enumerate(FIGURE_38):
        body = load_presets()[name]
        clouds = {name: body.vertices}
        for union in unions:
            *_, clouds[union] = flowing_sphere(1000, body, union, STEPS, automatic=True)
        *_, clouds["exact, equal steps"] = flowing_sphere(1000, body, "exact", STEPS)
        for column, (title, points) in enumerate(clouds.items()):
            axis = figure.add_subplot(3, 5, 5 * line + column + 1, projection="3d")
            assert isinstance(axis, Axes3D)
            hull = hull_beside(points, body)
            draw_hull(axis, hull, column == 0)
            if column > 0:
                title = f"{title}, {hull.median_angle:.1f}°"
            axis.set_title(title, fontsize=9, y=0.98)
    figure.subplots_adjust(left=0.0, right=1.0, bottom=0.0, top=0.95, wspace=0.0, hspace=0.08)
    save(figure, "polyhedra.png")


def draw_hull(axis: Axes3D, hull: Hull, plain: bool) -> None:
    """Draw a hull, coloured by the nearest facet of K and paler where it is far from it."""
    up, around = np.radians(VIEW)
    eye = np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])
    seen = hull.normals @ eye > 0.0
    colors = plt.get_cmap("tab20")(hull.nearest[seen] % 20)[:, :3]
    light = 0.75 + 0.25 * hull.normals[seen] @ np.array([0.36, -0.48, 0.8])
    near = np.clip(1.0 - hull.angles[seen] / 40.0, 0.15, 1.0)
    colors = (near * light)[:, np.newaxis] * colors + (1.0 - near)[:, np.newaxis]
    edges = "none" if plain else "0.35"
    shape = Poly3DCollection(hull.triangles[seen], facecolors=colors, edgecolors=edges, lw=0.15)
    axis.add_collection3d(shape)
    corners = hull.triangles.reshape(-1, 3)
    reach = np.linalg.norm(corners, axis=1).max()
    axis.set_xlim(-reach, reach)
    axis.set_ylim(-reach, reach)
    axis.set_zlim(-reach, reach)
    axis.set_box_aspect((1, 1, 1), zoom=1.5)
    axis.set_proj_type("ortho")
    axis.view_init(*VIEW)
    axis.patch.set_visible(False)
    axis.set_axis_off()


if __name__ == "__main__":
    walls()
    spheres()
