"""Who was cut off from the team, for how long and how far.

It is found from the trajectories and the events themselves, not by sampling. While two robots
keep to one leg each, the squared distance between them and the side of a corner on which the line
between them passes are functions of time, whose roots are the only moments at which a link can
come or go: polynomials of degree two where both move straight, and smooth functions with a bound
on their second derivative where one is on an arc. Between two such moments the radio itself is
asked once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from multisrt.analysis import clearances
from multisrt.environments.environment import Environment
from multisrt.events import CameBack, Died, FellSilent, Joined
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray, IntArray, kernel
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.recording import Recording
from multisrt.simulation.radio import links_hold, weakened_range
from multisrt.spec import LateStart, RadioSpec

RESOLUTION_S = 1e-6
"""Spells and gaps between spells that last no longer than this are none."""

TOLERANCE_M = 1e-6
"""The largest distance beyond range is found to within this."""

ROUNDING = 1e-9
"""What is nearer to a root than this (m), or to another root (s), is taken as being there."""

SHORTEST_SPAN_S = 1e-8
"""A span of time in which a root on an arc may lie is not halved any more when it is this short."""

MOST_SPANS = 4096
"""No more such spans are looked at; there are only many where a function is next to zero."""

Spell = tuple[float, float]
"""When something began and when it ended (s)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Isolation:
    """How a robot was cut off from all others.

    Attributes
    ----------
    total_s : float
        How long in all.
    longest_s : float
        The longest spell.
    beyond_range_m : float or None
        The largest distance to the nearest other robot that lives, less the range of the radio,
        while it was isolated; 0 if it never was, or never out of range of the nearest: silent,
        or behind a wall. None for a radio without a range.
    spells : tuple of (begin_s, end_s)
        When it was isolated, in the order of time.
    """

    total_s: float
    longest_s: float
    beyond_range_m: float | None
    spells: tuple[Spell, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class TeamIsolation:
    """How the members of a team were cut off from one another.

    Attributes
    ----------
    robots : tuple of Isolation
        Every robot's.
    total_s : float
        Time during which at least one robot was isolated.
    longest_s : float
        The longest spell of one robot.
    beyond_range_m : float or None
        The largest of any robot.
    split_s : float
        Time during which some robot that lives could not have reached another one: with relays
        while the network is in more than one part, without while a link of any two is missing.
    """

    robots: tuple[Isolation, ...]
    total_s: float
    longest_s: float
    beyond_range_m: float | None
    split_s: float


def isolation(
    recording: Recording, environment: Environment | None = None
) -> tuple[Isolation, ...]:
    """Measure how each robot was cut off from all others; see `team_isolation`."""
    return team_isolation(recording, environment).robots


def team_isolation(recording: Recording, environment: Environment | None = None) -> TeamIsolation:
    """Measure how the robots of a team were cut off from one another.

    A robot is isolated while there are others that live, and a message of its would come to none
    of them: no link of its own holds. Relays make no difference to that, for whoever is reached
    through a relay reaches the relay. Links are those of the run's `RadioSpec`; delays and losses
    do not count. A robot whose radio is silent is isolated, and links to it or through it do not
    hold. A robot counts from when it is switched on to its death or the end of the run, also when
    it is done; one that lives on alone has no team to be cut off from.

    Moments are exact to `RESOLUTION_S`. Where a robot on an arc keeps within a micrometre of
    where a link begins to hold, for long, they are those for a range changed by as much.

    Parameters
    ----------
    recording : Recording
        What happened.
    environment : Environment, optional
        The world, if it is at hand already; else it is taken from the recording. It is needed
        only where walls matter to the radio. Robots are taken to have kept out of its walls.

    Notes
    -----
    Source: J. C. Elizondo, G. Ramírez, E. Rodriguez and J. R. Martínez, Multi-robot Exploration
    Using Self-Biddings under Constraints on Communication Range (SBX-R), section IV and Tables I
    to III: `total_s`, `longest_s` and `beyond_range_m` of the team. There a robot is isolated that
    has moved out of range of all others, and the first table is also called the time in which the
    network was broken; two halves of a team that are out of range of each other break it without
    isolating anybody, which is `split_s`.
    """
    spec, end = recording.spec.radio, recording.footer.time_s
    here, silent = _presence(recording)
    alone = len(here) < 2
    reaches_all = spec.range_m is None and spec.walls == "pass"
    needed = not (alone or reaches_all)
    tracks = [_motions(track.legs) for track in clearances.tracks(recording)] if needed else []
    if tracks and spec.walls != "pass" and environment is None:
        environment = recording.environment()
    changes = [*_switches(here, silent)]
    if reaches_all:
        changes += [(0.0, NEAR, i, j) for i, j in itertools.combinations(range(len(here)), 2)]
    elif not alone:
        changes += _contacts(spec, tracks, environment)
    spells = _spells(changes, len(here), end, spec.multi_hop)
    robots = []
    for robot, own in enumerate(spells[:-2]):
        beyond = None if spec.range_m is None else 0.0
        if own and spec.range_m is not None:
            beyond = max(0.0, _farthest(robot, own, tracks, here) - spec.range_m)
        robots.append(
            Isolation(
                total_s=math.fsum(b - a for a, b in own),
                longest_s=max((b - a for a, b in own), default=0.0),
                beyond_range_m=beyond,
                spells=own,
            )
        )
    return TeamIsolation(
        robots=tuple(robots),
        total_s=math.fsum(b - a for a, b in spells[-2]),
        longest_s=max(robot.longest_s for robot in robots),
        beyond_range_m=max(
            (robot.beyond_range_m for robot in robots if robot.beyond_range_m is not None),
            default=None,
        ),
        split_s=math.fsum(b - a for a, b in spells[-1]),
    )


# Who takes part ----------------------------------------------------------------------------


def _presence(recording: Recording) -> tuple[list[Spell], list[tuple[float, int]]]:
    # From when to when each robot lived, and when a radio fell silent or came back.
    end = recording.footer.time_s
    late = {fault.robot for fault in recording.spec.faults if isinstance(fault, LateStart)}
    robots = range(len(recording.starts))
    begins = [math.inf if robot in late else 0.0 for robot in robots]
    ends = [end for _ in robots]
    for joined in recording.of(Joined):
        begins[joined.robot] = joined.time_s
    for died in recording.of(Died):
        ends[died.robot] = min(end, died.time_s)
    changes = (*recording.of(FellSilent), *recording.of(CameBack))
    silent = [(change.time_s, change.robot) for change in changes]
    return list(zip(begins, ends, strict=True)), silent


HERE, SILENT, NEAR = 0, 1, 2
"""What changes: a robot is there or not, is silent or not, or a pair is in contact or not."""

_Change = tuple[float, int, int, int]
"""When, which of these, and of whom: a robot twice, or two robots."""


def _switches(here: list[Spell], silent: list[tuple[float, int]]) -> Iterator[_Change]:
    for robot, (begin, end) in enumerate(here):
        if begin < end:
            yield begin, HERE, robot, robot
            yield end, HERE, robot, robot
    for time, robot in silent:
        yield time, SILENT, robot, robot


def _spells(
    changes: list[_Change], robots: int, end: float, multi_hop: bool
) -> list[tuple[Spell, ...]]:
    # When each robot was isolated, when any was, and when the team was split.
    changes.sort()
    times = np.array([change[0] for change in changes])
    what = np.array([change[1:] for change in changes], np.int64).reshape(-1, 3)
    rows = _sweep(times, what, robots, end, multi_hop)
    found: list[list[Spell]] = [[] for _ in range(robots + 2)]
    for number, begin, until in rows.tolist():
        spells = found[int(number)]
        if spells and begin - spells[-1][1] <= RESOLUTION_S:
            spells[-1] = spells[-1][0], until
        else:
            spells.append((begin, until))
    return [tuple((a, b) for a, b in spells if b - a > RESOLUTION_S) for spells in found]


@kernel
def _sweep(
    times: FloatArray, what: IntArray, robots: int, end: float, multi_hop: bool
) -> FloatArray:
    # Spells (number, begin, end) of every robot, then of any of them and of a split team.
    state = np.zeros((3, robots, robots), np.bool_)
    since = np.full(robots + 2, -1.0)
    rows = [(0, 0.0, 0.0)]
    k = 0
    while k < times.shape[0] and times[k] < end:
        now = times[k]
        while k < times.shape[0] and times[k] == now:
            kind, i, j = what[k, 0], what[k, 1], what[k, 2]
            state[kind, i, j] = not state[kind, i, j]
            state[kind, j, i] = state[kind, i, j]
            k += 1
        cut_off = _cut_off(state, multi_hop)
        for number in range(robots + 2):
            if cut_off[number] and since[number] < 0.0:
                since[number] = now
            elif not cut_off[number] and since[number] >= 0.0:
                rows.append((number, since[number], now))
                since[number] = -1.0
    for number in range(robots + 2):
        if since[number] >= 0.0:
            rows.append((number, since[number], end))
    spells = np.empty((len(rows) - 1, 3))
    for k in range(1, len(rows)):
        spells[k - 1, 0], spells[k - 1, 1], spells[k - 1, 2] = rows[k]
    return spells


@kernel
def _cut_off(state: BoolArray, multi_hop: bool) -> BoolArray:
    robots = state.shape[1]
    cut_off = np.zeros(robots + 2, np.bool_)
    team = 0
    first = -1
    for i in range(robots):
        if state[HERE, i, i]:
            team += 1
            first = i if first < 0 else first
    if team < 2:
        return cut_off
    links = np.zeros((robots, robots), np.bool_)
    for i in range(robots):
        if not state[HERE, i, i]:
            continue
        count = 0
        for j in range(robots):
            works = state[HERE, j, j] and not state[SILENT, i, i] and not state[SILENT, j, j]
            links[i, j] = j != i and works and state[NEAR, i, j]
            count += links[i, j]
        cut_off[i] = count == 0
        cut_off[robots] |= count == 0
        cut_off[robots + 1] |= count < team - 1
    if multi_hop and not cut_off[robots] and cut_off[robots + 1]:
        # It is no split if all are reached from the first through others.
        reached = np.zeros(robots, np.bool_)
        reached[first] = True
        relays = [first]
        found = 1
        while len(relays):
            i = relays.pop()
            for j in range(robots):
                if links[i, j] and not reached[j]:
                    reached[j] = True
                    relays.append(j)
                    found += 1
        cut_off[robots + 1] = found < team
    return cut_off


# Motions: (n, 8) arrays of the times at the start and the end of each leg, the place and the
# velocity at its start, how fast it turns and how fast the place moves. They follow one another
# from 0 to the end of the run without gaps.

START, END, X, Y, VX, VY, TURN, SPEED = range(8)


def _motions(legs: FloatArray) -> FloatArray:
    a, b = legs[:, :4], legs[:, 4:]
    lasting = b[:, 0] > a[:, 0]
    moves = lasting & (a[:, 1:3] != b[:, 1:3]).any(axis=1)
    chord = np.where(moves[:, None], b[:, 1:3] - a[:, 1:3], 0.0)
    turn = np.where(moves, b[:, 3] - a[:, 3], 0.0)
    duration = np.where(lasting, b[:, 0] - a[:, 0], 1.0)
    # An arc is longer than its chord, and sets out half of its turn to the other side.
    rate = 1.0 / (np.sinc(turn / (2.0 * math.pi)) * duration)
    cos, sin = rate * np.cos(turn / 2.0), rate * np.sin(turn / 2.0)
    vx = cos * chord[:, 0] + sin * chord[:, 1]
    vy = cos * chord[:, 1] - sin * chord[:, 0]
    track = np.column_stack(
        [a[:, 0], b[:, 0], a[:, 1:3], vx, vy, turn / duration, np.hypot(vx, vy)]
    )
    return track[lasting] if lasting.any() else track[-1:]


@kernel
def _place(leg: FloatArray, time: float) -> tuple[float, float]:
    after = time - leg[START]
    if leg[TURN] == 0.0:
        return leg[X] + leg[VX] * after, leg[Y] + leg[VY] * after
    along = np.sin(leg[TURN] * after) / leg[TURN]
    aside = 2.0 * np.sin(0.5 * leg[TURN] * after) ** 2 / leg[TURN]
    return (
        leg[X] + along * leg[VX] - aside * leg[VY],
        leg[Y] + along * leg[VY] + aside * leg[VX],
    )


@kernel
def _velocity(leg: FloatArray, time: float) -> tuple[float, float]:
    cos, sin = np.cos(leg[TURN] * (time - leg[START])), np.sin(leg[TURN] * (time - leg[START]))
    return cos * leg[VX] - sin * leg[VY], sin * leg[VX] + cos * leg[VY]


@kernel
def _leg_at(track: FloatArray, time: float) -> int:
    first, last = 0, track.shape[0] - 1
    while first < last:
        middle = (first + last + 1) // 2
        if track[middle, START] <= time:
            first = middle
        else:
            last = middle - 1
    return first


@kernel
def _lines_at(one: FloatArray, two: FloatArray, times: FloatArray) -> FloatArray:
    # The line between two robots at some times.
    lines = np.empty((times.shape[0], 4))
    for k in range(times.shape[0]):
        i, j = _leg_at(one, times[k]), _leg_at(two, times[k])
        lines[k, 0], lines[k, 1] = _place(one[i], times[k])
        lines[k, 2], lines[k, 3] = _place(two[j], times[k])
    return lines


# When a link comes or goes -----------------------------------------------------------------


def _contacts(
    spec: RadioSpec, tracks: list[FloatArray], environment: Environment | None
) -> Iterator[_Change]:
    # The moments at which pairs come into contact or lose it, were all radios at work.
    corners = np.empty((0, 2))
    index = None
    reaches = np.array([math.inf if spec.range_m is None else spec.range_m])
    if environment is not None and spec.walls != "pass":
        index = EdgeIndex(environment.edges, (spec.range_m or 12.0) / 3.0)
        corners = np.unique(environment.edges[:, :2], axis=0)  # in the order of x
    if environment is not None and spec.walls == "weaken":
        reaches = np.unique(weakened_range(spec, np.arange(len(environment.edges) // 2 + 1)))
    end = tracks[0][-1, END]
    for i, j in itertools.combinations(range(len(tracks)), 2):
        roots = np.unique(_moments(tracks[i], tracks[j], reaches, corners))
        times = np.concatenate([[0.0], roots[(roots > ROUNDING) & (roots < end)]])
        times = np.append(times[np.append(True, np.diff(times) > ROUNDING)], max(end, times[-1]))
        lines = _lines_at(tracks[i], tracks[j], (times[:-1] + times[1:]) / 2.0)
        holds = links_hold(spec, index, lines)
        for k in np.flatnonzero(np.diff(holds, prepend=False)):
            yield float(times[k]), NEAR, i, j


@kernel
def _moments(
    one: FloatArray, two: FloatArray, reaches: FloatArray, corners: FloatArray
) -> FloatArray:
    # All moments at which a link of two robots can change, and perhaps some others: when their
    # distance is one of the reaches, in increasing order, and when a corner lies between them.
    times = [0.0]
    i = j = 0
    while i < one.shape[0] and j < two.shape[0]:
        begin = max(one[i, START], two[j, START])
        end = min(one[i, END], two[j, END])
        if begin < end and one[i, SPEED] + two[j, SPEED] > 0.0:
            _moments_in(one[i], two[j], begin, end, reaches, corners, times)
        if one[i, END] <= two[j, END]:
            i += 1
        else:
            j += 1
    return np.array(times)


@kernel
def _moments_in(
    one: FloatArray,
    two: FloatArray,
    begin: float,
    end: float,
    reaches: FloatArray,
    corners: FloatArray,
    times: list[float],
) -> None:
    # In the middle of the span, the robots are as near as they can be and as far, but for this.
    half = (end - begin) / 2.0
    middle = begin + half
    (ax, ay), (bx, by) = _place(one, middle), _place(two, middle)
    apart = np.hypot(ax - bx, ay - by)
    strays = (one[SPEED] + two[SPEED]) * half + ROUNDING
    if apart - strays > reaches[-1]:
        return
    straight = one[TURN] == 0.0 and two[TURN] == 0.0
    first = np.searchsorted(reaches, apart - strays)
    last = np.searchsorted(reaches, apart + strays)
    for k in range(first, min(last, reaches.shape[0])):
        if straight:
            _straight_moments(one, two, begin, end, False, reaches[k], 0.0, times)
        elif reaches[k] < np.inf:
            _curved_moments(one, two, begin, end, False, reaches[k], 0.0, times)
    if not corners.shape[0]:
        return
    reach_one, reach_two = one[SPEED] * half, two[SPEED] * half
    low_x, high_x = min(ax - reach_one, bx - reach_two), max(ax + reach_one, bx + reach_two)
    low_y, high_y = min(ay - reach_one, by - reach_two), max(ay + reach_one, by + reach_two)
    for k in range(np.searchsorted(corners[:, 0], low_x), corners.shape[0]):
        x, y = corners[k, 0], corners[k, 1]
        if x > high_x:
            break
        if y < low_y or y > high_y:
            continue
        # The line between the two passes a corner that is nearer to it than they can move.
        side = (ax - x) * (by - y) - (ay - y) * (bx - x)
        far_a, far_b = np.hypot(ax - x, ay - y), np.hypot(bx - x, by - y)
        if abs(side) > far_b * reach_one + far_a * reach_two + reach_one * reach_two + ROUNDING:
            continue
        if straight:
            _straight_moments(one, two, begin, end, True, x, y, times)
        else:
            _curved_moments(one, two, begin, end, True, x, y, times)


@kernel
def _value(
    one: FloatArray, two: FloatArray, time: float, corner: bool, p: float, q: float
) -> tuple[float, float, float]:
    # What is zero when a link changes, its rate, and a measure of how exact it is: the square of
    # the distance less that of a reach p; or on which side of the corner (p, q) the line passes.
    (ax, ay), (bx, by) = _place(one, time), _place(two, time)
    (ux, uy), (vx, vy) = _velocity(one, time), _velocity(two, time)
    if corner:
        ax, ay, bx, by = ax - p, ay - q, bx - p, by - q
        value = ax * by - ay * bx
        return value, ux * by - uy * bx + ax * vy - ay * vx, abs(ax) + abs(ay) + abs(bx) + abs(by)
    x, y = bx - ax, by - ay
    return x * x + y * y - p * p, 2.0 * (x * (vx - ux) + y * (vy - uy)), abs(x) + abs(y) + p


@kernel
def _straight_moments(
    one: FloatArray,
    two: FloatArray,
    begin: float,
    end: float,
    corner: bool,
    p: float,
    q: float,
    times: list[float],
) -> None:
    # The roots of a polynomial a t^2 + b t + c. What starts, ends or turns next to zero counts.
    c, b, scale = _value(one, two, begin, corner, p, q)
    if corner:
        a = one[VX] * two[VY] - one[VY] * two[VX]
    else:
        a = (two[VX] - one[VX]) ** 2 + (two[VY] - one[VY]) ** 2
    length = end - begin
    near = ROUNDING * scale
    if abs(c) <= near:
        _take(one, two, begin, corner, p, q, times)
    if abs((a * length + b) * length + c) <= near:
        _take(one, two, end, corner, p, q, times)
    below = b * b - 4.0 * a * c
    if a == 0.0:
        if b != 0.0:
            _take_within(one, two, begin, end, begin - c / b, corner, p, q, times)
        return
    if below < 0.0:
        if abs(below) <= 4.0 * abs(a) * near:
            _take_within(one, two, begin, end, begin - 0.5 * b / a, corner, p, q, times)
        return
    # The sum is of equal signs, so that no digits cancel.
    larger = -0.5 * (b + (np.sqrt(below) if b >= 0.0 else -np.sqrt(below)))
    _take_within(one, two, begin, end, begin + larger / a, corner, p, q, times)
    if larger != 0.0:
        _take_within(one, two, begin, end, begin + c / larger, corner, p, q, times)


@kernel
def _take_within(
    one: FloatArray,
    two: FloatArray,
    begin: float,
    end: float,
    time: float,
    corner: bool,
    p: float,
    q: float,
    times: list[float],
) -> None:
    if begin - ROUNDING <= time <= end + ROUNDING:
        _take(one, two, min(max(time, begin), end), corner, p, q, times)


@kernel
def _take(
    one: FloatArray,
    two: FloatArray,
    time: float,
    corner: bool,
    p: float,
    q: float,
    times: list[float],
) -> None:
    # A corner in line with two robots matters where it is between them.
    if corner:
        (ax, ay), (bx, by) = _place(one, time), _place(two, time)
        if (p - ax) * (p - bx) + (q - ay) * (q - by) > ROUNDING:
            return
    times.append(time)


@kernel
def _curved_moments(
    one: FloatArray,
    two: FloatArray,
    begin: float,
    end: float,
    corner: bool,
    p: float,
    q: float,
    times: list[float],
) -> None:
    # Halve the span until in each part there is no root, or the function only rises or falls:
    # by its value and rate in the middle, and a bound on its second derivative.
    speed = one[SPEED] + two[SPEED]
    bend_one, bend_two = one[SPEED] * abs(one[TURN]), two[SPEED] * abs(two[TURN])
    starts, ends = np.array([begin]), np.array([end])
    while starts.shape[0]:
        left = np.empty(2 * starts.shape[0])
        right = np.empty(2 * starts.shape[0])
        count = 0
        for k in range(starts.shape[0]):
            middle, half = (starts[k] + ends[k]) / 2.0, (ends[k] - starts[k]) / 2.0
            value, rate, _ = _value(one, two, middle, corner, p, q)
            (ax, ay), (bx, by) = _place(one, middle), _place(two, middle)
            if corner:
                far_one = np.hypot(ax - p, ay - q) + one[SPEED] * half
                far_two = np.hypot(bx - p, by - q) + two[SPEED] * half
                bend = bend_one * far_two + 2.0 * one[SPEED] * two[SPEED] + far_one * bend_two
            else:
                far = np.hypot(bx - ax, by - ay) + speed * half
                bend = 2.0 * (speed * speed + far * (bend_one + bend_two))
            if abs(value) > (abs(rate) + 0.5 * bend * half) * half + ROUNDING:
                continue
            if abs(rate) > bend * half:
                _one_root(one, two, starts[k], ends[k], corner, p, q, times)
            elif half <= SHORTEST_SPAN_S or starts.shape[0] > MOST_SPANS:
                _take(one, two, middle, corner, p, q, times)
            else:
                left[count], right[count] = starts[k], middle
                left[count + 1], right[count + 1] = middle, ends[k]
                count += 2
        starts, ends = left[:count].copy(), right[:count].copy()


@kernel
def _one_root(
    one: FloatArray,
    two: FloatArray,
    begin: float,
    end: float,
    corner: bool,
    p: float,
    q: float,
    times: list[float],
) -> None:
    # Bisection, of a function that only rises or falls.
    at_begin, _, scale = _value(one, two, begin, corner, p, q)
    at_end, _, _ = _value(one, two, end, corner, p, q)
    for value, time in ((at_begin, begin), (at_end, end)):
        if abs(value) <= ROUNDING * scale:
            _take(one, two, time, corner, p, q, times)
    if (at_begin > 0.0) == (at_end > 0.0):
        return
    while end - begin > ROUNDING:
        middle = (begin + end) / 2.0
        value, _, _ = _value(one, two, middle, corner, p, q)
        if (value > 0.0) == (at_begin > 0.0):
            begin = middle
        else:
            end = middle
    _take(one, two, (begin + end) / 2.0, corner, p, q, times)


# How far beyond the range ------------------------------------------------------------------


def _farthest(
    robot: int, spells: tuple[Spell, ...], tracks: list[FloatArray], here: list[Spell]
) -> float:
    # The largest distance of a robot to the nearest other one that lives, in some spells.
    legs = np.vstack(tracks)
    first = np.cumsum([0, *map(len, tracks)])
    lives = np.array(here)
    joints = np.unique(np.concatenate([legs[:, START], lives.ravel()]))
    farthest = -math.inf
    for begin, end in spells:
        inside = joints[(joints > begin) & (joints < end)]
        times = np.concatenate([[begin], inside, [end]])
        farthest = _farthest_in(robot, times, legs, first, lives, farthest)
    return farthest


@kernel
def _farthest_in(
    robot: int,
    times: FloatArray,
    legs: FloatArray,
    first: IntArray,
    lives: FloatArray,
    farthest: float,
) -> float:
    # Branch and bound over spans in which every robot keeps to one leg: where both move straight,
    # they are in between no farther apart than at the ends, and else no farther than arcs bend.
    nearest = 0
    stack = np.empty((64, 2))
    on = np.zeros(lives.shape[0], np.int64)
    for k in range(times.shape[0] - 1):
        stack[0, 0], stack[0, 1] = times[k], times[k + 1]
        middle = (times[k] + times[k + 1]) / 2.0
        for j in range(lives.shape[0]):
            last = first[j + 1] - 1
            if on[j] == 0:
                on[j] = first[j] + _leg_at(legs[first[j] : first[j + 1]], middle)
            while on[j] < last and legs[on[j] + 1, START] <= middle:
                on[j] += 1
        depth = 1
        while depth > 0:
            depth -= 1
            begin, end = stack[depth, 0], stack[depth, 1]
            own = legs[on[robot]]
            (ax, ay), (bx, by) = _place(own, begin), _place(own, end)
            bound = at_begin = at_end = np.inf
            # Who was nearest is asked first: most often the others need not be.
            for turn in range(-1, lives.shape[0]):
                j = nearest if turn < 0 else turn
                if j == robot or lives[j, 0] > middle or lives[j, 1] < middle:
                    continue
                other = legs[on[j]]
                (px, py), (qx, qy) = _place(other, begin), _place(other, end)
                one, two = np.hypot(px - ax, py - ay), np.hypot(qx - bx, qy - by)
                most = max(one, two)
                bend = own[SPEED] * abs(own[TURN]) + other[SPEED] * abs(other[TURN])
                if bend > 0.0:
                    # The square of the distance bends down by no more than 2 `far` `bend`.
                    length = end - begin
                    far = most + (own[SPEED] + other[SPEED]) * length
                    most = np.sqrt(most * most + 0.25 * far * bend * length * length)
                if most < bound:
                    bound = most
                    nearest = j
                at_begin, at_end = min(at_begin, one), min(at_end, two)
                if bound <= farthest + TOLERANCE_M:
                    break
            if bound <= farthest + TOLERANCE_M:
                continue
            farthest = max(farthest, at_begin, at_end)
            if bound > farthest + TOLERANCE_M and end - begin > ROUNDING and depth + 2 <= 64:
                half = (begin + end) / 2.0
                stack[depth, 0], stack[depth, 1] = begin, half
                stack[depth + 1, 0], stack[depth + 1, 1] = half, end
                depth += 2
    return farthest
