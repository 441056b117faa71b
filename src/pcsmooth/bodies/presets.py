"""Bodies by name: those that are shipped, and those of a user's file."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.bodies.recipes import body_of
from pcsmooth.bodies.suggestions import suggestion
from pcsmooth.bodies.toml_files import read_toml
from pcsmooth.errors import CloudFileError, InvalidInputError

_SHIPPED = str(Path(__file__).with_name("presets.toml"))


#: Longest chain of presets that are based on each other.
_MOST_BASES = 100


@dataclass(frozen=True, eq=False)
class Preset:
    """A body by name.

    Attributes
    ----------
    name : str
        The head of its table.
    path : str
        The file that defines it.
    table : mapping
        What the file says about it.
    shelf : mapping of str to Preset
        Where its base is looked up.
    allow_outside : bool
        Whether its mesh may lie outside of the folder of the file.
    """

    name: str
    path: str
    table: Mapping[str, Any]
    shelf: Mapping[str, Preset]
    allow_outside: bool = False

    @property
    def description(self) -> str:
        """What the file says it is."""
        return str(self.table.get("description", ""))

    @property
    def source(self) -> str:
        """Where it is defined: "shipped" or the path of a file."""
        return "shipped" if self.path == _SHIPPED else self.path

    @cached_property
    def body(self) -> ConvexBody:
        """The body, made when it is first asked for.

        Raises
        ------
        CloudFileError
            If there is no such body; file, preset and fault are named.
        """
        try:
            self._check_bases()
            return body_of(
                self.table,
                Path(self.path).parent,
                lambda name: self.shelf[name].body,
                self.allow_outside,
            )
        except InvalidInputError as error:
            cause, _, remedy = str(error).partition("; ")
            raise CloudFileError(
                self.path, f"preset {self.name!r}: {cause}", remedy or "correct it"
            ) from error

    def _check_bases(self) -> None:
        chain = [self.name]
        while isinstance(base := self.shelf[chain[-1]].table.get("base"), str):
            if base not in self.shelf:
                raise InvalidInputError(
                    f"there is no preset {base!r} to base it on; {suggestion(base, self.shelf)}"
                )
            chain.append(base)
            if len(chain) - 1 > _MOST_BASES:
                raise InvalidInputError(
                    f"it is based on more than {_MOST_BASES} others, one on the next; "
                    "give one of them a shape"
                )
            if base in chain[:-1]:
                raise InvalidInputError(
                    f"it is based on itself: {' -> '.join(chain)}; give one of them a shape"
                )


def read_presets(
    path: str | os.PathLike[str] | None = None, *, allow_outside: bool = False
) -> Mapping[str, Preset]:
    """Read the presets that are shipped and those of a file.

    Parameters
    ----------
    path : str, PathLike or None
        A TOML file with a table for each body, as the shipped ``presets.toml``.
    allow_outside : bool
        Whether meshes may lie outside of the folder of the file.

    Returns
    -------
    mapping of str to Preset
        By name: first the shipped, then those of the file, whose bodies have all been made.

    Raises
    ------
    CloudFileError
        If the file cannot be read, defines a preset that is shipped, or one of its presets is
        wrong. It and its meshes must be files of 256 MB at most, no pipes or devices.
    """
    shelf: dict[str, Preset] = {}
    _put(shelf, _SHIPPED)
    if path is not None:
        for preset in _put(shelf, os.fspath(path), allow_outside):
            _ = preset.body  # so that its errors are found now
    return shelf


def load_presets(
    path: str | os.PathLike[str] | None = None, *, allow_outside: bool = False
) -> Mapping[str, ConvexBody]:
    """Load the bodies that are shipped and those of a file, by name.

    Parameters
    ----------
    path : str, PathLike or None
        A TOML file with a table for each body.
    allow_outside : bool
        Whether meshes may lie outside of the folder of the file.

    Returns
    -------
    mapping of str to ConvexBody
        First the shipped, each made when it is first asked for, then those of the file.

    Raises
    ------
    CloudFileError
        As `read_presets`.

    Examples
    --------
    >>> bodies = load_presets()
    >>> round(bodies["octahedron"].volume, 6)
    6.928203
    """
    return _Bodies(read_presets(path, allow_outside=allow_outside))


def find_preset(
    name: str,
    path: str | os.PathLike[str] | None = None,
    dimension: int | None = None,
    *,
    allow_outside: bool = False,
) -> Preset:
    """Find a preset by name.

    Parameters
    ----------
    name : str
        Of a shipped preset or one of the file.
    path : str, PathLike or None
        A TOML file with a table for each body.
    dimension : int or None
        Coordinates that its body must have; None allows any.
    allow_outside : bool
        Whether meshes may lie outside of the folder of the file.

    Raises
    ------
    InvalidInputError
        If there is no such preset, or it has another dimension.
    CloudFileError
        As `read_presets`.
    """
    presets = read_presets(path, allow_outside=allow_outside)
    if name not in presets:
        raise InvalidInputError(f"there is no preset {name!r}; {suggestion(name, presets)}")
    preset = presets[name]
    if dimension not in (None, preset.body.dimension):
        fitting = [other.name for other in presets.values() if other.body.dimension == dimension]
        raise InvalidInputError(
            f"preset {name!r} is a body in {preset.body.dimension}D, but the points have "
            f"{dimension} coordinates; use one of {', '.join(fitting)}"
        )
    return preset


class _Bodies(Mapping[str, ConvexBody]):
    """The bodies of presets."""

    def __init__(self, presets: Mapping[str, Preset]) -> None:
        self._presets = presets

    def __getitem__(self, name: str) -> ConvexBody:
        return self._presets[name].body

    def __iter__(self) -> Iterator[str]:
        return iter(self._presets)

    def __len__(self) -> int:
        return len(self._presets)


def _put(shelf: dict[str, Preset], path: str, allow_outside: bool = False) -> list[Preset]:
    """Add the presets of a file to a shelf, and give them back."""
    tables = read_toml(path)
    for name, table in tables.items():
        if not isinstance(table, dict):
            raise CloudFileError(
                path, f"{name!r} stands outside of a table", f"write a table such as [{name}]"
            )
        if name in shelf:
            raise CloudFileError(
                path, f"preset {name!r} is shipped with pcsmooth", "choose another name"
            )
    presets = [Preset(name, path, table, shelf, allow_outside) for name, table in tables.items()]
    shelf.update((preset.name, preset) for preset in presets)
    return presets
