"""Points selected by an expression on the columns of their file, such as `classification == 2`."""

from __future__ import annotations

import ast
import operator
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats.number_text import parsed

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from pcsmooth.cloud import PointCloud

_LONGEST = 1000
_DEEPEST = 50

_ARITHMETIC: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
}
_COMPARISONS: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
_MEMBERSHIP = (ast.In, ast.NotIn)
_ALLOWED = (
    ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.Name, ast.Load, ast.USub, ast.UAdd,
    ast.Not, ast.And, ast.Or, *_ARITHMETIC, *_COMPARISONS, *_MEMBERSHIP,
)  # fmt: skip

#: A word in quotation marks, as it is, or a name in back ticks.
_QUOTED = re.compile(r"""'(?:[^'\\\n]|\\.)*'|"(?:[^"\\\n]|\\.)*"|`([^`\n]+)`""")


@dataclass(frozen=True)
class Where:
    """Which points are selected.

    Attributes
    ----------
    text : str
        Names of columns and x, y, z, other names in back ticks, numbers, words in quotation marks,
        ``+ - * / // % **``, comparisons, ``in (1, 2)``, ``not in``, ``and``, ``or``, ``not`` and
        parentheses, with the ranks they have in Python.
        Columns of text are numbers (NaN where they are not) but where they are compared with a
        word. A point is not selected where a number that is compared, or is a condition itself,
        is NaN.

    Raises
    ------
    InvalidInputError
        If it is anything else, or longer than 1000 characters, or deeper than 50 levels.
    """

    text: str
    _root: ast.expr = field(init=False, repr=False, compare=False)
    _names: dict[str, str] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Parse and check it; nothing of it is ever run as code."""
        if len(self.text) > _LONGEST:
            raise InvalidInputError(f"the expression is longer than {_LONGEST} characters")
        plain = self._with_plain_names()
        try:
            with warnings.catch_warnings(action="ignore"):  # of backslashes and the like
                root = ast.parse(plain, mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise InvalidInputError(
                f"{self.text!r} is no expression such as classification == 2 and z > 5"
            ) from None
        self._check(root, 1, plain)
        object.__setattr__(self, "_root", root)

    def _with_plain_names(self) -> str:
        """Put a name that the text does not have in place of each in back ticks."""
        plain = "column"
        while plain in self.text:
            plain += "_"
        names: dict[str, str] = {}

        def replaced(found: re.Match[str]) -> str:
            if found[1] is None:
                return found[0]
            names[f"{plain}{len(names)}"] = found[1]
            return f" {plain}{len(names) - 1} "

        text = _QUOTED.sub(replaced, self.text).strip()
        object.__setattr__(self, "_names", names)
        return text

    def selected(self, cloud: PointCloud, path: str) -> npt.NDArray[np.bool_]:
        """Find the selected points.

        Parameters
        ----------
        cloud : PointCloud
            What was read.
        path : str
            The file, for messages.

        Returns
        -------
        ndarray of bool, shape (n,)

        Raises
        ------
        CloudFileError
            If there is no column of a name, or a column of it is neither numbers nor text.
        """
        import numpy as np

        reading = _Reading(cloud, path, self._names, np.zeros(len(cloud), np.bool_))
        with np.errstate(all="ignore"):
            chosen = reading.condition(self._root)
        return np.asarray(chosen & ~reading.unknown)

    def _check(self, node: ast.AST, depth: int, plain: str) -> None:
        if depth > _DEEPEST:
            raise InvalidInputError(f"the expression is deeper than {_DEEPEST} levels")
        if not _is_value(node) and not isinstance(node, _ALLOWED):
            part = ast.get_source_segment(plain, node) if hasattr(node, "lineno") else ""
            for name, meant in self._names.items():
                for found in (f" {name} ", name):
                    part = part and part.replace(found, f"`{meant}`")
            raise InvalidInputError(
                f"{part or type(node).__name__!r} in {self.text!r} is neither a column, a number, "
                "a word in quotation marks, arithmetic, a comparison, and, or, nor not"
            )
        if not isinstance(node, ast.Compare):
            for child in ast.iter_child_nodes(node):
                self._check(child, depth + 1, plain)
            return
        self._check(node.left, depth + 1, plain)
        for op, right in zip(node.ops, node.comparators, strict=True):
            self._check(op, depth + 1, plain)
            if not isinstance(op, _MEMBERSHIP):
                self._check(right, depth + 1, plain)
            elif not (isinstance(right, ast.Tuple | ast.List) and right.elts):
                raise InvalidInputError(
                    f"what follows in is no list such as (1, 2) in {self.text!r}"
                )
            else:
                for value in right.elts:
                    self._check(value, depth + 2, plain)


@dataclass(eq=False)
class _Reading:
    """Values of an expression in a cloud, and where a number that matters is NaN."""

    cloud: PointCloud
    path: str
    names: dict[str, str]
    unknown: npt.NDArray[np.bool_]

    def condition(self, node: ast.expr) -> Any:
        """Evaluate what is true or false."""
        import numpy as np

        if isinstance(node, ast.BoolOp):
            join = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
            return join.reduce([self.condition(value) for value in node.values])
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return ~self.condition(node.operand)
        if not isinstance(node, ast.Compare):
            return self._known(self.numbers(node)) != 0
        found = np.ones(len(self.cloud), np.bool_)
        terms = [node.left, *node.comparators]
        for left, right, op in zip(terms, terms[1:], node.ops, strict=False):
            if isinstance(op, _MEMBERSHIP):
                assert isinstance(right, ast.Tuple | ast.List)
                is_among = self._is_among(left, right.elts)
                found &= ~is_among if isinstance(op, ast.NotIn) else is_among
            else:
                found &= self._compared(_COMPARISONS[type(op)], left, right)
        return found

    def _compared(
        self, compare: Callable[[Any, Any], Any], left: ast.expr, right: ast.expr
    ) -> npt.NDArray[np.bool_]:
        """Compare words if one of both is a word, else numbers."""
        import numpy as np

        if _is_word(left) or _is_word(right):
            return np.asarray(compare(self.words(left), self.words(right)))
        known = (self._known(self.numbers(side)) for side in (left, right))
        return np.asarray(compare(*known))

    def _is_among(self, left: ast.expr, values: list[ast.expr]) -> npt.NDArray[np.bool_]:
        """Compare with each of some values: words if one of all is a word, else numbers."""
        import numpy as np

        found = np.zeros(len(self.cloud), np.bool_)
        has_words = any(map(_is_word, [left, *values]))
        for value in values:
            if has_words:
                found |= self.words(left) == self.words(value)
            else:
                found |= self._compared(operator.eq, left, value)
        return found

    def numbers(self, node: ast.expr) -> npt.NDArray[np.float64]:
        """Evaluate numbers."""
        import numpy as np

        if isinstance(node, ast.BinOp):
            return np.asarray(
                _ARITHMETIC[type(node.op)](self.numbers(node.left), self.numbers(node.right))
            )
        if isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.Not):
            value = self.numbers(node.operand)
            return -value if isinstance(node.op, ast.USub) else value
        if isinstance(node, ast.Name):
            return self._column_of_numbers(node.id)
        if isinstance(node, ast.Constant):
            number = np.nan if isinstance(node.value, str) else float(str(node.value))
            return np.full(len(self.cloud), number)
        return np.asarray(self.condition(node), np.float64)

    def words(self, node: ast.expr) -> npt.NDArray[np.str_]:
        """Evaluate words."""
        import numpy as np

        if isinstance(node, ast.Name):
            return self._column(node.id).astype(np.str_)
        if isinstance(node, ast.Constant):
            return np.array(str(node.value))  # one for all rows: it may be long
        return self.numbers(node).astype(np.str_)

    def _known(self, values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        import numpy as np

        self.unknown |= np.isnan(values)
        return values

    def _column(self, name: str) -> npt.NDArray[Any]:
        columns = self.cloud.columns
        name = self.names.get(name, name)
        axes = "xyz"[: self.cloud.dimension]
        if name in axes and name not in columns:
            return self.cloud.points[:, axes.index(name)]
        if name in columns and columns[name].dtype.kind in "biufU":
            return columns[name]
        known = [*axes, *(key for key in columns if columns[key].dtype.kind in "biufU")]
        raise CloudFileError(
            self.path, f"there is no column '{name}' to select by", f"choose of {', '.join(known)}"
        )

    def _column_of_numbers(self, name: str) -> npt.NDArray[np.float64]:
        import numpy as np

        column = self._column(name)
        if column.dtype.kind != "U":
            return column.astype(np.float64)
        numbers = np.full(len(column), np.nan)
        for row, value in enumerate(column.tolist()):
            try:
                numbers[row] = parsed([value])[0]
            except ValueError:
                continue
        return numbers


def without_spaces(text: str) -> str:
    """Write a text without spaces or line breaks, these as in an address (%20)."""
    return quote(text, safe="=<>!()+-*/'\",.")


def _is_value(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) in (int, float, str)


def _is_word(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)
