"""The direction in which a symmetric tensor is largest."""

import math

from pcsmooth.kernels.compiled import inner

#: A cross product of two rows below this share of its largest possible value is rounding.
_ROUNDING = 1e-12


@inner
def leading_direction(xx, xy, xz, yy, yz, zz):
    """Find a unit eigenvector of the largest eigenvalue of a positive semidefinite matrix.

    The eigenvalue is the largest root of the characteristic polynomial in trigonometric form, the
    eigenvector the largest cross product of two rows of what is left when it is subtracted. Where
    the two largest eigenvalues are equal, some direction of their plane; where all are or the
    trace is 0, there is none: 0.
    """
    trace = xx + yy + zz
    if not trace > 0.0:
        return 0.0, 0.0, 0.0
    share = 1.0 / trace
    xx *= share
    xy *= share
    xz *= share
    yy *= share
    yz *= share
    zz *= share
    mean = 1.0 / 3.0
    ax = xx - mean
    ay = yy - mean
    az = zz - mean
    square = ax * ax + ay * ay + az * az + 2.0 * (xy * xy + xz * xz + yz * yz)
    scale = math.sqrt(square / 6.0)
    if not scale > _ROUNDING:
        return 0.0, 0.0, 0.0
    determinant = ax * (ay * az - yz * yz) - xy * (xy * az - yz * xz) + xz * (xy * yz - ay * xz)
    cosine = min(1.0, max(-1.0, 0.5 * determinant / (scale * scale * scale)))
    largest = 2.0 * scale * math.cos(math.acos(cosine) / 3.0)
    ax -= largest
    ay -= largest
    az -= largest
    # Rows (ax, xy, xz), (xy, ay, yz), (xz, yz, az): their span lacks the direction wanted.
    x = xy * yz - xz * ay
    y = xz * xy - ax * yz
    z = ax * ay - xy * xy
    length2 = x * x + y * y + z * z
    u = xy * az - xz * yz
    v = xz * xz - ax * az
    w = ax * yz - xy * xz
    other2 = u * u + v * v + w * w
    if other2 > length2:
        x, y, z, length2 = u, v, w, other2
    u = ay * az - yz * yz
    v = yz * xz - xy * az
    w = xy * yz - ay * xz
    other2 = u * u + v * v + w * w
    if other2 > length2:
        x, y, z, length2 = u, v, w, other2
    if not length2 > _ROUNDING * _ROUNDING * square * square:
        # One row is left: anything perpendicular to it will do.
        u, v, w = ax, xy, xz
        if abs(ay) > max(abs(ax), abs(az)):
            u, v, w = xy, ay, yz
        elif abs(az) > abs(ax):
            u, v, w = xz, yz, az
        if abs(u) <= min(abs(v), abs(w)):
            x, y, z = 0.0, w, -v
        elif abs(v) <= abs(w):
            x, y, z = -w, 0.0, u
        else:
            x, y, z = v, -u, 0.0
        length2 = x * x + y * y + z * z
    length = math.sqrt(length2)
    return x / length, y / length, z / length
