"""Steps of the method of conjugate gradients for M + f L, L a weighted graph Laplacian.

Vectors are arrays (n, 3), a right-hand side a column, real or complex. Sums over all rows are
returned as sums over blocks of fixed size, so that they do not depend on the number of threads.
"""

from pcsmooth.kernels.compiled import kernel
from pcsmooth.kernels.threads import MANY, shared_out

#: Rows per block.
BLOCK = 4096


@shared_out("sums", 2)
@kernel("i1 j1 f1 f1 f b1 f2 f2 f2 i i", "i1 j1 f1 f1 z b1 z2 z2 z2 i i")
def multiply(
    starts, columns, weights, masses, factor, held, x, product, sums, first, last
):  # fmt: skip
    """Set product = (M + factor L) x, 0 in the rows that are held, and sums of x product.

    Rows of L: starts (n + 1,), columns and weights; diagonal of M (n,); x (n, 3) is 0 in the held
    rows; sums (blocks, 3).
    """
    n = masses.size
    for block in range(first, last):
        begin = block * BLOCK
        t0 = t1 = t2 = x[0, 0] * 0.0
        for i in range(begin, min(begin + BLOCK, n)):
            x0 = x[i, 0]
            x1 = x[i, 1]
            x2 = x[i, 2]
            s0 = s1 = s2 = x0 * 0.0
            for k in range(starts[i], starts[i + 1]):
                j = columns[k]
                w = weights[k]
                s0 += w * (x0 - x[j, 0])
                s1 += w * (x1 - x[j, 1])
                s2 += w * (x2 - x[j, 2])
            free = 0.0 if held[i] else 1.0
            s0 = free * (masses[i] * x0 + factor * s0)
            s1 = free * (masses[i] * x1 + factor * s1)
            s2 = free * (masses[i] * x2 + factor * s2)
            product[i, 0] = s0
            product[i, 1] = s1
            product[i, 2] = s2
            t0 += x0 * s0
            t1 += x1 * s1
            t2 += x2 * s2
        sums[block, 0] = t0
        sums[block, 1] = t1
        sums[block, 2] = t2


@shared_out("sums", 4)
@kernel("f1 f2 f2 f1 f1 f2 f2 f2 f1 f1 i i", "z1 z2 z2 z1 f1 z2 z2 z2 f1 f1 i i")
def advance(
    lengths, direction, product, inverse, masses, solution, residual, sums, errors, moves,
    first, last,
):  # fmt: skip
    """Go along the direction by the lengths (3,), and measure what is left.

    Residual r (n, 3), solution x; inverse (n,) of the diagonal D. Sets sums (blocks, 3) of
    r^T r / D, errors (blocks,) of abs(r)^2 / M and moves (blocks,) of M Re(x)^2.
    """
    n = masses.size
    for block in range(first, last):
        begin = block * BLOCK
        error = 0.0
        move = 0.0
        for column in range(3):
            sums[block, column] = 0.0
        for i in range(begin, min(begin + BLOCK, n)):
            square = 0.0
            length = 0.0
            for column in range(3):
                x = solution[i, column] + lengths[column] * direction[i, column]
                r = residual[i, column] - lengths[column] * product[i, column]
                solution[i, column] = x
                residual[i, column] = r
                sums[block, column] += r * inverse[i] * r
                square += r.real * r.real + r.imag * r.imag
                length += x.real * x.real
            error += square / masses[i]
            move += masses[i] * length
        errors[block] = error
        moves[block] = move


@shared_out("inverse", MANY)
@kernel("f1 f1 f2 f2 i i", "z1 z1 z2 z2 i i")
def turn_direction(ratios, inverse, residual, direction, first, last):
    """Set direction = residual / D + ratios (3,) direction."""
    for i in range(first, last):
        for column in range(3):
            direction[i, column] = (
                inverse[i] * residual[i, column] + ratios[column] * direction[i, column]
            )
