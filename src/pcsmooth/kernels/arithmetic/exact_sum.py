"""Sums of products of floats without any rounding, for the signs that decide combinatorics.

A sum is kept as an expansion: floats of increasing size that do not overlap, so that the last one
has the sign of the whole; see J. R. Shewchuk, "Adaptive precision floating-point arithmetic and
fast robust geometric predicates", Discrete Comput. Geom. 18 (1997), grow-expansion.
"""

from pcsmooth.kernels.arithmetic.double_double import product_of, sum_of
from pcsmooth.kernels.compiled import inner


@inner
def add_exactly(expansion, n, value):
    """Add a float to an expansion of n floats; returns how many there are then."""
    rest = value
    kept = 0
    for k in range(n):
        rest, low = sum_of(rest, expansion[k])
        if low != 0.0:
            expansion[kept] = low
            kept += 1
    if rest != 0.0:
        expansion[kept] = rest
        kept += 1
    return kept


@inner
def add_product(expansion, n, a, b, c, d):
    """Add the product of four floats to an expansion of n floats; returns how many there are."""
    ab = product_of(a, b)
    cd = product_of(c, d)
    for p in ab:
        for q in cd:
            high, low = product_of(p, q)
            n = add_exactly(expansion, n, low)
            n = add_exactly(expansion, n, high)
    return n
