"""Options for clouds larger than memory, and when they apply."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any, Literal

import click

from pcsmooth import machine
from pcsmooth.cli.options import whole_number
from pcsmooth.cli.process_count import fitting_processes

if TYPE_CHECKING:
    from pathlib import Path

    from pcsmooth.cli.messages import Say
    from pcsmooth.tiling.runner import Runner

Command = Callable[..., None]

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


class TileSize(click.ParamType[int | str]):
    """A number of points, auto, or off."""

    name = "points"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn a number into an int and leave words alone."""
        if value in ("auto", "off"):
            return value
        number = whole_number(str(value))
        if not number:
            self.fail(f"{value!r} is neither a number of points, nor auto, nor off", param, ctx)
        return number


@dataclass(frozen=True)
class Tiling:
    """How clouds larger than memory are cut up.

    Attributes
    ----------
    size : int, "auto" or "off"
        Points of a tile; auto cuts only what does not fit into memory.
    folder : str or None
        Where tiles lie while they are worked on; by default beside the output.
    workers : int or None
        Local processes that share the tiles; None is this one.
    scheduler : str or None
        Address of a scheduler of dask.distributed whose workers share them.
    """

    size: int | Literal["auto", "off"]
    folder: str | None
    workers: int | None
    scheduler: str | None

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
    def work_folder(self, output_path: str, say: Say) -> Iterator[Path]:
        """Make a folder for the tiles, and remove it in the end; those of killed runs at once."""
        from pathlib import Path

        from pcsmooth.cleanup import temporary_folder
        from pcsmooth.cli.files import remove_left_over
        from pcsmooth.formats.system_errors import named_system_errors
        from pcsmooth.temporaries import folder_prefix

        parent = self.folder or str(Path(output_path).resolve().parent)
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
            from pcsmooth.cleanup import on_failure
            from pcsmooth.tiling.processes import ProcessRunner

            count = fitting_processes(
                "--workers", self.workers, _BYTES_PER_TILE_POINT * tile_points, say
            )
            share = None if threads is None else max(1, threads // count)
            with ProcessRunner(count, share) as processes, on_failure(processes.close):
                yield processes
        else:
            from pcsmooth.tiling.runner import InProcess

            yield InProcess()


_OPTIONS = (
    click.option(
        "--tile",
        type=TileSize(),
        default="auto",
        show_default=True,
        help="Cut the cloud into tiles of so many points on disk, so that memory goes with the "
        "tile and not with the cloud; the result is the same. Less than 10000 points become more "
        "where there would be more than 32 tiles. auto cuts clouds that do not fit "
        "into memory, into tiles of 2 million points; off never does.",
    ),
    click.option(
        "--tile-folder",
        metavar="DIR",
        help="Where the tiles lie meanwhile, up to 400 bytes a point. [default: a folder beside "
        "the output]",
    ),
    click.option(
        "--workers",
        type=click.IntRange(min=1),
        metavar="N",
        help="Local processes that share the tiles. [default: this one, with all its threads]",
    ),
    click.option(
        "--scheduler",
        metavar="ADDRESS",
        help="Scheduler of dask.distributed whose workers share the tiles, such as "
        "tcp://host:8786; all must see the tile folder (needs pcsmooth[dask]).",
    ),
)


def tile_options(command: Command) -> Command:
    """Give a command the options of `Tiling`, and one of these as the keyword `tiling`."""

    @wraps(command)
    def collected(
        *,
        tile: int | Literal["auto", "off"],
        tile_folder: str | None,
        workers: int | None,
        scheduler: str | None,
        **others: Any,
    ) -> None:
        if workers is not None and scheduler is not None:
            raise click.UsageError("--workers are local, and --scheduler has its own")
        if tile == "off" and (workers is not None or scheduler is not None):
            raise click.UsageError("--workers and --scheduler need tiles, not --tile off")
        command(tiling=Tiling(tile, tile_folder, workers, scheduler), **others)

    for option in reversed(_OPTIONS):
        collected = option(collected)
    return collected
