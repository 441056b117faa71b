"""Facet of a 3D restricted cell: a convex polygon in a bisector plane, inside a disk.

The bisector plane of p_i and p_j meets the ball in a disk of radius rho about the foot O of the
perpendicular from p_i. Every other neighbour k cuts the plane along a line; the facet is what
the half-planes leave of the disk. Each facet is clipped on its own: nothing combinatorial is
shared between facets, so rounding on degenerate sets (grids, cospherical points) moves a
measure by rounding only.
"""

import math

from numba import njit

from pcsmooth.kernels.angle_sum import add_angle, total_angle

#: Half side of the square that a facet's polygon starts from, in units of rho. Anything above 1
#: keeps the square's own edges away from the disk.
_SQUARE = 1.0625

#: Width of a polygon, relative to its length, and extent, relative to its distance from O, that
#: rounding can feign.
_COLLAPSED = 1e-13


@njit(cache=True, error_model="numpy", inline="always")
def _tangent_frame(x, y, z):
    """Two unit vectors orthogonal to a unit vector and to each other (Duff et al. 2017)."""
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return 1.0 + sign * x * x * a, sign * b, -sign * x, b, sign + y * y * a, -y


@njit(cache=True, error_model="numpy")
def _clip(polygon, source, target, count, nx, ny, level):
    """Keep the side n . v <= level of a convex polygon; returns the new number of vertices.

    polygon (2, 5, capacity): two buffers with rows x, y of the vertices and nx, ny, level of the
    edge that leaves each vertex. Nothing is written when no vertex is cut off (the count comes
    back negative then: the polygon is still in `source`).
    """
    p = polygon[source]
    q = polygon[target]
    last = count - 1
    any_out = False
    for v in range(count):
        if nx * p[0, v] + ny * p[1, v] > level:
            any_out = True
            break
    if not any_out:
        return -count
    new_count = 0
    here = nx * p[0, 0] + ny * p[1, 0] - level
    for v in range(count):
        w = v + 1 if v < last else 0
        there = nx * p[0, w] + ny * p[1, w] - level
        if here <= 0.0:
            for row in range(5):
                q[row, new_count] = p[row, v]
            new_count += 1
        if (here <= 0.0) != (there <= 0.0):
            t = here / (here - there)
            q[0, new_count] = p[0, v] + t * (p[0, w] - p[0, v])
            q[1, new_count] = p[1, v] + t * (p[1, w] - p[1, v])
            if here <= 0.0:
                q[2, new_count] = nx
                q[3, new_count] = ny
                q[4, new_count] = level
            else:
                q[2, new_count] = p[2, v]
                q[3, new_count] = p[3, v]
                q[4, new_count] = p[4, v]
            new_count += 1
        here = there
    return new_count


@njit(cache=True, error_model="numpy")
def _is_collapsed(p, count):
    """Whether clipping has left a sliver or a point, no wider than rounding.

    Its edges need no longer agree with its vertices, so nothing can be measured on it.
    """
    x0 = p[0, 0]
    y0 = p[1, 0]
    extent2 = 0.0
    doubled_area = 0.0
    dx1 = 0.0
    dy1 = 0.0
    for v in range(1, count):
        dx2 = p[0, v] - x0
        dy2 = p[1, v] - y0
        extent2 = max(extent2, dx2 * dx2 + dy2 * dy2)
        doubled_area += dx1 * dy2 - dx2 * dy1
        dx1, dy1 = dx2, dy2
    return doubled_area <= _COLLAPSED * extent2 or extent2 <= _COLLAPSED * _COLLAPSED * (
        x0 * x0 + y0 * y0
    )


@njit(cache=True, error_model="numpy")
def _measure_polygon_in_disk(p, count, rho, height, radius):
    """Measure polygon and disk: rows of p as in `_clip`, O at the origin.

    Returns (area, solid angle seen from height above O, visible angle of the circle, first
    moment x, y). The boundary is walked once. Each edge inside the disk spans a triangle with O,
    whose solid angle is 2 arg((R1 + h)(R2 + h) + P1 . P2 + i P1 x P2), R the distances from the
    apex (Van Oosterom and Strackee 1983); each arc spans a sector, of solid angle
    angle (1 - h / r).

    The visible angle is the sum of the arcs where some edge passes within rho / 2 of O (no arc
    is then longer than 4 pi / 3), and a full turn less the edges' angles where none does (O is
    then well inside): each where it is well conditioned, also when arcs or edges shrink to
    nothing.
    """
    rho2 = rho * rho
    least_level = rho
    doubled_area = 0.0
    mx = 0.0
    my = 0.0
    solid_re, solid_im, solid_half = 1.0, 0.0, 0
    arc_re, arc_im, arc_half = 1.0, 0.0, 0
    crossings = False
    pieces = 0
    first_x = first_y = exit_x = exit_y = 0.0
    open_arc = False

    for e in range(count):
        least_level = min(least_level, p[4, e])
    wide = least_level >= 0.5 * rho
    if _is_collapsed(p, count):
        return 0.0, 0.0, 0.0, 0.0, 0.0

    x1 = p[0, count - 1]
    y1 = p[1, count - 1]
    inside1 = x1 * x1 + y1 * y1 <= rho2
    for e_next in range(count):
        e = e_next - 1 if e_next > 0 else count - 1
        x2 = p[0, e_next]
        y2 = p[1, e_next]
        inside2 = x2 * x2 + y2 * y2 <= rho2
        nx = p[2, e]
        ny = p[3, e]
        level = p[4, e]
        starts_inside = inside1
        ax, ay = x1, y1
        bx, by = x2, y2
        x1, y1, inside1 = x2, y2, inside2
        if not (starts_inside and inside2):
            along1 = nx * ay - ny * ax
            along2 = nx * by - ny * bx
            is_chord = abs(level) < rho and along1 < 0.0 < along2
            if not (starts_inside or inside2 or is_chord):
                continue
            # The line meets the circle at -half_chord and half_chord; a vertex outside goes to
            # the end on its side (also when rounding has put it beyond the wrong one).
            half_chord = math.sqrt(max(0.0, (rho - level) * (rho + level)))
            if not starts_inside:
                along = math.copysign(half_chord, along1)
                ax = nx * level - ny * along
                ay = ny * level + nx * along
            if not inside2:
                along = math.copysign(half_chord, along2)
                bx = nx * level - ny * along
                by = ny * level + nx * along
        pieces += 1

        cross = ax * by - ay * bx
        doubled_area += cross
        mx += cross * (ax + bx)
        my += cross * (ay + by)
        reach1 = height + (
            math.sqrt(height * height + ax * ax + ay * ay) if starts_inside else radius
        )
        reach2 = height + (math.sqrt(height * height + bx * bx + by * by) if inside2 else radius)
        scale = 1.0 / (reach1 * reach2)
        solid_re, solid_im, solid_half = add_angle(
            solid_re, solid_im, solid_half, 1.0 + (ax * bx + ay * by) * scale, cross * scale
        )

        if wide:
            arc_re, arc_im, arc_half = add_angle(
                arc_re, arc_im, arc_half, (ax * bx + ay * by) / rho2, cross / rho2
            )
        if not starts_inside:
            if open_arc:
                if not wide:
                    arc_re, arc_im, arc_half = _add_arc(
                        arc_re, arc_im, arc_half, exit_x, exit_y, ax, ay, rho2
                    )
                mx += 2.0 * rho2 * (ay - exit_y)
                my -= 2.0 * rho2 * (ax - exit_x)
                open_arc = False
            else:
                first_x, first_y = ax, ay
            crossings = True
        if not inside2:
            exit_x, exit_y = bx, by
            open_arc = True

    if pieces == 0:
        if not wide:
            return 0.0, 0.0, 0.0, 0.0, 0.0
        full = 2.0 * math.pi
        return math.pi * rho2, full * (1.0 - height / radius), full, 0.0, 0.0
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
    return area, solid, visible_angle, mx / 6.0, my / 6.0


@njit(cache=True, error_model="numpy", inline="always")
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


@njit(cache=True, error_model="numpy")
def measure_polygon(xi, yi, zi, j, count, x, y, z, radius, lines, polygon):
    """Measure F_ij, the part of the bisector of p_i and p_j in both restricted cells.

    Parameters: p_i; the neighbours x, y, z (the first `count`, nearest first, p_j being number
    j); r; scratch lines (3, >= count) and polygon (2, 5, >= count + 8).
    Returns (area, solid angle seen from p_i, weight of u in the area's gradient r phi, first
    moment about O: x, y, z).
    """
    xj = x[j]
    yj = y[j]
    zj = z[j]
    ux = xj - xi
    uy = yj - yi
    uz = zj - zi
    distance = math.sqrt(ux * ux + uy * uy + uz * uz)
    height = 0.5 * distance
    rho2 = (radius - height) * (radius + height)
    if rho2 <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    e1x, e1y, e1z, e2x, e2y, e2z = _tangent_frame(ux / distance, uy / distance, uz / distance)

    # Lines a . v <= b in the plane; most far facets are seen to be empty here.
    n_lines = 0
    for k in range(count):
        wx = x[k] - xj
        wy = y[k] - yj
        wz = z[k] - zj
        b = 0.5 * ((x[k] - xi) * wx + (y[k] - yi) * wy + (z[k] - zi) * wz)
        a1 = wx * e1x + wy * e1y + wz * e1z
        a2 = wx * e2x + wy * e2y + wz * e2z
        if b * b >= rho2 * (a1 * a1 + a2 * a2):
            if b >= 0.0:  # beyond the disk; also k == j, where a = 0 and b = 0
                continue
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        lines[0, n_lines] = a1
        lines[1, n_lines] = a2
        lines[2, n_lines] = b
        n_lines += 1

    rho = math.sqrt(rho2)
    side = _SQUARE * rho
    vertices = 4
    for v in range(4):
        polygon[0, 0, v] = side if v == 0 or v == 3 else -side
        polygon[0, 1, v] = side if v < 2 else -side
        polygon[0, 2, v] = 1.0 if v == 3 else (-1.0 if v == 1 else 0.0)
        polygon[0, 3, v] = 1.0 if v == 0 else (-1.0 if v == 2 else 0.0)
        polygon[0, 4, v] = side
    source = 0
    reach2 = rho2
    for k in range(n_lines):
        a1 = lines[0, k]
        a2 = lines[1, k]
        b = lines[2, k]
        norm2 = a1 * a1 + a2 * a2
        if b > 0.0 and b * b >= reach2 * norm2:
            continue
        scale = 1.0 / math.sqrt(norm2)
        clipped = _clip(polygon, source, 1 - source, vertices, a1 * scale, a2 * scale, b * scale)
        if clipped < 0:
            continue
        if clipped < 3:
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        vertices = clipped
        source = 1 - source
        farthest2 = 0.0
        for v in range(vertices):
            vx = polygon[source, 0, v]
            vy = polygon[source, 1, v]
            farthest2 = max(farthest2, vx * vx + vy * vy)
        reach2 = min(rho2, farthest2)

    area, solid, visible_angle, mx, my = _measure_polygon_in_disk(
        polygon[source], vertices, rho, height, radius
    )
    return (
        area,
        solid,
        radius * visible_angle,
        mx * e1x + my * e2x,
        mx * e1y + my * e2y,
        mx * e1z + my * e2z,
    )
