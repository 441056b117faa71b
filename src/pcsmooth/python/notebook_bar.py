"""A progress bar for Python callers: of notebooks, or on the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pcsmooth.progress import Callback, Progress


@contextmanager
def notebook_bar(stages: int, callback: Callback, *, shows: bool) -> Iterator[Callback]:
    """Give what is to be told how far a run is: a bar, if it is to be shown, and a callback.

    Parameters
    ----------
    stages : int
        How many stages there will be at most.
    callback : callable
        Is told, too.
    shows : bool
        Whether there is a bar.
    """
    if not shows:
        yield callback
        return
    from tqdm.auto import tqdm

    with tqdm(total=stages, unit="stage", leave=False) as bar:

        def tell(progress: Progress) -> None:
            if progress.record is None and progress.total == 1:
                bar.set_description(progress.stage, refresh=False)
                bar.update(progress.done)
            callback(progress)

        yield tell
