"""Which objects the keywords of `denoise` stand for, and what does not go together."""

from __future__ import annotations

import dataclasses
import pickle
from typing import Any

import numpy as np
import pytest

import oracles
import pcsmooth
from pcsmooth import Balls, Estimate, EulerFlow, Filter, ImplicitFlow, Motion, Polyhedra
from pcsmooth.errors import InvalidInputError
from pcsmooth.methods.keywords import UnfitOptionError, method_of, resolve_keywords
from pcsmooth.methods.method import Method

CUBE = pcsmooth.load_presets()["cube"]
SPHERE = oracles.sphere_surface(200).noisy(0.3)

#: Keywords, and the method that they stand for.
METHODS: dict[str, tuple[dict[str, Any], Method]] = {
    "nothing": ({}, Filter()),
    "what is left open": (
        {"scheme": "auto", "iterations": "auto", "step": "auto", "radius": " AUTO", "noise": None},
        Filter(),
    ),
    "filter": (
        {"scheme": "filter", "radius": "3x", "noise": 0.1}, Filter(radius="3x", noise=0.1)
    ),
    "union without bodies": ({"union": "naive"}, Filter()),
    "radius": ({"radius": "3x"}, EulerFlow(shapes=Balls(radius="3x"))),
    "energy": (
        {"energy": "area", "weight": "none"},
        EulerFlow(shapes=Balls(quantity="area", weight="none")),
    ),
    "steps": (
        {"iterations": 3.0, "step": 0.1, "stop": 0.01}, EulerFlow(iterations=3, step=0.1, stop=0.01)
    ),
    "autodiff": ({"gradient": "autodiff"}, EulerFlow(shapes=Balls(gradient="autodiff"))),
    "bodies": (
        {"polyhedron": CUBE, "union": "naive"},
        EulerFlow(shapes=Polyhedra(body=CUBE, union="naive")),
    ),
    "implicit": ({"scheme": "implicit"}, ImplicitFlow(order=2)),
    "implicit of order 1": (
        {"scheme": "implicit", "order": 1, "noise": "1x", "iterations": 0},
        ImplicitFlow(order=1, noise="1x", iterations=0),
    ),
    "implicit, bodies": (
        {"scheme": "implicit", "polyhedron": CUBE},
        ImplicitFlow(shapes=Polyhedra(body=CUBE), order=1),
    ),
}  # fmt: skip


@pytest.mark.parametrize(("keywords", "method"), METHODS.values(), ids=METHODS)
def test_keywords_stand_for_a_method(keywords: Any, method: Method) -> None:
    found = method_of(keywords)
    assert found == method
    assert type(found) is type(method)


@pytest.mark.parametrize("name", ["nothing", "energy", "bodies", "implicit"])
def test_objects_do_what_their_keywords_do(name: str) -> None:
    keywords, method = METHODS[name]
    motion, estimate = Motion("normal", "0.5x", keep_volume=True), Estimate(30, "outward")
    result = pcsmooth.denoise(SPHERE, method, motion=motion, estimate=estimate)
    told = pcsmooth.denoise(
        SPHERE, motion="normal", max_move="0.5x", keep_volume=True, support=30, orient="outward",
        **keywords,
    )  # fmt: skip
    assert (result.method, result.motion) == (told.method, told.motion)
    assert (result.method, dataclasses.replace(result.motion, max_move="0.5x")) == (method, motion)
    assert result.motion.max_move == pytest.approx(0.5 * result.spacing, rel=1e-15)
    np.testing.assert_array_equal(result.points, told.points)
    np.testing.assert_array_equal(result.normals, told.normals)


@pytest.mark.parametrize(
    ("scheme", "option", "value", "others"),
    [
        ("filter", "energy", "area", ("euler", "implicit")),
        ("filter", "polyhedron", CUBE, ("euler", "implicit")),
        ("filter", "order", 1, ("implicit",)),
        ("euler", "order", 2, ("implicit",)),
        ("euler", "noise", 0.1, ("filter", "implicit")),
    ],
)
def test_options_that_a_method_does_not_have(
    scheme: Any, option: Any, value: Any, others: tuple[str, ...]
) -> None:
    keywords: Any = {"scheme": scheme, option: value}
    message = f"{option} is given and the scheme is {scheme}, which has no such option; .* or "
    with pytest.raises(UnfitOptionError, match=message) as raised:
        method_of(keywords)
    error = raised.value
    assert (error.option, error.method, error.others) == (option, scheme, others)


@pytest.mark.parametrize(
    ("whole", "part"),
    [
        ({"method": Filter()}, {"noise": 0.1}),
        ({"method": EulerFlow()}, {"scheme": "euler"}),
        ({"motion": Motion()}, {"max_move": 0.1}),
        ({"estimate": Estimate()}, {"support": 12}),
    ],
)
def test_nothing_is_said_twice(whole: dict[str, Any], part: dict[str, Any]) -> None:
    [name], [option] = whole, part
    message = f"{option} is given beside {name}, which says it, too; leave one of them out"
    with pytest.raises(InvalidInputError, match=message):
        pcsmooth.denoise(SPHERE, **whole, **part)


def test_unknown_keywords() -> None:
    wrong: Any = {"radii": 1.0}
    with pytest.raises(TypeError, match="unexpected keyword argument 'radii'"):
        pcsmooth.denoise(SPHERE, **wrong)
    with pytest.raises(TypeError, match="unexpected keyword argument 'radii'"):
        resolve_keywords(None, "free", None, wrong)


@pytest.mark.parametrize(
    ("make", "values", "message"),
    [
        (Filter, {"noise": -1.0}, "noise '-1.0' is not a positive length"),
        (Filter, {"radius": "far"}, "radius 'far' is not a positive length"),
        (EulerFlow, {"iterations": -1}, "iterations is -1; it must be 0 or more and whole"),
        (EulerFlow, {"iterations": True}, "iterations is True"),
        (EulerFlow, {"step": 0.0}, "step is 0.0; it must be positive and finite, or auto"),
        (ImplicitFlow, {"stop": -1.0}, "stop is -1.0; it must be positive and finite, or None"),
        (ImplicitFlow, {"order": 3}, "order is 3; it must be 1 or 2"),
        (ImplicitFlow, {"noise": "0x"}, "noise '0x' is not a positive length"),
        (
            ImplicitFlow,
            {"shapes": Polyhedra(body=CUBE), "order": 2},
            "the order is 2, which is for balls, not polyhedra",
        ),
        (
            ImplicitFlow,
            {"shapes": Balls(gradient="autodiff")},
            "gradient is 'autodiff' and the scheme is implicit",
        ),
        (Balls, {"quantity": "mass"}, "energy is 'mass'; it must be volume or area"),
        (Balls, {"weight": "heavy"}, "weight is 'heavy'; it must be none, cell or boundary"),
        (Balls, {"gradient": "guess"}, "gradient is 'guess'; it must be analytic or autodiff"),
        (Polyhedra, {"body": CUBE, "union": "rough"}, "union is 'rough'; it must be naive, incl"),
        (Motion, {"direction": "wild"}, "motion is 'wild'; it must be free, normal or ray"),
        (Motion, {"max_move": 0.0}, "max_move '0.0' is not a positive length"),
        (Estimate, {"support": 1}, "support is 1"),
        (Estimate, {"orient": "inward"}, "orientation is 'inward'"),
    ],
)
def test_values_are_checked_where_they_are_given(
    make: type, values: dict[str, Any], message: str
) -> None:
    with pytest.raises(InvalidInputError, match=message):
        make(**values)


@pytest.mark.parametrize("method", [method for _, method in METHODS.values()], ids=METHODS)
def test_methods_are_values(method: Any) -> None:
    """They cannot be changed, are equal if they say the same, and go to other processes."""
    with pytest.raises(dataclasses.FrozenInstanceError):
        method.noise = 1.0
    assert dataclasses.replace(method) == method
    sent = pickle.loads(pickle.dumps(method))
    if not isinstance(method.shapes, Polyhedra):  # bodies are the same or not
        assert sent == method
    assert sent.name == method.name
