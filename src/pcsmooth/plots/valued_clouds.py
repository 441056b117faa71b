"""Clouds with a value at every point, to be shown side by side, and what is said of the values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.files.colors import largest_shown
from pcsmooth.plots.finite_rows import finite_rows

Floats = npt.NDArray[np.float64]

#: Names of the two clouds of a comparison.
_PAIR = ("before", "after")

#: Percentiles of values between which a scale goes.
_OUTERMOST = (2.0, 98.0)

_LENGTHS = "coordinate units"
_CURVATURES = {2: "curvature k, 1/unit", 3: "mean curvature H = (k1+k2)/2, 1/unit"}


@dataclass(frozen=True)
class ValuedCloud:
    """A cloud with a value at every point.

    Attributes
    ----------
    title : str
        What it is.
    points : ndarray, shape (n, d)
        Usable positions, L, n >= 1.
    values : ndarray, shape (n,)
        NaN where unknown.
    rows : ndarray of int, shape (n,)
        Their rows in the cloud that was given.
    left_out : int
        Rows that are not here, because they have no finite coordinates.
    """

    title: str
    points: Floats
    values: Floats
    rows: npt.NDArray[np.int64]
    left_out: int


@dataclass(frozen=True)
class ValuedClouds:
    """Clouds that share a scale.

    Attributes
    ----------
    label : str
        What the values are, with their unit.
    clouds : tuple of ValuedCloud
        One, or before and after.
    distributions : mapping of str to ndarray
        The known values, by the name of what they belong to.
    limits : tuple of float
        Values of the first and the last color; what is beyond has the same.
    symbol : str
        The absolute values in a formula; none for lengths, which have no sign.
    """

    label: str
    clouds: tuple[ValuedCloud, ...]
    distributions: Mapping[str, Floats]
    limits: tuple[float, float]
    symbol: str = ""

    @property
    def dimension(self) -> int:
        """Number of coordinates, 2 or 3."""
        return int(self.clouds[0].points.shape[1])

    @property
    def is_signed(self) -> bool:
        """Whether 0 is in the middle of the scale."""
        return self.limits[0] == -self.limits[1]

    @property
    def is_paired(self) -> bool:
        """Whether there are two clouds, and point i of one is point i of the other."""
        first, last = self.clouds[0], self.clouds[-1]
        return (
            len(self.clouds) == 2
            and first.left_out == last.left_out
            and np.array_equal(first.rows, last.rows)
        )

    @property
    def reaches_beyond(self) -> Literal["max", "both"]:
        """On which sides of the scale there may be more: sizes do not go below 0."""
        return "max" if self.limits[0] == 0.0 else "both"

    @property
    def colormap(self) -> str:
        """The color map that suits the values."""
        return "coolwarm" if self.is_signed else "viridis"

    @property
    def box(self) -> tuple[Floats, Floats]:
        """Lowest and highest coordinates of all clouds, each (d,), L."""
        lows = [cloud.points.min(axis=0) for cloud in self.clouds]
        highs = [cloud.points.max(axis=0) for cloud in self.clouds]
        return np.min(lows, axis=0), np.max(highs, axis=0)


@dataclass(frozen=True)
class Magnitudes:
    """What is said of values: their absolute values, in the unit of the values.

    Attributes
    ----------
    mean, median, root_mean_square, largest : float
        NaN if there is no value.
    """

    mean: float
    median: float
    root_mean_square: float
    largest: float

    def in_words(self, symbol: str = "") -> str:
        """Name each number; the symbol says what it is the number of, such as |H|."""
        of = f" {symbol}" if symbol else ""
        return (
            f"mean{of} {self.mean:.4g}, median {self.median:.4g}, "
            f"RMS {self.root_mean_square:.4g}, max {self.largest:.4g}"
        )


def magnitudes(values: Floats) -> Magnitudes:
    """Sum up the absolute values of an array.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Finite.

    Returns
    -------
    Magnitudes

    Examples
    --------
    >>> magnitudes(np.array([-3.0, 1.0, 1.0, 3.0, -2.0]))
    Magnitudes(mean=2.0, median=2.0, root_mean_square=2.1908902300206643, largest=3.0)
    """
    if len(values) == 0:
        return Magnitudes(np.nan, np.nan, np.nan, np.nan)
    sizes = np.abs(values)
    return Magnitudes(
        float(sizes.mean()),
        float(np.median(sizes)),
        float(np.sqrt(np.mean(sizes**2))),
        float(sizes.max()),
    )


def by_displacement(before: Floats, after: Floats, titles: Sequence[str] = _PAIR) -> ValuedClouds:
    """Show on both clouds how far each point has moved.

    Parameters
    ----------
    before, after : ndarray, shape (n, d)
        Positions, L; row i is the same point in both. Rows that are not finite in both are left
        out.
    titles : sequence of str
        What the clouds are.

    Returns
    -------
    ValuedClouds

    Raises
    ------
    InvalidInputError
        If the clouds differ in shape, or no point is left.
    """
    if before.shape != after.shape:
        raise InvalidInputError(
            f"{len(after)} points cannot be the {len(before)} points before, moved; choose "
            "--color-by distance"
        )
    rows = finite_rows(before, after)
    moved = np.linalg.norm(after[rows] - before[rows], axis=1)
    clouds = tuple(
        ValuedCloud(title, points[rows], moved, rows, len(points) - len(rows))
        for title, points in zip(titles, (before, after), strict=True)
    )
    return ValuedClouds(
        f"displacement, {_LENGTHS}", clouds, {"displacement": moved}, _limits([moved])
    )


def by_distance(
    before: Floats,
    after: Floats,
    reference: Floats | None = None,
    titles: Sequence[str] = _PAIR,
) -> ValuedClouds:
    """Show how far each point is from the nearest one of a reference, or of the other cloud.

    Parameters
    ----------
    before, after : ndarray, shape (n, d), (m, d)
        Positions, L. Rows that are not finite are left out.
    reference : ndarray, shape (k, d), optional
        What both are measured against; by default each is against the other.
    titles : sequence of str
        What the clouds are.

    Returns
    -------
    ValuedClouds

    Raises
    ------
    InvalidInputError
        If a cloud has no finite point.
    """
    from scipy.spatial import cKDTree

    rows = [finite_rows(cloud) for cloud in (before, after)]
    own = [before[rows[0]], after[rows[1]]]
    others = own[::-1] if reference is None else [reference[finite_rows(reference)]] * 2
    values = [
        np.asarray(cKDTree(other).query(points)[0])
        for points, other in zip(own, others, strict=True)
    ]
    clouds = tuple(
        ValuedCloud(title, points, distances, found, len(cloud) - len(found))
        for title, points, distances, found, cloud in zip(
            titles, own, values, rows, (before, after), strict=True
        )
    )
    target = "the other cloud" if reference is None else "the reference"
    return ValuedClouds(
        f"distance to {target}, {_LENGTHS}",
        clouds,
        dict(zip(_PAIR, values, strict=True)),
        _limits(values),
    )


def by_curvature(
    clouds: Mapping[str, tuple[Floats, Floats]], titles: Sequence[str] = _PAIR
) -> ValuedClouds:
    """Show mean curvatures, on a scale that leaves out 2 percent at either end.

    If surfaces bend both ways, 0 is in its middle.

    Parameters
    ----------
    clouds : mapping of str to tuple of ndarray, shapes (n, d) and (n,)
        Positions, L, and mean curvatures (k1 + k2) / 2, in 2D k, 1/L, by the name of the cloud.
        Rows without finite coordinates are left out; curvatures that are not finite are unknown.
    titles : sequence of str
        What the clouds are.

    Returns
    -------
    ValuedClouds

    Raises
    ------
    InvalidInputError
        If a cloud has no finite point.
    """
    shown = []
    for title, (points, curvatures) in zip(titles, clouds.values(), strict=True):
        rows = finite_rows(points)
        values = np.where(np.isfinite(curvatures), curvatures, np.nan)[rows]
        shown.append(ValuedCloud(title, points[rows], values, rows, len(points) - len(rows)))
    known = [cloud.values[~np.isnan(cloud.values)] for cloud in shown]
    dimension = shown[0].points.shape[1]
    return ValuedClouds(
        _CURVATURES[dimension],
        tuple(shown),
        dict(zip(clouds, known, strict=True)),
        _middle_of(known),
        {2: "|k|", 3: "|H|"}[dimension],
    )


def along_normals(moved: ValuedClouds, normals: Floats) -> ValuedClouds:
    """Show on the same clouds how far each point has moved along its normal, with the sign.

    Parameters
    ----------
    moved : ValuedClouds
        The same points before and after.
    normals : ndarray, shape (n, d)
        Normals of the rows of the cloud after, of any length; zero or NaN where unknown.

    Returns
    -------
    ValuedClouds
    """
    before, after = moved.clouds
    own = normals[after.rows]
    lengths = np.linalg.norm(own, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        steps = np.einsum("ij,ij->i", after.points - before.points, own / lengths[:, np.newaxis])
    return with_values(
        moved,
        f"displacement along the normal, {_LENGTHS}",
        [steps] * 2,
        is_signed=True,
        symbol="|d|",
    )


def with_values(
    shown: ValuedClouds,
    label: str,
    values: Sequence[Floats],
    *,
    is_signed: bool | None = None,
    symbol: str = "",
) -> ValuedClouds:
    """Show other values on the same clouds.

    Parameters
    ----------
    shown : ValuedClouds
        The clouds.
    label : str
        What the values are, with their unit.
    values : sequence of ndarray, shape (n,)
        Of the points of each cloud; unknown where not finite. If they are the same in both, they
        are one distribution.
    is_signed : bool, optional
        Whether the scale has 0 in its middle; by default if there are values of both signs. Else
        it goes from what 2 percent are below to what 2 percent are above.
    symbol : str
        The absolute values in a formula.

    Returns
    -------
    ValuedClouds
    """
    found = [np.where(np.isfinite(column), column, np.nan) for column in values]
    known = [column[~np.isnan(column)] for column in found]
    clouds = tuple(
        replace(cloud, values=column) for cloud, column in zip(shown.clouds, found, strict=True)
    )
    is_one = all(np.array_equal(found[0], column, equal_nan=True) for column in found)
    names = [label.partition(",")[0]] if is_one else _PAIR
    distributions = dict(zip(names, known[: len(names)], strict=True))
    return ValuedClouds(label, clouds, distributions, _middle_of(known, is_signed), symbol)


def _limits(distributions: Sequence[Floats]) -> tuple[float, float]:
    """From 0 to what all but 2 percent of the absolute values of all distributions are below."""
    sizes = [np.abs(values) for values in distributions]
    high = largest_shown(lambda: sizes)
    largest = max(float(values.max(initial=0.0)) for values in sizes)
    return 0.0, high or largest or 1.0


def _middle_of(
    distributions: Sequence[Floats], is_signed: bool | None = None
) -> tuple[float, float]:
    """Leave out 2 percent at either end; values of both signs have 0 in the middle of the scale."""
    together = np.concatenate(distributions)
    low, high = np.percentile(together, _OUTERMOST) if len(together) else (0.0, 1.0)
    if low < 0.0 < high if is_signed is None else is_signed:
        _, high = _limits(distributions)
        low = -high
    elif low == high:
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    return float(low), float(high)
