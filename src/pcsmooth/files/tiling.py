"""How clouds larger than memory are cut up, as it is asked for, and who works on them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from pcsmooth import machine
from pcsmooth.cleanup import on_failure, temporary_folder
from pcsmooth.errors import InvalidInputError
from pcsmooth.files.notes import Say, remove_left_over
from pcsmooth.formats.system_errors import named_system_errors
from pcsmooth.process_count import fitting_processes
from pcsmooth.temporaries import folder_prefix
from pcsmooth.tiling.runner import InProcess, Runner

#: Points of a tile by default, and the memory that each takes with what is around it, bytes.
_TILE_POINTS = 2_000_000
_BYTES_PER_TILE_POINT = 750

#: Memory that a point takes when a cloud is denoised as a whole, bytes, and the largest share of
#: the machine's memory that is taken so.
_BYTES_PER_POINT = 700
_LARGEST_SHARE = 0.5

#: Tiles of less than this many points are made larger where there would be more than so many of
#: them: each takes a second, however small (20,000 points: 25 s in 21 tiles, 120 s in 70).
_SMALL_TILE = 10_000
_MOST_SMALL_TILES = 32


@dataclass(frozen=True)
class Tiling:
    """How clouds larger than memory are cut up.

    Attributes
    ----------
    size : int, "auto" or "off"
        Points of a tile; auto cuts only what does not fit into memory.
    folder : str or None
        Where tiles lie while they are worked on; by default beside the output, and where
        none is written in the system's folder for temporary files.
    workers : int or None
        Local processes that share the tiles; None is this one.
    scheduler : str or None
        Address of a scheduler of dask.distributed whose workers share them.
    """

    size: int | Literal["auto", "off"] = "auto"
    folder: str | None = None
    workers: int | None = None
    scheduler: str | None = None

    def __post_init__(self) -> None:
        """Check the size.

        Raises
        ------
        InvalidInputError
            It is no number of points, 1 or more, and neither auto nor off.
        """
        size: Any = self.size
        if isinstance(size, int | np.integer) and not isinstance(size, bool) and size >= 1:
            object.__setattr__(self, "size", int(size))
        elif not (isinstance(size, str) and size in ("auto", "off")):
            raise InvalidInputError(
                f"tile is {size!r}; it must be a number of points, 1 or more, auto or off"
            )

    @property
    def is_asked_for(self) -> bool:
        """Whether there are to be tiles whatever the size of the cloud."""
        return isinstance(self.size, int) or self.scheduler is not None

    def points_of_tile(self, count: int) -> int | None:
        """Points of a tile for a cloud of so many points; None if it is not cut.

        Not fewer than asked for, and more where tiles would be small and very many.
        """
        if isinstance(self.size, int):
            return max(self.size, min(_SMALL_TILE, -(-count // _MOST_SMALL_TILES)))
        fits = count * _BYTES_PER_POINT <= _LARGEST_SHARE * machine.memory()
        if self.size == "off" or (fits and self.scheduler is None):
            return None
        return _TILE_POINTS

    @contextmanager
    def work_folder(self, default: str, say: Say) -> Iterator[Path]:
        """Make a folder for the tiles, and remove it in the end; those of killed runs at once.

        It is made in the default one if no other is named.
        """
        parent = self.folder or default
        remove_left_over(parent, say)
        with ExitStack() as opened:
            with named_system_errors(parent):
                folder = opened.enter_context(temporary_folder(folder_prefix("tiles"), parent))
            yield Path(folder).resolve()

    @contextmanager
    def runner(
        self, folder: Path, tile_points: int, threads: int | None, say: Say
    ) -> Iterator[Runner]:
        """Start what does the work on tiles of so many points in a folder."""
        if self.scheduler is not None:
            import logging

            from pcsmooth.tiling.dask_runner import DaskRunner

            for name in ("distributed", "distributed.client"):  # what goes wrong is our error
                logging.getLogger(name).setLevel(logging.CRITICAL)
            with DaskRunner(self.scheduler, folder) as cluster:
                yield cluster
        elif self.workers is not None:
            from pcsmooth.tiling.processes import ProcessRunner

            count = fitting_processes(
                "--workers", self.workers, _BYTES_PER_TILE_POINT * tile_points, say
            )
            share = None if threads is None else max(1, threads // count)
            with ProcessRunner(count, share) as processes, on_failure(processes.close):
                yield processes
        else:
            yield InProcess()
