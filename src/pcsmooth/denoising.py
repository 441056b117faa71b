"""Denoise a cloud: from positions as they come to smoothed positions with estimates."""

from __future__ import annotations

from dataclasses import replace
from typing import Unpack

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.estimate import estimate_on_union, given_normals, spread_over
from pcsmooth.denoise_result import DenoiseResult, Record, record_of
from pcsmooth.errors import InvalidInputError
from pcsmooth.filters.plan import plan_filter
from pcsmooth.filters.surface_filter import N_PASSES
from pcsmooth.flows.filtering import Filtering
from pcsmooth.flows.flow import run_flow
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.methods.estimate import Estimate
from pcsmooth.methods.keywords import Keywords, resolve_keywords
from pcsmooth.methods.measured import Measured
from pcsmooth.methods.method import Method
from pcsmooth.methods.motion import Direction, Motion
from pcsmooth.neighbors import distinct_points, mean_spacing
from pcsmooth.point_order import take_in_order
from pcsmooth.positions import as_positions, usable_rows
from pcsmooth.progress import Callback, Progress
from pcsmooth.real_numbers import real_array
from pcsmooth.unit_of_length import unit_for


def denoise(
    points: npt.ArrayLike,
    method: Method | None = None,
    *,
    motion: Motion | Direction = "free",
    estimate: Estimate | None = None,
    fixed: npt.ArrayLike | None = None,
    normals: npt.ArrayLike | None = None,
    threads: int | None = None,
    callback: Callback | None = None,
    **keywords: Unpack[Keywords],
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
    method : Filter, EulerFlow or ImplicitFlow, optional
        How; by default the filter.
    motion : Motion, "free" or "normal"
        How points may move.
    estimate : Estimate, optional
        How normals and curvatures are estimated at the new positions.
    fixed : array_like of bool, shape (n,), optional
        Points that stay, and act on the others; masked ones do not stay.
    normals : array_like, shape (n, d), optional
        Normals of the input, which those at the new positions may follow: see
        `estimate_curvature`.
    threads : int, optional
        Threads to use, all by default. The result does not depend on it.
    callback : callable, optional
        Called with a `Progress` after each pass of the filter, and with its `record` set when a
        state is reached.
    **keywords
        In place of objects, what they are made of, all optional: ``scheme``, ``noise``, ``order``,
        ``iterations``, ``step``, ``stop``, ``radius``, ``energy``, ``weight``, ``gradient``,
        ``polyhedron`` and ``union`` of the method (see `MethodKeywords`), ``max_move`` and
        ``keep_volume`` of the motion, ``support`` and ``orient`` of the estimate.

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
    >>> flow = EulerFlow(shapes=Balls(radius="3x", quantity="area"), iterations=10)
    >>> denoise(circle, flow).history[-1].iteration
    10
    """
    method, motion, estimate = resolve_keywords(method, motion, estimate, keywords)
    positions = as_positions(points)
    orientation = estimate.orientation
    given = given_normals(normals, positions.shape, orientation)
    finite = usable_rows(positions)
    if not finite.any():
        raise InvalidInputError("there is no point with finite coordinates; nothing to denoise")
    held = None if fixed is None else _as_marks(fixed, len(positions))

    with thread_limit(threads) as n_threads:
        taken = take_in_order(positions, finite, given)
        start, rows = taken.points, taken.rows
        spacing = mean_spacing(start, n_threads)
        unit = unit_for(start, spacing)
        start, spacing = start / unit, spacing / unit  # everything is in this unit from here on
        cloud = Measured(start, spacing, unit)
        radius = cloud.radius(method.shapes.radius)
        plan = None
        if method.needs_plan:
            plan = plan_filter(distinct_points(start), method.told_noise(cloud), n_threads)
        restraint = motion.restraint(cloud, moves_along_normals=method.moves_along_normals)
        scheme = method.scheme(cloud, plan, motion)
        tell = _Teller(callback, method.iterations)
        if isinstance(scheme, Filtering):
            scheme = replace(scheme, on_pass=tell.of_pass)
        states = run_flow(
            method.shapes.energy(radius), start, scheme, method.iterations,
            fixed=None if held is None else held[rows],
            restraint=restraint,
            stop=0.0 if method.stop is None else method.stop * spacing,
        )  # fmt: skip
        history, solved, error = [], [], 0.0
        for state in states:
            history.append(record_of(state).scaled(unit, start.shape[1]))
            if state.solver_iterations:
                solved.append(state.solver_iterations)
            error = max(error, state.solver_error)
            tell.of_state(history[-1])
        # Normals and curvatures are those of the surface, whatever the shapes that moved it.
        curvature = estimate_on_union(
            state.points, state.balls, radius, spacing,
            support=estimate.support,
            orientation=orientation.seen_from(taken.origin, unit),
            given=None if given is None else given[rows],
            is_smoothed=state.iteration > 0,
        )  # fmt: skip

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
        method=method,
        motion=motion,
        spacing=spacing * unit,
        radius=radius * unit,
        step=state.step * method.unit_of_step(cloud),
        plan=None if plan is None else plan.scaled(unit),
        max_move=None if motion.max_move is None else restraint.longest * unit,
        stopped_early=state.iteration < method.iterations,
        solver_iterations=tuple(solved),
        solver_error=error,
        finite=finite,
    )


def _as_marks(fixed: npt.ArrayLike, count: int) -> npt.NDArray[np.bool_]:
    """Take the marks of fixed points; masked ones are not set."""
    marks = np.nan_to_num(real_array(fixed, "fixed marks", may_be_bool=True)) != 0.0
    if marks.shape != (count,):
        raise InvalidInputError(
            f"fixed has shape {marks.shape}; it must have one value per point, ({count},)"
        )
    return np.asarray(marks)


class _Teller:
    """Tells a callback of passes and states."""

    def __init__(self, callback: Callback | None, steps: int) -> None:
        self._callback = callback if callback is not None else lambda _progress: None
        self._steps = steps
        self._passes = 0

    def of_pass(self) -> None:
        self._passes += 1
        self._callback(Progress("filter", self._passes, N_PASSES))

    def of_state(self, record: Record) -> None:
        self._callback(Progress("steps", record.iteration, self._steps, record))
