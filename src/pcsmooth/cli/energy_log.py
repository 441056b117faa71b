"""The energy log: one row of CSV per state of a flow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, fields
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pcsmooth.denoise_result import Record


def write_energy_log(history: Iterable[Record], path: str) -> None:
    """Write iteration, volume, area, mean_move and max_move, to the last digit of a double."""
    from pcsmooth.denoise_result import Record
    from pcsmooth.formats.atomic import atomic_write
    from pcsmooth.formats.system_errors import named_system_errors

    lines = [",".join(field.name for field in fields(Record))]
    lines += [",".join(repr(value) for value in astuple(record)) for record in history]
    with named_system_errors(path), atomic_write(path) as file:
        file.write(("\n".join(lines) + "\n").encode())
