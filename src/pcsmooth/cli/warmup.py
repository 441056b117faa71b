"""`pcsmooth warmup`: compile before anything is to be done."""

from __future__ import annotations

import sys
import time

import click

from pcsmooth.cli.messages import speaker
from pcsmooth.cli.options import quiet_option
from pcsmooth.errors import PcsmoothError


@click.command(short_help="Compile ahead what a first run would compile.")
@click.option(
    "--all", "everything", is_flag=True, help="Also for tiles, implicit flows and polyhedra."
)
@quiet_option
def warmup(everything: bool, quiet: bool) -> None:
    """Compile ahead what a first run would have to compile, and say where it is kept.

    For images of containers, machines that test, and the workers of a cluster. By default what
    denoise and curvature need without options. What is there already is not compiled again.

    \b
    Examples:
      pcsmooth warmup
      pcsmooth warmup --all
    """
    from tqdm import tqdm

    from pcsmooth.kernels.ahead import missing, missing_of_all, usual_kernels, warm_up
    from pcsmooth.kernels.cache import cache_root, why_not_kept

    say = speaker(quiet)
    left = missing_of_all() if everything else missing(usual_kernels())
    if not left:
        say("nothing to do: all of them have been compiled")
        return
    root, reason = cache_root(), why_not_kept()
    if reason:
        raise PcsmoothError(
            f"nothing would be kept: {reason}; set NUMBA_CACHE_DIR to a folder that you alone may "
            "write"
        )
    started = time.perf_counter()
    bar = tqdm(
        total=len(left), desc="compiling", unit="kernel", leave=False, file=sys.stderr,
        disable=True if quiet else None,
    )  # fmt: skip
    with bar:
        warm_up(left, bar.update)
    say(f"compiled {len(left)} kernels in {time.perf_counter() - started:.1f} s, kept in {root}")
