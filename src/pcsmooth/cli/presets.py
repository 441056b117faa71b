"""`pcsmooth presets`: the bodies that have a name, and one of them as a mesh."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.messages import speaker
from pcsmooth.cli.options import (
    STANDARD_STREAM,
    Named,
    json_option,
    overwrite_option,
    presets_options,
)
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from pcsmooth.bodies.presets import Preset

#: Facets that are shown one by one.
_MOST_SHOWN = 20


@click.command(short_help="List the convex bodies that can stand for the ball.")
@click.argument("name", required=False)
@presets_options
@click.option(
    "-o",
    "--output",
    "output_path",
    type=Named(),
    metavar="MESH",
    help="File to write the body NAME to, as triangles (.ply .stl .obj .off).",
)
@overwrite_option
@json_option
def presets(
    name: str | None,
    presets_path: str | None,
    allow_outside: bool,
    output_path: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """List the convex bodies that can stand for the ball, or describe the body NAME.

    Each holds the origin strictly inside; the radii are those of the balls around the origin
    that just fit inside and around. Lengths are multiples of the radius.

    \b
    Examples:
      pcsmooth presets
      pcsmooth presets dodecahedron -o dodecahedron.stl
      pcsmooth presets --presets bodies.toml --json | jq -r '.presets[].name'
    """
    from pcsmooth.bodies.presets import find_preset, read_presets

    if output_path is not None and name is None:
        raise click.UsageError("-o needs the NAME of a body")
    if output_path == STANDARD_STREAM:
        raise click.UsageError("-o needs the name of a file")
    if name is None:
        shelf = read_presets(presets_path, allow_outside=allow_outside)
        found = [_facts(preset) for preset in shelf.values()]
        click.echo(json.dumps({"presets": found}) if as_json else _table(found))
        return
    preset = find_preset(name, presets_path, allow_outside=allow_outside)
    if output_path is not None:
        _export(preset, output_path, overwrite)
    details = {
        "description": preset.description,
        **_facts(preset),
        "volume": preset.body.volume,
        "normals": preset.body.normals.tolist(),
        "offsets": preset.body.offsets.tolist(),
    }
    click.echo(json.dumps(details) if as_json else _described(details))


def _export(preset: Preset, path: str, overwrite: bool) -> None:
    from pcsmooth.bodies.mesh_files import write_mesh
    from pcsmooth.cli.files import attribute_teller
    from pcsmooth.files.notes import remove_left_over
    from pcsmooth.files.targets import check_target

    say = speaker(quiet=False)
    check_target(path, overwrite)
    remove_left_over(os.path.dirname(os.path.realpath(path)), say)
    write_mesh(preset.body, path, overwrite=overwrite, tell=attribute_teller(path, say))


def _facts(preset: Preset) -> dict[str, Any]:
    body = preset.body
    return {
        "name": preset.name,
        "dimension": body.dimension,
        "facets": len(body.facets),
        "vertices": len(body.vertices),
        "symmetric": body.is_symmetric,
        "inradius": body.inradius,
        "circumradius": body.circumradius,
        "defined_in": preset.source,
    }


def _table(presets: list[dict[str, Any]]) -> str:
    """Lay facts out in columns, numbers to the right."""
    rows = [[*map(_readable, preset.values())] for preset in presets]
    head = [name.replace("_", " ") for name in presets[0]]
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    is_text = [isinstance(value, str) for value in presets[0].values()]
    return "\n".join(
        "  ".join(
            entry.ljust(width) if text else entry.rjust(width)
            for entry, width, text in zip(row, widths, is_text, strict=True)
        ).rstrip()
        for row in [head, *rows]
    )


def _described(details: dict[str, Any]) -> str:
    half_spaces = list(zip(details.pop("normals"), details.pop("offsets"), strict=True))
    width = max(map(len, details))
    lines = [
        f"{name.replace('_', ' '):<{width}}  {_readable(value)}".rstrip()
        for name, value in details.items()
    ]
    lines.append("normal . x <= offset:")
    for normal, offset in half_spaces[:_MOST_SHOWN]:
        entries = "".join(f"{entry:>13.9f}" for entry in normal)
        lines.append(f"{entries}  <= {offset:.10g}")
    if len(half_spaces) > _MOST_SHOWN:
        lines.append(f"  and {len(half_spaces) - _MOST_SHOWN} more, which --json shows")
    return "\n".join(lines)


def _readable(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else printable(str(value))
