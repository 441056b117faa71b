"""Options of the method and of how points move, and what is said of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.options import Length, Place, Positive, Step
from pcsmooth.files.notes import WARNING, Say

if TYPE_CHECKING:
    from pcsmooth.files.report import DenoiseReport
    from pcsmooth.methods.keywords import MethodKeywords
    from pcsmooth.methods.method import Method

Command = Callable[..., Any]


def say_motion(report: DenoiseReport, say: Say) -> None:
    """Say how the points moved."""
    from pcsmooth.files.report import filled_in_words

    is_solid = report.scheme == "filter" and report.plan.surface is False
    if (noise := report.noise_in_words()) and not is_solid:
        say(f"  noise {noise}")
    if report.scheme == "filter":
        if report.plan.noise is None:
            say("  too few points to filter: none moved")
        elif is_solid:
            say(
                f"{WARNING} {filled_in_words(report.points.dimension)}: none moved; "
                "--noise or a flow moves them all the same"
            )
        elif report.plan.noise == 0.0:
            say("  no noise found, or too few points to tell: none moved")
        else:
            say(f"  filtered in neighbourhoods of {report.plan.filter_support:.0f} points")
        if report.sides is not None:
            say(
                "  both sides of thin parts told apart"
                if report.sides
                else "  sides of thin parts not told apart: noise is not 1/230 to 1/30 of the size"
            )
        if report.outliers or report.outliers_as != "mark":
            say(f"  {report.outliers_in_words()}")
        if words := report.at_limit_in_words():
            say(f"  {words} (edges, leaves?)")
    else:
        say(
            f"  {report.iterations} {report.scheme} steps of {report.step:.6g} "
            f"on the {report.energy}, weight {report.weight}"
        )
    if report.scheme == "implicit":
        total = sum(report.solver_iterations)
        say(f"  of order {report.order}, {total} solver iterations")
    if restraints := report.restraints_in_words():
        say(f"  motion: {', '.join(restraints)}")
    if why := report.early_end_in_words():
        say(f"  stopped: {why}")


_OPTIONS = (
    click.option(
        "--scheme",
        type=click.Choice(["auto", "filter", "euler", "implicit"]),
        default="auto",
        show_default=True,
        help="filter takes the noise out by means over neighbourhoods as wide as the measured "
        "noise needs; euler takes explicit steps down the gradient of an energy; "
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
        "--closed",
        is_flag=True,
        help="The points lie on closed surfaces: the filter then tells both sides of thin parts "
        "apart, down to three times the noise, if the noise is 1/230 to 1/30 of the cloud's "
        "size. Open sheets can get worse.",
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
        callback=lambda _context, _option, value: value and int(value),
        help="Of implicit steps: 1 is mean curvature flow, 2 is surface diffusion, which takes "
        "noise away and leaves curvature. [default: 2, with polyhedra 1]",
    ),
    click.option(
        "--motion",
        type=click.Choice(["free", "normal", "ray"]),
        default="free",
        show_default=True,
        help="Let points go where the scheme takes them, or along their normals only: a flow "
        "then opens no holes and lets no border creep, the filter does not spread points evenly; "
        "or along the beams that come from --origin, so that only ranges are corrected.",
    ),
    click.option(
        "--origin",
        type=Place(),
        metavar="X,Y[,Z]",
        help="Where the scanner stood, for --motion ray.",
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
        "--strength",
        type=click.FloatRange(0.0, 1.0),
        default=1.0,
        show_default=True,
        help="Share of its way, from 0 to 1, that each point goes in the end.",
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
        help="Gradients of euler steps in closed form, or, as the thesis does it, by automatic "
        "differentiation of the energy: the same but for rounding, slow, for 1000 points at most. "
        "[default: analytic]",
    ),
)


def method_options(command: Command) -> Command:
    """Give a command the options of a method and a motion, and these as keywords.

    The radius and the body are options of the command, too. It gets `method` and `motion`, and
    of the other options `polyhedron` and `presets_path`, which messages name.
    """

    @wraps(command)
    def collected(
        *,
        radius: str,
        union: str | None,
        allow_outside: bool,
        max_move: str | None,
        motion: Any,
        keep_volume: bool,
        strength: float,
        origin: tuple[float, ...] | None,
        **others: Any,
    ) -> Any:
        from pcsmooth.bodies.presets import find_preset
        from pcsmooth.methods.motion import Motion

        name, path = others["polyhedron"], others["presets_path"]
        if name is None and (union or path):
            raise click.UsageError("--union and --presets need --polyhedron")
        body = None
        if name is not None:
            body = find_preset(name, path, allow_outside=allow_outside).body
        if (motion == "ray") != (origin is not None):
            raise click.UsageError("--motion ray and --origin need each other")
        given: Any = {option: others.pop(option) for option in _OF_METHODS}
        given |= {"radius": radius, "polyhedron": body, "union": union}
        return command(
            method=_method_of(given),
            motion=Motion(motion, max_move, keep_volume, strength, origin),
            **others,
        )

    for option in reversed(_OPTIONS):
        collected = option(collected)
    return collected


#: Options that go into the method as they are.
_OF_METHODS = (
    "scheme", "noise", "closed", "energy", "weight", "iterations", "step", "order", "stop",
    "gradient",
)  # fmt: skip


def _method_of(given: MethodKeywords) -> Method:
    """Make the method, or say in words of the command line what does not go together."""
    from pcsmooth.errors import InvalidInputError
    from pcsmooth.methods.keywords import UnfitOptionError, method_of

    try:
        return method_of(given)
    except UnfitOptionError as error:
        needed = f"--scheme {' or '.join(error.others)}"
        raise click.UsageError(
            f"--{error.option} needs {needed}, not --scheme {error.method}"
        ) from error
    except InvalidInputError as error:
        raise click.UsageError(str(error)) from error
