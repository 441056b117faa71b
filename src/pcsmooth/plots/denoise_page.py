"""The page on how a cloud was denoised: what was chosen, what came of it, pictures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple
from pathlib import Path

import numpy as np

import pcsmooth
from pcsmooth.denoising import Denoised
from pcsmooth.files.denoise_file import Sample
from pcsmooth.files.report import DenoiseReport
from pcsmooth.plots.cloud_figure import cloud_figure
from pcsmooth.plots.curve_figure import curve_figure
from pcsmooth.plots.energy_figure import MEASURES, energy_figure
from pcsmooth.plots.figures import png_of
from pcsmooth.plots.page import heading, page, paragraph, picture, table
from pcsmooth.plots.shaded_figure import shaded_figure
from pcsmooth.plots.valued_clouds import along_normals, by_curvature, by_displacement, magnitudes
from pcsmooth.plots.views import View, facing

#: The mean curvature shown, by the convention of the summary.
_FORMULAS = {None: "k", "half": "H = (k1+k2)/2", "sum": "H = (k1+k2)/2; the file has k1+k2"}


def denoise_page(sample: Sample, denoised: Denoised, report: DenoiseReport) -> str:
    """Write the page.

    Parameters
    ----------
    sample : Sample
        The points, or some of them.
    denoised : Denoised
        The cloud.
    report : DenoiseReport
        What was done; the time it took is left out, so that the same input gives the same page.

    Returns
    -------
    str
        HTML that needs no other file.

    Raises
    ------
    PcsmoothError
        If matplotlib is not installed.
    """
    dimension = report.points.dimension
    view = facing(sample.normals) if dimension == 3 else None
    moved = by_displacement(sample.before, sample.after)
    along = along_normals(moved, sample.normals)
    curvature = np.where(sample.normals.any(axis=1), sample.mean_curvature, np.nan)
    curved = by_curvature({"after": (sample.after, curvature)}, ["after"])
    numbers = magnitudes(moved.distributions["displacement"])
    in_spacings = [
        [name, f"{length:.6g}", f"{length / report.spacing:.4g}" if report.spacing else "-"]
        for name, length in zip(("mean", "median", "RMS", "max"), astuple(numbers), strict=True)
    ]
    return page(
        f"{Path(report.input).name}, denoised",
        [
            paragraph(
                "Lengths are in the unit of the file's coordinates, curvatures in 1 over that."
            ),
            heading("What was done", "choices"),
            table([], _choices(report)),
            *_shapes(sample, view),
            heading("How far the points moved", "displacement"),
            table(["displacement", "coordinate units", "mean spacings"], in_spacings),
            paragraph(
                "Along the normal after: red where a point moved the way its normal shows, "
                "outwards on closed shapes, blue where it moved against it, grey where it stayed. "
                "Noise that is taken out is red and blue mixed; an area of one colour has moved as "
                "a whole."
            ),
            picture(
                png_of(cloud_figure(along, view=view, spacing=report.spacing)),
                "The cloud before and after, coloured by the displacement along the normal, and "
                "its histogram",
            ),
            *_energies(denoised, report),
            heading("Curvature after", "curvature"),
            paragraph(
                f"{_FORMULAS[report.estimates.mean_convention]}, positive where the surface bends "
                "away from the normal. The scale leaves out 2 percent at either end."
            ),
            picture(
                png_of(cloud_figure(curved, view=view)),
                "The cloud after, coloured by mean curvature, and its histogram",
            ),
        ],
    )


def _shapes(sample: Sample, view: View | None) -> Iterator[str]:
    """Show a surface or a curve before and after."""
    yield heading("Before and after", "surfaces")
    if view is None:
        yield picture(
            png_of(curve_figure(sample.before, sample.after)),
            "The curve before and after, and the part that moved most",
        )
        return
    yield paragraph(
        "Lit from the left above. Before, each point is lit by the plane through the eight points "
        "nearest to it, so that noise is seen as roughness; after, by its normal."
    )
    yield picture(
        png_of(shaded_figure(sample.before, sample.after, sample.normals, view)),
        "The surface before and after, a part of it, and a thin slice through it",
    )


def _choices(report: DenoiseReport) -> Iterator[tuple[str, str]]:
    """Say what was found and chosen, in rows of name and value."""
    is_filter = report.scheme == "filter"
    yield "input", report.input
    yield "output", report.output
    points = f"{report.points.points} in {report.points.dimension}D"
    yield "points", ", ".join([points, *report.points.exceptions_in_words(report.fixed)])
    yield "mean spacing", f"{report.spacing:.6g}"
    if noise := report.noise_in_words():
        yield "noise", noise
    yield "moved", "; ".join(filter(None, (report.moved_in_words(), report.rms_in_words())))
    yield "scheme", report.scheme
    if is_filter and report.plan.surface is False:
        yield "surface", "none shows at any scale: no point moved"
    elif is_filter and report.plan.filter_support is not None:
        yield "neighbourhoods", f"{report.plan.filter_support:.0f} points"
    if report.outliers is not None:
        yield "outliers", report.outliers_in_words()
    if words := report.at_limit_in_words():
        yield "at their limit", words
    if not is_filter:
        yield "energy", report.energy
        yield "weight", report.weight
        yield "gradient", report.gradient or ""
        why = report.early_end_in_words()
        yield "iterations", f"{report.iterations}{why and f', stopped: {why}'}"
        yield "step", f"{report.step:.6g}"
    if report.order is not None:
        yield "order", str(report.order)
        yield "solver iterations", str(sum(report.solver_iterations))
    if report.shape is not None:
        yield "polyhedron", report.shape.polyhedron
        yield "union", report.shape.union
    if report.radius_range is not None:
        why = "" if report.sparse_share is None else "; one is too small for {:.0%} of the surface"
        words = "{:.6g} to {:.6g}".format(*report.radius_range)
        yield "local radius", words + why.format(report.sparse_share)
    elif not is_filter:
        spacings = f", {report.radius / report.spacing:.3g} spacings" if report.spacing else ""
        yield "radius", f"{report.radius:.6g}{spacings}"
    yield "motion", ", ".join(report.restraints_in_words()) or "free"
    yield "normals from", f"{report.estimates.normal_support:.0f} points"
    yield "curvature from", f"{report.estimates.curvature_support:.0f} points"
    yield "version", f"pcsmooth {pcsmooth.__version__}"


def _energies(denoised: Denoised, report: DenoiseReport) -> Iterator[str]:
    """Show the energies: a curve over the steps of a flow, start and end of a filter."""
    history, dimension = denoised.history, report.points.dimension
    first, last = history[0], history[-1]
    names = MEASURES[dimension]
    yield heading(f"{names[0].capitalize()} and {names[1]}", "energy")
    yield paragraph(
        "Of the union of the bodies around the points. The filter follows the gradient of "
        "neither: they are measured before and after it."
        if report.scheme == "filter"
        else f"Of the union of the bodies around the points. The flow goes down the gradient of "
        f"the {names[report.energy == 'area']}."
    )
    yield table(
        ["", "before", "after", "change"],
        [
            [name, f"{start:.9g}", f"{end:.9g}", f"{(end - start) / start:+.3%}" if start else "-"]
            for name, start, end in zip(
                names, (first.volume, first.area), (last.volume, last.area), strict=True
            )
        ],
    )
    if report.scheme != "filter" and len(history) > 1:
        yield picture(
            png_of(energy_figure(history, dimension)),
            f"{names[0].capitalize()} and {names[1]} of every state of the flow",
        )
