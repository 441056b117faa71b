"""Denoise a cloud: from positions as they come to smoothed positions with estimates."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.estimate import (
    CurvatureEstimate,
    Support,
    check_support,
    estimate_on_union,
    given_normals,
    spread_over,
)
from pcsmooth.curvature.orientation import parse_orientation
from pcsmooth.denoise_options import MotionName, check_options
from pcsmooth.energies.choice import choose_energy
from pcsmooth.energies.weighting import Quantity, Weight
from pcsmooth.errors import InvalidInputError
from pcsmooth.flows.choice import SchemeName, choose_scheme, default_iterations, resolve_order
from pcsmooth.flows.flow import run_flow
from pcsmooth.flows.implicit import Order
from pcsmooth.flows.motion import Motion
from pcsmooth.flows.state import State
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.lengths import resolve_length, resolve_radius
from pcsmooth.neighbors import mean_spacing
from pcsmooth.positions import as_positions, local_origin, usable_rows

if TYPE_CHECKING:
    from pcsmooth.bodies.convex_body import ConvexBody
    from pcsmooth.energies.polyhedra.union import Union


@dataclass(frozen=True)
class Record:
    """One state of a flow.

    Attributes
    ----------
    iteration : int
        Steps taken before it.
    volume, area : float
        Volume of the union, L^d, and measure of its boundary, L^(d-1), of this state.
    mean_move, max_move : float
        Mean and largest length of the step that led here, L; 0 at the start.
    """

    iteration: int
    volume: float
    area: float
    mean_move: float
    max_move: float


@dataclass(frozen=True)
class DenoiseResult:
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
    spacing, radius, step : float
        Mean spacing of the input, radius and time step used.
    order : {1, 2} or None
        Order of the implicit steps.
    max_move : float or None
        Most that a point could move, L.
    stopped_early : bool
        Whether the steps had become shorter than the tolerance before the last one.
    solver_iterations : tuple of int
        Iterations of the solver of linear equations in each step; empty if the scheme has none.
    solver_error : float
        Bound of the error that it has left, as a share of the step, in the worst step. Above
        `TOLERANCE` the limit of iterations was reached.
    finite : ndarray of bool, shape (n,)
        False for rows with a NaN, an infinity or a coordinate beyond 1e150, passed through.
    """

    points: npt.NDArray[np.float64]
    history: tuple[Record, ...]
    curvature: CurvatureEstimate
    displacement: npt.NDArray[np.float64]
    spacing: float
    radius: float
    step: float
    order: Order | None
    max_move: float | None
    stopped_early: bool
    solver_iterations: tuple[int, ...]
    solver_error: float
    finite: npt.NDArray[np.bool_]

    @property
    def normals(self) -> npt.NDArray[np.float64]:
        """Unit normals at the new positions, (n, d); zero where unknown."""
        return self.curvature.normals

    @property
    def mean_curvature(self) -> npt.NDArray[np.float64]:
        """Mean curvature at the new positions, (n,), 1/L: see `CurvatureEstimate`."""
        return self.curvature.mean_curvature


def denoise(
    points: npt.ArrayLike,
    *,
    energy: Quantity = "volume",
    weight: Weight = "cell",
    radius: float | str = "auto",
    iterations: int | Literal["auto"] = "auto",
    step: float | Literal["auto"] = "auto",
    scheme: SchemeName = "euler",
    order: Order | None = None,
    motion: MotionName = "free",
    max_move: float | str | None = None,
    keep_volume: bool = False,
    stop: float | None = None,
    polyhedron: ConvexBody | None = None,
    union: Union = "exact",
    fixed: npt.ArrayLike | None = None,
    support: Support = "auto",
    orient: str = "auto",
    normals: npt.ArrayLike | None = None,
    threads: int | None = None,
    on_state: Callable[[Record], None] | None = None,
) -> DenoiseResult:
    """Smooth a point cloud by gradient descent on an energy of the union of balls around it.

    With a convex polyhedron in place of the ball the flow is anisotropic: it turns the surface
    towards the polyhedron's facets.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3)
        Positions, L. Rows with a NaN or infinity take no part and come back as they are.
    energy : {"volume", "area"}
        Volume of the union or measure of its boundary (2D: area, perimeter).
    weight : {"none", "cell", "boundary"}
        What each point's gradient is divided by (see `weigh`).
    radius : float or str
        A length, ``"3x"`` the spacing, ``"2%"`` of the bounding box's diagonal, or ``"auto"``,
        twice the spacing.
    iterations : int or "auto"
        Number of steps, >= 0; by default 6 of Euler and 2 implicit ones.
    step : float or "auto"
        Time step; in units of L^2 for weighted flows. ``"auto"`` is stable (see `Euler` and
        `Implicit`).
    scheme : {"euler", "implicit"}
        Explicit Euler steps, or semi-implicit ones, which are stable whatever their length.
    order : {1, 2}, optional
        Order of an implicit flow: mean curvature flow, or surface diffusion, which shrinks far
        less. By default 2, with polyhedra 1.
    motion : {"free", "normal"}
        Whether points go where the flow takes them or along their normals only.
    max_move : float or str, optional
        Most that a point may move in all: a length, ``"0.5x"`` the spacing, or ``"1%"`` of the
        bounding box's diagonal.
    keep_volume : bool
        Take the mean normal displacement of each connected component out of each step.
    stop : float, optional
        End after the step in which the points that are not fixed move less than this on average,
        in units of the spacing.
    polyhedron : ConvexBody, optional
        The body K, in d dimensions; the shapes are p_i + radius K.
    union : {"naive", "inclusion-exclusion", "exact"}
        How the union of these is computed (see `measure_polyhedra`).
    fixed : array_like of bool, shape (n,), optional
        Points that stay, and act on the others.
    support, orient, normals
        How normals and curvatures are estimated at the new positions: see `estimate_curvature`.
    threads : int, optional
        Threads to use, all by default. The result does not depend on it.
    on_state : callable, optional
        Called with the record of each state as it is reached.

    Returns
    -------
    DenoiseResult
        points, history, normals, curvatures, displacement and what was chosen.

    Raises
    ------
    InvalidInputError
        Wrong shapes or option values, no finite point, or a radius that cannot be derived.

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
    check_options(
        energy=energy, weight=weight, radius=radius, iterations=iterations, step=step,
        scheme=scheme, order=order, motion=motion, max_move=max_move, stop=stop,
    )  # fmt: skip
    order = resolve_order(scheme, order, is_polyhedral=polyhedron is not None)
    steps = default_iterations(scheme) if iterations == "auto" else int(iterations)
    check_support(support)
    orientation = parse_orientation(orient)
    given = given_normals(normals, positions.shape, orientation)
    finite = usable_rows(positions)
    if not finite.any():
        raise InvalidInputError("there is no point with finite coordinates; nothing to denoise")
    held = None
    if fixed is not None:
        held = np.asarray(fixed, dtype=bool)
        if held.shape != (len(positions),):
            raise InvalidInputError(
                f"fixed has shape {held.shape}; it must have one value per point, "
                f"({len(positions)},)"
            )
        held = held[finite]

    with thread_limit(threads) as n_threads:
        start = positions[finite]
        origin = local_origin(start)
        start -= origin
        spacing = mean_spacing(start, n_threads)
        length = resolve_radius(radius, start, spacing)
        chosen = choose_energy(length, energy, weight, polyhedron, union)
        longest = math.inf
        if max_move is not None:
            longest = resolve_length(max_move, start, spacing, "max_move")
        states = run_flow(
            chosen,
            start,
            choose_scheme(order, None if step == "auto" else step, spacing),
            steps,
            fixed=held,
            motion=Motion(motion == "normal", keep_volume, longest),
            stop=0.0 if stop is None else stop * spacing,
        )
        history, solved, error = [], [], 0.0
        for state in states:
            history.append(_record(state))
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
            orientation=orientation.seen_from(origin),
            given=None if given is None else given[finite],
            is_smoothed=state.iteration > 0,
        )

    displacement = np.zeros_like(positions)
    displacement[finite] = state.points - start
    return DenoiseResult(
        points=np.where(displacement == 0.0, positions, positions + displacement),  # keeps -0.0
        history=tuple(history),
        curvature=spread_over(finite, curvature),
        displacement=np.linalg.norm(displacement, axis=1),
        spacing=spacing,
        radius=length,
        step=state.step,
        order=order,
        max_move=None if max_move is None else longest,
        stopped_early=state.iteration < steps,
        solver_iterations=tuple(solved),
        solver_error=error,
        finite=finite,
    )


def _record(state: State) -> Record:
    return Record(
        state.iteration,
        state.evaluation.union.volume,
        state.evaluation.union.area,
        float(state.moves.mean()),
        float(state.moves.max()),
    )
