"""Options for clouds larger than memory, and when they apply."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Literal

import click

from pcsmooth.cli.options import Named, whole_number

Command = Callable[..., Any]


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


_OPTIONS = (
    click.option(
        "--tile",
        type=TileSize(),
        default="auto",
        show_default=True,
        help="Cut the cloud into tiles of so many points on disk, so that memory goes with the "
        "tile and not with the cloud; the result is the same. Less than 10000 points become more "
        "where there would be more than 32 tiles. auto cuts clouds that do not fit "
        "into memory, into tiles of 2 million points; off never does. Streams, meshes (obj, off, "
        "stl) and compressed pcd cannot be cut.",
    ),
    click.option(
        "--tile-folder",
        type=Named("dir"),
        metavar="DIR",
        help="Where the tiles lie meanwhile, up to 400 bytes a point. [default: a folder beside "
        "the output; where none is written, the system's for temporary files]",
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
    ) -> Any:
        if workers is not None and scheduler is not None:
            raise click.UsageError("--workers are local, and --scheduler has its own")
        if tile == "off" and (workers is not None or scheduler is not None):
            raise click.UsageError("--workers and --scheduler need tiles, not --tile off")
        from pcsmooth.files.tiling import Tiling

        return command(tiling=Tiling(tile, tile_folder, workers, scheduler), **others)

    for option in reversed(_OPTIONS):
        collected = option(collected)
    return collected
