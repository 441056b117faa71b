"""The cloud that a command writes: positions, and normals and curvatures under their names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

import pcsmooth
from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.errors import CloudFileError
from pcsmooth.files.colors import colors_of, largest_shown
from pcsmooth.files.notes import WARNING, Say
from pcsmooth.files.output_columns import (
    WAYS_BACK,
    EstimatedCloud,
    color_names,
    foreign_columns,
    named_estimates,
    names_asked_for,
    outlier_columns,
    with_estimates,
)
from pcsmooth.files.writing import Writing
from pcsmooth.formats import lost_in, naming_of, output_format, stored_positions
from pcsmooth.formats.stored_positions import MUCH_ROUNDING, StoredPositions

#: Rounding is much if it takes more than this share of the mean displacement: less adds less than a
#: hundredth to the square of what moved.
_MUCH_OF_DISPLACEMENT = 0.1

ESTIMATES_IN_WORDS = {
    "mean": "mean curvature",
    "gaussian": "Gaussian curvature",
    "k1": "k1",
    "k2": "k2",
    "confidence": "confidence",
}


def check_color_by(writing: Writing, dimension: int, name: str) -> None:
    """Raise `CloudFileError` if colors are to show what a curve has not."""
    if writing.colormap and dimension == 2 and writing.color_by not in ("mean", "confidence"):
        raise CloudFileError(
            name,
            f"a plane curve has no {ESTIMATES_IN_WORDS[writing.color_by]}",
            "choose --color-by mean or confidence",
        )


def check_displacement(writing: Writing, cloud: PointCloud, target: str, path: str) -> None:
    """Raise `CloudFileError` if the way back is to be written where it cannot be.

    Parameters
    ----------
    writing : Writing
        What is to be written.
    cloud : PointCloud
        What was read, perhaps without its points.
    target : str
        Name of the format of the result.
    path : str
        Name of its file in errors.
    """
    if not writing.displacement:
        return
    if not _can_hold(WAYS_BACK, cloud, target):
        raise CloudFileError(
            path,
            f"{target} files like this have no named columns for the displacement",
            "write .ply or .csv instead",
        )
    taken = foreign_columns(cloud, WAYS_BACK)
    if taken:
        raise CloudFileError(
            path,
            f"the input has a column '{taken[0]}' of its own, which the displacement would replace",
            "rename it, or leave out --write-displacement",
        )


def marks_outliers(writing: Writing, cloud: PointCloud, target: str) -> bool:
    """Whether a column of the result marks outliers.

    Parameters
    ----------
    writing : Writing
        What is to be written.
    cloud : PointCloud
        What was read, perhaps without its points.
    target : str
        Name of the format of the result.
    """
    names = outlier_columns(naming_of(target), writing.dialect)
    return bool(names) and not foreign_columns(cloud, names) and _can_hold(names, cloud, target)


def _can_hold(names: Sequence[str], cloud: PointCloud, target: str) -> bool:
    """Whether a file of a format, like that of a cloud, has columns of any names."""
    columns = dict.fromkeys(names, np.empty(0))
    new = replace(cloud, columns=columns, points=cloud.points[:0], comments=())
    return not any("column" in phrase for phrase in lost_in(new, target))


@dataclass(frozen=True)
class Colors:
    """How the colors of a cloud are made.

    Attributes
    ----------
    writing : Writing
        Color map, estimate and convention.
    limits : tuple of float
        The values with the first and the last color.
    """

    writing: Writing
    limits: tuple[float, float]

    @classmethod
    def for_all(
        cls, writing: Writing, estimates: Callable[[], Iterable[CurvatureEstimate]]
    ) -> Colors | None:
        """Find the limits of a whole cloud whose estimates come in parts; None for no colors."""
        if writing.colormap is None:
            return None
        if writing.color_by == "confidence":
            return cls(writing, (0.0, 1.0))

        def sizes() -> Iterator[npt.NDArray[np.float64]]:
            for estimate in estimates():
                values = named_estimates(estimate, writing.convention)[writing.color_by]
                yield np.abs(values[estimate.has_normal])

        largest = largest_shown(sizes)
        return cls(writing, (0.0 - largest, largest))  # not -0

    @property
    def note(self) -> str:
        """What they show."""
        low, high = self.limits
        what = ESTIMATES_IN_WORDS[self.writing.color_by]
        return f"{what} from {low:.4g} to {high:.4g} by {self.writing.colormap}"

    def of(self, estimate: CurvatureEstimate) -> npt.NDArray[np.uint8]:
        """Color points by their estimates."""
        assert self.writing.colormap is not None
        values = named_estimates(estimate, self.writing.convention)[self.writing.color_by]
        return colors_of(values, estimate.has_normal, self.writing.colormap, self.limits)


class EstimatesOutput:
    """The cloud to write, whole or part by part.

    Parameters
    ----------
    cloud : PointCloud
        What was read, with or without its points.
    output_path : str
        Where it will be written.
    writing : Writing
        Names, types and colors.
    provenance : str
        Command and values, for a comment.
    colors : Colors or None
        How colors are made, if there are to be any.

    Attributes
    ----------
    layout : object or None
        Layout of the result, if that is settled before its parts.
    """

    def __init__(
        self,
        cloud: PointCloud,
        output_path: str,
        writing: Writing,
        provenance: str,
        colors: Colors | None = None,
    ) -> None:
        self._path, self._writing, self._provenance = output_path, writing, provenance
        self._colors = colors
        self._target = output_format(None if output_path == "-" else output_path, cloud)
        self._naming = naming_of(self._target)
        self._rounding = 0.0
        self.layout: object | None = None
        self._stored: StoredPositions | None = None

    def part(
        self,
        cloud: PointCloud,
        points: npt.NDArray[np.float64],
        estimate: CurvatureEstimate,
        displacement: npt.NDArray[np.float64] | None = None,
        outliers: npt.NDArray[np.bool_] | None = None,
        spacings: npt.NDArray[np.float64] | None = None,
        sigma: npt.NDArray[np.float64] | None = None,
        sigma_after: npt.NDArray[np.float64] | None = None,
    ) -> EstimatedCloud:
        """Put positions and estimates into a part of the cloud.

        Parameters
        ----------
        cloud : PointCloud
            What was read.
        points : ndarray, shape (n, d)
            Positions to write.
        estimate : CurvatureEstimate
            Estimates there.
        displacement : ndarray, shape (n,), optional
            Distance moved.
        outliers : ndarray of bool, shape (n,), optional
            Points taken for outliers.
        spacings : ndarray, shape (n,), optional
            Local spacing, L.
        sigma : ndarray, shape (n,), optional
            Standard deviation of the noise of the input, L.
        sigma_after : ndarray, shape (n,), optional
            Standard deviation of the error that is left, L.

        Raises
        ------
        CloudFileError
            If the type chosen for positions cannot hold them, or if the way back is to be written
            where the input has a column of its own of that name.
        """
        for_pcl = self._naming == "ply" and self._writing.dialect == "pcl"
        before = cloud.points
        cloud = with_position_type(cloud, self._target, self._writing.single, for_pcl=for_pcl)
        self._add_rounding(replace(cloud, points=points), estimate.finite)
        return with_estimates(
            cloud,
            points,
            estimate,
            displacement=displacement,
            outliers=outliers,
            spacings=spacings,
            sigma=sigma,
            sigma_after=sigma_after,
            way_back=self._way_back(before, estimate.finite),
            colors=None if self._colors is None else self._colors.of(estimate),
            naming=self._naming,
            dialect=self._writing.dialect,
            convention=self._writing.convention,
            provenance=f"{pcsmooth.__version__} {self._provenance}",
            color_note="" if self._colors is None else self._colors.note,
        )

    def _way_back(
        self, before: npt.NDArray[np.float64], finite: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.float64] | None:
        """Vectors from what the file will hold to what was read, if they are to be written."""
        if not self._writing.displacement or self._stored is None:
            return None
        way_back = np.zeros_like(before)
        way_back[finite] = before[finite] - self._stored.points[finite]
        return way_back

    def _add_rounding(self, cloud: PointCloud, finite: npt.NDArray[np.bool_]) -> None:
        """Note what the format does to the positions; an error if it cannot hold them."""
        if self.layout is not None:
            cloud = replace(cloud, layout=self.layout)
        self._stored = stored_positions(cloud, self._target, self._path)
        self._rounding = max(self._rounding, self._stored.rounding(cloud, finite))

    @property
    def rounding(self) -> float:
        """Most that the format rounds a coordinate of any part, L."""
        return self._rounding

    def say_rounding(self, spacing: float, mean_displacement: float | None, say: Say) -> None:
        """Say what the format does to the positions of all parts."""
        stored = self._stored
        if stored is None:
            return
        if stored.note:
            say(stored.note)
        against, length, much = "spacing", spacing, MUCH_ROUNDING
        if mean_displacement is not None:
            against, length, much = "displacement", mean_displacement, _MUCH_OF_DISPLACEMENT
        if self._rounding > much * length:
            beside = f", against a mean {against} of {length:.2g}"
            say(f"{WARNING} {stored.rounding_in_words(self._rounding, beside)}")

    def say_losses(self, cloud: PointCloud, estimated: EstimatedCloud, say: Say) -> None:
        """Say what is lost, replaced or left out of a part, and what the colors show."""
        names = {*cloud.columns, *(color_names(cloud) if self._writing.colormap else ())}
        names |= names_asked_for(self._writing.extra_columns)
        columns = estimated.cloud.columns
        kept = {name: columns[name] for name in columns if name in names}
        lost = lost_in(replace(cloud, columns=kept), self._target)
        if lost:
            say(f"{WARNING} {self._target} files cannot hold {', '.join(lost)}")
        if self._naming == "mesh":
            say(
                f"{WARNING} {self._target} files hold no curvatures, and normals only where they "
                "had them"
            )
        for column in estimated.kept:
            say(
                f"column '{column}' is the input's own and kept; the estimate is not written "
                "under this name"
            )
        if estimated.replaced:
            say(f"colors of the input are replaced: {', '.join(estimated.replaced)}")
        if estimated.dropped:
            say(f"columns of an earlier run are left out: {', '.join(estimated.dropped)}")
        if self._colors is not None:
            say(f"colors: {self._colors.note}")


def with_position_type(
    cloud: PointCloud, target: str, single: bool | None, *, for_pcl: bool = False
) -> PointCloud:
    """Choose the type of the positions to write.

    Parameters
    ----------
    cloud : PointCloud
        What was read.
    target : str
        Format of the file to be written.
    single : bool or None
        Whether positions are to be float; None leaves them as they were read. But PCL, and
        Open3D, read none but float, so that a new PCD file gets these.
    for_pcl : bool
        Whether None is for PCL in any format.
    """
    own = output_format(None, cloud)
    is_new_pcd = naming_of(target) == "pcd" and target != own
    if single is None and not (for_pcl or is_new_pcd):
        return cloud
    double = single is False
    return replace(cloud, position_type=np.dtype(np.float64 if double else np.float32))
