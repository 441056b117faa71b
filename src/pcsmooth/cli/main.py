"""The command `pcsmooth`: its group, and how every failure ends."""

from __future__ import annotations

import contextlib
import sys
from typing import NoReturn

import click

import pcsmooth
from pcsmooth.cli.convert import convert
from pcsmooth.cli.curvature import curvature
from pcsmooth.cli.denoise import denoise
from pcsmooth.cli.exit_status import ExitStatus
from pcsmooth.cli.experiments import experiments
from pcsmooth.cli.help import show_help
from pcsmooth.cli.info import info
from pcsmooth.cli.interrupts import Interrupts, end
from pcsmooth.cli.plot import plot
from pcsmooth.cli.presets import presets
from pcsmooth.cli.streams import cause_and_remedy, claim_standard_streams, settle_stdout
from pcsmooth.cli.undo import undo
from pcsmooth.cli.warmup import warmup
from pcsmooth.errors import PcsmoothError
from pcsmooth.printable import printable


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(pcsmooth.__version__, prog_name="pcsmooth")
def main() -> None:
    """Denoise 2D and 3D point clouds, and estimate their normals and curvatures.

    To denoise, a filter measures the noise and takes it out, or the points go down the gradient of
    the volume (or the boundary area) of the union of balls or convex polyhedra around them; to
    estimate, none moves. Colours, labels, faces and comments come back as they were, in the same
    order.

    \b
    Examples:
      pcsmooth denoise scan.ply -o smooth.ply
      pcsmooth curvature scan.ply -o curved.ply --colormap coolwarm
      pcsmooth info scan.ply
      pcsmooth convert station.e57 -o station.laz
      pcsmooth plot scan.ply smooth.ply -o moved.png
      pcsmooth denoise facade.ply -o straight.ply --polyhedron cube
      pcsmooth undo smooth.ply -o scan_again.ply
      pcsmooth presets
      pcsmooth experiments --out out/experiments
      pcsmooth warmup
      pcsmooth help denoise
      zcat scan.ply.gz | pcsmooth denoise - -o - | gzip > smooth.ply.gz
    """


main.add_command(denoise)
main.add_command(curvature)
main.add_command(convert)
main.add_command(info)
main.add_command(plot)
main.add_command(experiments)
main.add_command(presets)
main.add_command(undo)
main.add_command(warmup)
main.add_command(show_help)


def run() -> NoReturn:
    """Run the command line and exit with an `ExitStatus`."""
    claim_standard_streams()
    interrupts = Interrupts()
    try:
        with interrupts.end_promptly():
            status = _run_command()
    except (KeyboardInterrupt, click.Abort):
        status = _fail(*interrupts.ending)
    except Exception:
        if interrupts.signal is None:
            raise
        # A library made another error of it.
        status = _fail(*interrupts.ending)
    settle_stdout()
    if interrupts.signal is not None:
        end(status)  # to close libraries and join threads may take longer than is bearable
    sys.exit(status)


def _run_command() -> ExitStatus:
    """Run the command line; what is wrong with the input or its use is told."""
    try:
        main(standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return ExitStatus.USAGE
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx else "pcsmooth"
        cause = error.format_message().rstrip(".")
        return _fail(f"{cause}; see {command} --help", ExitStatus.USAGE)
    except MemoryError:
        return _fail(
            "not enough memory; use a smaller radius or a part of the cloud", ExitStatus.FAILED
        )
    except PcsmoothError as error:
        return _fail(str(error), ExitStatus.FAILED)
    except OSError as error:  # of files it would be a CloudFileError
        name = error.filename or "<stdout>"
        return _fail(f"{name}: {cause_and_remedy(error)}", ExitStatus.FAILED)
    return ExitStatus.OK


def _fail(message: str, status: ExitStatus) -> ExitStatus:
    with contextlib.suppress(OSError):
        click.echo("Error: " + printable(" ".join(message.split())), err=True)
    return status
