"""Inclusion-exclusion over the alpha-complex, and its error for squares (Figure 33)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.bodies.presets import load_presets
from pcsmooth.energies.polyhedra.union import measure_polyhedra
from pcsmooth.plots.figures import new_figure
from pcsmooth_experiments.claims import verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Verdict
from pcsmooth_experiments.sampled_shapes import ellipse, spheroid
from pcsmooth_experiments.space.triple_complexes import (
    Simplex,
    alpha_complex,
    nerve_of_squares,
    square_complex,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]

#: Three points each, and squares of half side 1.
_TRIPLES = {
    "the thesis': triangle in L², not in L∞": [[0.0, 0.0], [0.15, 0.85], [1.3, 1.0]],
    "triangle not in L²": [[0.0, 0.0], [1.76, 0.0], [0.88, 1.54]],
    "edge and triangle not in L²": [[0.0, 0.0], [1.42, 1.42], [1.8, -0.1]],
}

#: A relative error below this is none.
_NONE = 1e-9

_SPACINGS = tuple(np.round(np.linspace(1.0, 2.2, 41), 6).tolist())
_ANGLES = tuple(np.linspace(0.0, 45.0, 13).tolist())
_RATIOS = tuple(np.round(np.linspace(0.5, 4.0, 22), 6).tolist())


@dataclass(frozen=True)
class Triple:
    """Three points with squares of half side 1.

    Attributes
    ----------
    name : str
        What it is an example of.
    points : ndarray, shape (3, 2)
        The points.
    alpha_complex, square_complex, nerve : frozenset of tuple of int
        Simplices of the alpha-complex, of that of the maximum norm, and of the nerve of the
        squares: all sets of squares that meet.
    computed, exact : float
        Area by inclusion-exclusion over the alpha-complex, and of the union.
    """

    name: str
    points: Array
    alpha_complex: frozenset[Simplex]
    square_complex: frozenset[Simplex]
    nerve: frozenset[Simplex]
    computed: float
    exact: float

    @property
    def error(self) -> float:
        """Relative error of the area."""
        return self.computed / self.exact - 1.0


@dataclass(frozen=True)
class Inclusion:
    """What was found about the error.

    Attributes
    ----------
    triples : tuple of Triple
        The examples; the first is the thesis'.
    spacings, angles : ndarray, shape (s,), (a,)
        Of endless square lattices: spacing over the half side of the squares, and angle to their
        sides, degrees.
    lattice_errors : ndarray, shape (a, s)
        Relative errors of the area of the union, per point of the lattice.
    ratios : ndarray, shape (q,)
        Half side or inradius over spacing of the clouds.
    cloud_errors : dict of str to ndarray, each (q,)
        Name of a cloud and body to relative errors of the volume.
    """

    triples: tuple[Triple, ...]
    spacings: Array
    angles: Array
    lattice_errors: Array
    ratios: Array
    cloud_errors: dict[str, Array]


def measure_inclusion(
    spacings: tuple[float, ...] = _SPACINGS,
    angles: tuple[float, ...] = _ANGLES,
    ratios: tuple[float, ...] = _RATIOS,
    on_curve: int = 400,
    on_surface: int = 1000,
) -> Inclusion:
    """Measure the error of inclusion-exclusion over the alpha-complex.

    Parameters
    ----------
    spacings, angles : tuple of float
        Of the lattices.
    ratios : tuple of float
        r over the spacing, on curves and surfaces.
    on_curve, on_surface : int
        Numbers of points there.

    Returns
    -------
    Inclusion
    """
    triples = tuple(_measure_triple(name, np.array(points)) for name, points in _TRIPLES.items())
    lattice = np.array([[_lattice_error(s, np.radians(a)) for s in spacings] for a in angles])
    bodies = load_presets()
    curve, surface = ellipse(1.0, 0.6), spheroid()
    random = np.random.default_rng(0).random((on_surface, 2))
    clouds = [
        ("ellipse", curve.sample(on_curve, "even").points, curve.area / on_curve, "square"),
        ("random in a square", random, on_surface**-0.5, "square"),
    ]
    for body in ("cube", "octahedron", "icosahedron"):
        points = surface.sample(on_surface, "even").points
        clouds.append(("sphere", points, (surface.area / on_surface) ** 0.5, body))
    errors = {
        f"{name}, {body}": np.array([
            _error(points, ratio * spacing, bodies[body]) for ratio in ratios
        ])
        for name, points, spacing, body in clouds
    }  # fmt: skip
    return Inclusion(
        triples, np.array(spacings), np.array(angles), lattice, np.array(ratios), errors
    )


def _measure_triple(name: str, points: Array) -> Triple:
    square = load_presets()["square"]
    return Triple(
        name,
        points,
        alpha_complex(points, 1.0),
        square_complex(points, 1.0),
        nerve_of_squares(points, 1.0),
        measure_polyhedra(points, 1.0, square, "inclusion-exclusion").volume,
        measure_polyhedra(points, 1.0, square, "exact").volume,
    )


def _error(points: Array, radius: float, body: ConvexBody) -> float:
    """Relative error of the volume by inclusion-exclusion."""
    computed = measure_polyhedra(points, radius, body, "inclusion-exclusion").volume
    return computed / measure_polyhedra(points, radius, body, "exact").volume - 1.0


def _lattice_error(spacing: float, angle: float) -> float:
    """Relative error per point of an endless square lattice, with squares of half side 1.

    What one row more adds, and of that what one column more adds, is free of the border.
    """
    square = load_presets()["square"]
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    per_point = {"inclusion-exclusion": 0.0, "exact": 0.0}
    for rows, columns in ((4, 4), (4, 5), (5, 4), (5, 5)):
        points = spacing * np.indices((rows, columns)).reshape(2, -1).T @ turn
        for union in per_point:
            volume = measure_polyhedra(points, 1.0, square, union).volume  # type: ignore[arg-type]
            per_point[union] += (-1) ** (rows + columns) * volume
    return per_point["inclusion-exclusion"] / per_point["exact"] - 1.0


def draw_inclusion(found: Inclusion) -> Figure:
    """Draw the three examples, the errors on lattices, and those on curves and surfaces."""
    figure = new_figure(13.0, 8.2)
    grid = figure.add_gridspec(2, 6)
    for column, triple in enumerate(found.triples):
        _draw_triple(figure.add_subplot(grid[0, 2 * column : 2 * column + 2]), triple)
    axes = figure.add_subplot(grid[1, :3])
    reach = float(np.abs(found.lattice_errors).max()) * 100.0
    drawn = axes.pcolormesh(
        found.spacings, found.angles, 100.0 * found.lattice_errors, cmap="RdBu_r", vmin=-reach,
        vmax=reach, shading="nearest",
    )  # fmt: skip
    figure.colorbar(drawn, ax=axes, label="relative error of the area, %")
    axes.axvline(np.sqrt(2.0), color="k", ls=":", lw=1.0)
    axes.axvline(2.0, color="k", ls=":", lw=1.0)
    axes.set_xlabel("spacing / r (triangles leave the complex at √2, edges at 2)", fontsize=9)
    axes.set_ylabel("angle of lattice and squares, degrees", fontsize=9)
    axes.set_title("endless square lattices", fontsize=9)
    axes = figure.add_subplot(grid[1, 3:])
    for name, errors in found.cloud_errors.items():
        axes.plot(found.ratios, 100.0 * errors, ".-", ms=4, lw=1.0, label=name)
    axes.axhline(0.0, color="k", lw=0.8)
    axes.set_xlabel("r / spacing", fontsize=9)
    axes.set_ylabel("relative error of the volume, %", fontsize=9)
    axes.set_title("clouds, with the body of the union", fontsize=9)
    axes.grid(alpha=0.25)
    axes.legend(fontsize=8)
    return figure


def _draw_triple(axes: Axes, triple: Triple) -> None:
    for x, y in triple.points:
        axes.fill(
            x + np.array([-1, 1, 1, -1]), y + np.array([-1, -1, 1, 1]), fc=(0.3, 0.5, 0.9, 0.12),
            ec="tab:blue", lw=0.8,
        )  # fmt: skip
    for complex_, color, width, label in (
        (triple.square_complex, "tab:green", 5.0, "complex of the maximum norm"),
        (triple.alpha_complex, "tab:red", 1.6, "alpha-complex"),
    ):
        for simplex in sorted(complex_, key=len):
            corners = triple.points[list(simplex)]
            if len(simplex) == 2:
                axes.plot(*corners.T, color=color, lw=width, solid_capstyle="round")
            elif len(simplex) == 3:
                axes.fill(*corners.T, color=color, alpha=0.25, lw=0)
        axes.plot([], [], color=color, lw=width, label=label)
    axes.plot(*triple.points.T, "k.", ms=7)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7)
    axes.set_title(
        f"{triple.name}\nnerve of the squares: {len(triple.nerve)} simplices, alpha-complex: "
        f"{len(triple.alpha_complex)}\narea {triple.computed:.4f}, union {triple.exact:.4f}: "
        f"{_signed(triple.error)}",
        fontsize=8,
    )
    if triple.name.startswith("the thesis"):
        axes.legend(fontsize=7, loc="upper left")


def _signed(error: float) -> str:
    return f"{100.0 * error:+.2f} %" if abs(error) > _NONE else "no error"


def judge(found: Inclusion) -> Verdict:
    """Compare with "there exist cases where the formula is not correct: see Figure 33".

    Two statements: there are points for which the area over the alpha-complex is not that of the
    union; and that is so where the triangle is in the alpha-complex but not in that of the
    maximum norm, as the figure says. Both, one or none of them hold, to a relative 1e-9.
    """
    holds = (
        any(abs(triple.error) > _NONE for triple in found.triples),
        any(
            abs(triple.error) > _NONE
            for triple in found.triples
            if (0, 1, 2) in triple.alpha_complex - triple.square_complex
        ),
    )
    return verdict_on(holds)


_EXPLANATION = """
The formula errs, as the thesis says, but not where its Figure 33 shows it: if the L2 alpha-complex
has the triangle, it has all simplices of three points, the sum over it is that over the nerve and
exact; and where the complex of the maximum norm lacks the triangle and one edge, because the third
square covers what the two others share, the sum over that is exact too. Every simplex of the L2
complex is in the nerve of the squares, which hold the disks; what errs is a simplex that is
missing although its squares meet. Missing triangles take away what squares share, down to
-(2 - sqrt 2)^2 / 2 = -17.2 % on square lattices along the axes with a spacing just above sqrt(2) r;
a missing edge counts the overlap of two squares twice, up to
2(2 - sqrt 2)^2 / (4 - 2(2 - sqrt 2)^2) = 20.7 % on a lattice turned by 45 degrees with a spacing
just above 2r. The thesis did not estimate the error. On even curves it is next to nothing, on
surfaces it grows with r over the spacing: it does not vanish as the points become dense.
""".strip().replace("\n", " ")


def outcome_of(found: Inclusion) -> Outcome:
    """Put the numbers into words and tables."""
    report, *others = found.triples
    dense = {
        name: 100.0 * errors[found.ratios >= 2.0] for name, errors in found.cloud_errors.items()
    }
    spheres = np.concatenate(
        [errors for name, errors in dense.items() if name.startswith("sphere")]
    )
    lattice = 100.0 * found.lattice_errors
    errors = " and ".join(f"{100.0 * triple.error:+.1f} %" for triple in others)
    caption = (
        f"The formula errs, but not in the thesis' case ({abs(100.0 * report.error):.1f} %): "
        f"missing simplices give {errors} for 3 squares, {lattice.min():.1f} to "
        f"{lattice.max():+.1f} % on lattices, {spheres.min():+.1f} to {spheres.max():+.1f} % on a "
        "sphere."
    )
    points = np.concatenate([triple.points for triple in found.triples])
    three = [3] * len(found.triples)
    tables = {
        "inclusion-exclusion-triples": {
            "example": np.repeat([triple.name for triple in found.triples], three),
            "x": points[:, 0],
            "y": points[:, 1],
            "alpha_complex": np.repeat([_spelled(t.alpha_complex) for t in found.triples], three),
            "maximum_norm": np.repeat([_spelled(t.square_complex) for t in found.triples], three),
            "nerve": np.repeat([_spelled(t.nerve) for t in found.triples], three),
            "area_computed": np.repeat([triple.computed for triple in found.triples], three),
            "area_exact": np.repeat([triple.exact for triple in found.triples], three),
        },
        "inclusion-exclusion-lattices": {
            "spacing_over_r": np.tile(found.spacings, len(found.angles)),
            "angle": np.repeat(found.angles, len(found.spacings)),
            "relative_error": found.lattice_errors.ravel(),
        },
        "inclusion-exclusion-clouds": {"r_over_spacing": found.ratios, **found.cloud_errors},
    }
    return Outcome(judge(found), caption, partial(draw_inclusion, found), tables, _EXPLANATION)


def _spelled(simplices: frozenset[Simplex]) -> str:
    return " ".join("".join(map(str, simplex)) for simplex in sorted(simplices, key=_by_size))


def _by_size(simplex: Simplex) -> tuple[int, Simplex]:
    return len(simplex), simplex


def _run(_inputs: Inputs) -> Outcome:
    return outcome_of(measure_inclusion())


EXPERIMENT = Experiment(
    "inclusion-exclusion",
    "Figure 33",
    "inclusion-exclusion over the alpha-complex for unions of squares and polyhedra",
    _run,
)
