"""A progress bar on stderr: over the stages of a run, or over the tiles of each stage."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pcsmooth.files.notes import Say
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from pcsmooth.progress import Progress


class ProgressBar:
    """A progress bar, as a context manager.

    Parameters
    ----------
    name : str
        What is worked on.
    stages : int
        How many stages there will be at most, of a cloud in one part.
    shows : bool
        Whether it is shown on a terminal.
    say : callable, optional
        Gets each state of the cloud, if these are to be said.
    """

    def __init__(self, name: str, stages: int, shows: bool, say: Say | None = None) -> None:
        from tqdm import tqdm

        self._name = printable(Path(name).name)
        self._say = say
        self._bar = tqdm(
            total=stages, desc=self._name, unit="stage", delay=1.0, leave=False, file=sys.stderr,
            disable=None if shows else True,
        )  # fmt: skip

    def __enter__(self) -> ProgressBar:
        """Give the bar itself."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Remove it."""
        self._bar.close()

    def tell(self, progress: Progress) -> None:
        """Show how far a run is."""
        if progress.record is not None:
            if self._say is not None:
                with self._bar.external_write_mode(file=sys.stderr):
                    self._say(progress.record.in_words())
        elif progress.total == 1:
            self._bar.set_description(f"{self._name}: {progress.stage}", refresh=False)
            self._bar.update(progress.done)
        elif progress.done == 0:
            self._bar.unit = "tile"
            self._bar.reset(progress.total)
            self._bar.set_description(f"{self._name}: {progress.stage}")
        else:
            self._bar.update(progress.done - self._bar.n)
