"""Checks of option values."""

from __future__ import annotations

import math
from numbers import Real
from typing import Any

from pcsmooth.errors import InvalidInputError


def check_word(name: str, value: object, words: tuple[str, ...]) -> None:
    """Raise `InvalidInputError` unless the value is one of the words."""
    if value not in words:
        *others, last = words
        raise InvalidInputError(f"{name} is {value!r}; it must be {', '.join(others)} or {last}")


def check_count(name: str, value: Any) -> None:
    """Raise `InvalidInputError` unless the value is whole, as an int or a float, and 0 or more."""
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    if not (is_number and 0 <= value < math.inf and value == int(value)):
        raise InvalidInputError(f"{name} is {value!r}; it must be 0 or more and whole, or auto")


def check_positive(name: str, value: object, besides: str) -> None:
    """Raise `InvalidInputError` unless the value is a finite number > 0."""
    if not (isinstance(value, Real) and 0.0 < float(value) < math.inf):
        raise InvalidInputError(
            f"{name} is {value!r}; it must be positive and finite, or {besides}"
        )


def check_share(name: str, value: Any) -> None:
    """Raise `InvalidInputError` unless the value is a number from 0 to 1."""
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    if not (is_number and 0.0 <= value <= 1.0):
        raise InvalidInputError(f"{name} is {value!r}; it must be a number from 0 to 1")


def check_numbers(name: str, value: Any) -> None:
    """Raise `InvalidInputError` unless the value is two or three finite numbers in a tuple."""
    is_place = isinstance(value, tuple) and len(value) in (2, 3)
    if not (is_place and all(isinstance(one, Real) and math.isfinite(one) for one in value)):
        raise InvalidInputError(f"{name} is {value!r}; it must be two or three finite numbers")
