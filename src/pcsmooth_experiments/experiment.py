"""What an experiment is, and what comes out of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import CloudFileError
from pcsmooth.formats import read_cloud

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Verdict = Literal["agrees", "agrees in part", "disagrees", "goes beyond the thesis"]
Table = dict[str, npt.NDArray[Any]]


@dataclass(frozen=True)
class Inputs:
    """The thesis' own clouds.

    Attributes
    ----------
    folder : Path
        Where they lie.
    """

    folder: Path

    def has(self, name: str) -> bool:
        """Whether there is a file of this name."""
        return (self.folder / name).is_file()

    def points(self, name: str) -> npt.NDArray[np.float64]:
        """Read the positions of a cloud, (n, d).

        Raises
        ------
        CloudFileError
            If there is no such file, or it cannot be read.
        """
        path = self.folder / name
        if not path.is_file():
            raise CloudFileError(
                str(path), "it is not there", "name the folder of the thesis' clouds (--data)"
            )
        return read_cloud(path).points


@dataclass(frozen=True)
class Outcome:
    """What an experiment found.

    Attributes
    ----------
    verdict : str
        How it compares with the thesis.
    caption : str
        One line, with numbers: what the picture shows and whether it agrees with the thesis.
    draw : callable
        Makes the picture.
    tables : dict of str to dict of str to ndarray
        Name of a file of numbers, without suffix, to its columns, all of one length.
    explanation : str
        Why it disagrees, where it does, or what else there is to know; may be empty.
    """

    verdict: Verdict
    caption: str
    draw: Callable[[], Figure]
    tables: dict[str, Table] = field(default_factory=dict)
    explanation: str = ""


@dataclass(frozen=True)
class Experiment:
    """An experiment of the thesis.

    Attributes
    ----------
    name : str
        In commands and files: lower case, with hyphens.
    place : str
        Where it stands in the thesis, such as "Figures 24 and 25".
    title : str
        What is looked at.
    run : callable
        Does it.
    """

    name: str
    place: str
    title: str
    run: Callable[[Inputs], Outcome]
