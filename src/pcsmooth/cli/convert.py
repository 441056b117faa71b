"""`pcsmooth convert`: read a cloud and write it in another format."""

from __future__ import annotations

from typing import Literal

import click

from pcsmooth.cli.messages import speaker
from pcsmooth.cli.options import (
    dimension_option,
    input_argument,
    output_option,
    overwrite_option,
    position_type_option,
    quiet_option,
)


@click.command()
@input_argument
@output_option
@position_type_option
@dimension_option
@overwrite_option
@quiet_option
def convert(
    input_path: str,
    output_path: str,
    single: bool | None,
    dim: Literal["auto", 2, 3],
    overwrite: bool,
    quiet: bool,
) -> None:
    """Write the point cloud INPUT (PLY, LAS, PCD, E57, mesh or text; - is stdin) as OUTPUT.

    Row i of OUTPUT is row i of the input with all that its format can hold; stderr says what it
    cannot, and how far it rounds the positions.

    \b
    Examples:
      pcsmooth convert station.e57 -o station.laz
      pcsmooth convert scan.laz -o scan.ply
      pcsmooth convert points.pcd -o points.csv --overwrite
    """
    import numpy as np

    from pcsmooth.cli.files import (
        check_output,
        check_writable,
        display_name,
        read_input,
        target_format,
        with_position_type,
        write_output,
    )
    from pcsmooth.formats import lost_in, stored_positions

    check_output(output_path, overwrite, as_json=False)
    say = speaker(quiet)
    cloud = read_input(input_path, dim)
    check_writable(cloud, output_path)
    target = target_format(cloud, output_path)
    cloud = with_position_type(cloud, target, single)
    lost = lost_in(cloud, target)
    if lost:
        say(f"warning: {target} files cannot hold {', '.join(lost)}")
    stored = stored_positions(cloud, target, output_path)
    if stored.note:
        say(stored.note)
    finite = np.isfinite(cloud.points)
    rounding = np.abs(stored.points[finite] - cloud.points[finite]).max(initial=0.0)
    if rounding > 0.0:
        say(f"{stored.kind} round these coordinates by up to {rounding:.2g}")
    write_output(cloud, output_path)
    say(f"{display_name(input_path)}: {len(cloud)} points written to {output_path}")
