"""A progress bar on stderr: over the stages of a run, or over the tiles of each stage."""

from __future__ import annotations

import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from pcsmooth.files.notes import Say
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from pcsmooth.progress import Progress


#: Seconds after which a bar is seen, and between the ticks of its clock.
_TICK = 1.0


class ProgressBar:
    """A progress bar, as a context manager.

    It is seen from the first second on, whatever is being done, and its clock goes on.

    Parameters
    ----------
    name : str
        What is worked on.
    stages : int
        How many stages there will be at most, of a cloud in one part.
    shows : bool
        Whether it is shown on a terminal.
    say : callable
        Takes messages.
    says_states : bool
        Whether each state of the cloud is said.
    """

    def __init__(
        self, name: str, stages: int, shows: bool, say: Say, *, says_states: bool = False
    ) -> None:
        from tqdm import tqdm

        self._name = printable(Path(name).name)
        self._say = say
        self._says_states = says_states
        self._bar = tqdm(
            total=stages, desc=f"{self._name}: reading", unit="stage", delay=_TICK, leave=False,
            file=sys.stderr, disable=None if shows else True,
        )  # fmt: skip
        self._ended = threading.Event()

    def __enter__(self) -> ProgressBar:
        """Give the bar itself."""
        if not self._bar.disable:
            threading.Thread(target=self._tick, name="progress bar", daemon=True).start()
        return self

    def __exit__(self, *_error: object) -> None:
        """Remove it."""
        self._ended.set()
        self._bar.close()

    def _tick(self) -> None:
        while not self._ended.wait(_TICK):
            self._bar.refresh()

    def say(self, message: str) -> None:
        """Print a message above the bar."""
        with self._bar.external_write_mode(file=sys.stderr):
            self._say(message)

    def begin(self, stage: str) -> None:
        """Show what is being done now."""
        self._bar.set_description(f"{self._name}: {stage}")

    def tell(self, progress: Progress) -> None:
        """Show how far a run is."""
        if progress.record is not None:
            if self._says_states:
                self.say(progress.record.in_words())
        elif progress.total == 1:
            self._bar.set_description(f"{self._name}: {progress.stage}", refresh=False)
            self._bar.update(progress.done)
        elif progress.done == 0:
            self._bar.unit = "tile"
            self._bar.reset(progress.total)
            self._bar.set_description(f"{self._name}: {progress.stage}")
        else:
            self._bar.update(progress.done - self._bar.n)
