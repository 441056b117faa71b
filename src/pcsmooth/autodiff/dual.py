"""Dual numbers: values that carry their derivatives through NumPy's arithmetic."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.lib.mixins import NDArrayOperatorsMixin

Array = npt.NDArray[np.float64]

#: Partial derivatives of functions of one argument x with result y: f(x, y).
_UNARY: dict[np.ufunc, Callable[[Array, Array], Any]] = {
    np.negative: lambda x, y: -1.0,
    np.positive: lambda x, y: 1.0,
    np.absolute: lambda x, y: np.sign(x),
    np.square: lambda x, y: 2.0 * x,
    np.sqrt: lambda x, y: 0.5 / y,
    np.exp: lambda x, y: y,
    np.log: lambda x, y: 1.0 / x,
    np.sin: lambda x, y: np.cos(x),
    np.cos: lambda x, y: -np.sin(x),
    np.tan: lambda x, y: 1.0 + y * y,
    np.arcsin: lambda x, y: 1.0 / np.sqrt(1.0 - x * x),
    np.arccos: lambda x, y: -1.0 / np.sqrt(1.0 - x * x),
    np.arctan: lambda x, y: 1.0 / (1.0 + x * x),
}

#: Partial derivatives of functions of two arguments a and b with result y: f(a, b, y).
_BINARY: dict[np.ufunc, Callable[[Array, Array, Array], tuple[Any, Any]]] = {
    np.add: lambda a, b, y: (1.0, 1.0),
    np.subtract: lambda a, b, y: (1.0, -1.0),
    np.multiply: lambda a, b, y: (b, a),
    np.divide: lambda a, b, y: (1.0 / b, -y / b),
    np.arctan2: lambda a, b, y: (b / (a * a + b * b), -a / (a * a + b * b)),
    np.hypot: lambda a, b, y: (a / y, b / y),
    np.maximum: lambda a, b, y: (a >= b, a < b),
    np.minimum: lambda a, b, y: (a <= b, a > b),
}

#: What only looks at values: the derivatives play no part in decisions.
_DECISIONS = frozenset(
    {np.less, np.less_equal, np.greater, np.greater_equal, np.equal, np.not_equal, np.sign}
)


class Dual(NDArrayOperatorsMixin):
    """An array of dual numbers x + sum_k x'_k e_k with e_j e_k = 0 (report, appendix).

    Arithmetic, comparisons and the usual functions of NumPy (``np.sqrt``, ``np.arctan2``,
    ``np.where``, ``np.sum`` over the first axis ...) take them in place of arrays of floats, so
    that a function written for floats yields its derivatives as well, exact but for rounding.
    Comparisons look at the values alone: what they choose is differentiated as it stands.

    Parameters
    ----------
    value : array_like, shape S
        x.
    derivatives : array_like, shape S + (m,)
        x', along m directions.

    Raises
    ------
    ValueError
        If the shapes do not match.
    TypeError
        From a function of NumPy whose derivative is not known here.

    Examples
    --------
    >>> x = Dual([2.0, 3.0], [[1.0], [1.0]])
    >>> y = np.sqrt(x * x + 5.0)
    >>> y.value, y.derivatives[:, 0] * 3.0
    (array([3.        , 3.74165739]), array([2.        , 2.40535118]))
    """

    def __init__(self, value: npt.ArrayLike, derivatives: npt.ArrayLike) -> None:
        self.value = np.asarray(value, dtype=float)
        self.derivatives = np.asarray(derivatives, dtype=float)
        if self.derivatives.shape[:-1] != self.value.shape or not self.derivatives.ndim:
            raise ValueError(
                f"derivatives of shape {self.derivatives.shape} do not belong to values of shape "
                f"{self.value.shape}; they need one more axis"
            )

    def __repr__(self) -> str:
        """Show values and derivatives."""
        return f"Dual({self.value!r}, {self.derivatives!r})"

    def __len__(self) -> int:
        """Return the length of the first axis."""
        return len(self.value)

    def __getitem__(self, key: Any) -> Dual:
        """Select values, with their derivatives, by anything but an ellipsis."""
        return Dual(self.value[key], self.derivatives[key])

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        """Apply the chain rule; called by NumPy."""
        if method != "__call__" or options:
            return NotImplemented
        values = [value_of(x) for x in inputs]
        if ufunc in _DECISIONS:
            return ufunc(*values)
        if ufunc is np.power and not isinstance(inputs[1], Dual):
            base, exponent = values
            return _chained(
                base**exponent, inputs[:1], (exponent * base ** np.subtract(exponent, 1),)
            )
        if ufunc in _UNARY:
            (x,) = values
            y = ufunc(x)
            return _chained(y, inputs, (_UNARY[ufunc](x, y),))
        if ufunc in _BINARY:
            a, b = values
            y = ufunc(a, b)
            return _chained(y, inputs, _BINARY[ufunc](a, b, y))
        return NotImplemented

    def __array_function__(
        self, function: Callable[..., Any], types: Any, args: Any, options: Any
    ) -> Any:
        """Choose and add up; called by NumPy."""
        if function is np.where and len(args) == 3 and not options:
            chosen, *others = args
            first, second = (as_dual(other, like=self) for other in others)
            return Dual(
                np.where(chosen, first.value, second.value),
                np.where(np.expand_dims(chosen, -1), first.derivatives, second.derivatives),
            )
        if function is np.sum and len(args) == 1 and options in ({}, {"axis": 0}):
            axes = 0 if options else tuple(range(self.value.ndim))
            return Dual(self.value.sum(axis=axes), self.derivatives.sum(axis=axes))
        return NotImplemented


def value_of(number: Any) -> Array:
    """Values of dual numbers, or of what has no derivatives."""
    return number.value if isinstance(number, Dual) else np.asarray(number, dtype=float)


def as_dual(number: Any, like: Dual) -> Dual:
    """Give a constant the derivatives 0 along the directions of another number."""
    if isinstance(number, Dual):
        return number
    value = np.asarray(number, dtype=float)
    return Dual(value, np.zeros((*value.shape, like.derivatives.shape[-1])))


def seed(values: Array) -> Dual:
    """Make independent variables of the last axes of an array.

    Parameters
    ----------
    values : ndarray, shape (m, ...)
        m times the same variables.

    Returns
    -------
    Dual
        Of the same shape; direction k is that of the k-th entry of each row.

    Examples
    --------
    >>> x = seed(np.array([[3.0, 4.0]]))
    >>> np.hypot(x[:, 0], x[:, 1]).derivatives
    array([[0.6, 0.8]])
    """
    size = int(np.prod(values.shape[1:]))
    ones = np.eye(size).reshape(*values.shape[1:], size)
    return Dual(values, np.broadcast_to(ones, (*values.shape, size)))


def _chained(y: Array, inputs: Sequence[Any], partials: Sequence[Any]) -> Dual:
    """Add up the derivatives of the arguments, each times its partial derivative."""
    derivatives: Any = 0.0
    for x, partial in zip(inputs, partials, strict=True):
        if isinstance(x, Dual):
            factor = np.broadcast_to(np.asarray(partial, dtype=float), y.shape)
            # an axis is put in front where broadcasting adds one to the value
            missing = (1,) * (y.ndim - x.value.ndim)
            derivatives = derivatives + factor[..., np.newaxis] * x.derivatives.reshape(
                missing + x.derivatives.shape
            )
    return Dual(y, derivatives)
