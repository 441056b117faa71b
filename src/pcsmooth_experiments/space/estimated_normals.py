"""Gradients of unions of polyhedra near the ball as normals (Figures 36 and 37)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.presets import load_presets
from pcsmooth.cloud import NORMALS
from pcsmooth.energies.polyhedra.union import measure_polyhedra
from pcsmooth.energies.protocol import UnionName
from pcsmooth.formats import read_cloud
from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth.plots.figures import new_figure
from pcsmooth.python.estimating import estimate_curvature
from pcsmooth_experiments.claims import verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table, Verdict
from pcsmooth_experiments.sampled_shapes import spheroid
from pcsmooth_experiments.space.ring_sector import sample_ring_sector

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]

#: Cloud of the thesis' Figure 37, which is not shipped, and the spacing of what stands in.
_FANDISK = "fandisk_simplified.xyz"
_STAND_IN, _STAND_IN_SPACING = "ring sector, for the fandisk", 0.055

#: Radii in spacings; the thesis gives none. The first decides.
_RADII = (2.0, 1.5, 3.0)

_BODY = "sphere-200"

#: What the thesis' words are taken for: gradients are oriented like the normals if half of them
#: are within these angles, degrees; norms are relatively constant if their standard deviation is
#: no more than this share of their mean.
_LIKE_NORMALS, _LIKE_NORMALS_CAD = 5.0, 10.0
_CONSTANT = 0.2


@dataclass(frozen=True)
class Gradients:
    """Gradients of a union beside the true normals.

    Attributes
    ----------
    radius : float
        r in mean spacings.
    union : {"naive", "exact"}
        How the union is computed.
    vectors : ndarray, shape (n, 3)
        Gradients of its volume, L^2.
    angles : ndarray, shape (n,)
        To the true outward normals, degrees.
    """

    radius: float
    union: UnionName
    vectors: Array
    angles: Array

    @property
    def spread(self) -> float:
        """Standard deviation of the norms over their mean."""
        lengths = np.linalg.norm(self.vectors, axis=1)
        return float(lengths.std() / lengths.mean())


@dataclass(frozen=True)
class Estimates:
    """All estimates for one cloud.

    Attributes
    ----------
    name : str
        What it is.
    points, normals : ndarray, shape (n, 3)
        Positions, L, and true outward unit normals.
    gradients : tuple of Gradients
        The first is that which decides.
    own_angles : ndarray, shape (n,)
        Angles of the normals of `estimate_curvature` to the true ones, degrees.
    """

    name: str
    points: Array
    normals: Array
    gradients: tuple[Gradients, ...]
    own_angles: Array

    @property
    def decisive(self) -> Gradients:
        """Naive gradients at two spacings."""
        return self.gradients[0]


def measure_normals(
    name: str, points: Array, normals: Array, radii: tuple[float, ...] = _RADII
) -> Estimates:
    """Measure how gradients of unions of polyhedra near the ball deviate from known normals.

    Parameters
    ----------
    name : str
        What the cloud is.
    points, normals : ndarray, shape (n, 3)
        Positions, L, and outward normals of any length but 0.
    radii : tuple of float
        In mean spacings; for the first there is the exact union beside the naive one.

    Returns
    -------
    Estimates
    """
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    spacing = mean_spacing(points)
    body = load_presets()[_BODY]
    cases: list[tuple[float, UnionName]] = [(radius, "naive") for radius in radii]
    found = []
    for radius, union in [*cases, (radii[0], "exact")]:
        vectors = measure_polyhedra(points, radius * spacing, body, union).volume_gradient
        found.append(Gradients(radius, union, vectors, degrees_between(vectors, unit)))
    own = estimate_curvature(points).normals
    return Estimates(name, points, unit, tuple(found), degrees_between(own, unit))


def degrees_between(vectors: Array, normals: Array) -> Array:
    """Angles between vectors, of any length, and unit normals, (n,); 90 of a vector 0."""
    lengths = np.linalg.norm(vectors, axis=1)
    along = np.einsum("ij,ij->i", vectors, normals)
    cosines = np.divide(along, lengths, out=np.zeros_like(along), where=lengths > 0.0)
    return np.asarray(np.degrees(np.arccos(cosines.clip(-1.0, 1.0))))


def draw_normals(found: tuple[Estimates, ...]) -> Figure:
    """Draw the gradients on the thesis' sphere and the CAD model, and how angles spread."""
    figure = new_figure(13.0, 4.6)
    _draw_arrows(figure, 131, found[0], longest=0.45, view=(20.0, -50.0))
    _draw_arrows(figure, 132, found[-1], longest=0.35, view=(35.0, -60.0))
    axes = figure.add_subplot(133)
    for one, color in zip(found, ("tab:blue", "tab:green", "tab:red"), strict=True):
        shares = 100.0 * (np.arange(len(one.points)) + 1.0) / len(one.points)
        axes.semilogx(
            np.sort(one.decisive.angles).clip(0.03), shares, color=color,
            label=f"{one.name}: gradients, naive",
        )  # fmt: skip
        axes.semilogx(
            np.sort(one.own_angles).clip(0.03), shares, "--", color=color,
            label=f"{one.name}: pcsmooth curvature",
        )  # fmt: skip
    axes.set_xlabel("angle to the true normal, degrees", fontsize=9)
    axes.set_ylabel("points within it, %", fontsize=9)
    axes.tick_params(labelsize=8)
    axes.grid(alpha=0.25)
    axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)
    return figure


def _draw_arrows(
    figure: Figure, place: int, one: Estimates, longest: float, view: tuple[float, float]
) -> None:
    axes = figure.add_subplot(place, projection="3d")
    elevation, azimuth = np.radians(view)
    towards = np.array([
        np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
    ])  # fmt: skip
    seen = one.normals @ towards > 0.1
    extent = float(np.ptp(one.points, axis=0).max())
    lengths = np.linalg.norm(one.decisive.vectors, axis=1)
    arrows = one.decisive.vectors / np.percentile(lengths, 98.0) * longest * extent / 2.0
    wrong = seen & (one.decisive.angles > 30.0)
    for chosen, color in ((seen & ~wrong, "tab:blue"), (wrong, "tab:red")):
        axes.quiver(*one.points[chosen].T, *arrows[chosen].T, color=color, lw=0.6)
    axes.scatter(*one.points[seen].T, color="k", s=2, depthshade=False)
    axes.set_box_aspect(np.ptp(one.points, axis=0), zoom=1.0)
    axes.view_init(*view)
    axes.set_axis_off()
    axes.set_title(
        f"{one.name}: {len(one.points)} points, naive, {_BODY}\nmedian angle "
        f"{np.median(one.decisive.angles):.1f}°, red beyond 30°",
        fontsize=9,
    )


def judge(found: tuple[Estimates, ...]) -> Verdict:
    """Compare with the thesis' words, naive union at two spacings.

    On its sphere half of the gradients are within 5 degrees of the outward normals; their norms
    have a standard deviation of no more than 0.2 of the mean; on the CAD model half of the
    gradients are within 10 degrees. All, some or none of these hold.
    """
    sphere, model = found[0].decisive, found[-1].decisive
    holds = (
        float(np.median(sphere.angles)) <= _LIKE_NORMALS,
        sphere.spread <= _CONSTANT,
        float(np.median(model.angles)) <= _LIKE_NORMALS_CAD,
    )
    return verdict_on(holds)


_EXPLANATION = """
The fandisk's file is not shipped; where it is missing a third of a thick ring with exact normals
stands in for it. The true normals are those of the files; on the sphere they are themselves 1.6
degrees from the radii in the median. A gradient is the mean curvature vector times the point's
share of the surface, so its norm is as uneven as the points: on a sphere of as many even points
it is nearly constant. On flat faces the mean curvature is 0, and what is left of the gradient is
the unevenness of the points, along the surface: only edges and curved parts give a direction, and
on concave parts it is the inward normal. Larger radii weaken the tangential part. The normals of
pcsmooth curvature come from the cells' tensors instead, which need no curvature.
""".strip().replace("\n", " ")


def outcome_of(found: tuple[Estimates, ...]) -> Outcome:
    """Put the numbers into words and tables."""
    sphere, even, model = found
    angles, own = model.decisive.angles, model.own_angles
    caption = (
        "Sphere: gradients "
        f"{np.median(sphere.decisive.angles):.1f}° off the normals (median); norms "
        f"vary by {sphere.decisive.spread:.2f} of their mean (even points "
        f"{even.decisive.spread:.2f}); {model.name}: {np.median(angles):.0f}°, 90 % "
        f"{np.percentile(angles, 90):.0f}°; pcsmooth {np.median(own):.0f}°, "
        f"{np.percentile(own, 90):.0f}°."
    )
    tables = {"normals-angles": _summary(found)}
    for key, one in (("sphere", sphere), ("model", model)):
        tables[f"normals-{key}"] = {
            **{axis: one.points[:, i] for i, axis in enumerate("xyz")},
            **{f"gradient_{axis}": one.decisive.vectors[:, i] for i, axis in enumerate("xyz")},
            "angle": one.decisive.angles,
            "angle_pcsmooth": one.own_angles,
        }
    return Outcome(judge(found), caption, partial(draw_normals, found), tables, _EXPLANATION)


def _summary(found: tuple[Estimates, ...]) -> Table:
    rows: list[tuple[str, str, float, Array, float]] = []
    for one in found:
        for case in one.gradients:
            rows.append(
                (one.name, f"gradient, {case.union}", case.radius, case.angles, case.spread)
            )
        rows.append((one.name, "pcsmooth curvature", 2.0, one.own_angles, 0.0))
    return {
        "cloud": np.array([row[0] for row in rows]),
        "normals_from": np.array([row[1] for row in rows]),
        "radius_in_spacings": np.array([row[2] for row in rows]),
        "median_angle": np.array([np.median(row[3]) for row in rows]),
        "angle_of_90_percent": np.array([np.percentile(row[3], 90.0) for row in rows]),
        "spread_of_norms": np.array([row[4] for row in rows]),
    }


def _with_normals(inputs: Inputs, name: str) -> tuple[Array, Array]:
    """Read a cloud and the normals that its file gives."""
    points = inputs.points(name)  # says what to do if there is no such file
    columns = read_cloud(inputs.folder / name).columns
    return points, np.stack([columns[axis].astype(np.float64) for axis in NORMALS], axis=1)


def _run(inputs: Inputs) -> Outcome:
    points, normals = _with_normals(inputs, "sphere_1k.xyz")
    even = spheroid().sample(len(points), "even")
    if inputs.has(_FANDISK):
        model = measure_normals("fandisk", *_with_normals(inputs, _FANDISK))
    else:
        model = measure_normals(_STAND_IN, *sample_ring_sector(_STAND_IN_SPACING))
    return outcome_of((
        measure_normals("report's sphere", points, normals),
        measure_normals("even sphere", even.points, even.normals),
        model,
    ))  # fmt: skip


EXPERIMENT = Experiment(
    "normals",
    "Figures 36 and 37",
    "gradients of unions of polyhedra near the ball as normals",
    _run,
)
