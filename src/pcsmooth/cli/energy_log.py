"""The energy log: one row of CSV per state of a flow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, fields
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pcsmooth.files.notes import Say
    from pcsmooth.record import Record


def write_energy_log(history: Iterable[Record], path: str, overwrite: bool, say: Say) -> None:
    """Write iteration, volume, area, mean_move and max_move, to the last digit of a double."""
    from pcsmooth.cli.files import write_beside
    from pcsmooth.record import Record

    lines = [",".join(field.name for field in fields(Record))]
    lines += [",".join(repr(value) for value in astuple(record)) for record in history]
    write_beside(("\n".join(lines) + "\n").encode(), path, overwrite, say)
