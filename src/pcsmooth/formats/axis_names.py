"""Names that people give to the coordinates of points, in the languages of surveying."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from pcsmooth.cloud import NORMALS

_LONGEST = 60
"""Longer labels are no names of coordinates."""

_DEGREES = frozenset(["deg", "degs", "degree", "degrees", "°"])
_UNITS = _DEGREES | frozenset(
    [
        "m",
        "mm",
        "cm",
        "dm",
        "km",
        "meters",
        "metres",
        "meter",
        "metre",
        "ft",
        "feet",
        "foot",
        "usft",
        "ftus",
        "in",
        "inch",
        "inches",
        "yd",
    ]
)

#: Levels that heights refer to.
_LEVELS = "msl amsl nhn nn ngf ahd nap odn navd88 ngvd29 dhhn92 dhhn2016 egm96 egm2008"

_BEHIND_NAMES = _UNITS.union(_LEVELS.split())

#: A unit or a reference system in brackets, but not the index of Points[0].
_IN_BRACKETS = re.compile(r"[\[({<]([^\])}>]*[^\])}>\s\d][^\])}>]*)[\])}>]$")
_BETWEEN_WORDS = re.compile(r"[^a-z0-9°]+")
_NOT_DECOMPOSED = str.maketrans({"ø": "o", "ł": "l", "æ": "ae"})

#: What may stand before or behind the letter of an axis, as in POINT_X and x-coordinate.
_QUALIFIER = (
    "(?:points?|pt|coords?|coordinates?|koordinaten?|coordinata|coordonnee|coordenada|pos|position|"
    "vertex|location|loc|utm|local|global|world|scan|map|cartesian|values?){0,2}"
)
_NUMBERED = "(?:points?|coords?|coordinates?|pos|positions?|xyz)"


def _any_of(names: str, unit: str = ".*") -> re.Pattern[str]:
    """Match a key and its unit, as `_key` joins them."""
    return re.compile(f"(?:{names.replace(' ', '|')}):{unit}")


def _lettered(letter: str) -> re.Pattern[str]:
    return _any_of(f"{_QUALIFIER}{letter}{_QUALIFIER}")


#: What names heights; the next is asked only where the one before finds none.
_HEIGHTS = (
    _any_of("z", unit=""),
    _lettered("z"),
    _any_of(
        "elevations? elev ele heights? hgt h altitudes? alti? altitud altura hauteur hohe hoehe "
        "cota quota elevacion elevacao elevazione altezza hoogte hojd hoyde hojde kote korkeus "
        "wysokosc vyska visina magassag yukseklik rl cote up "
        "(?:ellipsoid(?:al|ische)?|ortho(?:metric)?)(?:height|hohe|elevation)"
    ),
    _any_of(_LEVELS),
    _any_of("depths? tiefe profondeur profundidade? profondita diepte djup dybde"),
)

_GEOGRAPHIC = (
    _any_of(
        "lon long lng longitude longitud longitudine laengengrad langengrad lengtegraad "
        "(?:geogr(?:aphische)?)(?:lange|laenge)"
    ),
    _any_of(
        "lat latitude latitud latitudine breitengrad breedtegraad (?:geogr(?:aphische)?)breite"
    ),
)

#: x, y and heights of the systems of coordinates, the first that a header names being taken.
_SYSTEMS: tuple[tuple[re.Pattern[str], re.Pattern[str], tuple[re.Pattern[str], ...]], ...] = (
    (_any_of("x", unit=""), _any_of("y", unit=""), _HEIGHTS),
    (_lettered("x"), _lettered("y"), _HEIGHTS),
    (_any_of(f"{_NUMBERED}0"), _any_of(f"{_NUMBERED}1"), (_any_of(f"{_NUMBERED}2"),)),
    (
        _any_of(
            "e east eastings? rechts rechtswert rw ost osten ostwert est este leste oest oost ita "
            "easting(?:utm|local|grid)"
        ),
        _any_of(
            "n north northings? hoch hochwert hw nord norden nordwert norte noord norr pohjoinen "
            "northing(?:utm|local|grid)"
        ),
        (*_HEIGHTS, _any_of("u")),
    ),
    (*_GEOGRAPHIC, _HEIGHTS),
)

_NORMALS = tuple(
    _any_of(f"n(?:ormals?)?{letter} normals?{digit}")
    for letter, digit in zip("xyz", "012", strict=True)
)


def _any_pattern(patterns: Iterable[re.Pattern[str]]) -> re.Pattern[str]:
    return re.compile("|".join(pattern.pattern for pattern in patterns))


_ANY_AXIS = _any_pattern(pattern for x, y, heights in _SYSTEMS for pattern in (x, y, *heights))
_ANY_NORMAL = _any_pattern(_NORMALS)


@dataclass(frozen=True)
class NamedAxes:
    """Columns whose names are those of coordinates.

    Attributes
    ----------
    candidates : tuple of list of int
        Indices of the columns named as x, as y and, if there is one, as z; empty unless x and y
        are named. Where there are several, there is no telling which it is.
    in_degrees : bool
        Whether the first two are longitude and latitude.
    """

    candidates: tuple[list[int], ...] = ()
    in_degrees: bool = False


def named_axes(labels: Sequence[str]) -> NamedAxes:
    """Find the columns of coordinates by their names.

    Parameters
    ----------
    labels : sequence of str
        Names of all columns, without quotes.

    Returns
    -------
    NamedAxes
        By plain x and y if there are such, else by those with units and the like, by Points:0 and
        so on, by eastings and northings, or by longitudes and latitudes.

    Examples
    --------
    >>> named_axes(["id", "Hochwert", "Rechtswert", "Höhe [m]"]).candidates
    ([2], [1], [3])
    >>> named_axes(["lon", "lat"]).in_degrees, named_axes(["x_old", "y_new"]).candidates
    (True, ())
    """
    keys = _keys(labels, _ANY_AXIS)
    for x, y, heights in _SYSTEMS:
        found = [_matching(keys, x), _matching(keys, y)]
        if not all(found):
            continue
        found += [named for z in heights if (named := _matching(keys, z))][:1]
        first = keys[found[0][0]]
        in_degrees = x is _GEOGRAPHIC[0] or first.partition(":")[2] in _DEGREES
        return NamedAxes(tuple(found), in_degrees)
    return NamedAxes()


def named_normals(labels: Sequence[str], dimension: int) -> tuple[int, ...]:
    """Find the columns of normals by their names.

    Parameters
    ----------
    labels : sequence of str
        Names of all columns, without quotes.
    dimension : {2, 3}
        Number of coordinates of a normal.

    Returns
    -------
    tuple of int
        Their indices; empty unless each is named once.

    Examples
    --------
    >>> named_normals(["x", "Normals:0", "Normals:1"], 2), named_normals(["nx"], 2)
    ((1, 2), ())
    """
    keys = _keys(labels, _ANY_NORMAL)
    found = [_matching(keys, pattern) for pattern in _NORMALS[:dimension]]
    return tuple(columns[0] for columns in found) if {*map(len, found)} == {1} else ()


def normals_among(names: Iterable[str]) -> dict[str, str]:
    """Find the names of a normal's coordinates in files whose columns all have a name.

    Parameters
    ----------
    names : iterable of str
        What a file calls its columns.

    Returns
    -------
    dict of str to str
        ``nx``, ``ny`` and ``nz``, as far as they are there, by the names in the file. Where these
        names themselves are there, no others count; where several could be meant, none does.

    Examples
    --------
    >>> normals_among(["x", "Normal_X", "Normal_Y", "Normal_Z"])
    {'Normal_X': 'nx', 'Normal_Y': 'ny', 'Normal_Z': 'nz'}
    """
    names = list(names)
    own = {normal: normal for normal in NORMALS if normal in names}
    if own:
        return own
    keys = _keys(names, _ANY_NORMAL)
    found = [_matching(keys, pattern) for pattern in _NORMALS]
    if max(map(len, found)) > 1:
        return {}
    return {
        names[column]: normal
        for columns, normal in zip(found, NORMALS, strict=True)
        for column in columns
    }


def _keys(labels: Sequence[str], pattern: re.Pattern[str]) -> dict[int, str]:
    """Keys of the labels that match a pattern, by their columns."""
    keys = enumerate(map(_key, labels))
    return {column: key for column, key in keys if pattern.fullmatch(key)}


def _matching(keys: Mapping[int, str], pattern: re.Pattern[str]) -> list[int]:
    return [column for column, key in keys.items() if pattern.fullmatch(key)]


def _key(label: str) -> str:
    """Bring a label to letters and digits, a colon, and the unit that it ends in.

    Examples
    --------
    >>> _key("X_m"), _key("Höhe [NHN]"), _key("Points:0"), _key("H_NN"), _key("Z (m) NAVD88")
    ('x:m', 'hohe:nhn', 'points0:', 'h:nn', 'z:m')
    """
    if len(label) > _LONGEST:
        return ":"
    name = label.strip().lower()
    if name.isalnum() and name.isascii():
        return f"{name}:"
    letters = unicodedata.normalize("NFKD", name.casefold().translate(_NOT_DECOMPOSED))
    name = "".join(letter for letter in letters if not unicodedata.combining(letter))
    unit = ""
    bracketed = _IN_BRACKETS.search(name)
    if bracketed:
        name, unit = name[: bracketed.start()], bracketed[1].strip()
    words = [word for word in _BETWEEN_WORDS.split(name) if word]
    while len(words) > 1 and words[-1] in _BEHIND_NAMES:
        unit = words.pop()
    return f"{''.join(words)}:{unit}"
