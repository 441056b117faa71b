"""The columns in which estimates are written, by the names that other programs know.

In PLY MeshLab takes nx ny nz and `quality`, CloudCompare nx ny nz and what contains `scalar`, PCL
and PDAL nx ny nz and `curvature`. Text and LAS get one column of each kind, PCD `curvature` too,
and meshes nothing but normals that were there. What normals are called in a file is the affair of
its format: here they are nx ny nz.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS, NORMALS, PointCloud
from pcsmooth.formats.number_text import parsed
from pcsmooth.formats.text.layout import TextLayout

if TYPE_CHECKING:
    from pcsmooth.curvature.estimate import CurvatureEstimate
    from pcsmooth.formats import Naming

Convention = Literal["half", "sum"]
Dialect = Literal["generic", "meshlab", "cloudcompare", "pcl"]

_DISPLACEMENT = "displacement"
_OUTLIER = "outlier"
_SPACING = "spacing"
_SIGMA = "sigma"
_SIGMA_AFTER = "sigma_after"

WAYS_BACK = ("dx", "dy", "dz")
"""Columns of the way from a written position to that of the input, by axis, in any format."""

#: Kinds that are written only where they are asked for, and then for any program.
_ASKED_FOR = (_SPACING, _SIGMA, _SIGMA_AFTER)

#: Names in PLY of each estimate, by the program that is to read them.
_CLOUDCOMPARE: dict[str, tuple[str, ...]] = {
    "mean": ("scalar_mean_curvature",),
    "gaussian": ("scalar_gaussian_curvature",),
    "k1": ("scalar_k1",),
    "k2": ("scalar_k2",),
    "confidence": ("scalar_confidence",),
    _DISPLACEMENT: ("scalar_displacement",),
    _OUTLIER: ("scalar_outlier",),
    _SPACING: ("scalar_spacing",),
    _SIGMA: ("scalar_sigma",),
    _SIGMA_AFTER: ("scalar_sigma_after",),
}
_PLY_NAMES: dict[Dialect, dict[str, tuple[str, ...]]] = {
    "generic": {**_CLOUDCOMPARE, "mean": ("quality", "scalar_mean_curvature", "curvature")},
    "meshlab": {"mean": ("quality",), **{kind: _CLOUDCOMPARE[kind] for kind in _ASKED_FOR}},
    "cloudcompare": _CLOUDCOMPARE,
    "pcl": {"mean": ("curvature",), **{kind: _CLOUDCOMPARE[kind] for kind in _ASKED_FOR}},
}

#: Names in text, and in LAS.
_TEXT_NAMES: dict[str, tuple[str, ...]] = {
    "mean": ("mean_curvature",),
    "gaussian": ("gaussian_curvature",),
    "k1": ("k1",),
    "k2": ("k2",),
    "confidence": ("confidence",),
    _DISPLACEMENT: ("displacement",),
    _OUTLIER: ("outlier",),
    _SPACING: ("spacing",),
    _SIGMA: ("sigma",),
    _SIGMA_AFTER: ("sigma_after",),
}

#: Names in PCD.
_PCD_NAMES = {**_TEXT_NAMES, "mean": ("curvature", *_TEXT_NAMES["mean"])}

#: Names in text that are plain enough to be replaced whoever wrote them.
_PLAIN_NAMES = frozenset(_TEXT_NAMES["mean"] + _TEXT_NAMES[_DISPLACEMENT])

#: Names, in any, of what only a command that moves points writes.
_MOTION_NAMES = frozenset(
    name
    for kind in (_DISPLACEMENT, _OUTLIER, _SIGMA, _SIGMA_AFTER)
    for name in _CLOUDCOMPARE[kind] + _TEXT_NAMES[kind]
).union(WAYS_BACK)

#: Every column that a run may leave behind in text, and anywhere; normals and, in text, colors
#: apart.
_ALL_TEXT_NAMES = frozenset(WAYS_BACK).union(*_TEXT_NAMES.values())
_ALL_NAMES = _ALL_TEXT_NAMES.union(COLORS, *_PLY_NAMES["generic"].values())

#: How every comment of pcsmooth begins, and those of which a file has one.
_SIGNATURE = "pcsmooth "
_COLUMNS = _SIGNATURE + "columns: "
_UNITS = _SIGNATURE + "units: "
_SIGNS = _SIGNATURE + "signs: "
_COLORS = _SIGNATURE + "colors: "

_UNITS_TEXT = (
    "radius, spacing, sigma, sigma_after, displacement and dx dy dz in coordinate units, "
    "curvature in 1/unit"
)
_FORMULAS: dict[Convention, str] = {"half": "H=(k1+k2)/2", "sum": "H=k1+k2"}
_RADIUS_TEXTS = {"half": "+1/R", "sum": "+2/R"}


@dataclass(frozen=True)
class EstimatedCloud:
    """A cloud with estimates, and what became of columns that were there before.

    Attributes
    ----------
    cloud : PointCloud
        The new cloud. Columns that exist keep their place.
    kept : list of str
        Names of estimates left out because the file uses the name for something else.
    replaced : list of str
        Colors of the input that are no more.
    dropped : list of str
        Estimates of an earlier run that this one does not write.
    """

    cloud: PointCloud
    kept: list[str]
    replaced: list[str]
    dropped: list[str]


def named_estimates(
    estimate: CurvatureEstimate, convention: Convention
) -> dict[str, npt.NDArray[np.float64]]:
    """Curvatures and confidence by name, as far as they are known.

    Parameters
    ----------
    estimate : CurvatureEstimate
        What was estimated.
    convention : {"half", "sum"}
        Whether the mean curvature of surfaces is (k1 + k2) / 2 or k1 + k2.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        mean, in 3D gaussian, k1 and k2 where the estimator gives them, and confidence.
    """
    is_surface = estimate.normals.shape[1] == 3
    named = {"mean": estimate.mean_curvature * (2.0 if is_surface and convention == "sum" else 1.0)}
    if is_surface and estimate.has_principal:
        named["gaussian"] = estimate.gaussian_curvature
        named["k1"], named["k2"] = estimate.principal_curvatures.T
    return {**named, "confidence": estimate.confidence}


def names_asked_for(kinds: Iterable[str]) -> set[str]:
    """Names, in any format, of columns that are written where they are asked for."""
    return {name for kind in kinds for name in _CLOUDCOMPARE[kind] + _TEXT_NAMES[kind]}


def outlier_columns(naming: Naming, dialect: Dialect) -> tuple[str, ...]:
    """Names of the columns that mark outliers; none where there are none."""
    return _names(naming, dialect).get(_OUTLIER, ())


def normals_of(cloud: PointCloud) -> npt.NDArray[np.float64] | None:
    """Read the normals that a cloud came with.

    Parameters
    ----------
    cloud : PointCloud
        What was read.

    Returns
    -------
    ndarray, shape (n, d), or None if the cloud has no columns of numbers with their names.
    """
    columns = [cloud.columns.get(name) for name in NORMALS[: cloud.dimension]]
    known = [values for column in columns if (values := numbers_of(column)) is not None]
    return np.stack(known, axis=1) if len(known) == cloud.dimension else None


def mean_curvature_of(cloud: PointCloud) -> tuple[npt.NDArray[np.float64], str] | None:
    """Read the mean curvature that a cloud came with.

    Parameters
    ----------
    cloud : PointCloud
        What was read.

    Returns
    -------
    values : ndarray, shape (n,)
        (k1 + k2) / 2, in 2D k, 1/L; NaN at points that have normals of length 0.
    name : str
        The column that holds it. Names that programs also use for something else count only
        where a comment says that pcsmooth wrote them.

    None instead of both if there is no such column of numbers.
    """
    claimed = _claimed(cloud.comments)
    trusted = (*_TEXT_NAMES["mean"], *_CLOUDCOMPARE["mean"])
    candidates = (*trusted, *(name for name in _PLY_NAMES["generic"]["mean"] if name in claimed))
    for name in candidates:
        values = numbers_of(cloud.columns.get(name))
        if values is not None:
            break
    else:
        return None
    family = _TEXT_NAMES if name in _ALL_TEXT_NAMES else _CLOUDCOMPARE
    k1, k2 = (numbers_of(cloud.columns.get(family[kind][0])) for kind in ("k1", "k2"))
    summed = f"{_SIGNS}mean curvature {_FORMULAS['sum']},"
    if k1 is not None and k2 is not None:
        values = 0.5 * (k1 + k2)  # whichever mean the file has: text does not say
    elif any(comment.startswith(summed) for comment in cloud.comments):
        values = 0.5 * values
    normals = normals_of(cloud)
    if normals is not None:
        values = np.where(normals.any(axis=1), values, np.nan)
    return values, name


def values_of(cloud: PointCloud) -> dict[str, npt.NDArray[np.float64]]:
    """Read the columns of numbers that tell points apart.

    Parameters
    ----------
    cloud : PointCloud
        What was read.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        By name; not among them are normals, colors, ways back, what is the same at all points, and
        what another column says, too.
    """
    found: dict[str, npt.NDArray[np.float64]] = {}
    left_out = {*NORMALS, *WAYS_BACK, *color_names(cloud)}
    for name, column in cloud.columns.items():
        values = None if name in left_out else numbers_of(column)
        known = np.empty(0) if values is None else values[np.isfinite(values)]
        if values is None or len(known) == 0 or known.min() == known.max():
            continue
        if not any(np.array_equal(values, other, equal_nan=True) for other in found.values()):
            found[name] = values
    return found


def numbers_of(column: npt.NDArray[Any] | None) -> npt.NDArray[np.float64] | None:
    """Read a column as numbers; None if there is none or it holds anything else."""
    if column is None or column.dtype.kind not in "biufU":
        return None
    if column.dtype.kind != "U":
        return column.astype(np.float64)
    try:
        return np.asarray(parsed(column.tolist()), np.float64)
    except ValueError:
        return None


def color_names(cloud: PointCloud) -> tuple[str, ...]:
    """Names of the columns of a color.

    Parameters
    ----------
    cloud : PointCloud
        What was read.

    Returns
    -------
    tuple of str
        Red, green and blue as the file spells them (also ``R G B``) if it has them all.
    """
    spelled = {name.lower(): name for name in cloud.columns}
    for names in (COLORS, ("r", "g", "b")):
        if all(name in spelled for name in names):
            return tuple(spelled[name] for name in names)
    return COLORS


def with_estimates(
    cloud: PointCloud,
    points: npt.NDArray[np.float64],
    estimate: CurvatureEstimate,
    *,
    displacement: npt.NDArray[np.float64] | None = None,
    outliers: npt.NDArray[np.bool_] | None = None,
    spacings: npt.NDArray[np.float64] | None = None,
    sigma: npt.NDArray[np.float64] | None = None,
    sigma_after: npt.NDArray[np.float64] | None = None,
    way_back: npt.NDArray[np.float64] | None = None,
    colors: npt.NDArray[np.uint8] | None = None,
    naming: Naming,
    dialect: Dialect = "generic",
    convention: Convention = "half",
    provenance: str,
    color_note: str = "",
) -> EstimatedCloud:
    """Put positions and estimates into a cloud.

    Parameters
    ----------
    cloud : PointCloud
        What was read; its other columns and comments are kept.
    points : ndarray, shape (n, d)
        Positions.
    estimate : CurvatureEstimate
        Estimates there, written as float32.
    displacement : ndarray, shape (n,), optional
        Distance moved; without it that of an earlier run is kept, and so are its outliers.
    outliers : ndarray of bool, shape (n,), optional
        Points taken for outliers, written as 1, others as 0.
    spacings : ndarray, shape (n,), optional
        Local spacing, L.
    sigma : ndarray, shape (n,), optional
        Standard deviation of the noise of the input, L.
    sigma_after : ndarray, shape (n,), optional
        Standard deviation of the error that is left, L.
    way_back : ndarray, shape (n, d), optional
        Vectors from the positions in the file to those of the input, L, written as double.
    colors : ndarray of uint8, shape (n, 3), optional
        Red, green and blue, which replace those of the input.
    naming : {"ply", "pcd", "las", "text", "mesh"}
        The family of formats that the names are for.
    dialect : {"generic", "meshlab", "cloudcompare", "pcl"}
        Which columns PLY gets; other formats get the same in any.
    convention : {"half", "sum"}
        See `named_estimates`.
    provenance : str
        What was done with which values; becomes a comment, together with units and signs.
    color_note : str
        What the colors show; becomes a comment too.

    Returns
    -------
    EstimatedCloud
    """
    named = named_estimates(estimate, convention)
    if displacement is not None:
        named[_DISPLACEMENT] = displacement
    if outliers is not None:
        named[_OUTLIER] = outliers.astype(np.float64)
    if spacings is not None:
        named[_SPACING] = spacings
    if sigma is not None:
        named[_SIGMA] = sigma
    if sigma_after is not None:
        named[_SIGMA_AFTER] = sigma_after
    values: dict[str, npt.NDArray[Any]] = {}
    for axis, name in enumerate(NORMALS):
        if naming == "mesh" and name not in cloud.columns:
            continue
        if axis < cloud.dimension:
            values[name] = _as_float(estimate.normals[:, axis])
        elif naming != "text":
            values[name] = np.zeros(len(cloud), np.float32)
    for kind, names in _names(naming, dialect).items():
        if kind in named:
            values.update(dict.fromkeys(names, _as_float(named[kind])))
    if way_back is not None:
        values.update(zip(WAYS_BACK, way_back.T, strict=False))

    own = _own_columns(cloud)
    replaceable = own.union(NORMALS, _PLAIN_NAMES if naming == "text" else ())
    kept = [name for name in values if name in cloud.columns and name not in replaceable]
    for name in kept:
        del values[name]
    replaced = []
    if colors is not None:
        channels = color_names(cloud)
        replaced = [name for name in channels if name in cloud.columns and name not in own]
        values.update(zip(channels, colors.T, strict=True))
    old_moves = own & _MOTION_NAMES if displacement is None else set()
    dropped = [name for name in cloud.columns if name in own - old_moves and name not in values]

    columns = {name: column for name, column in cloud.columns.items() if name not in dropped}
    comments = _without_conventions(cloud.comments)
    comments += [
        _SIGNATURE + provenance,
        _COLUMNS + " ".join([*values, *(name for name in columns if name in old_moves)]),
        *_conventions(cloud.dimension, convention),
    ]
    if color_note:
        comments.append(_COLORS + color_note)
    return EstimatedCloud(
        replace(cloud, points=points, columns={**columns, **values}, comments=tuple(comments)),
        kept,
        replaced,
        dropped,
    )


def _names(naming: Naming, dialect: Dialect) -> dict[str, tuple[str, ...]]:
    """Names of each estimate."""
    tables = {"pcd": _PCD_NAMES, "las": _TEXT_NAMES, "text": _TEXT_NAMES, "mesh": {}}
    return _PLY_NAMES[dialect] if naming == "ply" else tables[naming]


def _as_float(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """Turn into float32; what is too large for it becomes its largest number, not infinity."""
    largest = np.finfo(np.float32).max
    return np.clip(values, -largest, largest).astype(np.float32)


def foreign_columns(cloud: PointCloud, names: Iterable[str]) -> list[str]:
    """List which columns of some names a cloud has that no earlier run wrote."""
    own = _own_columns(cloud)
    return [name for name in names if name in cloud.columns and name not in own]


def without_estimates(cloud: PointCloud) -> PointCloud:
    """Take out the columns that an earlier run wrote, and its comments.

    Normals are among them where comments say that it wrote them. Of several runs that said what
    they did, the comment of the last one goes.
    """
    gone = _own_columns(cloud) | (_claimed(cloud.comments) & set(NORMALS))
    comments = _without_conventions(cloud.comments)
    told = [number for number, text in enumerate(comments) if text.startswith(_SIGNATURE)]
    if told:
        del comments[told[-1]]
    columns = {name: column for name, column in cloud.columns.items() if name not in gone}
    return replace(cloud, columns=columns, comments=tuple(comments))


def ways_back_of(cloud: PointCloud) -> npt.NDArray[np.float64] | None:
    """Read the vectors from the positions of a cloud to those that an earlier run had read.

    Parameters
    ----------
    cloud : PointCloud
        What was read.

    Returns
    -------
    ndarray, shape (n, d), or None if a run has not written them.
    """
    own = _own_columns(cloud)
    columns = [numbers_of(cloud.columns[name]) for name in WAYS_BACK if name in own]
    known = [values for values in columns if values is not None]
    return np.stack(known, axis=1) if len(known) == cloud.dimension else None


def _without_conventions(comments: Iterable[str]) -> list[str]:
    """Leave out what an earlier run said of columns, units, signs and colors."""
    said = (_COLUMNS, _UNITS, _SIGNS, _COLORS)
    return [comment for comment in comments if not comment.startswith(said)]


def _own_columns(cloud: PointCloud) -> set[str]:
    """Columns that an earlier run wrote, normals apart.

    Comments list them. Text has none, but there they were appended, mean curvature first;
    of colors nothing is known.
    """
    own = _claimed(cloud.comments) & _ALL_NAMES
    (mean,) = _TEXT_NAMES["mean"]
    if isinstance(cloud.layout, TextLayout) and mean in cloud.columns:
        names = list(cloud.columns)
        own |= set(names[names.index(mean) :]) & _ALL_TEXT_NAMES
    return own & cloud.columns.keys()


def _claimed(comments: Iterable[str]) -> set[str]:
    """Columns that the comments say pcsmooth wrote."""
    return {
        name
        for comment in comments
        if comment.startswith(_COLUMNS)
        for name in comment.removeprefix(_COLUMNS).split()
    }


def _conventions(dimension: int, convention: Convention) -> tuple[str, str]:
    """Comments on units and signs."""
    if dimension == 2:
        return (
            _UNITS + _UNITS_TEXT,
            _SIGNS + "curvature k of the curve, positive where it bends away from the normal "
            "(+1/R on a circle with outward normals)",
        )
    return (
        _UNITS + _UNITS_TEXT + ", Gaussian curvature in 1/unit^2",
        _SIGNS + f"mean curvature {_FORMULAS[convention]}, positive where the surface bends away "
        f"from the normal ({_RADIUS_TEXTS[convention]} on a sphere with outward normals)",
    )
