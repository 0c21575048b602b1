"""Smooth Nearness Diagram: drive towards a goal among obstacles by what the beams say now.

Source: J. W. Durham and F. Bullo, "Smooth Nearness-Diagram Navigation" (IROS 2008), after
J. Minguez and L. Montano, "Nearness Diagram (ND) Navigation" (2004); the navigator of Elizondo
et al., "Multi-robot Exploration Using Self-Biddings under Constraints on Communication Range".
Differs in: beams all around, so that a turn in place shows nothing new and only points a robot at
a goal behind it; a drive in any direction, whose goal is always ahead.

It remembers nothing. Out of a dead end it goes by the opening nearest to the goal's direction;
where that is right behind a wall, openings on both sides are equally near, and it may go to and
fro between them for ever. A plan has to lead out of those, of which the goals given here are
places near by.

Beam i of n points in the direction ``2 pi i / n`` from the robot's front, counter-clockwise. They
have to be dense: along a wall at a distance a to the side, neighbouring beams that end r away
differ by about ``2 pi r^2 / (n a)``, and where that is more than the body's width the wall looks
like a row of gaps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Final, Literal, NamedTuple

import numpy as np

from multisrt.geometry.bodies.clearance import disc_clearance
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import FloatArray, IntArray, inlined_kernel, kernel
from multisrt.geometry.regions.boundary import OBSTACLE, TagArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.planners.motion.kinematics import Differential, Holonomic, Kinematics
from multisrt.planners.motion.trajectory import Trajectory, Waypoint

AVOID_RADII: Final = 4.0
"""Obstacles are avoided from so many radii of the body on (D)."""

PASSABLE_RADII: Final = 2.2
"""What stands opposite a gap's corner leaves a way if it is so many radii away from it."""

BEAMS: Final = 720
"""So many keep the wall beside a small robot in one piece at a range of a few metres."""

MIN_BEAMS: Final = 8
"""With fewer beams no valley has a meaning."""

Situation = Literal["goal", "gap", "middle", "turn", "blocked"]
"""What a robot heads for: the goal; past a gap's corner; the middle of a narrow valley; nothing,
it turns to a goal behind it that it can go to straight; nothing, there is no way it could see."""

SITUATIONS: Final[tuple[Situation, ...]] = ("goal", "gap", "middle", "turn", "blocked")
_GOAL, _GAP, _MIDDLE, _TURN, _BLOCKED = range(5)


class Command(NamedTuple):
    """What to do now, and why. Angles are relative to the robot's front.

    Attributes
    ----------
    speed_m_s : float
        How fast to drive: along the front, or for a drive in any direction along `heading_rad`.
    turn_rate_rad_s : float
        How fast to turn, counter-clockwise positive; 0 for a drive in any direction.
    heading_rad : float
        Where to go, after obstacles have pushed it aside.
    situation : Situation
        What it heads for.
    desired_rad : float
        Where to go but for the push of obstacles.
    gap_rad : float
        Direction of the gap that is gone by; NaN where none is.
    valley_rad : float
        Signed angle from that gap over the valley to its other end; NaN where none is.
    """

    speed_m_s: float
    turn_rate_rad_s: float
    heading_rad: float
    situation: Situation
    desired_rad: float
    gap_rad: float
    valley_rad: float


def command(
    ranges: FloatArray,
    radius_m: float,
    goal: tuple[float, float],
    v_max_m_s: float,
    w_max_rad_s: float,
    *,
    range_m: float,
    avoid_m: float | None = None,
    any_direction: bool = False,
) -> Command:
    """Decide how to move now.

    Parameters
    ----------
    ranges : (n,) array
        Distance along each beam from the robot's reference point; what is not below `range_m`
        is open.
    radius_m : float
        Radius of the body (R), with the margin that it shall keep.
    goal : (x, y)
        The goal, from the robot, x along its front.
    v_max_m_s, w_max_rad_s : float
        Greatest speed and greatest rate of turning.
    range_m : float
        How far the beams reach.
    avoid_m : float, optional
        How far from the body obstacles push it aside (D); default `AVOID_RADII` of its radii.
    any_direction : bool
        Whether the drive is holonomic: it need not turn to where it goes.

    Raises
    ------
    InvalidInputError
        For fewer than `MIN_BEAMS` beams, a reading that is no distance, a goal that is not
        finite, or a radius, range, speed or rate that is not positive.
    """
    avoid_m = AVOID_RADII * radius_m if avoid_m is None else avoid_m
    for name, value in (
        ("radius_m", radius_m),
        ("v_max_m_s", v_max_m_s),
        ("w_max_rad_s", w_max_rad_s),
        ("range_m", range_m),
        ("avoid_m", avoid_m),
    ):
        if not 0.0 < value < math.inf:
            raise InvalidInputError(f"{name} is a positive, finite number, not {value:g}")
    goal_x, goal_y = goal
    if not math.isfinite(goal_x + goal_y):
        raise InvalidInputError(f"the goal is a place, not ({goal_x}, {goal_y})")
    directions = _directions_of(ranges)
    kind, desired, heading, d_min, gap, valley = _steer(
        ranges, directions, radius_m, avoid_m, range_m, goal_x, goal_y, any_direction
    )
    if not d_min >= 0.0:
        raise InvalidInputError("a beam's reading is a distance of 0 or more, inf where it is open")
    speed = 0.0
    if kind < _TURN:
        speed = v_max_m_s * _clip(2.0 * math.hypot(goal_x, goal_y))
        speed *= _clip((d_min - radius_m) / avoid_m)
        if not any_direction:
            speed *= _clip(1.0 - 6.0 * abs(heading) / math.pi)
    turn_rate = 0.0
    if not any_direction:
        turn_rate = w_max_rad_s * min(1.0, max(-1.0, 2.0 * heading / math.pi))
    return Command(speed, turn_rate, heading, SITUATIONS[kind], desired, gap, valley)


def motion(
    chosen: Command, kinematics: Kinematics, at: Configuration, duration_s: float
) -> Trajectory:
    """Give the motion of a command that is held for a time.

    A differential drive follows a circular arc; a holonomic one goes straight where the command
    heads (one that was made for a drive in any direction) and keeps its heading.

    Raises
    ------
    InvalidInputError
        For a car, for a time that is not positive, and where a drive would turn by more than
        half a circle on the way.
    """
    if not 0.0 < duration_s < math.inf:
        raise InvalidInputError(f"a command is held for a positive time, not {duration_s:g} s")
    length = chosen.speed_m_s * duration_s
    if isinstance(kinematics, Differential):
        turn = chosen.turn_rate_rad_s * duration_s
        half = 0.5 * turn
        chord = length if half == 0.0 else length * math.sin(half) / half
        direction, heading = at.heading + half, at.heading + turn
    elif isinstance(kinematics, Holonomic):
        chord, direction, heading = length, at.heading + chosen.heading_rad, at.heading
    else:
        raise InvalidInputError(
            "a car cannot turn in place, as the nearness diagram asks for; "
            "use a holonomic or differential drive, or plan its way instead"
        )
    x, y = at.x + chord * math.cos(direction), at.y + chord * math.sin(direction)
    return Trajectory((Waypoint(0.0, *at), Waypoint(duration_s, x, y, heading)))


def safe_time(
    chosen: Command, clearance_m: float, radius_m: float, *, margin_m: float = 0.0
) -> float:
    """How long a command may be held at most without any part of a body leaving known space.

    A body that drives no farther than its distance to everything cannot touch anything. A
    command slows down by the same distance, so what comes out is ``avoid_m / v_max_m_s`` or
    more wherever `clearance_m` is what its beams saw, and it was made for the radius with the
    margin.

    Parameters
    ----------
    chosen : Command
        What is held.
    clearance_m : float
        Distance of the reference point from what is nearest, see `known_clearance`.
    radius_m : float
        Radius of the body: from its reference point to its farthest corner.
    margin_m : float
        What shall stay free around it.

    Returns
    -------
    float
        Seconds; 0 where the body may not move, inf where it only turns.
    """
    if chosen.speed_m_s == 0.0:
        return math.inf
    return max(0.0, clearance_m - radius_m - margin_m) / chosen.speed_m_s


def known_clearance(
    boundary: FloatArray, at: Configuration, discs: FloatArray | None = None
) -> float:
    """Distance from a place to whatever is nearest: the border of known free space, or a body.

    Parameters
    ----------
    boundary : (n, 2) array
        The known region; all of its border counts, also where it is open.
    at : Configuration
        The place, in the frame of the region.
    discs : (m, 3) array, optional
        x, y and radius of other bodies, in the same frame.

    Returns
    -------
    float
        Metres; 0 outside the region, and inside a disc.
    """
    if not inside(boundary, at.x, at.y):
        return 0.0
    nearest = disc_clearance(boundary, at.x, at.y)
    if discs is not None and len(discs):
        apart = np.hypot(discs[:, 0] - at.x, discs[:, 1] - at.y) - discs[:, 2]
        nearest = min(nearest, float(apart.min()))
    return max(0.0, nearest)


def in_frame_of(at: Configuration, x: float, y: float) -> tuple[float, float]:
    """Give a place as a robot sees it: x along its front, y to its left."""
    c, s = math.cos(at.heading), math.sin(at.heading)
    dx, dy = x - at.x, y - at.y
    return c * dx + s * dy, c * dy - s * dx


def region_ranges(region: LocalSafeRegion, at: Configuration, beams: int = BEAMS) -> FloatArray:
    """Give what beams would say in a region: surfaces are hit, where it ends openly is open.

    Parameters
    ----------
    region : LocalSafeRegion
        The region.
    at : Configuration
        Where the robot is in it, mostly the place of its scan; beam 0 points along its heading.
    beams : int
        How many, at least `MIN_BEAMS`.

    Returns
    -------
    (beams,) array
        Distances in metres; inf where the region ends at its range, or at a gap or cut.

    Raises
    ------
    InvalidInputError
        If the robot is not in the region, or there are too few beams.
    """
    if beams < MIN_BEAMS:
        raise InvalidInputError(f"navigation takes at least {MIN_BEAMS} beams, not {beams}")
    if not inside(region.boundary, at.x, at.y):
        raise InvalidInputError(
            f"({at.x:g}, {at.y:g}) is not in the region around ({region.x:g}, {region.y:g}); "
            "scan again from there"
        )
    return _ranges_in(region.boundary, region.tags, at.x, at.y, at.heading, beams)


def nearer(
    ranges: FloatArray,
    discs: FloatArray | None = None,
    polygons: Sequence[FloatArray] = (),
) -> FloatArray:
    """Let bodies stand in the way of beams.

    Parameters
    ----------
    ranges : (n,) array
        What the beams say without them.
    discs : (m, 3) array, optional
        x, y, radius of round bodies, in the robot's frame.
    polygons : sequence of (k, 2) array
        Corners of other bodies, in the robot's frame.

    Returns
    -------
    (n,) array
        The ranges, shorter where a body is nearer; all 0 where a body covers the robot's own
        reference point.
    """
    directions = _directions_of(ranges)
    if discs is not None:
        ranges = _cut_by_discs(ranges, directions, np.ascontiguousarray(discs, dtype=np.float64))
    for corners in polygons:
        corners = np.ascontiguousarray(corners, dtype=np.float64)
        ranges = _cut_by_polygon(ranges, directions, corners)
    return ranges


def _directions_of(ranges: FloatArray) -> FloatArray:
    if ranges.ndim != 1 or len(ranges) < MIN_BEAMS:
        raise InvalidInputError(
            f"beams are an (n,) array with n of at least {MIN_BEAMS}, not {ranges.shape}"
        )
    return _directions(len(ranges))


@lru_cache(maxsize=32)
def _directions(beams: int) -> FloatArray:
    angles = np.arange(beams) * (2.0 * math.pi / beams)
    directions = np.array([np.cos(angles), np.sin(angles)])
    directions.setflags(write=False)
    return directions


def _clip(value: float) -> float:
    return min(1.0, max(0.0, value))


@inlined_kernel
def _wrapped(angle: float) -> float:
    turns = math.ceil((angle - math.pi) / (2.0 * math.pi))
    return angle - 2.0 * math.pi * turns


@kernel
def _steer(
    ranges: FloatArray,
    directions: FloatArray,
    radius: float,
    avoid: float,
    range_m: float,
    goal_x: float,
    goal_y: float,
    any_direction: bool,
) -> tuple[int, float, float, float, float, float]:
    # Gives situation, desired heading, heading, d_min, and the gap's direction and valley.
    beams = ranges.shape[0]
    step = 2.0 * math.pi / beams
    d_min = np.inf
    for i in range(beams):
        # Not a number stays what it is.
        if not ranges[i] >= 0.0:
            return _BLOCKED, 0.0, 0.0, np.nan, np.nan, np.nan
        d_min = min(d_min, ranges[i])
    towards = math.atan2(goal_y, goal_x)

    # 1. The goal, if it is ahead and the way to it is clear.
    clear = _goal_is_clear(ranges, directions, radius, range_m, goal_x, goal_y)
    gap_rad, valley_rad = np.nan, np.nan
    if clear and (any_direction or abs(towards) <= 0.5 * math.pi):
        kind, desired = _GOAL, towards
    else:
        # 2. Past the corner of the best gap, or between it and the other end of its valley.
        gaps = _gaps(ranges, radius, range_m)
        best = _best_gap(ranges, directions, gaps, radius, range_m, towards)
        if best < 0:
            # 3. No valley: turn in place.
            kind = _TURN if clear else _BLOCKED
            return kind, towards, towards, d_min, np.nan, np.nan
        side = _valley_side(ranges, gaps[best])
        following = gaps[(best + side) % gaps.shape[0]]
        width = (side * (following - gaps[best])) % beams
        # A single gap is both ends of its valley.
        width = (width if width > 0 else beams) * step
        corner = _corner(gaps[best], side, beams)
        past = 0.5 * math.pi
        if ranges[corner] > avoid + radius:
            past = math.asin((avoid + radius) / ranges[corner])
        kind = _GAP if past <= 0.5 * width else _MIDDLE
        gap_rad, valley_rad = _wrapped((gaps[best] + 0.5) * step), side * width
        desired = _wrapped(gap_rad + side * min(past, 0.5 * width))

    delta = _push(ranges, radius, avoid, d_min, desired, step)
    return kind, desired, _wrapped(desired + delta), d_min, gap_rad, valley_rad


@kernel
def _goal_is_clear(
    ranges: FloatArray,
    directions: FloatArray,
    radius: float,
    range_m: float,
    goal_x: float,
    goal_y: float,
) -> bool:
    # Whether no beam ends in the corridor to the goal, as wide as the body and as long as the way.
    distance = math.hypot(goal_x, goal_y)
    if distance == 0.0:
        return True
    ux, uy = goal_x / distance, goal_y / distance
    for i in range(ranges.shape[0]):
        if ranges[i] < range_m:
            x, y = ranges[i] * directions[0, i], ranges[i] * directions[1, i]
            if 0.0 < x * ux + y * uy <= distance and abs(x * uy - y * ux) < radius:
                return False
    return True


@kernel
def _gaps(ranges: FloatArray, radius: float, range_m: float) -> IntArray:
    # Gap i lies between beams i and i + 1, whose nearness differs by more than the body's width.
    # Nearness is 0 where a beam is open and above that width where it is not (Minguez and
    # Montano's PND), so a surface that ends at the range ends in a gap.
    beams = ranges.shape[0]
    gaps = np.empty(beams, np.int64)
    count = 0
    width = 2.0 * radius
    first = range_m + width - ranges[0] if ranges[0] < range_m else 0.0
    here = first
    for i in range(beams):
        beyond = first
        if i + 1 < beams:
            beyond = range_m + width - ranges[i + 1] if ranges[i + 1] < range_m else 0.0
        if abs(beyond - here) > width:
            gaps[count] = i
            count += 1
        here = beyond
    return gaps[:count]


@inlined_kernel
def _valley_side(ranges: FloatArray, gap: int) -> int:
    # A gap rises as seen from the valley on its far side: 1 where that is counter-clockwise.
    following = gap + 1 if gap + 1 < ranges.shape[0] else 0
    return 1 if ranges[following] > ranges[gap] else -1


@inlined_kernel
def _corner(gap: int, side: int, beams: int) -> int:
    # The beam that ends at the obstacle on a gap's near side.
    return gap if side > 0 else (gap + 1) % beams


@kernel
def _best_gap(
    ranges: FloatArray,
    directions: FloatArray,
    gaps: IntArray,
    radius: float,
    range_m: float,
    towards: float,
) -> int:
    # Of the gaps that leave a way past their corner, the one nearest to the goal's direction.
    step = 2.0 * math.pi / ranges.shape[0]
    refused = np.zeros(gaps.shape[0], np.bool_)
    while True:
        best, nearest = -1, np.inf
        for k in range(gaps.shape[0]):
            if not refused[k]:
                aside = abs(_wrapped((gaps[k] + 0.5) * step - towards))
                if aside < nearest:
                    best, nearest = k, aside
        if best < 0 or _leaves_a_way(ranges, directions, gaps[best], radius, range_m):
            return best
        refused[best] = True


@kernel
def _leaves_a_way(
    ranges: FloatArray, directions: FloatArray, gap: int, radius: float, range_m: float
) -> bool:
    # Whether nothing on the valley's side, over half a circle, is too near to the gap's corner.
    beams = ranges.shape[0]
    side = _valley_side(ranges, gap)
    corner = _corner(gap, side, beams)
    x, y = ranges[corner] * directions[0, corner], ranges[corner] * directions[1, corner]
    least2 = (PASSABLE_RADII * radius) ** 2
    for k in range(1, beams // 2 + 1):
        i = (corner + side * k) % beams
        if ranges[i] < range_m:
            dx, dy = ranges[i] * directions[0, i] - x, ranges[i] * directions[1, i] - y
            if dx * dx + dy * dy < least2:
                return False
    return True


@kernel
def _push(
    ranges: FloatArray, radius: float, avoid: float, d_min: float, desired: float, step: float
) -> float:
    # How far obstacles turn the heading away from them (Durham and Bullo's delta).
    reach = min(avoid, max(0.0, 5.0 * (d_min - radius)))
    cubes, squares = 0.0, 0.0
    for i in range(ranges.shape[0]):
        if ranges[i] >= reach + radius and reach > 0.0:
            continue
        s = 1.0 if ranges[i] <= radius else 0.0
        if reach > 0.0:
            s = min(1.0, (reach + radius - ranges[i]) / reach)
        cubes += s * s * s * _wrapped(i * step + math.pi - desired)
        squares += s * s
    return cubes / squares if squares > 0.0 else 0.0


@kernel
def _ranges_in(
    boundary: FloatArray, tags: TagArray, x: float, y: float, heading: float, beams: int
) -> FloatArray:
    # As a laser's, each edge visits the beams that it spans; which way it faces tells whether it
    # is a way out of the region, as is the first edge that a beam meets.
    inverse = np.zeros(beams)
    open_there = np.ones(beams, np.bool_)
    per_rad = beams / (2.0 * math.pi)
    corners = boundary.shape[0]
    for e in range(corners):
        following = e + 1 if e + 1 < corners else 0
        ax, ay = boundary[e, 0] - x, boundary[e, 1] - y
        bx, by = boundary[following, 0] - x, boundary[following, 1] - y
        cross = ax * by - ay * bx
        if cross <= 0.0:
            continue
        begin_rad = math.atan2(ay, ax) - heading
        start = begin_rad * per_rad
        end = start + math.atan2(cross, ax * bx + ay * by) * per_rad
        along_x, along_y = (by - ay) / cross, (ax - bx) / cross
        is_open = tags[e] != OBSTACLE
        for i in range(int(np.ceil(start - 1e-9)), int(np.floor(end + 1e-9)) + 1):
            angle = heading + i / per_rad
            value = math.cos(angle) * along_x + math.sin(angle) * along_y
            k = i % beams
            # Where a surface and an opening meet, the surface counts.
            if value > inverse[k] * (1.0 + 1e-9):
                open_there[k] = is_open
            elif value > inverse[k] * (1.0 - 1e-9):
                open_there[k] = open_there[k] and is_open
            inverse[k] = max(inverse[k], value)
    ranges = np.full(beams, np.inf)
    for k in range(beams):
        if not open_there[k]:
            ranges[k] = 1.0 / inverse[k]
    return ranges


@kernel
def _cut_by_discs(ranges: FloatArray, directions: FloatArray, discs: FloatArray) -> FloatArray:
    cut = ranges.copy()
    for k in range(discs.shape[0]):
        x, y, radius = discs[k, 0], discs[k, 1], discs[k, 2]
        outside2 = x * x + y * y - radius * radius
        for i in range(cut.shape[0]):
            if outside2 <= 0.0:
                cut[i] = 0.0
                continue
            ahead = x * directions[0, i] + y * directions[1, i]
            under = ahead * ahead - outside2
            if ahead > 0.0 and under >= 0.0:
                cut[i] = min(cut[i], ahead - math.sqrt(under))
    return cut


@kernel
def _cut_by_polygon(ranges: FloatArray, directions: FloatArray, corners: FloatArray) -> FloatArray:
    cut = ranges.copy()
    covered = inside(corners, 0.0, 0.0)
    ax, ay = corners[-1, 0], corners[-1, 1]
    for k in range(corners.shape[0]):
        bx, by = corners[k, 0], corners[k, 1]
        for i in range(cut.shape[0]):
            ux, uy = directions[0, i], directions[1, i]
            side_a, side_b = ux * ay - uy * ax, ux * by - uy * bx
            if (side_a > 0.0) != (side_b > 0.0):
                share = side_a / (side_a - side_b)
                along = ux * (ax + share * (bx - ax)) + uy * (ay + share * (by - ay))
                if along >= 0.0:
                    cut[i] = min(cut[i], along)
        ax, ay = bx, by
    if covered:
        cut[:] = 0.0
    return cut
