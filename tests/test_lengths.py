from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.errors import InvalidInputError
from pcsmooth.lengths import (
    check_length,
    check_radius,
    local_multiple,
    resolve_length,
    resolve_radius,
    step_in_unit,
)

#: Extent 3 by 4, diagonal 5.
BOX = np.array([[1.0, 2.0], [4.0, 6.0], [2.0, 3.0]])
SPACING = 0.25


@pytest.mark.parametrize(
    ("spec", "length"),
    [
        (0.5, 0.5),
        (3, 3.0),
        (np.float64(0.5), 0.5),
        ("0.5", 0.5),
        (" 1e-3 ", 1e-3),
        ("+2", 2.0),
        ("3x", 0.75),
        ("3 X", 0.75),
        ("1e1x", 2.5),
        ("2%", 0.1),
        (" 20 % ", 1.0),
        ("auto", 0.5),
        (" AUTO", 0.5),
        ("local", 0.5),
        ("Local:3x", 0.75),
        (" local : 1.5 x ", 0.375),
    ],
)
def test_forms(spec: float | str, length: float) -> None:
    check_radius(spec)
    assert resolve_radius(spec, BOX, SPACING) == pytest.approx(length, rel=1e-15)


@pytest.mark.parametrize(
    "spec",
    ["", "x", "%", "three", "3y", "x3", "3xx", "3%x", "0", "-1", "0x", "-2%", "nan", "inf", "1e999",
     "nanx", "local:", "local:3", "local:x", "local:0x", "local:-1x", "local:nanx", "local:3%",
     "local3x", "locale", 0.0, -2.0, float("nan"), float("inf")],
)  # fmt: skip
def test_what_is_no_radius(spec: float | str) -> None:
    for act in (check_radius, lambda text: resolve_radius(text, BOX, SPACING)):
        with pytest.raises(InvalidInputError, match="is not a positive length; give a length"):
            act(spec)


@pytest.mark.parametrize(
    ("spec", "multiple"), [("local", 2.0), ("local:3x", 3.0), ("3x", None), (2, None), ("no", None)]
)
def test_multiples_of_the_local_spacing(spec: float | str, multiple: float | None) -> None:
    assert local_multiple(spec) == multiple


@pytest.mark.parametrize("spec", ["auto", "3x", "2%", "local", "local:3x"])
def test_relative_radius_needs_points_that_differ(spec: str) -> None:
    reason = "has no spacing" if spec[0] in "al" else f"makes the radius '{spec}' 0"
    for count, place in ((1, "there is only one point"), (3, "all points are at one place")):
        message = f"^{place}, which {reason}; give the radius as a length$"
        with pytest.raises(InvalidInputError, match=message):
            resolve_radius(spec, np.ones((count, 2)), 0.0)


def test_points_that_are_too_near_to_tell_apart() -> None:
    message = r"^radius '3x' is 0 for this cloud; give a length from 1e-103 to 1e\+100$"
    with pytest.raises(InvalidInputError, match=message):
        resolve_radius("3x", np.array([[0.0, 0.0], [1e-300, 0.0]]), 0.0)


def test_absolute_radius_needs_no_extent() -> None:
    assert resolve_radius("0.5", np.ones((1, 3)), 0.0) == 0.5


def test_radius_beyond_all_numbers() -> None:
    with pytest.raises(InvalidInputError, match="is inf for this cloud"):
        resolve_radius("1e308x", BOX, 100.0)


@pytest.mark.parametrize(("spec", "length"), [(0.5, 0.5), ("3x", 0.75), ("2%", 0.1)])
def test_other_lengths(spec: float | str, length: float) -> None:
    check_length(spec, "reach")
    assert resolve_length(spec, BOX, SPACING, "reach") == pytest.approx(length, rel=1e-15)


@pytest.mark.parametrize("spec", ["auto", "AUTO", "-1", "wide", 0.0])
def test_what_is_no_length(spec: float | str) -> None:
    message = r"^reach '.*' is not a positive length; give .* or a share of the extent \(2%\)$"
    with pytest.raises(InvalidInputError, match=message):
        check_length(spec, "reach")
    with pytest.raises(InvalidInputError, match=message):
        resolve_length(spec, BOX, SPACING, "reach")


def test_relative_length_needs_points_that_differ() -> None:
    message = "^all points are at one place, which makes the reach '3x' 0; give the reach as"
    with pytest.raises(InvalidInputError, match=message):
        resolve_length("3x", np.ones((3, 2)), 0.0, "reach")


def test_lengths_in_another_unit() -> None:
    """Numbers are multiples of the file's unit, the others go with points and spacing."""
    unit = 2.0**200
    lengths = [resolve_radius(spec, BOX, SPACING, unit) for spec in (3 * unit, "3x", "2%")]
    assert lengths == pytest.approx([3.0, 0.75, 0.1], rel=1e-15)


@pytest.mark.parametrize("spec", [1e-300, "1e300", "5e-324", "1e100x"])
def test_lengths_that_cannot_be_measured(spec: float | str) -> None:
    for unit in (1.0, 2.0**150):
        with pytest.raises(InvalidInputError, match="for this cloud; give a length from 1e-103 to"):
            resolve_length(spec, BOX, 4.0, "reach", unit)


def test_steps() -> None:
    assert step_in_unit("auto", 4.0) is None
    assert step_in_unit(3.0, 4.0) == 0.75
    message = r"^step is 1e\+102, and steps on this cloud go from 4e-103 to 4e\+100; choose one of"
    with pytest.raises(InvalidInputError, match=message):
        step_in_unit(1e102, 4.0)
    with pytest.raises(InvalidInputError, match="choose one of these"):
        step_in_unit(1e-103, 4.0)
