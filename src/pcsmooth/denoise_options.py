"""What the options of `denoise` may be, alone and together."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real
from typing import Any, Literal, get_args

from pcsmooth.energies.choice import GradientName
from pcsmooth.energies.protocol import Quantity, Weight
from pcsmooth.errors import InvalidInputError
from pcsmooth.flows.choice import (
    ITERATIONS,
    ChosenScheme,
    SchemeName,
    resolve_order,
    resolve_scheme,
)
from pcsmooth.flows.implicit import Order
from pcsmooth.lengths import check_length, check_radius, is_auto

MotionName = Literal["free", "normal"]


@dataclass(frozen=True)
class SchemeOptions:
    """What the options of `denoise` say about its steps, with what was left open filled in.

    Attributes
    ----------
    scheme : {"filter", "euler", "implicit"}
        How to step.
    steps : int
        How often.
    order : {1, 2} or None
        Of implicit steps.
    energy, weight : str
        Of the energy.
    """

    scheme: ChosenScheme
    steps: int
    order: Order | None
    energy: Quantity
    weight: Weight


def resolve_options(
    *,
    energy: Quantity | None,
    weight: Weight | None,
    radius: float | str,
    iterations: int | Literal["auto"],
    step: float | Literal["auto"],
    scheme: SchemeName,
    order: Order | None,
    motion: MotionName,
    max_move: float | str | None,
    stop: float | None,
    noise: float | str | None,
    gradient: GradientName | None,
    is_polyhedral: bool,
) -> SchemeOptions:
    """Check the options of `denoise` and fill in what depends on nothing but them.

    Raises
    ------
    InvalidInputError
        An option is out of range, or not one of the scheme.
    """
    check_options(
        energy=energy, weight=weight, radius=radius, iterations=iterations, step=step,
        scheme=scheme, order=order, motion=motion, max_move=max_move, stop=stop, noise=noise,
        gradient=gradient,
    )  # fmt: skip
    of_flows = options_of_flows(
        energy=energy, weight=weight, iterations=iterations, step=step, stop=stop,
        gradient=gradient, is_polyhedral=is_polyhedral,
    )  # fmt: skip
    chosen = resolve_scheme(scheme, is_flow=bool(of_flows) or not is_auto(radius))
    check_scheme(chosen, of_flows, noise, gradient)
    return SchemeOptions(
        chosen,
        ITERATIONS[chosen] if iterations == "auto" else int(iterations),
        resolve_order(chosen, order, is_polyhedral=is_polyhedral),
        energy or "volume",
        weight or "cell",
    )


def check_options(
    *,
    energy: str | None,
    weight: str | None,
    radius: float | str,
    iterations: Any,
    step: object,
    scheme: str,
    order: object,
    motion: str,
    max_move: float | str | None,
    stop: object,
    noise: float | str | None,
    gradient: str | None,
) -> None:
    """Raise `InvalidInputError` for an option of `denoise` that is out of range or out of place."""
    if energy is not None:
        _check_word("energy", energy, get_args(Quantity))
    if weight is not None:
        _check_word("weight", weight, get_args(Weight))
    if gradient is not None:
        _check_word("gradient", gradient, get_args(GradientName))
    check_radius(radius)
    if iterations != "auto" and not _is_count(iterations):
        raise InvalidInputError(
            f"iterations is {iterations!r}; it must be 0 or more and whole, or auto"
        )
    if step != "auto" and not _is_positive(step):
        raise InvalidInputError(f"step is {step!r}; it must be positive and finite, or auto")
    _check_word("scheme", scheme, get_args(SchemeName))
    _check_word("motion", motion, get_args(MotionName))
    if max_move is not None:
        check_length(max_move, "max_move")
    if stop is not None and not _is_positive(stop):
        raise InvalidInputError(f"stop is {stop!r}; it must be positive and finite, or None")
    if order not in (None, 1, 2):
        raise InvalidInputError(f"order is {order!r}; it must be 1 or 2")
    if order is not None and scheme != "implicit":
        raise InvalidInputError(f"order is {order!r}; only the scheme implicit has an order")
    if noise is not None:
        check_length(noise, "noise")


def options_of_flows(
    *,
    energy: str | None,
    weight: str | None,
    iterations: object,
    step: object,
    stop: object,
    gradient: str | None,
    is_polyhedral: bool,
) -> list[str]:
    """Name the options that were given and that only flows have."""
    given = {
        "energy": energy is not None,
        "weight": weight is not None,
        "iterations": iterations != "auto",
        "step": step != "auto",
        "stop": stop is not None,
        "gradient": gradient is not None,
        "polyhedron": is_polyhedral,
    }
    return [name for name, is_given in given.items() if is_given]


def check_scheme(
    scheme: str, of_flows: list[str], noise: float | str | None, gradient: str | None
) -> None:
    """Raise `InvalidInputError` for options that the scheme does not have."""
    if scheme == "filter" and of_flows:
        raise InvalidInputError(
            f"{of_flows[0]} is given and the scheme is filter, which has no such option; "
            "leave it out or choose the scheme euler or implicit"
        )
    if scheme == "implicit" and gradient == "autodiff":
        raise InvalidInputError(
            "gradient is 'autodiff' and the scheme is implicit, which needs more than gradients; "
            "choose the scheme euler"
        )
    if scheme == "euler" and noise is not None:
        raise InvalidInputError(
            "noise is given and the scheme is euler, which does not ask for it; "
            "leave it out or choose the scheme filter or implicit"
        )


def _check_word(name: str, value: str, words: tuple[str, ...]) -> None:
    if value not in words:
        *others, last = words
        raise InvalidInputError(f"{name} is {value!r}; it must be {', '.join(others)} or {last}")


def _is_count(value: Any) -> bool:
    """Whether a value is a whole number, 0 or more, as an int or a float."""
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    return bool(is_number and 0 <= value < math.inf and value == int(value))


def _is_positive(value: object) -> bool:
    return isinstance(value, Real) and 0.0 < float(value) < math.inf
