"""The option that selects points by an expression."""

from __future__ import annotations

from typing import Any

import click

from pcsmooth.errors import InvalidInputError


class Expression(click.ParamType[Any]):
    """An expression on columns."""

    name = "expression"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Parse it."""
        from pcsmooth.files.where import Where

        try:
            return Where(value)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)


where_option = click.option(
    "--where",
    type=Expression(),
    metavar="EXPRESSION",
    help="Only these points move, the others act on them: names of columns and x y z, numbers, "
    "words in quotation marks, + - * / // % **, comparisons, and, or, not. NaN is never selected.",
)
