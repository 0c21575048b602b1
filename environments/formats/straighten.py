"""Replacement of rings along the borders of cells by polygons of few vertices.

A ring consists of runs, straight pieces between turns. Where it passes between two cells there
is a window: the line between their centres, cut to the tolerance around the border. A segment
may replace a piece of ring if it crosses that piece's windows in the direction of their runs.
Between two windows it then stays in the square of four cell centres to which they belong. No
other ring enters that square, except at a pinch, where the windows' ends keep both apart.

Vertices are chosen among the turns and the middles of the runs; at a pinch the turn's place is
taken by the two ends of a cut. The polygon is a shortest path over these candidates, with a cost
of one for each vertex and a price for the area between polygon and ring, similar to the optimal
polygons of potrace. With vertices anywhere in the windows, polygons would have fewer of them, by
up to a half on curved outlines, but straight walls would be tilted and several times the area
misplaced.

Source: P. Selinger, Potrace: a polygon-based tracing algorithm, 2003, section 2.2; differs in:
windows with a tolerance in place of the maximum distance, which keeps the topology; candidates
at turns and middles only; signed area in place of the standard deviation, which keeps corners.
"""

import numpy as np

from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel

PINCH_CUT = 0.25
"""Legs of the triangles cut from two free cells that touch at a corner, in cells."""

AREA_PRICE = 2.5
"""Cost of a cell of misplaced area, in vertices; above 2, a single cell stays a square."""

Cone = tuple[float, float, float, float]
"""Directions from (x, y) counter-clockwise to (x, y), by at most half a turn."""

EMPTY: Cone = (1.0, 0.0, 1.0, -1.0)


@kernel
def straighten_rings(
    turns: IntArray, pinched: BoolArray, ring_starts: IntArray, tolerance: float
) -> tuple[FloatArray, IntArray]:
    """Replace every ring by its cheapest polygon.

    Parameters
    ----------
    turns : int array, shape (n, 2)
        Lattice points at which the rings turn, one ring after the other.
    pinched : bool array, shape (n,)
        At which of them two rings, or two parts of one, would touch.
    ring_starts : int array, shape (rings + 1,)
        Where each ring starts in ``turns``, and the end.
    tolerance : float
        Half the width of the windows, in cells, below one half.

    Returns
    -------
    vertices : float array, shape (k, 2)
        In cells.
    vertex_starts : int array, shape (rings + 1,)
        Where each polygon starts in ``vertices``, and the end.
    """
    vertices = np.empty((2 * len(turns) + np.count_nonzero(pinched), 2), np.float64)
    vertex_starts = np.zeros(len(ring_starts), np.int64)
    n = 0
    for ring in range(len(ring_starts) - 1):
        first, last = ring_starts[ring], ring_starts[ring + 1]
        corners = turns[first:last]
        places, run_of, is_middle, swept = _candidates(corners, pinched[first:last])
        # The start of a path is always a vertex, whatever its cost: repeat from a chosen one.
        chosen = _cheapest_polygon(corners, places, run_of, is_middle, swept, 0, tolerance)
        start = chosen[len(chosen) // 2]
        chosen = _cheapest_polygon(corners, places, run_of, is_middle, swept, start, tolerance)
        for index in chosen:
            vertices[n] = places[index]
            n += 1
        vertex_starts[ring + 1] = n
    return vertices[:n], vertex_starts


@kernel
def _candidates(
    turns: IntArray, pinched: BoolArray
) -> tuple[FloatArray, IntArray, BoolArray, FloatArray]:
    """Return the vertices to choose from, in the order of the ring.

    Returns their places relative to the ring's first turn; the run that each is the middle of
    or, for a turn, that leaves it; which are middles; and twice the area that the ring has
    swept around its first turn when it comes to each, with the whole ring's appended.
    """
    runs = len(turns)
    count = 2 * runs + np.count_nonzero(pinched)
    places = np.empty((count, 2), np.float64)
    run_of = np.empty(count, np.int64)
    is_middle = np.zeros(count, np.bool_)
    swept = np.empty(count + 1, np.float64)
    n, total = 0, 0.0
    for run in range(runs):
        x, y = turns[run]
        next_x, next_y = turns[(run + 1) % runs]
        x0, y0 = x - turns[0, 0], y - turns[0, 1]
        if pinched[run]:
            for other in (run - 1, (run + 1) % runs):
                dx, dy = turns[other, 0] - x, turns[other, 1] - y
                cut = PINCH_CUT / (abs(dx) + abs(dy))
                places[n, 0], places[n, 1] = x + cut * dx, y + cut * dy
                swept[n] = total + _cross(x0, y0, cut * dx, cut * dy)
                run_of[n] = run
                n += 1
        else:
            places[n, 0], places[n, 1] = x, y
            swept[n] = total
            run_of[n] = run
            n += 1
        run_area = _cross(x0, y0, next_x - x, next_y - y)
        places[n, 0], places[n, 1] = (x + next_x) / 2, (y + next_y) / 2
        swept[n] = total + run_area / 2
        run_of[n] = run
        is_middle[n] = True
        n += 1
        total += run_area
    swept[n] = total
    return places, run_of, is_middle, swept


@kernel
def _cheapest_polygon(
    turns: IntArray,
    places: FloatArray,
    run_of: IntArray,
    is_middle: BoolArray,
    swept: FloatArray,
    start: int,
    tolerance: float,
) -> IntArray:
    """Return the candidates on the cheapest polygon that has the candidate ``start``.

    Candidates are counted from ``start`` on; number n is ``start`` again. From each, the ring is
    followed for as long as some direction crosses all the windows that it has passed.
    """
    runs, n = len(turns), len(places)
    cost = np.full(n + 1, np.inf)
    came_from = np.zeros(n + 1, np.int64)
    cost[0] = 0.0
    for i in range(n):
        source = (start + i) % n
        here = places[source]
        run = run_of[source]
        from_middle = is_middle[source]
        j = i
        if not from_middle and not is_middle[(source + 1) % n]:  # the other end of the cut
            j += 1
            _offer(i, j, start, places, swept, cost, came_from)
        cone = (0.0, 0.0, 0.0, 0.0)
        is_first = True
        while j < n:
            head, tail = turns[run], turns[(run + 1) % runs]
            length = abs(tail[0] - head[0]) + abs(tail[1] - head[1])
            dx, dy = (tail[0] - head[0]) // length, (tail[1] - head[1]) // length
            if is_first:
                cone = (float(dy), float(-dx), float(-dy), float(dx))
            else:
                cone = _narrowed(cone, dy, -dx, -dy, dx)
                if _is_empty(cone):
                    break
            is_first = False
            if not from_middle:
                cone = _through_window(cone, here, head, dx, dy, 0.5, tolerance)
                if _is_empty(cone):
                    break
                j += 1
                if _leads_to(cone, here, places[(start + j) % n]):
                    _offer(i, j, start, places, swept, cost, came_from)
                if j == n:
                    break
            # Offsets vary linearly along a run: its first and last window stand for all. (The
            # first window of a run that turns back is behind, which ends the search above.)
            if length > 1:
                cone = _through_window(cone, here, head, dx, dy, length - 0.5, tolerance)
                if _is_empty(cone):
                    break
            while True:  # the turn, or both ends of the cut
                j += 1
                target = (start + j) % n
                if _leads_to(cone, here, places[target]):
                    _offer(i, j, start, places, swept, cost, came_from)
                if j == n or is_middle[(target + 1) % n]:
                    break
            run = (run + 1) % runs
            from_middle = False
    return _vertices(came_from, start)


@kernel
def _vertices(came_from: IntArray, start: int) -> IntArray:
    """Return the candidates on the cheapest path to the last number, in their order."""
    n = len(came_from) - 1
    vertices = 0
    chosen = np.empty(n, np.int64)
    j = n
    while j > 0:
        j = came_from[j]
        chosen[vertices] = (start + j) % n
        vertices += 1
    return chosen[:vertices][::-1].copy()


@kernel
def _offer(
    i: int,
    j: int,
    start: int,
    places: FloatArray,
    swept: FloatArray,
    cost: FloatArray,
    came_from: IntArray,
) -> None:
    """Store the path to candidate j by way of candidate i if that is the cheapest so far."""
    n = len(places)
    a, b = (start + i) % n, (start + j) % n
    area = swept[b] - swept[a]
    if b <= a:
        area += swept[n]
    x0, y0 = places[0]
    area += _cross(places[b, 0] - x0, places[b, 1] - y0, places[a, 0] - x0, places[a, 1] - y0)
    offer = cost[i] + 1.0 + AREA_PRICE * abs(area) / 2
    if offer < cost[j]:
        cost[j] = offer
        came_from[j] = i


@kernel
def _cross(ax: float, ay: float, bx: float, by: float) -> float:
    return ax * by - ay * bx


@kernel
def _narrowed(cone: Cone, ax: float, ay: float, bx: float, by: float) -> Cone:
    """Cut a cone to the directions from a counter-clockwise to b."""
    lo_x, lo_y, hi_x, hi_y = cone
    if _cross(lo_x, lo_y, ax, ay) > 0:
        lo_x, lo_y = float(ax), float(ay)
        if _cross(lo_x, lo_y, hi_x, hi_y) < 0:
            return EMPTY
    if _cross(bx, by, hi_x, hi_y) > 0:
        hi_x, hi_y = float(bx), float(by)
    return lo_x, lo_y, hi_x, hi_y


@kernel
def _through_window(
    cone: Cone, here: FloatArray, head: IntArray, dx: int, dy: int, along: float, tolerance: float
) -> Cone:
    """Cut a cone at ``here`` to one window of the run that leaves ``head`` in direction d."""
    x, y = head[0] + along * dx - here[0], head[1] + along * dy - here[1]
    if x * dx + y * dy <= 0:  # the window is behind
        return EMPTY
    return _narrowed(
        cone, x + tolerance * dy, y - tolerance * dx, x - tolerance * dy, y + tolerance * dx
    )


@kernel
def _is_empty(cone: Cone) -> bool:
    return _cross(cone[0], cone[1], cone[2], cone[3]) < 0


@kernel
def _leads_to(cone: Cone, here: FloatArray, there: FloatArray) -> bool:
    x, y = there[0] - here[0], there[1] - here[1]
    return _cross(cone[0], cone[1], x, y) >= 0 and _cross(x, y, cone[2], cone[3]) >= 0
