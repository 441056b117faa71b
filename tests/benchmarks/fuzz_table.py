"""What became of many inputs, as Markdown tables."""

from collections.abc import Mapping, Sequence

from tables import header, heading, row

SHOWN = 3
"""Failures of each kind that are named."""


def print_endings(
    counts: Mapping[tuple[str, str], int], names: Sequence[str], endings: Sequence[str]
) -> None:
    """Print how often the inputs of each group came to each of the endings.

    counts: by group and ending; names: of the columns, those of the groups and of all endings
    together first.
    """
    header(*names)
    for group in sorted({group for group, _ in counts}):
        of = [counts.get((group, ending), 0) for ending in endings]
        row(group, str(sum(of)), *map(str, of))
    totals = [sum(n for (_, each), n in counts.items() if each == ending) for ending in endings]
    row("all", str(sum(totals)), *map(str, totals))


def print_failures(failures: Mapping[str, Sequence[int]], seed: int, note: str = "") -> None:
    """Print which inputs failed, if any, by the kind of failure."""
    if not failures:
        return
    heading("Failures", f"`--seed {seed} --only INDEX` shows one{note}")
    header("kind", "times", "index")
    for kind, indices in sorted(failures.items(), key=lambda item: -len(item[1])):
        row(kind, str(len(indices)), ", ".join(map(str, sorted(indices)[:SHOWN])))
