"""
A noisy ellipse, by the filter and by flows
===========================================

The thesis' 200 noisy points of an ellipse, and what the ways to denoise make of them. The filter,
which is the default, leaves the ellipse as large as it was. A flow moves every point down the
gradient of an energy of the union of discs around the points: its area or its perimeter.
"""

import matplotlib.pyplot as plt
from shipped import DATA

import pcsmooth

points = pcsmooth.read_cloud(DATA / "report" / "ellipse-noisy-dense.xy").points

# %%
# The perimeter flow is the thesis' own, in its 59 steps. Of the filter there are two kinds: free,
# it also spreads points evenly along the curve; with `motion="normal"` none moves along it.
ways = {
    "pcsmooth denoise": {},
    "--motion normal": {"motion": "normal"},
    "--scheme euler --energy area --weight none\n--radius 15 --step 1 --iterations 59": {
        "scheme": "euler",
        "energy": "area",
        "weight": "none",
        "radius": 15.0,
        "step": 1.0,
        "iterations": 59,
    },
    "--scheme euler --radius 15 --iterations 20": {
        "scheme": "euler",
        "radius": 15.0,
        "iterations": 20,
    },
    "--scheme implicit": {"scheme": "implicit"},
}
figure, axes = plt.subplots(2, 3, figsize=(11, 6), sharex=True, sharey=True, layout="constrained")
axes[0, 0].plot(*points.T, ".", ms=3, color="tab:red")
axes[0, 0].set_title("200 noisy points", fontsize=9)
for axis, (title, options) in zip(axes.flat[1:], ways.items(), strict=False):
    result = pcsmooth.denoise(points, **options)
    axis.quiver(*result.points.T, *result.normals.T, color="0.7", width=0.002, scale=25)
    axis.plot(*result.points.T, ".", ms=3, color="tab:blue")
    axis.set_title(title, fontsize=9)
for axis in axes.flat:
    axis.set_aspect("equal")
    axis.set_axis_off()
