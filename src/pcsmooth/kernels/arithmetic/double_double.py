"""Numbers of about 106 bits as pairs (high, low) of floats, low being what high leaves over.

Sums and products err by less than 1e-30 of their terms; see T. J. Dekker, "A floating-point
technique for extending the available precision", Numer. Math. 18 (1971).
"""

from pcsmooth.kernels.compiled import inner

#: Splits a float into two halves of 26 bits.
_SPLITTER = 134217729.0


@inner
def product_of(a, b):
    """Product of two floats, exact."""
    high = a * b
    scaled = _SPLITTER * a
    a_high = scaled - (scaled - a)
    a_low = a - a_high
    scaled = _SPLITTER * b
    b_high = scaled - (scaled - b)
    b_low = b - b_high
    low = a_low * b_low - (((high - a_high * b_high) - a_low * b_high) - a_high * b_low)
    return high, low


@inner
def sum_of(a, b):
    """Sum of two floats, exact."""
    high = a + b
    part = high - a
    return high, (a - (high - part)) + (b - part)


@inner
def add(a, b):
    """Sum of two pairs."""
    high, low = sum_of(a[0], b[0])
    more, rest = sum_of(a[1], b[1])
    high, low = sum_of(high, low + more)
    return sum_of(high, low + rest)


@inner
def subtract(a, b):
    """Difference of two pairs."""
    return add(a, (-b[0], -b[1]))


@inner
def multiply(a, b):
    """Product of two pairs."""
    high, low = product_of(a[0], b[0])
    return sum_of(high, low + (a[0] * b[1] + a[1] * b[0]))


@inner
def dot(a, b):
    """Scalar product of two vectors of three pairs."""
    return add(add(multiply(a[0], b[0]), multiply(a[1], b[1])), multiply(a[2], b[2]))


@inner
def cross(a, b):
    """Vector product of two vectors of three pairs."""
    return (
        subtract(multiply(a[1], b[2]), multiply(a[2], b[1])),
        subtract(multiply(a[2], b[0]), multiply(a[0], b[2])),
        subtract(multiply(a[0], b[1]), multiply(a[1], b[0])),
    )
