"""Bodies of methods, by the names that users know them by."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pcsmooth.methods.shapes import Balls


def union_of(shapes: Balls) -> str | None:
    """How the union of polyhedra is computed; None of balls."""
    from pcsmooth.methods.shapes import Polyhedra

    return shapes.union if isinstance(shapes, Polyhedra) else None


def shape_in_words(shapes: Balls, name: str | None) -> dict[str, str]:
    """Say which body is used, by its name, and its union; nothing of balls."""
    union = union_of(shapes)
    return {} if name is None or union is None else {"polyhedron": name, "union": union}


def check_dimension(
    shapes: Balls, name: str | None, presets_path: str | None, dimension: int
) -> None:
    """Raise `InvalidInputError` if points have not as many coordinates as the body."""
    from pcsmooth.bodies.presets import find_preset
    from pcsmooth.methods.shapes import Polyhedra

    if name is not None and isinstance(shapes, Polyhedra) and shapes.body.dimension != dimension:
        find_preset(name, presets_path, dimension, allow_outside=True)  # says which would fit
