"""Options of how points move, and what is said of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any, Literal

import click

from pcsmooth.cli.messages import WARNING, Say, filled_in_words
from pcsmooth.cli.options import Length, Positive, Step

if TYPE_CHECKING:
    from pcsmooth.denoise_result import DenoiseResult
    from pcsmooth.filters.plan import FilterPlan

Command = Callable[..., None]

_ORDERS: dict[str | None, Literal[1, 2] | None] = {None: None, "1": 1, "2": 2}


@dataclass(frozen=True)
class Moving:
    """How points are to move.

    Attributes
    ----------
    energy, weight, iterations, step, scheme, noise, order, motion, max_move, keep_volume, stop,
    gradient
        Arguments of `pcsmooth.denoise`, under their names there.
    """

    energy: Literal["volume", "area"] | None
    weight: Literal["none", "cell", "boundary"] | None
    iterations: int | Literal["auto"]
    step: float | Literal["auto"]
    scheme: Literal["filter", "euler", "implicit"]
    noise: str | None
    order: Literal[1, 2] | None
    motion: Literal["free", "normal"]
    max_move: str | None
    keep_volume: bool
    stop: float | None
    gradient: Literal["analytic", "autodiff"] | None

    @property
    def stages(self) -> int:
        """Number of states, unless the flow stops early, and of passes of the filter."""
        from pcsmooth.flows.choice import ITERATIONS

        if self.scheme == "filter":
            from pcsmooth.filters.surface_filter import N_PASSES

            return 1 + ITERATIONS["filter"] + N_PASSES
        return 1 + (ITERATIONS[self.scheme] if self.iterations == "auto" else self.iterations)

    def provenance(self, result: DenoiseResult) -> str:
        """Write what was done for a comment, in which values have no spaces."""
        is_filter = result.scheme == "filter"
        steps = len(result.history) - 1
        words = {
            "scheme": result.scheme,
            "noise": result.plan and f"{result.plan.noise.deviation:.9g}",
            "energy": "" if is_filter else result.energy,
            "weight": "" if is_filter else result.weight,
            "order": result.order,
            "step": "" if is_filter else f"{result.step:.9g}",
            "iterations": "" if is_filter else str(steps),
            "motion": "" if self.motion == "free" else self.motion,
            "max_move": result.max_move and f"{result.max_move:.9g}",
            "keep_volume": "yes" if self.keep_volume else "",
            "stop": self.stop and f"{self.stop:.9g}",
            "gradient": self.gradient,
        }
        return "".join(f"{name}={value} " for name, value in words.items() if value)

    def summary(self, result: DenoiseResult, outliers: int | None) -> dict[str, Any]:
        """Collect what the summary says of the motion, and how many outliers there are."""
        return {
            "scheme": result.scheme,
            "energy": result.energy,
            "weight": result.weight,
            "step": result.step,
            "iterations": len(result.history) - 1,
            **plan_summary(result.plan),
            "outliers": outliers,
            "order": result.order,
            "motion": self.motion,
            "max_move": result.max_move,
            "keep_volume": self.keep_volume,
            "stop": self.stop,
            "gradient": None if result.scheme == "filter" else self.gradient or "analytic",
            "stopped_early": result.stopped_early,
            "solver_iterations": list(result.solver_iterations),
            "solver_error": result.solver_error,
        }


def plan_summary(plan: FilterPlan | None) -> dict[str, Any]:
    """Collect what was found of a cloud's noise and density."""
    if plan is None:
        return dict.fromkeys(
            ("noise", "noise_ratio", "surface", "density_variation", "filter_support")
        )
    return {
        "noise": plan.noise.deviation,
        "noise_ratio": plan.noise.deviation / plan.spacing if plan.spacing > 0.0 else 0.0,
        "surface": plan.has_surface,
        "density_variation": plan.density_variation,
        "filter_support": plan.support,
    }


def say_motion(summary: dict[str, Any], say: Say) -> None:
    """Say how the points moved."""
    is_solid = summary["scheme"] == "filter" and summary["surface"] is False
    if summary["noise"] is not None and not is_solid:
        say(
            f"  noise {summary['noise']:.4g}, {summary['noise_ratio']:.2g} of the local spacing "
            f"sqrt(area/points)"
        )
    if summary["scheme"] == "filter":
        if summary["noise"] is None:
            say("  too few points to filter: none moved")
        elif is_solid:
            say(
                f"{WARNING} {filled_in_words(summary)}: none moved; "
                "--noise or a flow moves them all the same"
            )
        elif summary["noise"] == 0.0:
            say("  no noise found, or too few points to tell: none moved")
        else:
            say(f"  filtered in neighbourhoods of {summary['filter_support']:.0f} points")
        if summary["outliers"]:
            say(f"  {summary['outliers']} outliers left where they are (column outlier)")
    else:
        say(
            f"  {summary['iterations']} {summary['scheme']} steps of {summary['step']:.6g} "
            f"on the {summary['energy']}, weight {summary['weight']}"
        )
    if summary["scheme"] == "implicit":
        total = sum(summary["solver_iterations"])
        say(f"  of order {summary['order']}, {total} solver iterations")
    restraints = [
        *(["along the normals"] if summary["motion"] == "normal" else []),
        *(["volume kept"] if summary["keep_volume"] else []),
        *([f"at most {summary['max_move']:.4g} in all"] if summary["max_move"] else []),
    ]
    if restraints:
        say(f"  motion: {', '.join(restraints)}")
    if summary["stopped_early"]:
        say(f"  stopped: the last step moved the points by less than {summary['stop']:g} spacings")


_OPTIONS = (
    click.option(
        "--scheme",
        type=click.Choice(["auto", "filter", "euler", "implicit"]),
        default="auto",
        show_default=True,
        help="filter takes the noise out by means over neighbourhoods as wide as the measured "
        "noise needs; euler is the report's flow, explicit steps down the gradient of an energy; "
        "implicit steps solve a linear system each and are stable whatever their length. auto is "
        "filter, or euler if --energy, --weight, --radius, --iterations, --step, --stop, "
        "--gradient or --polyhedron is given.",
    ),
    click.option(
        "--noise",
        type=Length("noise"),
        metavar="VALUE",
        help="Standard deviation of the noise, for filter and implicit: a length, 0.5x (times the "
        "mean spacing) or 0.1% (of the bounding box's diagonal); more smooths more. "
        "[default: measured]",
    ),
    click.option(
        "--energy",
        type=click.Choice(["volume", "area"]),
        help="What a flow decreases: volume of the union of balls or polyhedra, or area of its "
        "boundary (2D: area and perimeter). [default: volume]",
    ),
    click.option(
        "--weight",
        type=click.Choice(["none", "cell", "boundary"]),
        help="What each gradient is divided by: nothing, the point's cell, or its visible "
        "boundary. [default: cell]",
    ),
    click.option(
        "--iterations",
        type=click.IntRange(min=0),
        metavar="N",
        help="Number of steps of a flow. [default: 6 of euler, 2 implicit ones]",
    ),
    click.option(
        "--step",
        type=Step(),
        default="auto",
        show_default=True,
        help="Time step of a flow; auto suits the cloud.",
    ),
    click.option(
        "--order",
        type=click.Choice(["1", "2"]),
        help="Of implicit steps: 1 is mean curvature flow, 2 is surface diffusion, which takes "
        "noise away and leaves curvature. [default: 2, with polyhedra 1]",
    ),
    click.option(
        "--motion",
        type=click.Choice(["free", "normal"]),
        default="free",
        show_default=True,
        help="Let points go where the scheme takes them, or along their normals only: a flow "
        "then opens no holes and lets no border creep, the filter does not spread points evenly.",
    ),
    click.option(
        "--max-move",
        type=Length("max_move"),
        help="Most that a point may move in all: a length, 0.5x (times the mean spacing), or 1% "
        "(of the bounding box's diagonal).",
    ),
    click.option(
        "--keep-volume",
        is_flag=True,
        help="Take the mean normal displacement of each connected component out of each step, so "
        "that closed shapes do not shrink.",
    ),
    click.option(
        "--stop",
        type=Positive(),
        help="End when a step moves the points by less than this on average, in units of the "
        "mean spacing, such as 0.01.",
    ),
    click.option(
        "--gradient",
        type=click.Choice(["analytic", "autodiff"]),
        help="Gradients of euler steps in closed form, or, as the report does it, by automatic "
        "differentiation of the energy: the same but for rounding, slow, for 1000 points at most. "
        "[default: analytic]",
    ),
)


def moving_options(command: Command) -> Command:
    """Give a command the options of `Moving`, and one of these as the keyword `moving`."""

    @wraps(command)
    def collected(
        *,
        energy: Literal["volume", "area"] | None,
        weight: Literal["none", "cell", "boundary"] | None,
        iterations: int | None,
        step: float | Literal["auto"],
        scheme: Literal["auto", "filter", "euler", "implicit"],
        noise: str | None,
        order: str | None,
        motion: Literal["free", "normal"],
        max_move: str | None,
        keep_volume: bool,
        stop: float | None,
        gradient: Literal["analytic", "autodiff"] | None,
        **others: Any,
    ) -> None:
        from pcsmooth.denoise_options import options_of_flows
        from pcsmooth.flows.choice import resolve_scheme
        from pcsmooth.lengths import is_auto

        steps: int | Literal["auto"] = "auto" if iterations is None else iterations
        of_flows = options_of_flows(
            energy=energy, weight=weight, iterations=steps, step=step, stop=stop,
            gradient=gradient, is_polyhedral=others["polyhedron"] is not None,
        )  # fmt: skip
        is_flow = bool(of_flows) or not is_auto(others["radius"])
        chosen = resolve_scheme(scheme, is_flow=is_flow)
        if order is not None and chosen != "implicit":
            raise click.UsageError("--order needs --scheme implicit")
        if order == "2" and others["polyhedron"] is not None:
            raise click.UsageError("--order 2 needs balls, not --polyhedron")
        if chosen == "filter" and of_flows:
            raise click.UsageError(f"--{of_flows[0]} needs a flow, not --scheme filter")
        if gradient == "autodiff" and chosen == "implicit":
            raise click.UsageError("--gradient autodiff needs --scheme euler")
        if noise is not None and chosen == "euler":
            raise click.UsageError("--noise needs --scheme filter or implicit")
        moving = Moving(
            energy, weight, steps, step, chosen, noise, _ORDERS[order], motion, max_move,
            keep_volume, stop, gradient,
        )  # fmt: skip
        command(moving=moving, **others)

    for option in reversed(_OPTIONS):
        collected = option(collected)
    return collected
