"""What a command is to do with its files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pcsmooth.cli.batch_table import Column
from pcsmooth.cli.options import Files

#: Works on one file: source, target, what it says, whether it shows a progress bar, and options;
#: returns its summary.
Work = Callable[..., dict[str, Any]]


@dataclass(frozen=True)
class FileTask:
    """What a command is to do with its files.

    Attributes
    ----------
    work : callable
        What to do with a file; a function that other processes can import.
    files : Files
        Which, and where results go; neither an output nor a folder if there are none.
    options : dict
        Further arguments of the work.
    quiet, verbose : bool
        Whether nothing but failures is told, and whether everything is.
    as_json : bool
        Whether a record of each file is printed on stdout.
    show : callable, optional
        Prints a summary on stdout, unless it is to be JSON.
    columns : tuple of Column
        What the table at the end of a batch says of each file.
    report : str or None
        Folder for the report on a batch.
    """

    work: Work
    files: Files
    options: dict[str, Any]
    quiet: bool = False
    verbose: bool = False
    as_json: bool = False
    show: Callable[[dict[str, Any]], None] | None = None
    columns: tuple[Column, ...] = ()
    report: str | None = None


@dataclass(frozen=True)
class ChosenOptions:
    """The options for a file.

    Attributes
    ----------
    options : dict
        Further arguments of the work.
    in_force : dict
        What decides on the result, as JSON, by the names of the options.
    """

    options: dict[str, Any]
    in_force: dict[str, Any]
