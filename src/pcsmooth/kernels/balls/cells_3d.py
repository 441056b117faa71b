"""Sums over the facets of a block of 3D cells, put together from the edges of the cells.

Cells near which that depends on a decision too close to call (cospherical and coplanar points,
points on a grid) are measured again, one by one, in a way that takes no such decision.

Counters that are handed on start as np.int64(0): for a literal 0 numba would compile whatever
takes them a second time.
"""

import math

import numpy as np

from pcsmooth.kernels.arithmetic.simd import (
    WIDTH,
    bits,
    everywhere,
    load,
    load_transposed,
    lowest_bit,
    multiply_add,
    select,
    square_root,
)
from pcsmooth.kernels.balls.cells_again import sum_cells_again
from pcsmooth.kernels.balls.facet_booking import (
    N_BOOKING_ROWS,
    N_MEASURES,
    book,
    book_outside,
    store_booking_terms,
)
from pcsmooth.kernels.balls.facet_table import (
    N_FACET_COLUMNS,
    N_LINK_COLUMNS,
    N_TERM_ROWS,
    NEXT,
    OTHER,
    OWNER,
    add_edges,
    find_facet,
    measure_facets,
    new_facet,
    signed_angle,
)
from pcsmooth.kernels.balls.voronoi_edges import (
    CLOSE,
    FIRST_PLACE,
    IS_TURNED,
    LEAST_GAP2,
    N_EDGE_ROWS,
    N_LINE_ROWS,
    RADII,
    SECOND_PLACE,
    TOLERANCE,
    add_lines,
    cut_lines,
    prepare_planes,
    split_edges,
)
from pcsmooth.kernels.cells.bounding_polyhedron import TOUCHING
from pcsmooth.kernels.cells.hidden_neighbors import sort_visible, thin_out
from pcsmooth.kernels.cells.radical_planes import (
    HALF,
    RADIUS,
    collect_radii,
    half_chord2,
    heights_over,
    place_neighbors,
    select_images,
)
from pcsmooth.kernels.compiled import inner
from pcsmooth.kernels.grid.grid import MOST_RANGES, adjacent_ranges, cell_of_point
from pcsmooth.kernels.grid.within_reach import (
    NUMBER,
    SQUARE,
    X,
    Y,
    Z,
    collect_points,
    count_points,
    neighbor_arrays,
    select_open,
    select_within_reach,
)

#: Lines that are gathered before they are cut.
_LINES_AT_ONCE = 64

#: Edges that are gathered before they are added to their facets.
_EDGES_AT_ONCE = 64

#: Facets that a block has room for at first.
_FACETS_AT_FIRST = 8192

#: A cell with more neighbours than this is not put together from edges: most of their bisectors
#: pass through one place, as those of points on a sphere do.
_MOST_NEIGHBORS = 256

#: A bisector nearer than this to the centre of a disk, in units of TOLERANCE, passes it.
_AT_CENTER = 1e-6


@inner
def sum_cells_3d(coordinates, cells, radius, radii, start, stop):
    """Sum over the facets of points start..stop-1; rows laid out as the measures they become."""
    sums = np.zeros((stop - start, N_MEASURES))
    unsure = np.zeros(stop - start, np.bool_)
    ranges = np.empty((2, MOST_RANGES), np.int64)
    capacity = np.int64(0)
    candidates, near, spare, hiders = neighbor_arrays(capacity)
    slots = np.empty(capacity, np.int64)
    lines = np.empty((N_LINE_ROWS, capacity))
    doubts = np.empty(capacity, np.bool_)
    edges = np.empty((N_EDGE_ROWS, capacity))
    edge_facets = np.empty((3, capacity), np.int64)
    n_edges = np.int64(0)
    n_columns = 2 * N_FACET_COLUMNS if radii is not None else N_FACET_COLUMNS
    edge_terms = np.empty((N_TERM_ROWS, n_columns))
    terms = np.empty((N_BOOKING_ROWS, N_MEASURES))
    facet_capacity = _FACETS_AT_FIRST
    facets = np.empty((facet_capacity + WIDTH, n_columns))
    links = np.empty((facet_capacity, N_LINK_COLUMNS), np.int64)
    heads = np.full(stop - start, -1)
    n_facets = np.int64(0)

    cell = cell_of_point(cells, start)
    while cell < cells.codes.size and cells.starts[cell] < stop:
        n_ranges = adjacent_ranges(cells, cell, 3, ranges)
        n_candidates = count_points(ranges, n_ranges)
        if n_candidates > capacity:
            add_edges(edges, edge_facets, n_edges, radius, radii, edge_terms, facets)
            n_edges = 0
            capacity = 2 * n_candidates
            candidates, near, spare, hiders = neighbor_arrays(capacity)
            slots = np.empty(capacity, np.int64)
            room = capacity + _LINES_AT_ONCE + 2 * WIDTH
            lines = np.empty((N_LINE_ROWS, room))
            doubts = np.empty(capacity, np.bool_)
            room += _EDGES_AT_ONCE
            edges = np.empty((N_EDGE_ROWS, room))
            edge_facets = np.empty((3, room), np.int64)
        collect_points(coordinates, ranges, n_ranges, candidates)
        if radii is not None:
            collect_radii(radii, candidates, n_candidates)
        for i in range(max(start, cells.starts[cell]), min(stop, cells.starts[cell + 1])):
            x = coordinates[0, i]
            y = coordinates[1, i]
            z = coordinates[2, i]
            if radii is not None:
                radius = radii[i]
                count, is_outside, is_crowded = select_images(
                    candidates, n_candidates, x, y, z, radius, LEAST_GAP2 * radius * radius, near
                )
                if is_outside:
                    book_outside(sums, i - start, 3)
            else:
                count = select_within_reach(candidates, n_candidates, x, y, z, 2.0 * radius, near)
                is_crowded = _is_crowded(near, count, radius)
            margin = (TOUCHING if is_crowded else 1.01 * CLOSE) * radius
            count = thin_out(near, count, radius, radii, margin, hiders)
            if is_crowded or count > _MOST_NEIGHBORS:
                doubts[:count] = True
                _mark_unsure(near, count, doubts, i, start, stop, unsure)
                continue
            count = sort_visible(near, count, radius, radii, spare, hiders)
            n_open = select_open(near, count, i, start, spare)
            if radii is not None:
                place_neighbors(coordinates, radii, i, near, count)
                place_neighbors(coordinates, radii, i, spare, n_open)
            prepare_planes(near, count, radius, radii)
            doubts[:n_open] = False
            _find_slots(links, heads, i, start, spare, n_open, slots)
            n_lines = np.int64(0)
            for j in range(n_open):
                n_lines = add_lines(
                    near, count, spare, n_open, j, radius, radii, lines, n_lines, doubts
                )
                if n_lines < _LINES_AT_ONCE and j < n_open - 1:
                    continue
                n_lines = cut_lines(near, count, lines, n_lines)
                first = n_edges
                n_edges = split_edges(lines, n_lines, edges, n_edges, doubts)
                n_lines = 0
                needed = n_facets + 3 * (n_edges - first)
                if needed > facet_capacity:
                    facet_capacity = 2 * needed
                    facets, links = _grow(facets, links, n_facets, facet_capacity)
                n_facets = _link_edges(
                    spare, radius, radii, i, start, stop, first, n_edges, edges, edge_facets,
                    slots, facets, links, heads, n_facets,
                )  # fmt: skip
                if n_edges >= _EDGES_AT_ONCE:
                    add_edges(edges, edge_facets, n_edges, radius, radii, edge_terms, facets)
                    n_edges = 0
            _mark_unsure(spare, n_open, doubts, i, start, stop, unsure)
            _book_disks(
                near, count, spare, n_open, slots, radius, radii, i, start, stop, terms, sums,
                unsure,
            )  # fmt: skip
        cell += 1
    add_edges(edges, edge_facets, n_edges, radius, radii, edge_terms, facets)
    _book_facets(
        facets, links, n_facets, coordinates, radius, radii, start, stop, terms, sums, unsure
    )
    if np.any(unsure):
        sum_cells_again(coordinates, cells, radius, radii, start, stop, unsure, terms, sums)
    return sums


@inner
def _is_crowded(near, count, radius):
    """Whether a neighbour is too close for cutting lines."""
    least2 = LEAST_GAP2 * radius * radius
    is_close = False
    for j in range(count):
        is_close |= near[SQUARE, j] < least2
    return is_close


@inner
def _grow(facets, links, n_facets, capacity):
    """Copy the tables of facets to larger ones."""
    larger = np.empty((capacity + WIDTH, facets.shape[1]))
    larger_links = np.empty((capacity, N_LINK_COLUMNS), np.int64)
    for facet in range(n_facets):
        for column in range(facets.shape[1]):
            larger[facet, column] = facets[facet, column]
        for column in range(N_LINK_COLUMNS):
            larger_links[facet, column] = links[facet, column]
    return larger, larger_links


@inner
def _find_slots(links, heads, i, start, others, n_others, slots):
    """Look up the facet of p_i with each of the padded others; -1 if it has not begun."""
    for j in range(n_others):
        slots[j] = -1
    facet = heads[i - start]
    while facet >= 0:
        number = float(links[facet, OTHER])
        for c in range(0, n_others, WIDTH):
            found = bits(load(others, NUMBER, c) == number)
            if found != 0:
                slots[c + lowest_bit(found)] = facet
                break
        facet = links[facet, NEXT]


@inner
def _link_edges(
    others, radius, radii, i, start, stop, first, n_edges, edges, edge_facets, slots, facets,
    links, heads, n_facets,
):  # fmt: skip
    """Complete new edges by u_j, u_k and their three facets; returns the number of facets."""
    for edge in range(first, n_edges):
        j = int(edges[FIRST_PLACE, edge])
        k = int(edges[SECOND_PLACE, edge])
        number_j = int(others[NUMBER, j])
        number_k = int(others[NUMBER, k])
        if slots[j] < 0:
            slots[j] = n_facets
            n_facets = new_facet(facets, links, heads, n_facets, i, number_j, start)
        if slots[k] < 0:
            slots[k] = n_facets
            n_facets = new_facet(facets, links, heads, n_facets, i, number_k, start)
        across = -1
        is_turned = False
        inside_j = start <= number_j < stop
        inside_k = start <= number_k < stop
        if inside_j or inside_k:
            owner = number_j
            other = number_k
            if not inside_j or (inside_k and number_k < number_j):
                owner = number_k
                other = number_j
                is_turned = True
            across = find_facet(links, heads, owner, other, start)
            if across < 0:
                across = n_facets
                n_facets = new_facet(facets, links, heads, n_facets, owner, other, start)
        for row in range(3):
            edges[row, edge] = others[row, j]
            edges[3 + row, edge] = others[row, k]
        if radii is not None:
            edges[RADII, edge] = radius
            edges[RADII + 1, edge] = others[RADIUS, j]
            edges[RADII + 2, edge] = others[RADIUS, k]
            edges[IS_TURNED, edge] = is_turned
        edge_facets[0, edge] = slots[j]
        edge_facets[1, edge] = slots[k]
        edge_facets[2, edge] = across
    return n_facets


@inner
def _mark_unsure(others, n_others, doubts, i, start, stop, unsure):
    """Mark p_i and those of the others that are in doubt, if there are any."""
    for j in range(n_others):
        if doubts[j]:
            unsure[i - start] = True
            number = int(others[NUMBER, j])
            if start <= number < stop:
                unsure[number - start] = True


@inner
def _book_disks(
    near, count, others, n_others, slots, radius, radii, i, start, stop, terms, sums, unsure
):
    """Book the facets that have no edge and are not empty: all of their disks.

    Such a facet holds the disk's centre, half of u_j if radii are equal: it is on p_i's side of
    all other bisectors.
    """
    for c in range(0, n_others, WIDTH):
        share = everywhere(0.5)
        if radii is not None:
            share = load(others, HALF, c) / load(others, SQUARE, c)
        x = load(others, X, c) * share
        y = load(others, Y, c) * share
        z = load(others, Z, c) * share
        left = (1 << min(WIDTH, n_others - c)) - 1
        for n in range(count):
            across = multiply_add(x, near[X, n], multiply_add(y, near[Y, n], z * near[Z, n]))
            left &= bits(across <= near[HALF, n] + _AT_CENTER * near[TOLERANCE, n])
            if left == 0:
                break
        while left != 0:
            j = c + lowest_bit(left)
            left &= left - 1
            if slots[j] < 0:
                _book_disk(
                    near, count, others, j, radius, radii, i, start, stop, terms, sums, unsure
                )


@inner
def _book_disk(near, count, others, j, radius, radii, i, start, stop, terms, sums, unsure):
    """Book the facet with others[j], which is all of its disk, unless another bisector passes."""
    ux = others[X, j]
    uy = others[Y, j]
    uz = others[Z, j]
    share = 0.5
    if radii is not None:
        share = others[HALF, j] / others[SQUARE, j]
    number = int(others[NUMBER, j])
    n_passing = 0
    for n in range(count):
        across = share * (ux * near[X, n] + uy * near[Y, n] + uz * near[Z, n])
        n_passing += abs(near[HALF, n] - across) <= _AT_CENTER * near[TOLERANCE, n]
    if n_passing != 1:  # another bisector than that of p_j
        unsure[i - start] = True
        if start <= number < stop:
            unsure[number - start] = True
        return
    distance = math.sqrt(others[SQUARE, j])
    turn = 2.0 * math.pi
    if radii is not None:
        square = everywhere(others[SQUARE, j])
        own = everywhere(radius)
        other = everywhere(others[RADIUS, j])
        heights = heights_over(square, own, other)
        area = half_chord2(heights[0], heights[1], own, other) * math.pi
        angle = signed_angle(square * 0.0, everywhere(turn), heights[0], own)
        other_angle = signed_angle(square * 0.0, everywhere(turn), heights[1], other)
        rim = (own * heights[1] + other * heights[0]) * (turn / distance)
    else:
        half = 0.5 * distance
        heights = (everywhere(half), everywhere(half))
        area = everywhere(math.pi * (radius - half) * (radius + half))
        angle = other_angle = everywhere(turn * (1.0 - half / radius))
        rim = everywhere(turn * radius)
    zero = everywhere(0.0)
    store_booking_terms(
        terms, everywhere(ux), everywhere(uy), everywhere(uz), area, heights[0], heights[1], angle,
        other_angle, rim, zero, zero, zero, zero, zero, zero,
    )  # fmt: skip
    book(terms, 0, sums, i - start)
    if i < number < stop:
        book(terms, WIDTH, sums, number - start)


@inner
def _book_facets(
    facets, links, n_facets, coordinates, radius, radii, start, stop, terms, sums, unsure
):
    """Book the facets put together from edges."""
    directions = np.ones((3, WIDTH))
    both_radii = np.ones((2, WIDTH))
    for c in range(0, n_facets, WIDTH):
        n_lanes = min(WIDTH, n_facets - c)
        for lane in range(n_lanes):
            for axis in range(3):
                here = coordinates[axis, links[c + lane, OWNER]]
                directions[axis, lane] = coordinates[axis, links[c + lane, OTHER]] - here
        x = load(directions, 0, 0)
        y = load(directions, 1, 0)
        z = load(directions, 2, 0)
        length2 = multiply_add(z, z, multiply_add(y, y, x * x))
        length = square_root(length2)
        height = other_height = length * 0.5
        own = other = everywhere(radius)
        rho2 = radius * radius - length2 * 0.25
        if radii is not None:
            for lane in range(n_lanes):
                both_radii[0, lane] = radii[links[c + lane, OWNER]]
                both_radii[1, lane] = radii[links[c + lane, OTHER]]
            own = load(both_radii, 0, 0)
            other = load(both_radii, 1, 0)
            height, other_height = heights_over(length2, own, other)
            rho2 = half_chord2(height, other_height, own, other)
        area, half_solid, arcs, mx, my, mz, sure = measure_facets(facets, c, rho2)
        sx = sy = sz = everywhere(0.0)
        if radii is not None:
            other_half_solid, sx, sy, sz, _, _, _, _ = load_transposed(facets, c, WIDTH)
            angle = signed_angle(half_solid, arcs, height, own)
            other_angle = signed_angle(other_half_solid, arcs, other_height, other)
            rim = arcs * (own * other_height + other * height) / length
            across = select(arcs > 0.0, (own - other) / length, 0.0)
            sx = sx * across
            sy = sy * across
            sz = sz * across
        else:
            angle = half_solid * 2.0 + arcs * (1.0 - length * (0.5 / radius))
            other_angle = angle
            rim = arcs * radius
        store_booking_terms(
            terms, x, y, z, area, height, other_height, angle, other_angle, rim, mx, my, mz,
            sx, sy, sz,
        )  # fmt: skip
        is_sure = bits(sure)
        for lane in range(n_lanes):
            owner = links[c + lane, OWNER] - start
            other_point = links[c + lane, OTHER]
            book(terms, lane, sums, owner)
            is_inside = start <= other_point < stop
            if is_inside:
                book(terms, WIDTH + lane, sums, other_point - start)
            if not (is_sure >> lane) & 1:
                unsure[owner] = True
                if is_inside:
                    unsure[other_point - start] = True
