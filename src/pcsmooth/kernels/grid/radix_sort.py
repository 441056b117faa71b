"""Stable parallel radix sort of pairs: rows of a key and what belongs to it."""

import numpy as np
import numpy.typing as npt

from pcsmooth.kernels.compiled import kernel
from pcsmooth.kernels.threads import shared_out

#: Pairs per block. The blocks are what the threads share out; a stable order is unique, so it
#: depends neither on their size nor on the number of threads.
BLOCK = 1 << 15

#: Widest digit: the places that a block writes to, one per digit, still fit a cache.
DIGIT_BITS = 12


def sort_pairs(pairs: npt.NDArray[np.int64], bits: int) -> npt.NDArray[np.int64]:
    """Sort pairs (n, 2) by their keys, 0 <= key < 2**bits, those of one key left in order.

    The array given is work space and may be the one returned.
    """
    n_passes = -(-bits // DIGIT_BITS)
    spare = np.empty_like(pairs)
    low = 0
    for left in range(n_passes, 0, -1):
        width = -(-(bits - low) // left)  # digits as even as can be
        _partition_pairs(pairs, low, width, spare)
        pairs, spare = spare, pairs
        low += width
    return pairs


def _partition_pairs(
    pairs: npt.NDArray[np.int64], low: int, width: int, parts: npt.NDArray[np.int64]
) -> None:
    """Copy pairs into parts by the digit of `width` bits from bit `low` of the key on."""
    counts = np.zeros((-(-len(pairs) // BLOCK), 1 << width), np.int64)
    _count_digits(pairs, low, counts)
    ends = np.cumsum(counts, axis=0)  # of a block among the pairs of one digit
    totals = ends[-1]
    _move_pairs(pairs, low, ends - counts + (np.cumsum(totals) - totals), parts)


@shared_out("counts")
@kernel("i2 i i2 i i")
def _count_digits(pairs, low, counts, first, last):
    """Count the digits of each block of pairs into counts (blocks, digits)."""
    mask = counts.shape[1] - 1
    for block in range(first, last):
        for i in range(block * BLOCK, min((block + 1) * BLOCK, pairs.shape[0])):
            counts[block, (pairs[i, 0] >> low) & mask] += 1


@shared_out("places")
@kernel("i2 i i2 i2 i i")
def _move_pairs(pairs, low, places, parts, first, last):
    """Move each pair to the next place of its digit in its block: places (blocks, digits)."""
    mask = places.shape[1] - 1
    for block in range(first, last):
        for i in range(block * BLOCK, min((block + 1) * BLOCK, pairs.shape[0])):
            digit = (pairs[i, 0] >> low) & mask
            place = places[block, digit]
            places[block, digit] = place + 1
            parts[place, 0] = pairs[i, 0]
            parts[place, 1] = pairs[i, 1]
