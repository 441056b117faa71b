"""One state of a cloud that is denoised, in numbers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Record:
    """One state of a cloud that is denoised.

    Attributes
    ----------
    iteration : int
        Steps taken before it.
    volume, area : float
        Volume of the union, L^d, and measure of its boundary, L^(d-1), of this state.
    mean_move, max_move : float
        Mean and largest length of the step that led here, L; 0 at the start.
    """

    iteration: int
    volume: float
    area: float
    mean_move: float
    max_move: float

    def scaled(self, factor: float, dimension: int) -> Record:
        """Return the same of a cloud of d dimensions times a factor."""
        return Record(
            self.iteration,
            self.volume * factor**dimension,
            self.area * factor ** (dimension - 1),
            self.mean_move * factor,
            self.max_move * factor,
        )

    def in_words(self) -> str:
        """Say all of it on a line."""
        return (
            f"  {self.iteration:4d}  volume {self.volume:.8g}  area {self.area:.8g}"
            f"  moved {self.mean_move:.3g} (at most {self.max_move:.3g})"
        )
