"""
A street from a laser station, near and far
===========================================

The scan of the tutorial on laser stations, every second row and column of it. The street is made
up (`street.py`), so that the error of every point is known. Points lie a centimetre apart beside
the scanner and half a metre apart at the ends of the street.
"""

import matplotlib.pyplot as plt
import numpy as np
from street import COLUMNS, HEIGHT, ROWS, scan

import pcsmooth

points, _ = scan(np.random.default_rng(0))
points = points.reshape(COLUMNS, ROWS, 3)[::2, ::2].reshape(-1, 3)
points = points[np.any(points != 0.0, axis=1)]
result = pcsmooth.denoise(points, motion="normal", max_move=0.04, orient="viewpoint=0,0,0")

# %%
# The noise of the ranges is the same everywhere, 12 mm, but not how far points are off their
# surface, nor how far they are apart. Both are measured place by place, and neighbourhoods are as
# wide as they ask for.
figure, axis = plt.subplots(figsize=(8, 3.6), layout="constrained")
far = np.linalg.norm(points, axis=1)
edges = np.array([2.0, 3, 4, 6, 8, 11, 15, 20, 26, 33])
on_ground = (np.abs(points[:, 2] + HEIGHT) < 0.06) & (np.abs(points[:, 1]) < 2.0)
on_facade = (np.abs(points[:, 1] + 6.0) < 0.06) & (np.abs(points[:, 2] - 3.0) < 4.0)
for chosen, normal, place, name, color in (
    (on_ground, 2, -HEIGHT, "the street", "tab:blue"),
    (on_facade, 1, -6.0, "the southern houses", "tab:orange"),
):
    for cloud, title, line in ((points, "scan", "--"), (result.points, "denoised", "-")):
        squares = 1e6 * (cloud[chosen, normal] - place) ** 2
        counts, _ = np.histogram(far[chosen], edges)
        sums, _ = np.histogram(far[chosen], edges, weights=squares)
        rms = np.sqrt(sums / np.where(counts > 50, counts, np.nan))
        middles = np.sqrt(edges[1:] * edges[:-1])
        axis.plot(middles, rms, line, color=color, label=f"{name}, {title}")
axis.set_xscale("log")
axis.set_xticks([], minor=True)
axis.set_xticks([2, 3, 5, 10, 20, 30], ["2", "3", "5", "10", "20", "30"])
axis.set_xlabel("distance from the scanner, m")
axis.set_ylabel("RMS distance to the truth, mm")
axis.legend(frameon=False, fontsize=8)
