"""Normals and curvatures of a cloud: one estimate per point.

Conventions: H = (k1 + k2) / 2 in 3D and the curvature k in 2D, in 1/L, positive where the surface
bends away from the normal (a sphere of radius R with outward normals has +1/R).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.fitted_cloud import FittedCloud
from pcsmooth.kernels.surface import shape_operators as columns


@dataclass(frozen=True)
class CurvatureEstimate:
    """Normals and curvatures at the points of a cloud, row i being row i of the input.

    Attributes
    ----------
    normals : ndarray, shape (n, d)
        Unit normals; zero where unknown: for a point that no other touches or that is not
        finite. Curvatures and confidence are zero there.
    mean_curvature : ndarray, shape (n,)
        (k1 + k2) / 2, in 2D k, 1/L, positive where the surface bends away from the normal.
    gaussian_curvature : ndarray, shape (n,)
        k1 k2, 1/L^2; in 2D k, 1/L.
    principal_curvatures : ndarray, shape (n, d - 1)
        k1 >= k2, in 2D k, 1/L.
    confidence : ndarray, shape (n,)
        From 0 to 1: 1 minus the RMS distance between the cell normals of the neighbourhood and
        the fitted ones. Near 1 on a smooth surface; noise, edges and thin neighbourhoods lower
        it.
    radius, spacing : float
        Radius of the balls and mean spacing, L.
    normal_support, curvature_support : float
        Points of a neighbourhood for normals and for curvature, on average where points are
        even.
    orientation : mapping of str to int
        How many connected components got the sign of their normals for which reason: outward,
        axis (open sheets: along the positive leading axis), input, viewpoint, direction,
        propagate.
    finite : ndarray of bool, shape (n,)
        False for rows with a NaN, an infinity or a coordinate beyond 1e150.
    has_principal : bool
        Whether Gaussian and principal curvatures are known.

    Notes
    -----
    The estimator ``report`` gives no Gaussian and principal curvatures: in 3D they are NaN. Its
    mean curvature has the length of the gradient's vector and is set along the fitted normal; its
    confidence is the share of that vector that is normal.
    """

    normals: npt.NDArray[np.float64]
    mean_curvature: npt.NDArray[np.float64]
    gaussian_curvature: npt.NDArray[np.float64]
    principal_curvatures: npt.NDArray[np.float64]
    confidence: npt.NDArray[np.float64]
    radius: float
    spacing: float
    normal_support: float
    curvature_support: float
    orientation: Mapping[str, int]
    finite: npt.NDArray[np.bool_]
    has_principal: bool = True

    @property
    def has_normal(self) -> npt.NDArray[np.bool_]:
        """Points that have a normal, (n,)."""
        return np.asarray(self.normals.any(axis=1))

    @property
    def mean_curvature_vectors(self) -> npt.NDArray[np.float64]:
        """Mean curvature times normal, (n, d), 1/L, whatever its sign: the way area grows."""
        return self.mean_curvature[:, np.newaxis] * self.normals

    def some_rows(self, kept: npt.NDArray[np.bool_]) -> CurvatureEstimate:
        """Give those of some rows (n,)."""
        arrays = {
            field.name: getattr(self, field.name)[kept]
            for field in fields(CurvatureEstimate)
            if isinstance(getattr(self, field.name), np.ndarray)
        }
        known = {field.name: getattr(self, field.name) for field in fields(CurvatureEstimate)}
        return CurvatureEstimate(**{**known, **arrays})

    @classmethod
    def in_chunks(
        cls,
        fitted: FittedCloud,
        *,
        dimension: int,
        unit: float,
        radius: float,
        spacing: float,
    ) -> Iterator[CurvatureEstimate]:
        """Make one of so many points at a time, in the order of the cloud in parts: see `of`."""
        for chunk in fitted.estimates.chunks():
            places = np.arange(len(chunk))
            yield cls.of(
                fitted, chunk, places, places >= 0, dimension=dimension, unit=unit,
                radius=radius, spacing=spacing,
            )  # fmt: skip

    @classmethod
    def of(
        cls,
        fitted: FittedCloud,
        estimates: npt.NDArray[np.float64],
        places: npt.NDArray[np.int64],
        finite: npt.NDArray[np.bool_],
        *,
        dimension: int,
        unit: float,
        radius: float,
        spacing: float,
    ) -> CurvatureEstimate:
        """Make it of what was estimated in parts.

        Parameters
        ----------
        fitted : FittedCloud
            What holds for the whole cloud.
        estimates : ndarray, shape (m, N_ESTIMATES)
            Of some points, in the unit.
        places : ndarray of int, shape (m,)
            Their rows.
        finite : ndarray of bool, shape (n,)
            Which rows are finite; the others get zeros.
        dimension : int
            d.
        unit : float
            What lengths are multiples of, L.
        radius, spacing : float
            In the unit.
        """

        def spread(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
            rows = np.zeros((len(finite), *values.shape[1:]))
            rows[places] = values
            return rows

        principal = estimates[:, columns.PRINCIPAL : columns.PRINCIPAL + dimension - 1]
        return cls(
            normals=spread(estimates[:, :dimension]),
            mean_curvature=spread(estimates[:, columns.MEAN] / unit),
            gaussian_curvature=spread(estimates[:, columns.GAUSSIAN] / unit ** (dimension - 1)),
            principal_curvatures=spread(principal / unit),
            confidence=spread(estimates[:, columns.CONFIDENCE]),
            radius=radius * unit,
            spacing=spacing * unit,
            normal_support=fitted.normal_support,
            curvature_support=fitted.curvature_support,
            orientation=fitted.orientation,
            finite=finite,
            has_principal=fitted.has_principal,
        )
