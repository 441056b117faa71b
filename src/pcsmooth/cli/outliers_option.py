"""The option that says what becomes of outliers."""

from __future__ import annotations

import click

outliers_option = click.option(
    "--outliers",
    type=click.Choice(["mark", "remove", "only", "class"]),
    default="mark",
    show_default=True,
    help="mark: they stay in their rows, a column tells which; remove: their rows are left out; "
    "only: all other rows are, to look at what would go; class: they get classes of LAS, 18 above "
    "the surface and else 7. Fixed points stay, and keep their class.",
)
