"""Denoise a cloud: from positions as they come to smoothed positions with estimates."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.estimate import (
    Support,
    check_support,
    estimate_on_union,
    given_normals,
    spread_over,
)
from pcsmooth.curvature.orientation import parse_orientation
from pcsmooth.denoise_options import MotionName, resolve_options
from pcsmooth.denoise_result import DenoiseResult, Record, record_of
from pcsmooth.energies.choice import GradientName, choose_energy
from pcsmooth.energies.protocol import Quantity, Weight
from pcsmooth.energies.weighting import power_of_step
from pcsmooth.errors import InvalidInputError
from pcsmooth.filters.plan import plan_filter
from pcsmooth.flows.choice import SchemeName, choose_scheme
from pcsmooth.flows.flow import run_flow
from pcsmooth.flows.implicit import Order
from pcsmooth.flows.motion import Motion
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.lengths import resolve_length, resolve_radius, step_in_unit
from pcsmooth.neighbors import distinct_points, mean_spacing
from pcsmooth.point_order import take_in_order
from pcsmooth.positions import as_positions, usable_rows
from pcsmooth.real_numbers import real_array
from pcsmooth.unit_of_length import unit_for

if TYPE_CHECKING:
    from pcsmooth.bodies.convex_body import ConvexBody
    from pcsmooth.energies.polyhedra.union import Union


def denoise(
    points: npt.ArrayLike,
    *,
    energy: Quantity | None = None,
    weight: Weight | None = None,
    radius: float | str = "auto",
    iterations: int | Literal["auto"] = "auto",
    step: float | Literal["auto"] = "auto",
    scheme: SchemeName = "auto",
    noise: float | str | None = None,
    order: Order | None = None,
    motion: MotionName = "free",
    max_move: float | str | None = None,
    keep_volume: bool = False,
    stop: float | None = None,
    gradient: GradientName | None = None,
    polyhedron: ConvexBody | None = None,
    union: Union = "exact",
    fixed: npt.ArrayLike | None = None,
    support: Support = "auto",
    orient: str = "auto",
    normals: npt.ArrayLike | None = None,
    threads: int | None = None,
    on_state: Callable[[Record], None] | None = None,
    on_pass: Callable[[], None] | None = None,
) -> DenoiseResult:
    """Denoise a point cloud: by default filtered with parameters measured from the cloud.

    Flows are the other way: gradient descent on an energy of the union of balls around the
    points. With a convex polyhedron in place of the ball a flow is anisotropic: it turns the
    surface towards the polyhedron's facets.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
        Positions, L. Rows with a NaN, an infinity or a masked coordinate take no part and come
        back as they are, what is masked as NaN.
    energy : {"volume", "area"}, optional
        Volume of the union (by default) or measure of its boundary (2D: area, perimeter).
    weight : {"none", "cell", "boundary"}, optional
        What each point's gradient is divided by (see `weigh`); by default its cell.
    radius : float or str
        Of the balls: a length, ``"3x"`` the spacing, ``"2%"`` of the bounding box's diagonal, or
        ``"auto"``, twice the spacing. The filter has no use for it, the normals have.
    iterations : int or "auto"
        Number of steps of a flow, >= 0; by default 6 of Euler and 2 implicit ones.
    step : float or "auto"
        Time step of a flow; in units of L^2 for weighted flows. ``"auto"`` is stable (see `Euler`
        and `Implicit`).
    scheme : {"auto", "filter", "euler", "implicit"}
        The filter (see `filter_points`), a flow in explicit Euler steps, as in the report, or one
        in semi-implicit steps, which are stable whatever their length. ``"auto"`` is the filter,
        or euler if an option of flows is given: energy, weight, radius, iterations, step, stop,
        gradient or polyhedron.
    noise : float or str, optional
        Standard deviation of the noise, for the filter and for automatic implicit steps: a
        length, ``"0.5x"`` the spacing or ``"0.1%"`` of the bounding box's diagonal. By default it
        is measured (see `measure_noise`). More smooths more.
    order : {1, 2}, optional
        Order of an implicit flow: mean curvature flow, or surface diffusion, which shrinks far
        less. By default 2, with polyhedra 1.
    motion : {"free", "normal"}
        Whether points go where the scheme takes them or along their normals only. The filter
        then leaves out its step along the surface.
    max_move : float or str, optional
        Most that a point may move in all: a length, ``"0.5x"`` the spacing, or ``"1%"`` of the
        bounding box's diagonal.
    keep_volume : bool
        Take the mean normal displacement of each connected component out of each step.
    stop : float, optional
        End after the step in which the points that are not fixed move less than this on average,
        in units of the spacing.
    gradient : {"analytic", "autodiff"}, optional
        Gradients of explicit flows in closed form (by default), or by automatic differentiation of
        a slow reference, for at most `LARGEST_CLOUD` points; they agree but for rounding.
    polyhedron : ConvexBody, optional
        The body K, in d dimensions; the shapes are p_i + radius K.
    union : {"naive", "inclusion-exclusion", "exact"}
        How the union of these is computed (see `measure_polyhedra`).
    fixed : array_like of bool, shape (n,), optional
        Points that stay, and act on the others; masked ones do not stay.
    support, orient, normals
        How normals and curvatures are estimated at the new positions: see `estimate_curvature`.
    threads : int, optional
        Threads to use, all by default. The result does not depend on it.
    on_state : callable, optional
        Called with the record of each state as it is reached.
    on_pass : callable, optional
        Called after each of the `N_PASSES` passes of the filter.

    Returns
    -------
    DenoiseResult
        points, history, normals, curvatures, displacement and what was chosen.

    Raises
    ------
    InvalidInputError
        Wrong shapes or option values, no finite point, a radius that cannot be derived, or an
        implicit step that cannot be solved.

    Notes
    -----
    Points are taken in the order of their positions (see `order_by_position`): permuted rows give
    the permuted result, to the last bit.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    >>> circle = np.c_[np.cos(angle), np.sin(angle)] * (1 + 0.01 * rng.normal(size=(200, 1)))
    >>> result = denoise(circle)
    >>> bool(np.linalg.norm(result.points, axis=1).std() < 0.005)
    True
    """
    positions = as_positions(points)
    options = resolve_options(
        energy=energy, weight=weight, radius=radius, iterations=iterations, step=step,
        scheme=scheme, order=order, motion=motion, max_move=max_move, stop=stop, noise=noise,
        gradient=gradient, is_polyhedral=polyhedron is not None,
    )  # fmt: skip
    chosen, order = options.scheme, options.order
    energy, weight = options.energy, options.weight
    check_support(support)
    orientation = parse_orientation(orient)
    given = given_normals(normals, positions.shape, orientation)
    finite = usable_rows(positions)
    if not finite.any():
        raise InvalidInputError("there is no point with finite coordinates; nothing to denoise")
    held = None
    if fixed is not None:
        held = np.nan_to_num(real_array(fixed, "fixed marks", may_be_bool=True)) != 0.0
        if held.shape != (len(positions),):
            raise InvalidInputError(
                f"fixed has shape {held.shape}; it must have one value per point, "
                f"({len(positions)},)"
            )

    with thread_limit(threads) as n_threads:
        taken = take_in_order(positions, finite, given)
        start, rows = taken.points, taken.rows
        spacing = mean_spacing(start, n_threads)
        unit = unit_for(start, spacing)
        start, spacing = start / unit, spacing / unit  # everything is in this unit from here on
        length = resolve_radius(radius, start, spacing, unit)
        plan = None
        if chosen != "euler":
            told = None if noise is None else resolve_length(noise, start, spacing, "noise", unit)
            plan = plan_filter(distinct_points(start), told, n_threads)
        longest = math.inf
        if max_move is not None:
            longest = resolve_length(max_move, start, spacing, "max_move", unit)
        unit_of_step = unit ** power_of_step(energy, weight, start.shape[1])
        states = run_flow(
            choose_energy(length, energy, weight, polyhedron, union, gradient or "analytic"),
            start,
            choose_scheme(
                chosen, order=order, step=step_in_unit(step, unit_of_step), spacing=spacing,
                plan=plan, evens=motion == "free", on_pass=on_pass,
            ),
            options.steps,
            fixed=None if held is None else held[rows],
            motion=Motion(motion == "normal" and chosen != "filter", keep_volume, longest),
            stop=0.0 if stop is None else stop * spacing,
        )  # fmt: skip
        history, solved, error = [], [], 0.0
        for state in states:
            history.append(record_of(state).scaled(unit, start.shape[1]))
            if state.solver_iterations:
                solved.append(state.solver_iterations)
            error = max(error, state.solver_error)
            if on_state is not None:
                on_state(history[-1])
        # Normals and curvatures are those of the surface, whatever the shapes that moved it.
        curvature = estimate_on_union(
            state.points,
            state.balls,
            length,
            spacing,
            support=support,
            orientation=orientation.seen_from(taken.origin, unit),
            given=None if given is None else given[rows],
            is_smoothed=state.iteration > 0,
        )

    displacement = np.zeros_like(positions)
    displacement[rows] = (state.points - start) * unit
    outliers = None
    if state.outliers is not None:
        outliers = np.zeros(len(positions), np.bool_)
        outliers[rows] = state.outliers
    return DenoiseResult(
        points=np.where(displacement == 0.0, positions, positions + displacement),  # keeps -0.0
        history=tuple(history),
        curvature=spread_over(rows, finite, curvature.scaled(unit)),
        displacement=np.linalg.norm(displacement, axis=1),
        outliers=outliers,
        scheme=chosen,
        energy=energy,
        weight=weight,
        spacing=spacing * unit,
        radius=length * unit,
        step=state.step * unit_of_step,
        plan=None if plan is None else plan.scaled(unit),
        order=order,
        max_move=None if max_move is None else longest * unit,
        stopped_early=state.iteration < options.steps,
        solver_iterations=tuple(solved),
        solver_error=error,
        finite=finite,
    )
