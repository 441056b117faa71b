"""What is said of a run: in JSON, in words, on the page and in the comments of the file."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.single_gradient import Estimator
from pcsmooth.denoising import Denoised, Facts
from pcsmooth.energies.protocol import Quantity
from pcsmooth.estimating import EstimatedParts
from pcsmooth.files.outlier_classes import ClassCounts
from pcsmooth.files.output_columns import Convention
from pcsmooth.files.selection import Others, Selection
from pcsmooth.files.taking_part import PointCounts
from pcsmooth.files.writing import Outliers
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.flows.implicit import Order
from pcsmooth.formats import coordinate_columns
from pcsmooth.methods.flows import EulerFlow, ImplicitFlow
from pcsmooth.methods.method import MethodName
from pcsmooth.printable import counted, printable

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

#: Names of facts that are left out where there are none.
_OPTIONAL = (
    "radius_range", "sparse_share", "origin", "shape", "findings", "hint", "selection", "where",
    "box", "polygon", "outlier_classes",
)  # fmt: skip


@dataclass(frozen=True)
class Report:
    """Facts of a run; those of parts of it are in dataclasses of their own."""

    def as_json(self) -> dict[str, Any]:
        """Give all facts by name in one mapping, in their order; what there is not is left out."""
        return _flat(self)


def _flat(facts: DataclassInstance) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for field in fields(facts):
        value = getattr(facts, field.name)
        if is_dataclass(value) and not isinstance(value, type):
            found |= _flat(value)
        elif value is not None or field.name not in _OPTIONAL:
            found[field.name] = value
    return found


@dataclass(frozen=True)
class SelectionFacts:
    """The points that are selected.

    Attributes
    ----------
    selected, ignored : int
        How many that are finite and no noise are, and how many such are not and take no part.
    where : str or None
        The expression.
    box : list of float or None
        The box, L.
    polygon : str or None
        The file of the polygon.
    others : {"act", "ignore"}
        What the others do.
    """

    selected: int
    ignored: int
    where: str | None
    box: list[float] | None
    polygon: str | None
    others: Others

    @classmethod
    def of(cls, selection: Selection | None, counts: PointCounts) -> SelectionFacts | None:
        """Take them from points that have been counted; None if nothing is selected by."""
        if selection is None:
            return None
        return cls(
            counts.selected,
            counts.ignored,
            None if selection.where is None else selection.where.text,
            None if selection.box is None else list(selection.box),
            None if selection.polygon is None else selection.polygon.path,
            selection.others,
        )


@dataclass(frozen=True)
class PointFacts:
    """The points of the input.

    Attributes
    ----------
    points, dimension : int
        How many, and of how many coordinates.
    coordinates : list of str
        Their columns.
    not_finite, noise_class : int
        Points that took no part as a coordinate is not finite, or as the file calls them noise.
    selection : SelectionFacts or None
        Which points were selected, if that was asked for.
    """

    points: int
    dimension: int
    coordinates: list[str]
    not_finite: int
    noise_class: int
    selection: SelectionFacts | None = None

    @classmethod
    def of(
        cls,
        cloud: PointCloud,
        count: int,
        taking_part: int,
        counts: PointCounts,
        selection: Selection | None,
    ) -> PointFacts:
        """Take them from a cloud, perhaps without its rows, and what of these takes part."""
        return cls(
            count,
            cloud.dimension,
            coordinate_columns(cloud),
            count - taking_part - counts.noise - counts.ignored,
            counts.noise,
            SelectionFacts.of(selection, counts),
        )

    @property
    def taking_part(self) -> int:
        """Number of points that take part."""
        ignored = 0 if self.selection is None else self.selection.ignored
        return self.points - self.not_finite - self.noise_class - ignored

    def exceptions_in_words(self, fixed: int = 0) -> list[str]:
        """Say which points are selected, do not take part, or are fixed; nothing of counts of 0."""
        chosen = self.selection
        words = {
            "not finite (passed through)": self.not_finite,
            "of a noise class or withheld (passed through)": self.noise_class,
            "not selected (passed through)": 0 if chosen is None else chosen.ignored,
            "fixed": fixed,
        }
        said = [f"{count} {what}" for what, count in words.items() if count]
        return said if chosen is None else [f"{chosen.selected} selected", *said]


@dataclass(frozen=True)
class PlanFacts:
    """What was found of a cloud's noise and density, None where there was no looking.

    Attributes
    ----------
    noise : float or None
        Standard deviation, L; the median where it differs from place to place.
    noise_range : list of float or None
        Its 5th and 95th percentile, if it does.
    noise_ratio : float or None
        In units of the local spacing.
    surface : bool or None
        Whether a surface shows at any scale.
    density_variation : float or None
        See `FilterPlan`.
    filter_support : float or None
        Points of a neighbourhood at the median.
    """

    noise: float | None
    noise_range: list[float] | None
    noise_ratio: float | None
    surface: bool | None
    density_variation: float | None
    filter_support: float | None

    @classmethod
    def of(cls, plan: FilterPlan | None) -> PlanFacts:
        """Take them from a plan, in the unit of the input."""
        if plan is None:
            return cls(None, None, None, None, None, None)
        return cls(
            plan.noise.deviation,
            None if plan.noise_range is None else list(plan.noise_range),
            plan.noise.deviation / plan.spacing if plan.spacing > 0.0 else 0.0,
            plan.has_surface,
            plan.density_variation,
            plan.support,
        )

    def noise_in_words(self) -> str:
        """Say how much noise was found, and how much it varies; nothing if there was no looking."""
        if self.noise is None:
            return ""
        varies = ""
        if self.noise_range is not None:
            low, high = self.noise_range
            varies = f" ({low:.4g} to {high:.4g} at nine points in ten)"
        ratio = f"{self.noise_ratio:.2g} of the local spacing sqrt(area/points)"
        return f"{self.noise:.4g}{varies}, {ratio}"


@dataclass(frozen=True)
class ShapeFacts:
    """The body in place of the ball, by the name that the user gave, and the union."""

    polyhedron: str
    union: str


@dataclass(frozen=True)
class EstimateFacts:
    """Normals and curvatures of the result.

    Attributes
    ----------
    normal_support : float
        Points of a neighbourhood for normals.
    curvature_support : float or None
        The same for curvature, if it is fitted.
    orientation : dict of str to int
        How many components got the sign of their normals for which reason.
    without_normal : int
        Points that have no normal.
    mean_convention : {"half", "sum"} or None
        Which mean curvature is meant; None in 2D.
    median_abs_mean_curvature : float
        1/L.
    """

    normal_support: float
    curvature_support: float | None
    orientation: dict[str, int]
    without_normal: int
    mean_convention: Convention | None
    median_abs_mean_curvature: float

    @classmethod
    def of(cls, estimated: EstimatedParts, convention: Convention) -> EstimateFacts:
        """Take them from what was estimated."""
        fitted, parts = estimated.fitted, estimated.parts
        without_normal, median = fitted.mean_curvature(parts.dimension, parts.unit)
        is_surface = parts.dimension == 3
        return cls(
            fitted.normal_support,
            fitted.curvature_support,
            dict(fitted.orientation),
            without_normal,
            convention if is_surface else None,
            median * (2.0 if is_surface and convention == "sum" else 1.0),
        )

    def provenance(self, orient: str) -> str:
        """How the estimates were made, for a comment."""
        supports = (self.normal_support, self.curvature_support)
        words = ",".join(f"{support:.4g}" for support in supports if support is not None)
        return f"support={words} orient={orient}"


@dataclass(frozen=True)
class DenoiseReport(Report):
    """What was done to a cloud, and what came of it.

    Attributes
    ----------
    input, output : str
        The files.
    points : PointFacts
        What was read.
    fixed : int
        Points that stay.
    tiles : int or None
        Tiles that the cloud was cut into, if it was.
    spacing, radius : float
        Mean spacing and radius of the shapes, of local radii the median, L.
    radius_range : list of float or None
        Least and largest of local radii, L.
    sparse_share : float or None
        If local radii were chosen, the share of the surface for which one would be too small.
    volume_before, volume_after, area_before, area_after : float
        Of the union, L^d and L^(d-1).
    mean_displacement, max_displacement : float
        From start to end, L, of the points that are not fixed.
    rms_along_normal, rms_along_surface : float or None
        See `Facts`.
    noise_after : float or None
        Median of the errors that the filter leaves along the normals, as standard deviations, L.
    scheme, energy, weight : str
        Of the method.
    step : float
        Time step; 0 of a filter.
    iterations : int
        Steps taken.
    plan : PlanFacts
        Noise and density.
    outliers : int or None
        Points taken for outliers, if that was looked for.
    outliers_as : {"mark", "remove", "only", "class"}
        Whether the file marks them, is without them, holds nothing else, or has their classes.
    outliers_marked : bool
        Whether a column of the file marks them.
    outlier_classes : ClassCounts or None
        How many got which class.
    removed : int
        Points of the input that the file does not hold for that.
    at_limit : int or None
        Points that the filter has moved as far as it moves any.
    sides : bool or None
        Whether the filter told both sides of thin parts apart; None if surfaces were not told to be
        closed.
    order : {1, 2} or None
        Of implicit steps.
    motion : str
        Free, normal or ray.
    origin : list of float or None
        Where the beams come from, L.
    max_move : float or None
        Most that a point could move, as a length, L.
    keep_volume : bool
        Whether volumes were kept.
    strength : float
        Share of its way that each point went.
    stop : float or None
        Mean move that ends the flow, in spacings.
    gradient : str or None
        How gradients were found, of flows.
    stopped_early : bool
        Whether it did end.
    solver_iterations : list of int
        Of each implicit step.
    solver_error : float
        Bound of the worst step's relative error.
    shape : ShapeFacts or None
        The body in place of the ball.
    estimates : EstimateFacts
        Normals and curvatures.
    rounding : float
        Most that the format of the output rounded a coordinate, L.
    seconds : float
        Time that it took.
    """

    input: str
    output: str
    points: PointFacts
    fixed: int
    tiles: int | None
    spacing: float
    radius: float
    radius_range: list[float] | None
    sparse_share: float | None
    volume_before: float
    volume_after: float
    area_before: float
    area_after: float
    mean_displacement: float
    max_displacement: float
    rms_along_normal: float | None
    rms_along_surface: float | None
    noise_after: float | None
    scheme: MethodName
    energy: str
    weight: str
    step: float
    iterations: int
    plan: PlanFacts
    outliers: int | None
    outliers_as: Outliers
    outliers_marked: bool
    outlier_classes: ClassCounts | None
    removed: int
    at_limit: int | None
    sides: bool | None
    order: Order | None
    motion: str
    origin: list[float] | None
    max_move: float | None
    keep_volume: bool
    strength: float
    stop: float | None
    gradient: str | None
    stopped_early: bool
    solver_iterations: list[int]
    solver_error: float
    shape: ShapeFacts | None
    estimates: EstimateFacts
    rounding: float
    seconds: float

    @classmethod
    def of(
        cls,
        denoised: Denoised,
        facts: Facts,
        convention: Convention,
        *,
        input: str,
        output: str,
        points: PointFacts,
        tiles: int | None,
        shape: ShapeFacts | None,
        seconds: float,
        outliers_as: Outliers = "mark",
        outliers_marked: bool = True,
        outlier_classes: ClassCounts | None = None,
        removed: int = 0,
    ) -> DenoiseReport:
        """Take it from what came of a cloud."""
        method, motion, moved = denoised.method, denoised.motion, denoised.moved
        unit = denoised.parts.unit
        first, last = denoised.history[0], denoised.history[-1]
        return cls(
            input,
            output,
            points,
            facts.fixed,
            tiles,
            denoised.measured.spacing * unit,
            moved.radius * unit,
            denoised.estimated.radius_range,
            denoised.estimated.sparse_share,
            first.volume,
            last.volume,
            first.area,
            last.area,
            facts.mean_displacement,
            facts.max_displacement,
            facts.rms_along_normal,
            facts.rms_along_surface,
            facts.noise_after,
            method.name,
            method.shapes.quantity,
            method.shapes.weight,
            denoised.step,
            len(denoised.history) - 1,
            PlanFacts.of(denoised.plan),
            facts.outliers,
            outliers_as,
            outliers_marked,
            outlier_classes,
            removed,
            facts.at_limit,
            None if denoised.plan is None else denoised.plan.tells_sides_apart,
            method.order,
            motion.direction,
            None if motion.origin is None else [float(place) for place in motion.origin],
            None if motion.max_move is None else float(motion.max_move),
            motion.keep_volume,
            float(motion.strength),
            method.stop if isinstance(method, EulerFlow | ImplicitFlow) else None,
            None if method.name == "filter" else method.shapes.gradient,
            denoised.stopped_early,
            list(moved.solver_iterations),
            moved.solver_error,
            shape,
            EstimateFacts.of(denoised.estimated, convention),
            0.0,  # until it is written
            seconds,
        )

    def outliers_in_words(self) -> str:
        """Say how many outliers there are and what became of them."""
        count = self.outliers or 0
        words = counted(count, "outlier")
        if self.outliers_as == "mark":
            where = "column outlier" if self.outliers_marked else "not marked in the file"
            return f"{words} left where they are ({where})"
        if self.outlier_classes is not None:
            low, high = self.outlier_classes.class_7, self.outlier_classes.class_18
            fixed = f", {count - low - high} of them fixed" if count > low + high else ""
            return f"{words}{fixed}: {low} to class 7, {high} above the surface to class 18"
        held = count - (
            self.removed if self.outliers_as == "remove" else self.points.points - self.removed
        )
        held_words = f", {held} of them fixed" if held else ""
        if self.outliers_as == "remove":
            left = self.points.points - self.removed
            return f"{words}{held_words}: {self.removed} removed, {left} points written"
        return f"{words}{held_words}: only they are written, {self.removed} points are not"

    def noise_in_words(self) -> str:
        """Say how much noise was found, and how much is left; nothing if there was no looking."""
        found = self.plan.noise_in_words()
        if not found or self.noise_after is None:
            return found
        return f"{found}; {self.noise_after:.4g} left"

    def moved_in_words(self) -> str:
        """Say how far points moved."""
        return f"{self.mean_displacement:.4g} on average, {self.max_displacement:.4g} at most"

    def rms_in_words(self) -> str:
        """Say how far points moved along the normal and along the surface; nothing if unknown."""
        if self.rms_along_normal is None:
            return ""
        return (
            f"RMS {self.rms_along_normal:.4g} along the normal, "
            f"{self.rms_along_surface:.4g} along the surface"
        )

    def at_limit_in_words(self) -> str:
        """Say how many points moved as far as the filter moves any; nothing of none."""
        if not self.at_limit:
            return ""
        share = self.at_limit / self.points.taking_part
        moved = f"{counted(self.at_limit, 'point')} ({100.0 * share:.2g} %)"
        return f"{moved} moved as far as noise explains"

    def restraints_in_words(self) -> list[str]:
        """Say how motion was restrained; nothing of free motion."""
        return [
            *(["along the normals"] if self.motion == "normal" else []),
            *([f"along the beams from {_place(self.origin)}"] if self.origin else []),
            *(["volume kept"] if self.keep_volume else []),
            *([f"at most {self.max_move:.4g} in all"] if self.max_move else []),
            *([f"{self.strength:.3g} of the way"] if self.strength != 1.0 else []),
        ]

    def early_end_in_words(self) -> str:
        """Say why a flow ended before its last step; nothing if it did not."""
        if not self.stopped_early:
            return ""
        return f"the last step moved the points by less than {self.stop:g} spacings"

    def provenance(self, orient: str) -> str:
        """Write what was done for a comment, in which values have no spaces."""
        is_filter = self.scheme == "filter"
        words = {
            "scheme": self.scheme,
            "noise": self.plan.noise is not None and f"{self.plan.noise:.9g}",
            "energy": "" if is_filter else self.energy,
            "weight": "" if is_filter else self.weight,
            "order": self.order,
            "step": "" if is_filter else f"{self.step:.9g}",
            "iterations": "" if is_filter else str(self.iterations),
            "motion": "" if self.motion == "free" else self.motion,
            "origin": "" if self.origin is None else _place(self.origin),
            "max_move": self.max_move and f"{self.max_move:.9g}",
            "keep_volume": "yes" if self.keep_volume else "",
            "strength": "" if self.strength == 1.0 else f"{self.strength:.9g}",
            "stop": self.stop and f"{self.stop:.9g}",
            "closed": "" if self.sides is None else "yes",
            "gradient": "" if self.gradient == "analytic" else self.gradient,
            "polyhedron": self.shape and printable("-".join(self.shape.polyhedron.split())),
            "union": self.shape and self.shape.union,
            "radius": _radius_in_a_word(self.radius, self.radius_range),
            "spacing": f"{self.spacing:.9g}",
        }
        said = "".join(f"{name}={value} " for name, value in words.items() if value)
        return f"denoise {said}{self.estimates.provenance(orient)}"


def _place(origin: list[float]) -> str:
    """Spell a place without spaces."""
    return ",".join(f"{number:.9g}" for number in origin)


def _radius_in_a_word(radius: float, radius_range: list[float] | None) -> str:
    """Say what the radius was, for a comment: of local ones median, least and largest."""
    return ",".join(f"{value:.9g}" for value in (radius, *(radius_range or ())))


def filled_in_words(dimension: int) -> str:
    """Say why a cloud without a surface is left alone."""
    flat = dimension == 2
    surface, filled = ("curve", "an area") if flat else ("surface", "a volume")
    return f"no {surface} shows at any scale, the points fill {filled}"


@dataclass(frozen=True)
class CurvatureReport(Report):
    """What was estimated of a cloud.

    Attributes
    ----------
    input, output : str
        The files.
    points : PointFacts
        What was read.
    tiles : int or None
        Tiles that the cloud was cut into, if it was.
    estimator : {"cells", "gradient"}
        How.
    energy : {"volume", "area"} or None
        Whose gradient is taken.
    spacing, radius : float
        Mean spacing and radius of the balls, of local radii the median, L.
    radius_range : list of float or None
        Least and largest of local radii, L.
    sparse_share : float or None
        If local radii were chosen, the share of the surface for which one would be too small.
    estimates : EstimateFacts
        Normals and curvatures.
    rounding : float
        Most that the format of the output rounded a coordinate, L.
    seconds : float
        Time that it took.
    """

    input: str
    output: str
    points: PointFacts
    tiles: int | None
    estimator: str
    energy: str | None
    spacing: float
    radius: float
    radius_range: list[float] | None
    sparse_share: float | None
    estimates: EstimateFacts
    rounding: float
    seconds: float

    @classmethod
    def of(
        cls,
        estimated: EstimatedParts,
        convention: Convention,
        estimator: Estimator,
        quantity: Quantity,
        *,
        input: str,
        output: str,
        points: PointFacts,
        tiles: int | None,
        seconds: float,
    ) -> CurvatureReport:
        """Take it from what was estimated of a cloud."""
        is_fitted = estimator == "cells"
        found = EstimateFacts.of(estimated, convention)
        if points.selection is not None:
            others = points.taking_part - points.selection.selected  # which have none, of course
            found = replace(found, without_normal=found.without_normal - others)
        return cls(
            input,
            output,
            points,
            tiles,
            estimator,
            None if is_fitted else quantity,
            estimated.spacing * estimated.parts.unit,
            estimated.radius * estimated.parts.unit,
            estimated.radius_range,
            estimated.sparse_share,
            found if is_fitted else replace(found, curvature_support=None),
            0.0,  # until it is written
            seconds,
        )

    def provenance(self, orient: str) -> str:
        """Write what was done for a comment, in which values have no spaces."""
        on = "" if self.energy is None else f" energy={self.energy}"
        return (
            f"curvature estimator={self.estimator}{on} "
            f"radius={_radius_in_a_word(self.radius, self.radius_range)} "
            f"spacing={self.spacing:.9g} {self.estimates.provenance(orient)}"
        )
