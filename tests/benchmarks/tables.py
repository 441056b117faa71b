"""Markdown tables, printed as their rows become known."""


def heading(text: str, *notes: str) -> None:
    """Print a heading and paragraphs."""
    print(f"\n## {text}\n")
    for note in notes:
        print(note, end="\n\n", flush=True)


def header(*names: str) -> None:
    """Begin a table; every column but the first is aligned to the right."""
    row(*names)
    row("---", *["--:"] * (len(names) - 1))


def row(*cells: str) -> None:
    """Print one row."""
    print("|", " | ".join(cells), "|", flush=True)


def percent(share: float) -> str:
    """Write a share as a percentage of three digits."""
    return f"{100 * share:.3g} %"
