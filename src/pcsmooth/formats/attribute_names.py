"""Names of columns that beyond doubt are no coordinates."""

from __future__ import annotations

import re


def _any_of(words: str) -> str:
    return f"(?:{words.replace(' ', '|')})"


_WORDS = _any_of(
    "[abcgikrstvw] id fid oid nr no num n[xyz] v[xyz] k1 k2 sf rgba? std rms mse snr ok age "
    "day hour minute week year u[vw]"
)
_BEGINNINGS = _any_of(
    "point punkt pkt object objekt name code class klass label segment cluster group type kind "
    "art index idx number nummer count anzahl column row line ring scan station user "
    "intens reflect ampl echo return puls color colour rgb red green blue alpha gr[ae]y rot grun "
    "gruen grün blau gps time zeit date datum stamp second epoch "
    "normal curv krumm kruemm krümm confid displac outlier noise weight gewicht sigma err fehler "
    "accura genau prec varia covar qual valid flag state status fix hold mask edge "
    "range dist angle winkel azimut temp density dichte radius diameter size scalar veloc speed"
)

#: What makes a height of any name that it is in.
_HEIGHTS = _any_of("height elev hoehe höhe")

_NAME = re.compile(
    rf"(?!.*{_HEIGHTS})(?:.*[\W_])?(?:{_WORDS}|{_BEGINNINGS}.*)(?:[\W_].*)?",
    re.IGNORECASE | re.DOTALL,
)
_LONGEST = 60
"""Of longer names no more is looked at."""


def names_attribute(name: str) -> bool:
    """Whether a column is known, by a word in its name, to be no coordinate.

    Parameters
    ----------
    name : str
        What a file calls it.

    Examples
    --------
    >>> list(map(names_attribute, ["intensity", "GPS time", "PointID", "H_local", "point_height"]))
    [True, True, True, False, False]
    """
    return _NAME.fullmatch(name[:_LONGEST]) is not None
