"""The numbers of the filter, each with its reason."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any, Generic, TypeVar

from pcsmooth.errors import InvalidInputError

_Value = TypeVar("_Value")


@dataclass(frozen=True)
class ByDimension(Generic[_Value]):
    """What differs between curves in the plane and surfaces in space.

    Attributes
    ----------
    plane, space
        In 2D and in 3D.
    """

    plane: _Value
    space: _Value

    def __getitem__(self, dimension: int) -> _Value:
        """Return what there is in 2 or 3 dimensions."""
        return self.plane if dimension == 2 else self.space


@dataclass(frozen=True, kw_only=True)
class FilterDesign:
    """Numbers by which the filter measures a cloud and takes its noise out.

    None has a unit. Where no measurement is named none is on record: the number is a choice, and
    `make bench-quality` shows what it does. Others are tried by `dataclasses.replace` and
    `Filter(design=...)`. What follows from the steps themselves, such as how far a point depends on
    others, stands beside them, and the range of the repulsion, 2.2 widths of its Gaussian, in its
    kernel (`tangential_repulsion.REACH`).

    Attributes
    ----------
    samples : int
        Points at which a cloud is looked at.
    nearest : int
        Nearest points there, whose distances are known. Bounds time and memory.
    noise_supports : ByDimension of tuple of int
        Points of the neighbourhoods in which the noise is measured, the smallest first. Of so many
        as the largest has, positions are known.
    noise_max_share : float
        Largest share of the points that such a neighbourhood may have: of a shape that is no more
        than a few neighbourhoods, everything is detail.
    noise_max_residual : ByDimension of float
        A neighbourhood is wide enough if the residuals are below this share of its radius: then it
        holds nearly all the noise along its normal, on a surface. Curves bring their own detail,
        and other parts of themselves, into neighbourhoods that wide.
    noise_kept : ByDimension of tuple of (float, float)
        The residual over the radius of the neighbourhood, and the residual that Gaussian noise of 1
        leaves there: less than 1 because the neighbourhood, a ball, cuts the noise off. Measured
        on random points of a plane and of a line.
    uneven_quantiles : tuple of float
        Low and high quantile of noise and spacing that are compared.
    uneven_spacing, uneven_noise : ByDimension of float
        Their ratio, of the spacings and of the noise around the samples, beyond which a cloud has a
        map of both. Even models with noise of 1 and 2 % of their size have 1.3 and 1.7 at most,
        simulated scans 1.2 to 12 and 1.3 to 4.7, mostly more of one than of the other. Random
        points of a curve vary more.
    uneven_cover : ByDimension of float
        Radius of the neighbourhoods that cover the surface, in units of the spacing in them, beyond
        which it has one too: points on lines. Even surfaces have 1.7 to 2.0, lines seven times as
        far apart as their points 2.3. Curves never do.
    map_samples, map_nearest : int
        The same as `samples` and `nearest` for the map.
    map_neighbors : int
        Nearest samples between which the map is interpolated.
    cover_supports : ByDimension of tuple of int
        Points of the neighbourhoods that may cover the surface. On curves all do.
    cover_ratio : float
        A neighbourhood covers the surface if the second largest variance of its points is this
        share of the largest, or more.
    cover_group : int
        Samples whose median is the spacing around one.
    cable_support : int
        Nearest points that tell if a point is on a cable.
    cable_width : float
        Variance across it in units of that along it, up to which points are a line.
    cable_roundness : float
        Least variance across it over the largest, from which on it is no line of a scan: of cables
        with noise in all directions half have 0.6 or more, of scan lines with noise along the beam
        nearly 0.
    layer_count : int
        Nearest points that tell if a point lies in an exactly flat layer.
    layer_thickness : float
        Thickness of a layer in units of the width of the neighbourhood, at most.
    layer_share : float
        Share of the samples that lie in such layers, from which on steps are looked for.
    layer_supports : tuple of int
        Points of neighbourhoods that may hold several layers, beyond those that may cover the
        surface.
    layer_rows : float
        Rows of points that a layer holds, at least: more than one, which lattices have.
    layer_slant : float
        Variance of the heights over the layers in units of that of the positions, at most: walls
        that are slanted by less than 45 degrees have less than a third, scan lines more.
    stepped_share : float
        Share of the samples that have several layers around, from which on a cloud has steps.
    noise_group : ByDimension of int
        Samples from which the noise around one is found.
    noise_wide_group : ByDimension of float
        Share of all samples that make a larger group around the same place. All of 48 of 8,000
        samples may be at edges, and then their noise is too large.
    noise_wide_limit : float
        Noise of a group in units of that of the larger one, at most. Errors at edges of two
        simulated scans are 0.96 and 0.98 of those before the filter, without limit 1.13 and 1.12.
        With 1, by the larger group alone, 0.95 and 0.96, but where noise grows with range all
        errors are a tenth larger.
    noise_quantile : float
        Share of them whose residuals are less than those that tell the noise. With half of them,
        the median, errors at edges of simulated scans are 2 to 11 % larger, and the noise of two
        sheets 20 noises apart comes out as 5.7 instead of 1.6 times what it is.
    scale_quantile, scale_limit : float
        No point has more noise or spacing than the limit times this quantile. Bounds the time that
        a few far points take.
    radius_slack : float
        Factor by which the radius of a neighbourhood may be larger than its noise and spacing let
        expect, where these differ.
    pilot_points : int
        Points of the pieces of a cloud on which the passes are tried, in all. A cloud of no more is
        taken as a whole.
    pilot_least, pilot_most : int
        Points of a piece. On clouds of fewer points nothing is tried: what it told would differ by
        5 % and more by chance.
    pilot_width : float
        Radius of a piece in units of the median radius of the neighbourhoods.
    pilot_max_extent : float
        Radius of a piece in units of that of most, at most.
    pilot_step : float
        Factor by which less noise is tried, below 1.
    pilot_steps : int
        Times that this is done, at most.
    pilot_slope : float
        Power of what filters are told to which what they take falls on a plateau, at most. On
        models with noise of 0.3 to 3 % of their size and up to 1.5 spacings it falls to a power of
        0 to 0.35, where two sheets are merged of 0.7 and more.
    pilot_support : float
        Points of the neighbourhoods up to which that is so; where there are more, the power grows
        in proportion. With 90 of them powers of 1.3 were met on models, with 200 of 2.2.
    pilot_max_support : float
        The same up to which what is taken is trusted.
    pilot_share : float
        What is taken on a plateau in units of what is told, at least, where both are trusted. Where
        one began to be looked for above it, 0.35 to 0.7 are found at its upper end.
    sides_samples : int
        Points from which is found which side of a closed surface is outside, at most.
    sides_nearest : int
        Points around each, itself included, whose distance tells how much of the surface it stands
        for.
    sides_far : float
        Points farther from these than so many times the median are left out, if they are few: a
        lattice around them would show nothing else.
    sides_few : float
        Share of the points that they are, at most: more are the sparse part of a surface.
    sides_noise : float
        Parts whose sides are in one neighbourhood show on the lattice if its step is at most so
        many times the noise; else sides are not told apart.
    sides_step : float
        Least step of the lattice, in units of the noise: on finer ones the noise of a sphere of
        5,000 points has an inside of its own.
    sides_cells : int
        Cells along each side of the lattice, at least. With 28 errors on a sphere whose noise is a
        tenth of its radius are up to three times as large as without sides.
    sides_width : float
        Width of the Gaussian by which the lattice's field is smoothed, in units of the noise. With
        0.7 errors on smooth shapes with noise of 3 % of their size are up to a third larger than
        without, with 1.4 as large.
    flatness_supports : ByDimension of tuple of int
        Points of the neighbourhoods whose flatness is looked at, the smallest first, each with
        nearly half as many again.
    flatness_max_share : float
        Largest share of the points that such a neighbourhood may have.
    solid_flatness : ByDimension of float
        Thickness of a neighbourhood over its width, squared, above which it is no piece of a
        surface. Half a ball has 0.3, the neighbourhoods of volumes 0.35 and more in the median, in
        the plane 0.38; pieces of surfaces, with any noise up to a third of the neighbourhood's
        radius, less.
    surface_flatness : float
        The same below which a neighbourhood surely is a piece of a surface.
    surface_share : float
        Share of points with such a neighbourhood from which on a cloud has a surface. Of volumes
        less than a tenth do.
    pass_count : ByDimension of float
        Points of the neighbourhoods of the passes without noise (see `Width`).
    pass_thickness : tuple of float
        Thickness of the sheet of points, in units of the noise, in each pass: the later find a
        thinner one.
    pass_exponents : tuple of int
        Exponents of the neighbours' weights |n_i . n_j| in each pass, even: normals are known
        better and better. Outliers are looked for by those of the first.
    pass_variances : tuple of float
        Variance of the heights around a point that noise explains in each pass, in units of the
        noise's: twice what is left of it, as heights are few. Where there is more, at edges and
        detail that the points are too far apart to show, a point takes only that share of its
        move. On scans of buildings with a spacing of many times the noise, errors at edges after
        the filter are 0.98 to 1.05 of those before, without it 1.3 to 1.7; models with as much
        noise as the benchmark's change by less than 0.2 %.
    normals_exponent : int
        Exponent of the weights with which the normals of a pass are averaged, even.
    last_count : ByDimension of float
        Points of the neighbourhoods of the last step without noise.
    last_thickness : float
        Thickness of the sheet of points, in units of the noise, in the last step.
    last_exponent : int
        Exponent of the neighbours' weights in the last step, even.
    radius_quantile : float
        Share of the points whose wanted radius is no larger than the largest radius of the
        neighbourhoods, but for the margin.
    radius_margin : float
        Factor of that radius.
    max_within : float
        Points within the largest radius of a point in the mean, at most. Bounds the time.
    radius_shrinkage : float
        Factor by which the largest radius is made smaller until that is so, below 1.
    residual_variance : float
        Variance that the passes leave on a smooth surface, in units of the noise's over the points
        of a neighbourhood: 0.93 to 1.03 on spheres with noise of 0.2 to 1.4 spacings, 0.97 to 1.26
        on circles, and a margin, because energies are means over few points.
    energy_share : float
        Share of a neighbourhood's area over which the energy of residuals is averaged.
    max_move : float
        Most that a point ends up away from its start, in units of the noise: real noise has long
        tails, and is larger in places. With 2.5, errors on a sphere among 1 to 30 % of outliers are
        a tenth to a quarter larger.
    max_move_by_map : float
        The same where the noise is known place by place, in units of what it is there. 6 instead of
        2.5 makes the errors on scans of buildings 1.5 times as large, at edges twice.
    left_kept : float
        Share of the variance of its error that a point keeps in a pass whose move it takes whole.
    left_heights : float
        Variance of the error that a pass brings, in units of that of the heights around, times the
        share of its move that a point takes. These two and the next three tell how much error is
        left (`DenoiseResult.sigma_after`). They are fitted to the true errors on half of 36 clouds:
        scan lines, sheets, outliers, simulated scans, and models with noise of 1 and 3 % of their
        size; of the errors of the other scans 66 to 78 % are within what is told, of those on these
        models 56 to 73 %, between two sheets of any distance 52 to 56 %.
    left_pass : float
        Variance of the error that the passes leave without detail, in units of the noise's over
        the points of a neighbourhood, where a point takes nothing of the last step.
    left_last : ByDimension of float
        The same of the last step, where it takes all. In the plane fitted to ellipses, squares and
        waves: 61 to 74 % of their errors are within what is told.
    left_detail : float
        Variance of the error that detail brings, in units of that of the heights around in the last
        step, which count up to the noise's.
    outlier_rounds : int
        Times that is looked for outliers, each without those found before, which stand by each
        other.
    outlier_deviations : float
        Heights beyond so many deviations are outliers', if they are beyond the spacing too.
    outlier_max_height : float
        Heights count for the deviation around them up to this many units of the noise.
    isolated_count : ByDimension of float
        Points of a neighbourhood, itself included, with fewer of which a point is isolated.
    isolated_share : ByDimension of float
        The same as a share of what is wanted within the largest radius. Gaps between random points
        of a curve can be wide.
    isolated_max_share : float
        Largest share of the points that may be isolated, beyond that of the strays. If there are
        more, the largest radius is less than their spacing: they are the sparse part of a cloud,
        not outliers.
    sheet_count : ByDimension of int
        Points nearest to an isolated one, itself included, that may show a sheet or line it is on.
    sheet_thickness : ByDimension of float
        Their thickness over their width, squared, up to which they do. Without that 0.12 to 0.45 %
        of the true points of simulated scans are taken for isolated, where these are sparse, with
        it 0.04 % at most; of random points in space 1.3 % are as flat, in the plane 1 in 10,000.
    clear_sheet_thickness : ByDimension of float
        The same among isolated points alone, in clouds of one spacing.
    clump_size : int
        Points of a clump, at most: as many that are close to each other and far from all others
        are outliers.
    stray_counts : tuple of int
        Ranks of the nearest points, itself included, whose distances tell if a sample is a stray:
        by the few single ones are told, by the many clumps.
    stray_distance : float
        Strays are farther from others than this many times what dense parts let expect. Of even
        surfaces' samples none to one in a thousand are, but these are no strays.
    stray_slope : float
        What the spacing of a scan may grow by with the distance from its dense parts, in units of
        the angle between its beams if all points had been seen from one place.
    stray_group : int
        Samples whose median tells if strays fill a volume, and if a dense part is one.
    stray_thickness : ByDimension of float
        Thickness of their neighbourhoods over their width, squared, beyond which they do. That of
        random points in space is 0.36 to 0.53 for half of them.
    stray_clear : float
        Strays are clear if they are beyond this many times both limits.
    stray_clear_share : float
        Share of the strays that are clear from which on they are a crowd of outliers. Of those
        among 5 to 30 % of random points around shapes and in scans 0.6 to 1 are, of those in
        vegetation and in a street from a rotating laser 0.24 to 0.46.
    stray_min_share : float
        Share of the samples up to which strays are let be: they do not spoil what is measured.
    redistribution_width : float
        Width of the Gaussian by which points repel each other, in units of the local spacing.
    redistribution_steps : int
        Steps of the repulsion.
    redistribution_strength : float
        Their strength.
    redistribution_max_move : float
        Most that a point may move along the surface, in units of the noise: the clean positions are
        no farther away.
    border_offset : float
        Points farther than this from the centroid of their neighbourhood, in units of its radius,
        are taken for points of a border, and stay: the centroid of a half disc is 4 / (3 pi) = 0.42
        from its centre, that of a half line 0.5.

    Raises
    ------
    InvalidInputError
        A number makes no sense where that would not show: one is not positive, a share is more than
        1, an exponent is odd, or the entries of a table are too few or not in order.
    """

    samples: int = 800
    nearest: int = 1000

    noise_supports: ByDimension[tuple[int, ...]] = ByDimension(
        (6, 8, 11, 16, 22, 32, 45, 64, 90, 128), (16, 24, 36, 54, 80, 120, 180, 270, 400)
    )
    noise_max_share: float = 0.25
    noise_max_residual: ByDimension[float] = ByDimension(0.34, 0.27)
    noise_kept: ByDimension[tuple[tuple[float, float], ...]] = ByDimension(
        (
            (0.0, 1.0), (0.1, 0.995), (0.15, 0.985), (0.2, 0.97), (0.25, 0.925), (0.3, 0.86),
            (0.35, 0.75),
        ),
        (
            (0.0, 1.0), (0.1, 0.99), (0.15, 0.973), (0.19, 0.945), (0.22, 0.917), (0.25, 0.885),
            (0.28, 0.82),
        ),
    )  # fmt: skip

    uneven_quantiles: tuple[float, float] = (0.1, 0.9)
    uneven_spacing: ByDimension[float] = ByDimension(2.5, 1.5)
    uneven_noise: ByDimension[float] = ByDimension(3.0, 2.0)
    uneven_cover: ByDimension[float] = ByDimension(2.0, 2.2)
    map_samples: int = 8000
    map_nearest: int = 256
    map_neighbors: int = 6
    cover_supports: ByDimension[tuple[int, ...]] = ByDimension(
        (16,), (6, 9, 13, 16, 24, 36, 54, 80, 120, 180, 256)
    )
    cover_ratio: float = 0.4
    cover_group: int = 16
    cable_support: int = 36
    cable_width: float = 0.05
    cable_roundness: float = 0.25
    layer_count: int = 6
    layer_thickness: float = 3e-3
    layer_share: float = 0.25
    layer_supports: tuple[int, ...] = (400,)
    layer_rows: float = 1.5
    layer_slant: float = 0.2
    stepped_share: float = 0.25
    noise_group: ByDimension[int] = ByDimension(128, 48)
    noise_wide_group: ByDimension[float] = ByDimension(0.0375, 0.0375)
    noise_wide_limit: float = 1.25
    noise_quantile: float = 0.2
    scale_quantile: float = 0.98
    scale_limit: float = 2.0
    radius_slack: float = 1.4

    pilot_points: int = 20_000
    pilot_least: int = 256
    pilot_most: int = 4096
    pilot_width: float = 4.0
    pilot_max_extent: float = 4.0
    pilot_step: float = 0.8
    pilot_steps: int = 6
    pilot_slope: float = 0.5
    pilot_support: float = 40.0
    pilot_max_support: float = 128.0
    pilot_share: float = 0.75

    sides_samples: int = 20_000
    sides_nearest: int = 9
    sides_far: float = 10.0
    sides_few: float = 0.01
    sides_noise: float = 5.0
    sides_step: float = 1.3
    sides_cells: int = 32
    sides_width: float = 1.4

    flatness_supports: ByDimension[tuple[int, ...]] = ByDimension(
        (11, 16, 22, 32, 45, 64, 90, 128, 180), (24, 36, 54, 80, 120, 180)
    )
    flatness_max_share: float = 0.25
    solid_flatness: ByDimension[float] = ByDimension(0.36, 0.33)
    surface_flatness: float = 0.15
    surface_share: float = 0.25

    pass_count: ByDimension[float] = ByDimension(4.0, 12.0)
    pass_thickness: tuple[float, ...] = (2.5, 2.0, 1.25)
    pass_exponents: tuple[int, ...] = (2, 4, 4)
    pass_variances: tuple[float, ...] = (2.0, 1.0, 0.6)
    normals_exponent: int = 4
    last_count: ByDimension[float] = ByDimension(32.0, 128.0)
    last_thickness: float = 2.5
    last_exponent: int = 8
    radius_quantile: float = 0.95
    radius_margin: float = 1.2
    max_within: float = 2000.0
    radius_shrinkage: float = 0.9
    residual_variance: float = 1.2
    energy_share: float = 0.5
    max_move: float = 6.0
    max_move_by_map: float = 2.5

    left_kept: float = 0.08
    left_heights: float = 0.35
    left_pass: float = 1.1
    left_last: ByDimension[float] = ByDimension(1.1, 0.55)
    left_detail: float = 0.03

    outlier_rounds: int = 2
    outlier_deviations: float = 5.0
    outlier_max_height: float = 4.0
    isolated_count: ByDimension[float] = ByDimension(2.0, 5.0)
    isolated_share: ByDimension[float] = ByDimension(0.25, 0.4)
    isolated_max_share: float = 0.1
    sheet_count: ByDimension[int] = ByDimension(9, 13)
    sheet_thickness: ByDimension[float] = ByDimension(0.03, 0.1)
    clear_sheet_thickness: ByDimension[float] = ByDimension(0.01, 0.05)
    clump_size: int = 20
    stray_counts: tuple[int, int] = (8, 22)
    stray_distance: float = 2.0
    stray_slope: float = 0.5
    stray_group: int = 9
    stray_thickness: ByDimension[float] = ByDimension(0.15, 0.22)
    stray_clear: float = 1.25
    stray_clear_share: float = 0.55
    stray_min_share: float = 0.02

    redistribution_width: float = 0.65
    redistribution_steps: int = 6
    redistribution_strength: float = 0.3
    redistribution_max_move: float = 1.0
    border_offset: float = 0.3

    def __post_init__(self) -> None:
        """Check the numbers."""
        for field in fields(self):
            name = field.name
            numbers = tuple(_numbers(getattr(self, name)))
            if name != "noise_kept" and not all(0.0 < number < math.inf for number in numbers):
                raise _wrong(name, "not positive")
            if name in _SHARES and max(numbers) > 1.0:
                raise _wrong(name, "more than 1")
            if "exponent" in name and any(number % 2 for number in numbers):
                raise _wrong(name, "not even")
        for name in ("radius_shrinkage", "pilot_step"):
            if getattr(self, name) == 1.0:
                raise _wrong(name, "not below 1")
        if self.pilot_max_extent < 1.0:
            raise _wrong("pilot_max_extent", "less than 1")
        if not self.pass_thickness:
            raise _wrong("pass_thickness", "empty")
        for name in ("pass_exponents", "pass_variances"):
            if len(getattr(self, name)) != len(self.pass_thickness):
                raise _wrong(name, "not as many as pass_thickness")
        for dimension in (2, 3):
            self._check_tables(dimension)

    def _check_tables(self, dimension: int) -> None:
        kept = self.noise_kept[dimension]
        for name, increasing in (
            ("noise_supports", self.noise_supports[dimension]),
            ("flatness_supports", self.flatness_supports[dimension]),
            ("cover_supports", self.cover_supports[dimension]),
            ("uneven_quantiles", self.uneven_quantiles),
            ("stray_counts", self.stray_counts),
            ("noise_kept", (-math.inf, *(residual for residual, _ in kept))),
        ):
            if not all(low < high for low, high in pairwise(increasing)):
                raise _wrong(name, "not increasing")
        if not all(0.0 < share <= 1.0 for _, share in kept):
            raise _wrong("noise_kept", "not a share")
        if self.noise_supports[dimension][0] <= QUADRIC_TERMS[dimension]:
            raise _wrong("noise_supports", "no more than the terms of a quadric")
        if self.noise_supports[dimension][-1] > self.nearest:
            raise _wrong("noise_supports", "more than nearest")
        if self.flatness_supports[dimension][0] <= dimension:
            raise _wrong("flatness_supports", "no more than a plane has")
        if min(self.stray_counts[1], self.sheet_count[dimension]) <= dimension + 1:
            name = "sheet_count" if self.stray_counts[1] > dimension + 1 else "stray_counts"
            raise _wrong(name, "no more than a plane has, and one")
        if self.noise_supports[dimension][0] > self.map_nearest:
            raise _wrong("map_nearest", "less than the noise needs")

    @property
    def n_passes(self) -> int:
        """Passes in all, the last step included."""
        return len(self.pass_exponents) + 1


#: Terms of a quadratic polynomial on a line and on a plane.
QUADRIC_TERMS = {2: 3, 3: 6}

#: Numbers that are at most 1.
_SHARES = frozenset({
    "noise_max_share", "noise_max_residual", "flatness_max_share", "solid_flatness",
    "surface_flatness", "surface_share", "radius_quantile", "radius_shrinkage", "energy_share",
    "isolated_share", "isolated_max_share", "uneven_quantiles", "cover_ratio", "noise_quantile",
    "noise_wide_group", "scale_quantile", "sheet_thickness", "clear_sheet_thickness",
    "sides_few", "stray_thickness", "stray_min_share", "stray_clear_share", "pilot_step",
    "pilot_share",
    "left_kept", "cable_width", "cable_roundness", "layer_share",
    "layer_thickness", "layer_slant", "stepped_share",
})  # fmt: skip


def _numbers(value: Any) -> Iterator[float]:
    """All numbers of a field."""
    if isinstance(value, ByDimension):
        value = (value.plane, value.space)
    if isinstance(value, tuple):
        for part in value:
            yield from _numbers(part)
    else:
        yield value


def _wrong(name: str, problem: str) -> InvalidInputError:
    return InvalidInputError(f"{name} of the filter's design is {problem}")


#: The design that is used.
DESIGN = FilterDesign()
