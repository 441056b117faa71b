"""Pages of commands as their help has them: examples as they are typed, options in groups."""

from __future__ import annotations

import click
from sphinx.application import Sphinx

from pcsmooth.cli.help import COMMON, options_by_group

_OPTION = ".. option:: "

#: Lines that are not of the help, and have a markup of their own.
_MARKED = {"**Required**"}


def _as_typed(_app: Sphinx, _context: click.Context, lines: list[str]) -> None:
    """Make literal blocks of examples, which come as lines of a line block."""
    found: list[str] = []
    for line in lines:
        if line.startswith("| ") and line.endswith(":"):
            found += [f"{line.removeprefix('| ')}", "", ".. code-block:: sh", ""]
        elif line.startswith("| "):
            found.append(f"   {line.removeprefix('| ').strip()}")
        else:
            found.append(line)
    lines[:] = found


def _in_groups(_app: Sphinx, context: click.Context, lines: list[str]) -> None:
    """Put options under the titles of their groups; what help says is plain text."""
    blocks: dict[str, list[str]] = {}
    for line in (line if line.strip() in _MARKED else line.replace("*", r"\*") for line in lines):
        if line.startswith(_OPTION):
            name = line
            blocks[name] = []
        blocks[name].append(line)

    def block_of(option: click.Option) -> list[str]:
        spelled = {*option.opts, *option.secondary_opts}
        for head, block in blocks.items():
            words = head.removeprefix(_OPTION).replace(",", " ").replace("/", " ").split()
            if spelled & set(words):
                return block
        return []  # --help, which is on every page

    found: list[str] = []
    for title, options in options_by_group(context.command, context).items():
        if title != COMMON:
            found += [f".. rubric:: {title}", ""]
        for option in options:
            found += block_of(option)
    lines[:] = found


def setup(app: Sphinx) -> dict[str, bool]:
    """Listen to what makes the pages of commands."""
    app.connect("sphinx-click-process-description", _as_typed)
    app.connect("sphinx-click-process-options", _in_groups)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
