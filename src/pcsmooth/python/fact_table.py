"""Results that show themselves in a line, and in notebooks in a small table."""

from __future__ import annotations

from abc import ABC, abstractmethod
from html import escape


class FactTable(ABC):
    """What says the most important numbers of itself, in place of all its arrays."""

    @abstractmethod
    def facts(self) -> dict[str, str]:
        """Say the most important numbers, in words by name."""

    def __repr__(self) -> str:
        """Say them in a line."""
        told = ", ".join(f"{name}: {words}" for name, words in self.facts().items())
        return f"<{type(self).__name__} {told}>"

    def _repr_html_(self) -> str:
        """Say them in a table."""
        rows = "".join(
            f"<tr><th>{escape(name)}</th><td>{escape(words)}</td></tr>"
            for name, words in self.facts().items()
        )
        return f"<table><caption>{type(self).__name__}</caption>{rows}</table>"
