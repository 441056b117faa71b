"""Tables made row by row."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pcsmooth_experiments.experiment import Table


def table_of(names: Sequence[str], rows: Iterable[Sequence[object]]) -> Table:
    """Turn rows into columns of these names.

    Raises
    ------
    ValueError
        If a row has more or fewer entries, or there is none.
    """
    columns = list(zip(*rows, strict=True))
    return {name: np.array(column) for name, column in zip(names, columns, strict=True)}
