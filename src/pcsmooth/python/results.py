"""What Python callers get: numbers that can be shown, written and drawn."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.denoised_rows import DenoisedRows
from pcsmooth.errors import InvalidInputError
from pcsmooth.files.denoise_file import denoised_piece
from pcsmooth.files.result_file import EstimatedPiece, result_cloud
from pcsmooth.files.writing import Writing
from pcsmooth.python.written_result import WrittenResult

if TYPE_CHECKING:
    from _typeshed import DataclassInstance
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class DenoiseResult(WrittenResult, DenoisedRows):
    """A denoised cloud, row i being row i of the input.

    Attributes
    ----------
    points : ndarray, shape (n, d)
        New positions, L.
    history : tuple of Record
        States 0 (the input) to N.
    curvature : CurvatureEstimate
        Normals and curvatures at the new positions.
    displacement : ndarray, shape (n,)
        Distance from old to new position, L.
    outliers : ndarray of bool, shape (n,), or None
        Points that the filter took for outliers and left where they are; None for flows.
    sigma : ndarray, shape (n,), or None
        Standard deviation of the noise of each point of the input along its normal, L; 0 for rows
        that are not finite. None for flows, and of too few points to filter.
    sigma_after : ndarray, shape (n,), or None
        Standard deviation of the error along the normal that is left of it, L: about 0.68 of the
        errors are smaller (see `errors_left`). That of a point that stayed is its noise. What a
        whole scan is off another, or its sensor off the truth, is not in it, nor what keeping a
        volume changes. Known where sigma is.
    method : Filter, EulerFlow or ImplicitFlow
        How it was denoised, with what was left open filled in.
    motion : Motion
        How points could move, lengths in L.
    spacing, radius, step : float
        Mean spacing of the input, radius and time step used; a filter has step 0. The radius is
        the median of local ones, of which the step is that of a ball of this radius.
    radii : ndarray, shape (n,), or None
        Radius of each ball, L, if it is local; 0 for rows that are not finite.
    plan : FilterPlan or None
        What was found of the cloud's noise and density, and the filter planned for it; None for
        the scheme euler, and where there are too few points.
    stopped_early : bool
        Whether the steps had become shorter than the tolerance before the last one.
    solver_iterations : tuple of int
        Iterations of the solver of linear equations in each step; empty if the scheme has none.
    solver_error : float
        Bound of the error that it has left, as a share of the step, in the worst step.
    finite : ndarray of bool, shape (n,)
        False for rows with a NaN, an infinity or a coordinate beyond 1e150, passed through.
    source : PointCloud
        The cloud that was given, whose columns and comments go with the result into a file.
    provenance : str
        What was done with which values, for a comment.
    """

    source: PointCloud
    provenance: str

    @classmethod
    def of(cls, rows: DenoisedRows, source: PointCloud, provenance: str) -> Self:
        """Make it of what came of all rows of a cloud."""
        return cls(**_values(rows), source=source, provenance=provenance)

    @property
    def displacement_vectors(self) -> npt.NDArray[np.float64]:
        """Ways from old to new positions, (n, d), L; zero for rows that are not finite."""
        vectors = np.zeros_like(self.points)
        vectors[self.finite] = self.points[self.finite] - self.source.points[self.finite]
        return vectors

    def facts(self) -> dict[str, str]:
        """Say the most important numbers, in words by name."""
        told = {
            "points": f"{len(self.points)} in {self.points.shape[1]}D",
            "method": self.method.name,
        }
        if self.plan is not None:
            told["noise"] = f"{self.plan.noise.deviation:.4g}"
        moved = self.displacement[self.finite]
        mean, most = (moved.mean(), moved.max()) if len(moved) else (0.0, 0.0)
        told["moved"] = f"{mean:.4g} on average, {most:.4g} at most"
        if self.outliers is not None:
            told["outliers"] = str(int(self.outliers.sum()))
        left_out = len(self.points) - int(self.finite.sum())
        return told | ({"took no part": str(left_out)} if left_out else {})

    def _cloud(self, path: str, writing: Writing | None) -> PointCloud:
        writing = writing or Writing()
        writing.check_moved_by(self.method.name)
        if writing.outliers != "mark":
            raise InvalidInputError(
                f"a result keeps all rows; outliers={writing.outliers!r} is for denoise_file"
            )
        piece = denoised_piece(self, self.source, writing)
        return result_cloud(piece, self.finite, path, writing, self.provenance)

    def _figure(self) -> Figure:
        """Draw surfaces, shaded, or curves, before and after."""
        from pcsmooth.plots.curve_figure import curve_figure
        from pcsmooth.plots.shaded_figure import shaded_figure
        from pcsmooth.plots.views import facing

        before, after = self.source.active_points, self.points
        if after.shape[1] == 3:
            return shaded_figure(before, after, self.normals, facing(self.normals))
        return curve_figure(before, after)


@dataclass(frozen=True, repr=False, kw_only=True)
class CurvatureResult(WrittenResult, CurvatureEstimate):
    """Normals and curvatures of a cloud, with the cloud: see `CurvatureEstimate`.

    Attributes
    ----------
    source : PointCloud
        The cloud that was given.
    provenance : str
        What was done with which values, for a comment.
    """

    source: PointCloud
    provenance: str

    @classmethod
    def of_rows(cls, rows: CurvatureEstimate, source: PointCloud, provenance: str) -> Self:
        """Make it of what was estimated of all rows of a cloud."""
        return cls(**_values(rows), source=source, provenance=provenance)

    def facts(self) -> dict[str, str]:
        """Say the most important numbers, in words by name."""
        known = np.abs(self.mean_curvature[self.has_normal])
        median = f"{np.median(known):.4g}" if len(known) else "unknown"
        return {
            "points": f"{len(self.normals)} in {self.normals.shape[1]}D",
            "without normal": str(int((~self.has_normal).sum())),
            "median |mean curvature|": median,
            "normals from": f"{self.normal_support:.0f} points",
        }

    def _cloud(self, path: str, writing: Writing | None) -> PointCloud:
        writing = writing or Writing()
        writing.check_moved_by("")
        piece = EstimatedPiece(self.source, self.source.points, self)
        return result_cloud(piece, self.finite, path, writing, self.provenance)

    def _figure(self) -> Figure:
        """Draw the cloud, coloured by its mean curvature."""
        from pcsmooth.plots.cloud_figure import cloud_figure
        from pcsmooth.plots.valued_clouds import by_curvature
        from pcsmooth.plots.views import facing

        view = facing(self.normals) if self.normals.shape[1] == 3 else None
        values = np.where(self.has_normal, self.mean_curvature, np.nan)
        shown = by_curvature({"curvature": (self.source.active_points, values)}, ["mean curvature"])
        return cloud_figure(shown, view=view, spacing=self.spacing)


def _values(rows: DataclassInstance) -> dict[str, Any]:
    """Give what a dataclass holds, by name."""
    return {field.name: getattr(rows, field.name) for field in fields(rows)}
