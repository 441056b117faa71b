"""Normals and curvatures in the output of a command, and in its summary."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pcsmooth.cli.messages import WARNING, Say
from pcsmooth.cli.options import Writing
from pcsmooth.errors import CloudFileError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from pcsmooth.attributes import EstimatedCloud
    from pcsmooth.cloud import PointCloud
    from pcsmooth.curvature.estimate import CurvatureEstimate
    from pcsmooth.formats.stored_positions import StoredPositions

#: Positions are warned about when rounding takes more than this share of the mean
#: displacement, or of the spacing where no point moves.
_ROUNDING_SHARE = 0.01

#: How a component got the sign of its normals, in words: of one, of more.
_REASONS = {
    "outward": ("outward", "outward"),
    "axis": ("along its leading axis", "along their leading axes"),
    "input": ("as in the input", "as in the input"),
    "viewpoint": ("to the viewpoint", "to the viewpoint"),
    "direction": ("along the direction", "along the direction"),
    "propagate": ("up at its highest point", "up at their highest points"),
}

_IN_WORDS = {
    "mean": "mean curvature",
    "gaussian": "Gaussian curvature",
    "k1": "k1",
    "k2": "k2",
    "confidence": "confidence",
}


def input_normals(cloud: PointCloud, orient: str, name: str) -> npt.NDArray[np.float64] | None:
    """Read the normals of the input, if it has any.

    Raises
    ------
    CloudFileError
        If it has none and normals are to be oriented by them.
    """
    from pcsmooth.attributes import normals_of

    normals = normals_of(cloud)
    if normals is None and orient == "input":
        columns = " ".join(("nx", "ny", "nz")[: cloud.dimension])
        raise CloudFileError(
            name, f"it has no normals {columns} to orient by", "choose another --orient"
        )
    return normals


def check_color_by(writing: Writing, dimension: int, name: str) -> None:
    """Raise `CloudFileError` if colors are to show what a curve has not."""
    if writing.colormap and dimension == 2 and writing.color_by not in ("mean", "confidence"):
        raise CloudFileError(
            name,
            f"a plane curve has no {_IN_WORDS[writing.color_by]}",
            "choose --color-by mean or confidence",
        )


def cloud_to_write(
    cloud: PointCloud,
    points: npt.NDArray[np.float64],
    estimate: CurvatureEstimate,
    output_path: str,
    writing: Writing,
    say: Say,
    *,
    provenance: str,
    displacement: npt.NDArray[np.float64] | None = None,
    outliers: npt.NDArray[np.bool_] | None = None,
) -> PointCloud:
    """Build the cloud to write; says what will be lost, rounded, replaced or left out.

    Parameters
    ----------
    cloud : PointCloud
        What was read.
    points : ndarray, shape (n, d)
        Positions to write.
    estimate : CurvatureEstimate
        Estimates there.
    output_path : str
        Where it will be written.
    writing : Writing
        Names, types and colors.
    say : callable
        Takes each message.
    provenance : str
        Command and values, for a comment.
    displacement : ndarray, shape (n,), optional
        Distance moved.
    outliers : ndarray of bool, shape (n,), optional
        Points taken for outliers.

    Returns
    -------
    PointCloud

    Raises
    ------
    CloudFileError
        If the type chosen for positions cannot hold them.
    """
    output = EstimatesOutput(cloud, output_path, writing, provenance)
    estimated = output.part(cloud, points, estimate, displacement, outliers)
    mean = None if displacement is None else float(displacement[estimate.finite].mean())
    output.say_rounding(estimate.spacing, mean, say)
    output.say_losses(cloud, estimated, say)
    return estimated.cloud


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

    Attributes
    ----------
    layout : object or None
        Layout of the result, if that is settled before its parts.
    """

    def __init__(
        self, cloud: PointCloud, output_path: str, writing: Writing, provenance: str
    ) -> None:
        from pcsmooth.cli.files import target_format
        from pcsmooth.formats import naming_of

        self._path, self._writing, self._provenance = output_path, writing, provenance
        self._target = target_format(cloud, output_path)
        self._naming = naming_of(self._target)
        self._rounding = 0.0
        self.layout: object | None = None
        self._stored: StoredPositions | None = None
        self._color_note = ""

    def part(
        self,
        cloud: PointCloud,
        points: npt.NDArray[np.float64],
        estimate: CurvatureEstimate,
        displacement: npt.NDArray[np.float64] | None = None,
        outliers: npt.NDArray[np.bool_] | None = None,
    ) -> EstimatedCloud:
        """Put positions and estimates into a part of the cloud: see `cloud_to_write`."""
        import pcsmooth
        from pcsmooth.attributes import with_estimates
        from pcsmooth.cli.files import with_position_type

        for_pcl = self._naming == "ply" and self._writing.dialect == "pcl"
        cloud = with_position_type(cloud, self._target, self._writing.single, for_pcl=for_pcl)
        self._add_rounding(replace(cloud, points=points), estimate.finite)
        colors, self._color_note = _colors(estimate, self._writing)
        return with_estimates(
            cloud,
            points,
            estimate,
            displacement=displacement,
            outliers=outliers,
            colors=colors,
            naming=self._naming,
            dialect=self._writing.dialect,
            convention=self._writing.convention,
            provenance=f"{pcsmooth.__version__} {self._provenance}",
            color_note=self._color_note,
        )

    def _add_rounding(self, cloud: PointCloud, finite: npt.NDArray[np.bool_]) -> None:
        """Note what the format does to the positions; an error if it cannot hold them."""
        import numpy as np

        from pcsmooth.formats import stored_positions

        if self.layout is not None:
            cloud = replace(cloud, layout=self.layout)
        self._stored = stored_positions(cloud, self._target, self._path)
        differences = np.abs(self._stored.points[finite] - cloud.points[finite])
        self._rounding = max(self._rounding, float(differences.max(initial=0.0)))

    def say_rounding(self, spacing: float, mean_displacement: float | None, say: Say) -> None:
        """Say what the format does to the positions of all parts."""
        stored = self._stored
        if stored is None:
            return
        if stored.note:
            say(stored.note)
        against, length = "spacing", spacing
        if mean_displacement is not None:
            against, length = "displacement", mean_displacement
        if self._rounding > _ROUNDING_SHARE * length:
            say(
                f"{WARNING} {stored.kind} round these coordinates by up to {self._rounding:.2g}, "
                f"against a mean {against} of {length:.2g}; {stored.remedy}"
            )

    def say_losses(self, cloud: PointCloud, estimated: EstimatedCloud, say: Say) -> None:
        """Say what is lost, replaced or left out of a part, and what the colors show."""
        from pcsmooth.attributes import color_names
        from pcsmooth.formats import lost_in

        names = {*cloud.columns, *(color_names(cloud) if self._writing.colormap else ())}
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
        if self._color_note:
            say(f"colors: {self._color_note}")


def known_estimates(
    estimate: CurvatureEstimate, writing: Writing
) -> dict[str, npt.NDArray[np.float64]]:
    """Curvatures and confidence by name, of the points that have a normal."""
    from pcsmooth.attributes import named_estimates

    known = _known(estimate)
    named = named_estimates(estimate, writing.convention)
    return {name: values[known] for name, values in named.items()}


def estimate_summary(estimate: CurvatureEstimate, writing: Writing) -> dict[str, Any]:
    """Collect what a summary says of the estimates, in the order of the JSON."""
    import numpy as np

    mean = known_estimates(estimate, writing)["mean"]
    return {
        "normal_support": estimate.normal_support,
        "curvature_support": estimate.curvature_support,
        "orientation": dict(estimate.orientation),
        "without_normal": int(estimate.finite.sum()) - len(mean),
        "mean_convention": writing.convention if estimate.normals.shape[1] == 3 else None,
        "median_abs_mean_curvature": float(np.median(np.abs(mean))) if len(mean) else 0.0,
    }


def say_estimates(summary: dict[str, Any], say: Say) -> None:
    """Say how normals and curvature were found."""
    without = summary["without_normal"]
    alone = f"; {without} point{'s' * (without > 1)} without normal" if without else ""
    curvature = summary["curvature_support"]
    fitted = "" if curvature is None else f", curvature from {curvature:.0f}"
    say(f"  normals from {summary['normal_support']:.0f} points{fitted}{alone}")
    say(f"  normals: {_orientation_in_words(summary['orientation'])}")
    median = f"{summary['median_abs_mean_curvature']:.4g}"
    medians = {
        "half": f"|H| {median}, H=(k1+k2)/2",
        "sum": f"|H| {median}, H=k1+k2",
        None: f"|k| {median}",
    }
    say(f"  median {medians[summary['mean_convention']]}")


def provenance_of(summary: dict[str, Any], orient: str) -> str:
    """How the estimates were made, for a comment."""
    supports = (summary["normal_support"], summary["curvature_support"])
    words = ",".join(f"{support:.4g}" for support in supports if support is not None)
    return f"support={words} orient={orient}"


def _orientation_in_words(orientation: dict[str, int]) -> str:
    parts: list[str] = []
    for reason, count in orientation.items():
        words = _REASONS[reason][count != 1]
        noun = f" component{'s' * (count != 1)}" if not parts else ""
        parts.append(f"{count}{noun} {words}")
    return ", ".join(parts)


def _known(estimate: CurvatureEstimate) -> npt.NDArray[np.bool_]:
    """Points that have a normal."""
    import numpy as np

    return np.asarray(estimate.normals.any(axis=1))


def _colors(
    estimate: CurvatureEstimate, writing: Writing
) -> tuple[npt.NDArray[np.uint8] | None, str]:
    """Colors by the color map, if there is to be one, and what they show."""
    if writing.colormap is None:
        return None, ""
    from pcsmooth.attributes import named_estimates
    from pcsmooth.colors import colors_of, symmetric_range

    values = named_estimates(estimate, writing.convention)[writing.color_by]
    known = _known(estimate)
    limits = (0.0, 1.0) if writing.color_by == "confidence" else symmetric_range(values, known)
    note = (
        f"{_IN_WORDS[writing.color_by]} from {limits[0]:.4g} to {limits[1]:.4g} "
        f"by {writing.colormap}"
    )
    return colors_of(values, known, writing.colormap, limits), note
