"""Bodies of methods, by the names that users know them by."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pcsmooth.files.report import ShapeFacts
    from pcsmooth.methods.shapes import Balls


def union_of(shapes: Balls) -> str | None:
    """How the union of polyhedra is computed; None of balls."""
    from pcsmooth.methods.shapes import Polyhedra

    return shapes.union if isinstance(shapes, Polyhedra) else None


def shape_facts(shapes: Balls, name: str | None) -> ShapeFacts | None:
    """Say which body is used, by its name, and its union; nothing of balls."""
    from pcsmooth.files.report import ShapeFacts

    union = union_of(shapes)
    return None if name is None or union is None else ShapeFacts(name, union)


def check_dimension(
    shapes: Balls, name: str | None, presets_path: str | None, dimension: int
) -> None:
    """Raise `InvalidInputError` if points have not as many coordinates as the body."""
    from pcsmooth.bodies.presets import find_preset
    from pcsmooth.methods.shapes import Polyhedra

    if name is not None and isinstance(shapes, Polyhedra) and shapes.body.dimension != dimension:
        find_preset(name, presets_path, dimension, allow_outside=True)  # says which would fit
