"""
What a sphere becomes with polyhedra
====================================

400 points of a sphere after 40 steps with a convex polyhedron K in place of the ball, as in the
thesis' Figure 38. The exact union turns the sphere into K; the naive one, each body within the
Voronoi cell of its point, leaves pillows on K's facets; inclusion-exclusion is between them.
"""

from itertools import product

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial import ConvexHull

import pcsmooth

N = 400
SPACING = np.sqrt(4.0 * np.pi / N)
ELEVATION, AZIMUTH = np.radians([22.0, -62.0])
EYE = np.array(
    [
        np.cos(ELEVATION) * np.cos(AZIMUTH),
        np.cos(ELEVATION) * np.sin(AZIMUTH),
        np.sin(ELEVATION),
    ]
)


def even_sphere(n_points):
    """Sample a sphere along a Fibonacci spiral."""
    z = 1.0 - (2.0 * np.arange(n_points) + 1.0) / n_points
    angle = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(n_points)
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), z], axis=1)


def draw_hull(axis, points, body):
    """Draw a convex hull, coloured by the nearest facet of K and paler where it is far from it."""
    hull = ConvexHull(points)
    normals = hull.equations[:, :3]
    seen = normals @ EYE > 0.0
    cosines = normals[seen] @ body.normals.T
    angles = np.degrees(np.arccos(np.clip(cosines.max(axis=1), -1.0, 1.0)))
    colors = plt.get_cmap("tab20")(cosines.argmax(axis=1) % 20)[:, :3]
    light = 0.75 + 0.25 * normals[seen] @ [0.36, -0.48, 0.8]
    near = np.clip(1.0 - angles / 40.0, 0.15, 1.0)
    colors = (near * light)[:, np.newaxis] * colors + (1.0 - near)[:, np.newaxis]
    triangles = points[hull.simplices]
    shown = Poly3DCollection(triangles[seen], facecolors=colors, edgecolors="0.35", lw=0.1)
    axis.add_collection3d(shown)
    reach = np.linalg.norm(points, axis=1).max()
    axis.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach))
    axis.set_box_aspect((1, 1, 1), zoom=1.5)
    axis.set_proj_type("ortho")
    axis.view_init(*np.degrees([ELEVATION, AZIMUTH]))
    axis.patch.set_visible(False)  # it would hide its neighbours
    axis.set_axis_off()


# %%
# Triangles of the convex hull have the colour of the facet of K that they are nearest to in
# direction, and are the paler the farther they are from it.
bodies = {name: pcsmooth.load_presets()[name] for name in ("cube", "bipyramid", "icosahedron")}
unions = ("naive", "inclusion-exclusion", "exact")
figure, axes = plt.subplots(3, 4, figsize=(9, 7), subplot_kw={"projection": "3d"})
for (line, (name, body)), column in product(enumerate(bodies.items()), range(4)):
    if column == 0:
        title, points = name, body.vertices
    else:
        title = unions[column - 1]
        points = pcsmooth.denoise(
            even_sphere(N),
            radius=2.0 * SPACING,
            polyhedron=body,
            union=title,
            iterations=40,
            threads=1,
        ).points
    draw_hull(axes[line, column], points, body)
    axes[line, column].set_title(title, fontsize=10, y=0.98)
figure.subplots_adjust(left=0.0, right=1.0, bottom=0.0, top=0.95, wspace=0.0, hspace=0.08)
