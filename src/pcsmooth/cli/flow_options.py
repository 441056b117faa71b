"""Options of how points move, and what is said of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any, Literal

import click

from pcsmooth.cli.options import MaxMove, Positive, Step

if TYPE_CHECKING:
    from pcsmooth.cli.messages import Say
    from pcsmooth.denoising import DenoiseResult

Command = Callable[..., None]

_ORDERS: dict[str | None, Literal[1, 2] | None] = {None: None, "1": 1, "2": 2}


@dataclass(frozen=True)
class Moving:
    """How points are to move.

    Attributes
    ----------
    iterations, step, scheme, order, motion, max_move, keep_volume, stop
        Arguments of `pcsmooth.denoise`, under their names there.
    """

    iterations: int | Literal["auto"]
    step: float | Literal["auto"]
    scheme: Literal["euler", "implicit"]
    order: Literal[1, 2] | None
    motion: Literal["free", "normal"]
    max_move: str | None
    keep_volume: bool
    stop: float | None

    def provenance(self, result: DenoiseResult) -> str:
        """Write what is not as usual for a comment, in which values have no spaces."""
        words = {
            "scheme": "" if self.scheme == "euler" else self.scheme,
            "order": result.order,
            "motion": "" if self.motion == "free" else self.motion,
            "max_move": result.max_move and f"{result.max_move:.9g}",
            "keep_volume": "yes" if self.keep_volume else "",
            "stop": self.stop and f"{self.stop:.9g}",
        }
        return "".join(f"{name}={value} " for name, value in words.items() if value)

    def summary(self, result: DenoiseResult) -> dict[str, Any]:
        """Collect what the summary says of the motion."""
        return {
            "scheme": self.scheme,
            "order": result.order,
            "motion": self.motion,
            "max_move": result.max_move,
            "keep_volume": self.keep_volume,
            "stop": self.stop,
            "stopped_early": result.stopped_early,
            "solver_iterations": list(result.solver_iterations),
            "solver_error": result.solver_error,
        }


def say_motion(summary: dict[str, Any], say: Say) -> None:
    """Say what of the motion is not as usual."""
    if summary["scheme"] == "implicit":
        from pcsmooth.flows.conjugate_gradients import TOLERANCE

        total = sum(summary["solver_iterations"])
        say(f"  implicit steps of order {summary['order']}, {total} solver iterations")
        if summary["solver_error"] > TOLERANCE:
            say(
                "warning: the solver has left an error of up to "
                f"{summary['solver_error']:.2g} of a step; a shorter --step needs fewer iterations"
            )
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
        "--iterations",
        type=click.IntRange(min=0),
        metavar="N",
        help="Number of steps. [default: 6 of euler, 2 implicit ones]",
    ),
    click.option(
        "--step",
        type=Step(),
        default="auto",
        show_default=True,
        help="Time step; auto suits the cloud.",
    ),
    click.option(
        "--scheme",
        type=click.Choice(["euler", "implicit"]),
        default="euler",
        show_default=True,
        help="Explicit Euler steps, or semi-implicit ones: a linear system each, stable "
        "whatever their length.",
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
        help="Let points go where the flow takes them, or along their normals only: no holes "
        "open and borders do not creep.",
    ),
    click.option(
        "--max-move",
        type=MaxMove(),
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
)


def moving_options(command: Command) -> Command:
    """Give a command the options of `Moving`, and one of these as the keyword `moving`."""

    @wraps(command)
    def collected(
        *,
        iterations: int | None,
        step: float | Literal["auto"],
        scheme: Literal["euler", "implicit"],
        order: str | None,
        motion: Literal["free", "normal"],
        max_move: str | None,
        keep_volume: bool,
        stop: float | None,
        **others: Any,
    ) -> None:
        if order is not None and scheme == "euler":
            raise click.UsageError("--order needs --scheme implicit")
        if order == "2" and others["polyhedron"] is not None:
            raise click.UsageError("--order 2 needs balls, not --polyhedron")
        steps: int | Literal["auto"] = "auto" if iterations is None else iterations
        moving = Moving(steps, step, scheme, _ORDERS[order], motion, max_move, keep_volume, stop)
        command(moving=moving, **others)

    for option in reversed(_OPTIONS):
        collected = option(collected)
    return collected
