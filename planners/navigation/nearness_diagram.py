"""Smooth Nearness Diagram: drive towards a goal among obstacles by the present readings.

Source: J. W. Durham and F. Bullo, "Smooth Nearness-Diagram Navigation" (IROS 2008), after
J. Minguez and L. Montano, "Nearness Diagram (ND) Navigation" (2004); the navigator of Elizondo
et al., "Multi-robot Exploration Using Self-Biddings under Constraints on Communication Range".
Differs in: beams all around, so that a turn in place reveals nothing new and only serves to face a
goal behind the robot; holonomic drives, for which every goal is ahead.

The navigator has no memory. It leaves a dead end by the opening nearest to the goal's direction;
where the goal lies right behind a wall, openings on both sides are equally near, and the robot may
go back and forth between them forever. A plan has to lead out of dead ends; the goals given here
are places near by on that plan.
"""

from __future__ import annotations

import math
from typing import Final, Literal, NamedTuple

import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray, IntArray
from multisrt.geometry.numerics.kernel import inlined_kernel, kernel
from multisrt.planners.navigation.beams import directions_of

AVOID_RADII: Final = 4.0
"""Default avoidance distance (D), in radii of the body."""

PASSABLE_RADII: Final = 2.2
"""Minimum distance of obstacles from a gap's corner for a passable gap, in radii of the body."""

Situation = Literal["goal", "gap", "middle", "turn", "blocked"]
"""What a robot heads for: the goal; a gap, past its corner; the middle of a narrow valley; nothing,
as it turns in place to a goal behind it that it can reach straight; nothing, without a path."""

SITUATIONS: Final[tuple[Situation, ...]] = ("goal", "gap", "middle", "turn", "blocked")
_GOAL, _GAP, _MIDDLE, _TURN, _BLOCKED = range(5)


class Command(NamedTuple):
    """A velocity command and its reason. Angles are relative to the robot's front.

    Attributes
    ----------
    speed_m_s : float
        Speed in m/s: along the front, or for a holonomic drive along `heading_rad`.
    turn_rate_rad_s : float
        Turn rate in rad/s, counter-clockwise positive; 0 for a holonomic drive.
    heading_rad : float
        Direction to go in, including the repulsion by obstacles.
    situation : Situation
        What the robot heads for.
    desired_rad : float
        Direction to go in without the repulsion.
    gap_rad : float
        Direction of the gap chosen; NaN without one.
    valley_rad : float
        Signed angle from that gap over the valley to its other end; NaN without one.
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
    """Return the command for the present readings.

    Parameters
    ----------
    ranges : (n,) array
        Distance along each beam from the robot's reference point in metres, see `beams`; readings
        of `range_m` or more are open.
    radius_m : float
        Radius of the body including its margin in metres (R).
    goal : (x, y)
        The goal in the robot's frame in metres, x along its front.
    v_max_m_s, w_max_rad_s : float
        Maximum speed in m/s and turn rate in rad/s.
    range_m : float
        Range of the beams in metres.
    avoid_m : float, optional
        Distance from the body within which obstacles repel it, in metres (D). Default:
        `AVOID_RADII` radii.
    any_direction : bool
        Whether the drive is holonomic and need not turn to its direction of motion.

    Returns
    -------
    Command

    Raises
    ------
    InvalidInputError
        If there are fewer than `MIN_BEAMS` beams, a reading is negative or NaN, the goal is not
        finite, or a radius, range, speed or rate is not positive.

    Examples
    --------
    Nothing is near, and the goal is ahead:

    >>> ranges = np.full(360, np.inf)
    >>> command(ranges, 0.25, (2.0, 0.0), 0.5, 1.5, range_m=4.0)[:4]
    (0.5, 0.0, 0.0, 'goal')
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
    directions = directions_of(ranges)
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


def _clip(value: float) -> float:
    return min(1.0, max(0.0, value))


@inlined_kernel
def _wrapped(angle: float) -> float:
    # As `wrap_angle`, for kernels: to (-pi, pi], but rounded differently.
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
    """Return situation, desired heading, heading, d_min, and the gap's direction and valley."""
    beams = ranges.shape[0]
    step = 2.0 * math.pi / beams
    d_min = np.inf
    for i in range(beams):
        # Negative or NaN: reported by d_min.
        if not ranges[i] >= 0.0:
            return _BLOCKED, 0.0, 0.0, np.nan, np.nan, np.nan
        d_min = min(d_min, ranges[i])
    towards = math.atan2(goal_y, goal_x)

    # 1. The goal, if it is ahead and the path to it is clear.
    clear = _goal_is_clear(ranges, directions, radius, range_m, goal_x, goal_y)
    gap_rad, valley_rad = np.nan, np.nan
    if clear and (any_direction or abs(towards) <= 0.5 * math.pi):
        kind, desired = _GOAL, towards
    else:
        # 2. Past the corner of the best gap, or between it and the other end of its valley.
        gaps = _gaps(ranges, radius, range_m)
        best = _best_gap(ranges, directions, gaps, radius, range_m, towards)
        if best < 0:
            # 3. Without a valley, turn in place.
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
    """Whether no beam ends in the corridor to the goal, which is as wide as the body."""
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
    """Return the gaps: gap i is between beams i and i + 1, where nearness jumps by over 2 R.

    Nearness is 0 for an open beam and above 2 R for any other (Minguez and Montano's PND), so that
    a surface that extends beyond the range ends in a gap.
    """
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
    """Return on which side of a gap its valley is: 1 counter-clockwise, -1 clockwise."""
    following = gap + 1 if gap + 1 < ranges.shape[0] else 0
    return 1 if ranges[following] > ranges[gap] else -1


@inlined_kernel
def _corner(gap: int, side: int, beams: int) -> int:
    """Return the beam that ends at the obstacle on the near side of a gap."""
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
    """Return the index of the passable gap nearest to the goal's direction; -1 without one."""
    step = 2.0 * math.pi / ranges.shape[0]
    rejected = np.zeros(gaps.shape[0], np.bool_)
    while True:
        best, nearest = -1, np.inf
        for k in range(gaps.shape[0]):
            if not rejected[k]:
                aside = abs(_wrapped((gaps[k] + 0.5) * step - towards))
                if aside < nearest:
                    best, nearest = k, aside
        if best < 0 or _is_passable(ranges, directions, gaps[best], radius, range_m):
            return best
        rejected[best] = True


@kernel
def _is_passable(
    ranges: FloatArray, directions: FloatArray, gap: int, radius: float, range_m: float
) -> bool:
    """Whether no reading on the valley's side is too near to the gap's corner."""
    beams = ranges.shape[0]
    side = _valley_side(ranges, gap)
    corner = _corner(gap, side, beams)
    x, y = ranges[corner] * directions[0, corner], ranges[corner] * directions[1, corner]
    min2 = (PASSABLE_RADII * radius) ** 2
    for k in range(1, beams // 2 + 1):
        i = (corner + side * k) % beams
        if ranges[i] < range_m:
            dx, dy = ranges[i] * directions[0, i] - x, ranges[i] * directions[1, i] - y
            if dx * dx + dy * dy < min2:
                return False
    return True


@kernel
def _push(
    ranges: FloatArray, radius: float, avoid: float, d_min: float, desired: float, step: float
) -> float:
    """Return the angle by which obstacles turn the heading away (Durham and Bullo's delta)."""
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
