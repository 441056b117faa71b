"""The page on how a cloud was denoised: what was chosen, what came of it, pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import pcsmooth
from pcsmooth.denoise_result import DenoiseResult
from pcsmooth.plots.cloud_figure import cloud_figure
from pcsmooth.plots.energy_figure import MEASURES, energy_figure
from pcsmooth.plots.figures import png_of
from pcsmooth.plots.page import heading, page, paragraph, picture, table
from pcsmooth.plots.valued_clouds import by_curvature, by_displacement, magnitudes
from pcsmooth.plots.views import facing
from pcsmooth.point_counts import exceptions_in_words

#: The mean curvature shown, by the convention of the summary.
_FORMULAS = {None: "k", "half": "H = (k1+k2)/2", "sum": "H = (k1+k2)/2; the file has k1+k2"}


def denoise_page(
    before: npt.NDArray[np.float64], result: DenoiseResult, summary: Mapping[str, Any]
) -> str:
    """Write the page.

    Parameters
    ----------
    before : ndarray, shape (n, d)
        The points that were denoised, L.
    result : DenoiseResult
        What came of them.
    summary : mapping
        The summary of the command as it is written in JSON; the time it took is left out, so that
        the same input gives the same page.

    Returns
    -------
    str
        HTML that needs no other file.

    Raises
    ------
    PcsmoothError
        If matplotlib is not installed.
    """
    view = facing(result.normals) if summary["dimension"] == 3 else None
    moved = by_displacement(before, result.points)
    curvature = np.where(result.normals.any(axis=1), result.mean_curvature, np.nan)
    curved = by_curvature({"after": (result.points, curvature)}, ["after"])
    numbers = magnitudes(moved.distributions["displacement"])
    in_spacings = [
        [name, f"{length:.6g}", f"{length / result.spacing:.4g}" if result.spacing else "-"]
        for name, length in zip(("mean", "median", "RMS", "max"), astuple(numbers), strict=True)
    ]
    return page(
        f"{Path(summary['input']).name}, denoised",
        [
            paragraph(
                "Lengths are in the unit of the file's coordinates, curvatures in 1 over that."
            ),
            heading("What was done", "choices"),
            table([], _choices(summary)),
            heading("How far the points moved", "displacement"),
            table(["displacement", "coordinate units", "mean spacings"], in_spacings),
            picture(
                png_of(cloud_figure(moved, view=view, spacing=result.spacing)),
                "The cloud before and after, coloured by displacement, and its histogram",
            ),
            *_energies(result, summary["dimension"]),
            heading("Curvature after", "curvature"),
            paragraph(
                f"{_FORMULAS[summary['mean_convention']]}, positive where the surface bends away "
                "from the normal."
            ),
            picture(
                png_of(cloud_figure(curved, view=view)),
                "The cloud after, coloured by mean curvature, and its histogram",
            ),
        ],
    )


def _choices(summary: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Say what was found and chosen, in rows of name and value."""
    is_filter = summary["scheme"] == "filter"
    yield "input", summary["input"]
    yield "output", summary["output"]
    points = f"{summary['points']} in {summary['dimension']}D"
    yield "points", ", ".join([points, *exceptions_in_words(summary)])
    yield "mean spacing", f"{summary['spacing']:.6g}"
    if summary["noise"] is not None:
        ratio = f"{summary['noise_ratio']:.2g} of the local spacing sqrt(area/points)"
        yield "noise", f"{summary['noise']:.4g}, {ratio}"
    yield "scheme", summary["scheme"]
    if is_filter and summary["surface"] is False:
        yield "surface", "none shows at any scale: no point moved"
    elif is_filter and summary["filter_support"] is not None:
        yield "neighbourhoods", f"{summary['filter_support']:.0f} points"
    if summary["outliers"] is not None:
        yield "outliers", f"{summary['outliers']}, left where they are"
    if not is_filter:
        yield "energy", summary["energy"]
        yield "weight", summary["weight"]
        yield "gradient", summary["gradient"]
        yield "iterations", _iterations(summary)
        yield "step", f"{summary['step']:.6g}"
    if summary["order"] is not None:
        yield "order", str(summary["order"])
        yield "solver iterations", str(sum(summary["solver_iterations"]))
    if "polyhedron" in summary:
        yield "polyhedron", summary["polyhedron"]
        yield "union", summary["union"]
    spacings = (
        f", {summary['radius'] / summary['spacing']:.3g} spacings" if summary["spacing"] else ""
    )
    yield "radius", f"{summary['radius']:.6g}{spacings}"
    yield "motion", summary["motion"] + (", volume kept" if summary["keep_volume"] else "")
    if summary["max_move"] is not None:
        yield "most that a point may move", f"{summary['max_move']:.4g}"
    yield "normals from", f"{summary['normal_support']:.0f} points"
    yield "curvature from", f"{summary['curvature_support']:.0f} points"
    yield "version", f"pcsmooth {pcsmooth.__version__}"


def _iterations(summary: Mapping[str, Any]) -> str:
    early = (
        f", stopped at less than {summary['stop']:g} spacings" if summary["stopped_early"] else ""
    )
    return f"{summary['iterations']}{early}"


def _energies(result: DenoiseResult, dimension: int) -> Iterator[str]:
    """Show the energies: a curve over the steps of a flow, start and end of a filter."""
    first, last = result.history[0], result.history[-1]
    names = MEASURES[dimension]
    yield heading(f"{names[0].capitalize()} and {names[1]}", "energy")
    yield paragraph(
        "Of the union of the bodies around the points. The filter follows the gradient of "
        "neither: they are measured before and after it."
        if result.method.name == "filter"
        else f"Of the union of the bodies around the points. The flow goes down the gradient of "
        f"the {names[result.method.shapes.quantity == 'area']}."
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
    if result.method.name != "filter" and len(result.history) > 1:
        yield picture(
            png_of(energy_figure(result.history, dimension)),
            f"{names[0].capitalize()} and {names[1]} of every state of the flow",
        )
