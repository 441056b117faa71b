"""Facet of a 3D restricted cell: a convex polygon in a bisector plane, inside a disk.

The bisector plane of p_i and p_j meets the ball in a disk of radius rho about the foot O of the
perpendicular from p_i. Every other neighbour k cuts the plane along a line; the facet is what
the half-planes leave of the disk. Each facet is clipped on its own: nothing combinatorial is
shared between facets, so rounding on degenerate sets (grids, cospherical points) moves a
measure by rounding only.
"""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.angle_sum import add_angle, total_angle
from pcsmooth.kernels.cells.radical_planes import difference_of_squares
from pcsmooth.kernels.compiled import inner

#: Half side of the square that a facet's polygon starts from, in units of rho. Anything above 1
#: keeps the square's own edges away from the disk.
_SQUARE = 1.0625

#: Width of a polygon, relative to its length, and extent, relative to its distance from O, that
#: rounding can feign.
_COLLAPSED = 1e-13

#: Planes this close, as an angle and in units of the radius, are one.
_SAME = 1e-10

#: Direction from which fans spread, no special one.
_ASIDE = (0.5376, 0.3123, math.sqrt(1.0 - 0.5376**2 - 0.3123**2))

#: Rows beside the positions of unequal balls: those of `place_neighbors`.
HALF_ROW = 3
RADIUS_ROW = 4
CHORD2_ROW = 5

#: A vertex nearer to O than the root of this, in units of rho, is placed by its edges, unless
#: they meet at an angle below _PARALLEL.
_NEAR = 1e-8
_PARALLEL = 1e-4


@inner
def facet_arrays(count):
    """Make room for the lines, vertices and edges of a facet among `count` neighbours."""
    return (
        np.empty((4, count + 8)),
        np.empty((2, 3, count + 8)),
        np.empty((2, count + 8), np.int64),
    )


@inner
def _tangent_frame(x, y, z):
    """Two unit vectors orthogonal to a unit vector and to each other (Duff et al. 2017)."""
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return (1.0 + sign * x * x * a, sign * b, -sign * x), (b, sign + y * y * a, -y)


@inner
def _clip(vertices, edges, source, count, lines, line):
    """Keep the side n . v <= level of a convex polygon.

    vertices (2, 3, capacity): two buffers with rows x, y, x^2 + y^2; edges (2, capacity): the
    line that leaves each vertex; lines (4, capacity): nx, ny, level; its row 3 is scratch.
    Returns (new buffer, new count, largest x^2 + y^2); the last is -1 if nothing was cut off.
    """
    nx = lines[0, line]
    ny = lines[1, line]
    level = lines[2, line]
    cut = False
    for v in range(count):
        lines[3, v] = nx * vertices[source, 0, v] + ny * vertices[source, 1, v] - level
        cut |= lines[3, v] > 0.0
    if not cut:
        return source, count, -1.0
    target = 1 - source
    new_count = 0
    reach2 = 0.0
    here = lines[3, 0]
    for v in range(count):
        w = v + 1 if v + 1 < count else 0
        there = lines[3, w]
        if here <= 0.0:
            vertices[target, 0, new_count] = vertices[source, 0, v]
            vertices[target, 1, new_count] = vertices[source, 1, v]
            vertices[target, 2, new_count] = vertices[source, 2, v]
            edges[target, new_count] = edges[source, v]
            reach2 = max(reach2, vertices[source, 2, v])
            new_count += 1
        if (here <= 0.0) != (there <= 0.0):
            t = here / (here - there)
            x = vertices[source, 0, v] + t * (vertices[source, 0, w] - vertices[source, 0, v])
            y = vertices[source, 1, v] + t * (vertices[source, 1, w] - vertices[source, 1, v])
            vertices[target, 0, new_count] = x
            vertices[target, 1, new_count] = y
            vertices[target, 2, new_count] = x * x + y * y
            edges[target, new_count] = line if here <= 0.0 else edges[source, v]
            reach2 = max(reach2, vertices[target, 2, new_count])
            new_count += 1
        here = there
    return target, new_count, reach2


@inner
def _sharpen(vertices, edges, source, count, lines, rho2):
    """Place the vertices nearest to O anew, where two edges' lines meet.

    Clipping places a vertex to within rounding of rho, which is too coarse in clusters much
    smaller than the ball.
    """
    for v in range(count):
        if vertices[source, 2, v] < _NEAR * rho2:
            e = edges[source, v - 1 if v > 0 else count - 1]
            f = edges[source, v]
            sine = lines[0, e] * lines[1, f] - lines[1, e] * lines[0, f]
            if abs(sine) > _PARALLEL:
                x = (lines[2, e] * lines[1, f] - lines[1, e] * lines[2, f]) / sine
                y = (lines[0, e] * lines[2, f] - lines[2, e] * lines[0, f]) / sine
                vertices[source, 0, v] = x
                vertices[source, 1, v] = y
                vertices[source, 2, v] = x * x + y * y


@inner
def _is_collapsed(vertices, source, count):
    """Whether clipping has left a sliver or a point, no wider than rounding.

    Its edges need no longer agree with its vertices, so nothing can be measured on it.
    """
    x0 = vertices[source, 0, 0]
    y0 = vertices[source, 1, 0]
    extent2 = 0.0
    doubled_area = 0.0
    dx1 = 0.0
    dy1 = 0.0
    for v in range(1, count):
        dx2 = vertices[source, 0, v] - x0
        dy2 = vertices[source, 1, v] - y0
        extent2 = max(extent2, dx2 * dx2 + dy2 * dy2)
        doubled_area += dx1 * dy2 - dx2 * dy1
        dx1, dy1 = dx2, dy2
    return doubled_area <= _COLLAPSED * extent2 or extent2 <= _COLLAPSED * _COLLAPSED * (
        x0 * x0 + y0 * y0
    )


@inner
def _measure_polygon_in_disk(
    vertices, edges, source, count, lines, rho, height, radius, radii, qu, q1, q2
):
    """Measure polygon and disk, O at the origin; vertices, edges and lines as in `_clip`.

    Returns (area, solid angle seen from height above O, visible angle of the circle, first
    moment x, y, integral of the vector from O over the visible angle x, y, angle of the fan). The
    boundary is walked once. Each edge inside the disk spans a triangle with O, whose solid angle is
    2 arg((R1 + h)(R2 + h) + P1 . P2 + i P1 x P2), R the distances from the apex (Van Oosterom and
    Strackee 1983); each arc spans a sector, of solid angle angle (1 - h / r).

    The height may be negative, and the angles are then, too. The fan consists of the arcs and of
    spherical triangles between their ends, the direction of O and a direction q of components qu,
    q1, q2. Whatever q is, the fans of a cell's facets make up what these hide of the sphere, up to
    full angles: their edges do not matter, though p_i may lie next to one. Only asked for if radii
    are unequal.

    The visible angle is the sum of the arcs where some edge passes within rho / 2 of O (no arc
    is then longer than 4 pi / 3), and a full turn less the edges' angles where none does (O is
    then well inside): each where it is well conditioned, also when arcs or edges shrink to
    nothing.
    """
    if _is_collapsed(vertices, source, count):
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0

    fan = 0.0
    above = height
    height = abs(height)
    rho2 = rho * rho
    doubled_area = 0.0
    mx = 0.0
    my = 0.0
    # The outward normals of all that bounds a facet add up to nothing.
    sx = 0.0
    sy = 0.0
    solid_re, solid_im, solid_half = 1.0, 0.0, 0
    arc_re, arc_im, arc_half = 1.0, 0.0, 0
    crossings = False
    pieces = 0
    first_x = first_y = exit_x = exit_y = 0.0
    open_arc = False

    least_level = rho
    for e in range(count):
        least_level = min(least_level, lines[2, edges[source, e]])
    wide = least_level >= 0.5 * rho

    x1 = vertices[source, 0, count - 1]
    y1 = vertices[source, 1, count - 1]
    inside1 = vertices[source, 2, count - 1] <= rho2
    for e_next in range(count):
        e = e_next - 1 if e_next > 0 else count - 1
        x2 = vertices[source, 0, e_next]
        y2 = vertices[source, 1, e_next]
        inside2 = vertices[source, 2, e_next] <= rho2
        nx = lines[0, edges[source, e]]
        ny = lines[1, edges[source, e]]
        level = lines[2, edges[source, e]]
        # The part of the edge in the disk: from start to end along the line, from its foot.
        start = nx * y1 - ny * x1
        end = nx * y2 - ny * x2
        starts_inside = inside1
        x1, y1, inside1 = x2, y2, inside2
        if not (starts_inside and inside2):
            is_chord = abs(level) < rho and start < 0.0 < end
            if not (starts_inside or inside2 or is_chord):
                continue
            # The line meets the circle at -half_chord and half_chord; a vertex outside goes to
            # the end on its side (also when rounding has put it beyond the wrong one).
            half_chord = math.sqrt(max(0.0, (rho - level) * (rho + level)))
            if not starts_inside:
                start = math.copysign(half_chord, start)
            if not inside2:
                end = math.copysign(half_chord, end)
        pieces += 1

        cross = level * (end - start)
        dot = level * level + start * end
        doubled_area += cross
        mx += cross * (2.0 * nx * level - ny * (start + end))
        my += cross * (2.0 * ny * level + nx * (start + end))
        if radii is not None:
            sx -= (end - start) * nx
            sy -= (end - start) * ny
        foot2 = height * height + level * level  # distance of the line from the apex, squared
        reach1 = math.sqrt(foot2 + start * start) if starts_inside else radius
        reach2 = math.sqrt(foot2 + end * end) if inside2 else radius
        if dot >= 0.0:
            real = (reach1 + height) * (reach2 + height) + dot
        else:  # the same without cancellation, for an edge that passes O closely at small height
            real = height * (reach1 + reach2 + height) + (
                height * height * (foot2 + level * level + start * start + end * end)
                + cross * cross
            ) / (reach1 * reach2 - dot)
        scale = 1.0 / ((reach1 + height) * (reach2 + height))
        solid_re, solid_im, solid_half = add_angle(
            solid_re, solid_im, solid_half, real * scale, cross * scale
        )

        if wide:
            arc_re, arc_im, arc_half = add_angle(arc_re, arc_im, arc_half, dot / rho2, cross / rho2)
        if not starts_inside:
            entry_x = nx * level - ny * start
            entry_y = ny * level + nx * start
            if radii is not None:
                fan -= _fan_angle(above, entry_x, entry_y, radius, qu, q1, q2)
            if open_arc:
                if not wide:
                    arc_re, arc_im, arc_half = _add_arc(
                        arc_re, arc_im, arc_half, exit_x, exit_y, entry_x, entry_y, rho2
                    )
                mx += 2.0 * rho2 * (entry_y - exit_y)
                my -= 2.0 * rho2 * (entry_x - exit_x)
                open_arc = False
            else:
                first_x, first_y = entry_x, entry_y
            crossings = True
        if not inside2:
            exit_x = nx * level - ny * end
            exit_y = ny * level + nx * end
            if radii is not None:
                fan += _fan_angle(above, exit_x, exit_y, radius, qu, q1, q2)
            open_arc = True

    if pieces == 0:
        if not wide:
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        full = 2.0 * math.pi
        solid = full * (1.0 - height / radius)
        fan = full * (1.0 - above / radius)
        solid = -solid if above < 0.0 else solid
        return math.pi * rho2, solid, full, 0.0, 0.0, 0.0, 0.0, fan
    if open_arc:
        if not wide:
            arc_re, arc_im, arc_half = _add_arc(
                arc_re, arc_im, arc_half, exit_x, exit_y, first_x, first_y, rho2
            )
        mx += 2.0 * rho2 * (first_y - exit_y)
        my -= 2.0 * rho2 * (first_x - exit_x)
    visible_angle = 0.0
    if crossings:
        visible_angle = total_angle(arc_re, arc_im, arc_half)
        if wide:
            visible_angle = max(0.0, 2.0 * math.pi - visible_angle)
    area = 0.5 * (doubled_area + rho2 * visible_angle)
    solid = 2.0 * total_angle(solid_re, solid_im, solid_half)
    solid += visible_angle * (1.0 - height / radius)
    # Moment of a triangle: cross (P1 + P2) / 6; of a sector: rho^2 (dy, -dx) / 3.
    if visible_angle == 0.0:
        sx = 0.0
        sy = 0.0
    solid = -solid if above < 0.0 else solid
    fan += visible_angle * (1.0 - above / radius)
    return area, solid, visible_angle, mx / 6.0, my / 6.0, sx, sy, fan


@inner
def _fan_angle(height, x, y, radius, qu, q1, q2):
    """Solid angle of the spherical triangle from q over a point of the circle to O's direction."""
    along = height / radius
    x /= radius
    y /= radius
    return 2.0 * math.atan2(q1 * y - q2 * x, 1.0 + along + qu + qu * along + q1 * x + q2 * y)


@inner
def _add_arc(re, im, half_turns, x1, y1, x2, y2, rho2):
    """Add the counter-clockwise angle, at most 4 pi / 3, from one point of the circle to another.

    Rounding can make an empty arc slightly negative; it is then left out.
    """
    cosine = (x1 * x2 + y1 * y2) / rho2
    sine = (x1 * y2 - y1 * x2) / rho2
    if sine < 0.0:
        if cosine > 0.0:
            return re, im, half_turns
        half_turns += 2  # the factor's own angle is the arc less a full turn
    return add_angle(re, im, half_turns, cosine, sine)


@inner
def measure_polygon(xi, yi, zi, j, count, near, radius, radii, lines, vertices, edges):
    """Measure F_ij, the part of the bisector of p_i and p_j in both restricted cells.

    Parameters: p_i; the first `count` neighbours in near (3, >= count), p_j being number j, if
    radii are unequal with rows beside them (6, >= count); r_i; whether they are; lines,
    vertices and edges from `facet_arrays`.
    Returns (height over p_i, area, solid angle seen from p_i, weight of u in the area's gradient,
    first moment about O: x, y, z, what the area's gradient has across u: x, y, z, angle of the
    fan).
    """
    empty = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    xj = near[0, j]
    yj = near[1, j]
    zj = near[2, j]
    ux = xj - xi
    uy = yj - yi
    uz = zj - zi
    square = ux * ux + uy * uy + uz * uz
    distance = math.sqrt(square)
    height = 0.5 * distance
    other_height = height
    other_radius = radius
    rho2 = (radius - height) * (radius + height)
    if radii is not None:
        height = near[HALF_ROW, j] / distance
        other_radius = near[RADIUS_ROW, j]
        other_height = 0.5 * (distance + difference_of_squares(other_radius, radius) / distance)
        rho2 = near[CHORD2_ROW, j]
    if rho2 <= 0.0:
        return empty
    rho = math.sqrt(rho2)
    e1, e2 = _tangent_frame(ux / distance, uy / distance, uz / distance)
    # Lines a . v <= b in the plane that meet the disk; many facets are seen to be empty here.
    n_lines = 0
    for k in range(count):
        wx = near[0, k] - xj
        wy = near[1, k] - yj
        wz = near[2, k] - zj
        b = 0.5 * ((near[0, k] - xi) * wx + (near[1, k] - yi) * wy + (near[2, k] - zi) * wz)
        a1 = wx * e1[0] + wy * e1[1] + wz * e1[2]
        a2 = wx * e2[0] + wy * e2[1] + wz * e2[2]
        if radii is not None:
            b += _radical_shift(xi, yi, zi, j, k, near, radius, square)
            square_k = (near[0, k] - xi) ** 2 + (near[1, k] - yi) ** 2 + (near[2, k] - zi) ** 2
            if a1 * a1 + a2 * a2 < _SAME * _SAME * square_k and (
                b * b < _SAME * _SAME * square_k * radius * radius
            ):
                # One plane for both, as of balls that share a circle: the near one takes the
                # facet. (If they are on both sides of p_i, its cell is flat.)
                along = (near[0, k] - xi) * ux + (near[1, k] - yi) * uy + (near[2, k] - zi) * uz
                if along > 0.0 and square_k < square:
                    return empty
                continue
        if b * b >= rho2 * (a1 * a1 + a2 * a2):
            if b >= 0.0:  # beyond the disk; also k == j, where a = 0 and b = 0
                continue
            return empty
        lines[0, n_lines] = a1
        lines[1, n_lines] = a2
        lines[2, n_lines] = b
        n_lines += 1

    side = _SQUARE * rho
    for v in range(4):
        vertices[0, 0, v] = side if v == 0 or v == 3 else -side
        vertices[0, 1, v] = side if v < 2 else -side
        vertices[0, 2, v] = 2.0 * side * side
        edges[0, v] = n_lines + v
        lines[0, n_lines + v] = 1.0 if v == 3 else (-1.0 if v == 1 else 0.0)
        lines[1, n_lines + v] = 1.0 if v == 0 else (-1.0 if v == 2 else 0.0)
        lines[2, n_lines + v] = side
    source = np.int64(0)  # not literals, for which numba would compile all below twice
    corners = np.int64(4)
    reach2 = rho2
    for k in range(n_lines):
        a1 = lines[0, k]
        a2 = lines[1, k]
        b = lines[2, k]
        norm2 = a1 * a1 + a2 * a2
        if b > 0.0 and b * b >= reach2 * norm2:
            continue
        scale = 1.0 / math.sqrt(norm2)
        lines[0, k] = a1 * scale
        lines[1, k] = a2 * scale
        lines[2, k] = b * scale
        source, corners, farthest2 = _clip(vertices, edges, source, corners, lines, k)
        if corners < 3:
            return empty
        if farthest2 >= 0.0:
            reach2 = min(rho2, farthest2)

    _sharpen(vertices, edges, source, corners, lines, rho2)
    qu = 0.0
    q1 = 0.0
    q2 = 0.0
    if radii is not None:
        qu = (_ASIDE[0] * ux + _ASIDE[1] * uy + _ASIDE[2] * uz) / distance
        q1 = _ASIDE[0] * e1[0] + _ASIDE[1] * e1[1] + _ASIDE[2] * e1[2]
        q2 = _ASIDE[0] * e2[0] + _ASIDE[1] * e2[1] + _ASIDE[2] * e2[2]
    area, solid, visible_angle, mx, my, sx, sy, fan = _measure_polygon_in_disk(
        vertices, edges, source, corners, lines, rho, height, radius, radii, qu, q1, q2
    )
    rim = radius * visible_angle
    across = 0.0
    if radii is not None:
        rim = visible_angle * (radius * other_height + other_radius * height) / distance
        across = (radius - other_radius) / distance
    return (
        height,
        area,
        solid,
        rim,
        mx * e1[0] + my * e2[0],
        mx * e1[1] + my * e2[1],
        mx * e1[2] + my * e2[2],
        across * (sx * e1[0] + sy * e2[0]),
        across * (sx * e1[1] + sy * e2[1]),
        across * (sx * e1[2] + sy * e2[2]),
        fan,
    )


@inner
def _radical_shift(xi, yi, zi, j, k, near, radius, square):
    """Find what unequal radii add to the level of the line that p_k's plane cuts p_j's in.

    square: |u_j|^2. The same from p_i and from p_j.
    """
    if j == k:
        return 0.0
    own = near[RADIUS_ROW, j]
    is_smaller = own < radius  # then p_j's ball takes p_i's part
    along = 0.0
    for axis in range(3):
        here = xi if axis == 0 else (yi if axis == 1 else zi)
        start = here if is_smaller else near[axis, j]
        along += (near[axis, k] - start) * (near[axis, j] - here)
    gain = difference_of_squares(radius if is_smaller else own, near[RADIUS_ROW, k])
    return 0.5 * (gain - along / square * difference_of_squares(radius, own))
