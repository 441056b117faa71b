"""`pcsmooth experiments`: the thesis' experiments, done again by a package beside this one."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pcsmooth.cli.messages import computing, speaker
from pcsmooth.cli.options import overwrite_option, quiet_option
from pcsmooth.files.notes import remove_left_over

if TYPE_CHECKING:
    from pcsmooth_experiments.experiment import Experiment
    from pcsmooth_experiments.gallery import Finished


@click.command()
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option(
    "--out",
    "out_folder",
    metavar="DIR",
    help="Folder to write into: NAME.png for each, tables as CSV, index.html. Made if not there.",
)
@click.option(
    "--data",
    "data_folder",
    metavar="DIR",
    default="data/report",
    show_default=True,
    help="Folder of the thesis' clouds.",
)
@click.option("--list", "as_list", is_flag=True, help="List the experiments and do none.")
@overwrite_option
@quiet_option
def experiments(
    names: tuple[str, ...],
    out_folder: str | None,
    data_folder: str,
    as_list: bool,
    overwrite: bool,
    quiet: bool,
) -> None:
    """Do the experiments of the thesis again, all or each NAME.

    Writes numbers, pictures and a page that says of each whether it agrees with the thesis. One
    that fails does not keep the others, but the command fails in the end.

    \b
    Examples:
      pcsmooth experiments --list
      pcsmooth experiments --out out/experiments
      pcsmooth experiments outliers noise --out out/holes --overwrite
    """
    _check_installed()
    if as_list:
        click.echo(_listed(_chosen(names)))
        return
    if out_folder is None:
        raise click.UsageError("--out DIR says where to write; --list shows what there is")
    chosen = _chosen(names)
    _check_folders(Path(data_folder), Path(out_folder), overwrite)
    failed = _make(chosen, Path(data_folder), Path(out_folder), quiet)
    if failed:
        from pcsmooth.errors import PcsmoothError

        raise PcsmoothError(
            f"{len(failed)} of {len(chosen)} experiments failed ({', '.join(failed)}); "
            f"{Path(out_folder) / 'index.html'} says why"
        )


def _check_installed() -> None:
    """Raise an error if this pcsmooth came without the experiments."""
    try:
        import pcsmooth_experiments  # noqa: F401
    except ImportError as error:
        from pcsmooth.errors import PcsmoothError

        raise PcsmoothError(
            "the experiments need the package pcsmooth_experiments, which is not installed; "
            "install all of pcsmooth"
        ) from error


def _chosen(names: tuple[str, ...]) -> list[Experiment]:
    """Look the experiments up; all if none is named."""
    from pcsmooth_experiments.catalogue import EXPERIMENTS

    known = [experiment.name for experiment in EXPERIMENTS]
    for name in names:
        if name not in known:
            raise click.UsageError(
                f"there is no experiment {name!r}; use one of {', '.join(known)}"
            )
    return [experiment for experiment in EXPERIMENTS if not names or experiment.name in names]


def _listed(chosen: list[Experiment]) -> str:
    """Lay names, places and titles out in columns."""
    rows = [(experiment.name, experiment.place, experiment.title) for experiment in chosen]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def _check_folders(data: Path, out: Path, overwrite: bool) -> None:
    """Raise an error if the clouds are not there, the page is, or nothing could be drawn."""
    from pcsmooth.errors import CloudFileError
    from pcsmooth.plots.figures import new_figure
    from pcsmooth_experiments.gallery import INDEX

    if not data.is_dir():
        raise CloudFileError(
            str(data), "there is no such folder", "name the folder of the thesis' clouds (--data)"
        )
    if out.exists() and not out.is_dir():
        raise CloudFileError(str(out), "is not a folder", "choose another --out")
    if (out / INDEX).exists() and not overwrite:
        raise CloudFileError(
            str(out / INDEX), "exists already", "pass --overwrite to replace the gallery"
        )
    new_figure(1.0, 1.0)


def _make(chosen: list[Experiment], data: Path, out: Path, quiet: bool) -> list[str]:
    """Write the gallery with a progress bar; returns the names of those that failed."""
    from tqdm import tqdm

    from pcsmooth_experiments.experiment import Inputs
    from pcsmooth_experiments.gallery import INDEX, write_gallery

    say = speaker(quiet)
    remove_left_over(str(out), say)
    bar = tqdm(
        total=len(chosen), desc="experiments", unit="experiment", delay=1.0, leave=False,
        file=sys.stderr, disable=True if quiet else None,
    )  # fmt: skip

    def on_finished(finished: Finished) -> None:
        with bar.external_write_mode(file=sys.stderr):
            say(f"{finished.experiment.name}: {finished.verdict}. {finished.summary}")
        bar.update()

    with bar, computing(str(out), say):
        gallery = write_gallery(chosen, Inputs(data), out, on_finished)
    say(f"wrote {out / INDEX}")
    return [finished.experiment.name for finished in gallery if finished.outcome is None]
