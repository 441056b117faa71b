"""The keywords of `denoise`, and the method, motion and estimate that they stand for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypedDict, get_args

from pcsmooth.curvature.support import Support
from pcsmooth.energies.protocol import GradientName, Quantity, UnionName, Weight
from pcsmooth.errors import InvalidInputError
from pcsmooth.flows.implicit import Order
from pcsmooth.lengths import is_auto
from pcsmooth.methods.checks import check_word
from pcsmooth.methods.estimate import Estimate
from pcsmooth.methods.filter import Filter
from pcsmooth.methods.flows import EulerFlow, ImplicitFlow
from pcsmooth.methods.method import Method, MethodName
from pcsmooth.methods.motion import Direction, Motion
from pcsmooth.methods.shapes import Balls, Polyhedra

if TYPE_CHECKING:
    from pcsmooth.bodies.convex_body import ConvexBody

SchemeName = Literal["auto", "filter", "euler", "implicit"]


class MethodKeywords(TypedDict, total=False):
    """Keywords that stand for a method; what is left out, None or "auto" has its default.

    Attributes
    ----------
    scheme : {"auto", "filter", "euler", "implicit"}
        `Filter`, `EulerFlow` or `ImplicitFlow`. ``"auto"`` is the filter, or euler if an option
        of flows is given: energy, weight, radius, iterations, step, stop, gradient or polyhedron.
    noise
        Of the filter and of implicit flows.
    closed
        Of the filter.
    order
        Of implicit flows.
    iterations, step, stop
        Of flows.
    radius
        Of the shapes.
    energy, weight, gradient
        Of the shapes of flows: their quantity, weight and gradient.
    polyhedron, union
        The body of `Polyhedra`, which take the place of balls, and how their union is computed.
    """

    scheme: SchemeName
    noise: float | str | None
    closed: bool
    order: Order | None
    iterations: int | Literal["auto"] | None
    step: float | Literal["auto"]
    stop: float | None
    radius: float | str
    energy: Quantity | None
    weight: Weight | None
    gradient: GradientName | None
    polyhedron: ConvexBody | None
    union: UnionName | None


class Keywords(MethodKeywords, total=False):
    """All keywords of `denoise` that stand for parts of what is asked for.

    Attributes
    ----------
    max_move, keep_volume, strength, origin
        Of the motion.
    support, orient
        Of the estimate.
    """

    max_move: float | str | None
    keep_volume: bool
    strength: float
    origin: tuple[float, ...] | None
    support: Support
    orient: str


#: Options of flows alone, in the order in which messages name them.
_OF_FLOWS = ("energy", "weight", "iterations", "step", "stop", "gradient", "polyhedron")

#: Options for which "auto" is the default.
_MAY_BE_AUTO = ("iterations", "step", "radius")

#: Which methods have an option, if not all have it.
_OF_METHODS: dict[str, tuple[MethodName, ...]] = {
    **dict.fromkeys(_OF_FLOWS, ("euler", "implicit")),
    "order": ("implicit",),
    "noise": ("filter", "implicit"),
    "closed": ("filter",),
}

#: Keywords that say something of the shapes, and their names there.
_OF_SHAPES = {
    "radius": "radius",
    "energy": "quantity",
    "weight": "weight",
    "gradient": "gradient",
    "polyhedron": "body",
    "union": "union",
}


class UnfitOptionError(InvalidInputError):
    """An option is given that the method does not have.

    Attributes
    ----------
    option : str
        Its keyword.
    method : str
        What the method is called.
    others : tuple of str
        Methods that have it.
    """

    def __init__(self, option: str, method: MethodName, others: tuple[MethodName, ...]) -> None:
        super().__init__(
            f"{option} is given and the scheme is {method}, which has no such option; "
            f"leave it out or choose the scheme {' or '.join(others)}"
        )
        self.option = option
        self.method = method
        self.others = others


def method_of(keywords: MethodKeywords) -> Method:
    """Make the method that keywords stand for.

    Raises
    ------
    UnfitOptionError
        The method has no such option.
    InvalidInputError
        A value is out of range.
    """
    given: dict[str, Any] = {
        name: value
        for name, value in keywords.items()
        if value is not None
        and value is not False
        and not (name in _MAY_BE_AUTO and is_auto(str(value)))
    }
    scheme = given.pop("scheme", "auto")
    check_word("scheme", scheme, get_args(SchemeName))
    is_flow = any(name in given for name in (*_OF_FLOWS, "radius"))
    chosen: MethodName = scheme if scheme != "auto" else "euler" if is_flow else "filter"
    for name, methods in _OF_METHODS.items():
        if name in given and chosen not in methods:
            raise UnfitOptionError(name, chosen, methods)
    if "polyhedron" not in given:
        given.pop("union", None)
    if chosen == "filter":
        return Filter(**given)
    of_shapes = {field: given.pop(name) for name, field in _OF_SHAPES.items() if name in given}
    shapes = Polyhedra(**of_shapes) if "body" in of_shapes else Balls(**of_shapes)
    return (EulerFlow if chosen == "euler" else ImplicitFlow)(shapes=shapes, **given)


def resolve_keywords(
    method: Method | None, motion: Motion | Direction, estimate: Estimate | None, given: Keywords
) -> tuple[Method, Motion, Estimate]:
    """Tell what is asked for: in objects, or in keywords that stand for them.

    Raises
    ------
    InvalidInputError
        A value is out of range, the method has no such option, or something is said twice.
    TypeError
        There is no such keyword.
    """
    unknown = given.keys() - Keywords.__annotations__.keys()
    if unknown:
        raise TypeError(f"got an unexpected keyword argument {min(unknown)!r}")

    def taken(*names: str) -> dict[str, Any]:
        return {name: value for name, value in given.items() if name in names}

    of_motion = taken("max_move", "keep_volume", "strength", "origin")
    of_estimate = taken("support", "orient")
    of_method = taken(*MethodKeywords.__annotations__)
    for name, whole, part in (
        ("method", method, of_method),
        ("motion", motion if isinstance(motion, Motion) else None, of_motion),
        ("estimate", estimate, of_estimate),
    ):
        if whole is not None and part:
            raise InvalidInputError(
                f"{min(part)} is given beside {name}, which says it, too; leave one of them out"
            )
    keywords: Any = of_method
    return (
        method or method_of(keywords),
        motion if isinstance(motion, Motion) else Motion(motion, **of_motion),
        estimate or Estimate(**of_estimate),
    )
