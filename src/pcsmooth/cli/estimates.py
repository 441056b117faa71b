"""Normals and curvatures in what a command says."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pcsmooth.files.notes import Say
from pcsmooth.printable import counted

if TYPE_CHECKING:
    from pcsmooth.files.report import EstimateFacts

#: How a component got the sign of its normals, in words: of one, of more.
_REASONS = {
    "outward": ("outward", "outward"),
    "axis": ("along its leading axis", "along their leading axes"),
    "input": ("as in the input", "as in the input"),
    "viewpoint": ("to the viewpoint", "to the viewpoint"),
    "direction": ("along the direction", "along the direction"),
    "propagate": ("up at its highest point", "up at their highest points"),
}


def say_estimates(facts: EstimateFacts, say: Say) -> None:
    """Say how normals and curvature were found."""
    without = facts.without_normal
    alone = f"; {counted(without, 'point')} without normal" if without else ""
    curvature = facts.curvature_support
    fitted = "" if curvature is None else f", curvature from {curvature:.0f}"
    say(f"  normals from {facts.normal_support:.0f} points{fitted}{alone}")
    say(f"  normals: {_orientation_in_words(facts.orientation)}")
    median = f"{facts.median_abs_mean_curvature:.4g}"
    medians = {
        "half": f"|H| {median}, H=(k1+k2)/2",
        "sum": f"|H| {median}, H=k1+k2",
        None: f"|k| {median}",
    }
    say(f"  median {medians[facts.mean_convention]}")


def _orientation_in_words(orientation: dict[str, int]) -> str:
    parts: list[str] = []
    for reason, count in orientation.items():
        words = _REASONS[reason][count != 1]
        noun = f" component{'s' * (count != 1)}" if not parts else ""
        parts.append(f"{count}{noun} {words}")
    return ", ".join(parts)
