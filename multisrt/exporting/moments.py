"""The contents of a run in order of time."""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from typing import Final

import numpy as np

from multisrt.analysis.poses import Track, poses, poses_on, tracks
from multisrt.analysis.run_tables import coverage_curve
from multisrt.environments.environment import Environment
from multisrt.events import (
    AnyEvent,
    CameBack,
    Died,
    FellSilent,
    Joined,
    Motion,
    NodeAdded,
    NodeName,
    Point,
)
from multisrt.explain.notes import notes
from multisrt.exporting.contents import (
    Body,
    Content,
    Covered,
    KnownMap,
    Links,
    Placed,
    Said,
    State,
    Tree,
    Truth,
    Way,
)
from multisrt.exporting.grids import Grid, KnownMaps, frontier_of, truth_of
from multisrt.exporting.options import ExportOptions
from multisrt.exporting.sampling import course_of, inner_times, nanoseconds
from multisrt.exporting.trees import is_joined
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.recording import Recording
from multisrt.simulation.radio import links_hold
from multisrt.spec import LateStart

STANDING_HZ: Final = 1.0
"""Upper bound of the rate of links and of poses of a standing robot, in hertz."""

ROUNDING_S: Final = 1e-6
"""Tolerance of times, in seconds."""

MAX_SAMPLES: Final = 50_000_000
"""Upper bound of the number of poses of all robots."""

MAX_END_S: Final = 2e9
"""Upper bound of the length of a run in seconds: later times may not fit into ROS stamps."""

Moment = tuple[int, Content]
"""Nanoseconds since the start of the run, and the content that is shown from then on."""


def moments(
    recording: Recording, environment: Environment, grid: Grid, options: ExportOptions
) -> Iterator[Moment]:
    """Yield the contents of a run in order of time.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment
        Its world.
    grid : Grid
        The lattice of its maps.
    options : ExportOptions
        Layers that are left out, and the sampling rates.

    Yields
    ------
    Moment
        Nanoseconds since the start of the run, and a content.

    Raises
    ------
    InvalidInputError
        If there would be too many poses, or the recording contradicts itself.
    """
    _require_bounded(recording, options)
    absent = frozenset(options.without)
    layers: tuple[tuple[str, Callable[[], Iterable[Moment]]], ...] = (
        ("bodies", lambda: _bodies(recording)),
        ("maps", lambda: _known_maps(recording, environment, grid, options)),
        ("nodes edges", lambda: _trees(recording, absent)),
        ("paths", lambda: _in_order(_motions(recording))),
        ("links", lambda: _links(recording, environment, options)),
        ("decisions", lambda: _in_order(_decisions(recording))),
    )
    sources: tuple[Iterable[Moment], ...] = (
        [(0, Truth(truth_of(environment, grid)))],
        *(_poses(robot, track, options) for robot, track in enumerate(tracks(recording))),
        *(made() for names, made in layers if not absent.issuperset(names.split())),
        _coverage(recording, environment),
    )
    return heapq.merge(*sources, key=lambda moment: moment[0])


def _decisions(recording: Recording) -> Iterator[Moment]:
    for note in notes(recording):
        yield nanoseconds(note.time_s), Said(note.robot, note.text, note.is_trouble)


def _require_bounded(recording: Recording, options: ExportOptions) -> None:
    end_s, robots = recording.footer.time_s, len(recording.starts)
    if end_s > MAX_END_S:
        raise InvalidInputError(
            f"the run lasts {end_s:g} s; at most {MAX_END_S:g} s can be exported"
        )
    if end_s * options.rate_hz * robots > MAX_SAMPLES:
        raise InvalidInputError(
            f"{options.rate_hz:g} poses a second over {end_s:g} s for {robots} robots are more "
            f"than {MAX_SAMPLES}: choose a lower rate"
        )
    for motion in recording.of(Motion):
        for time_s, *_ in motion.waypoints:
            if not -ROUNDING_S <= time_s <= end_s + ROUNDING_S:
                raise InvalidInputError(
                    f"the motion of robot {motion.robot} at {motion.time_s:g} s has a waypoint at "
                    f"{time_s:g} s, in a run from 0 to {end_s:g} s"
                )
    if end_s / options.map_interval_s > MAX_SAMPLES:
        raise InvalidInputError(
            f"a map every {options.map_interval_s:g} s over {end_s:g} s is more than "
            f"{MAX_SAMPLES}: choose a longer interval"
        )


def _in_order(moments: Iterable[Moment]) -> list[Moment]:
    # Events are recorded when they end, and their times may differ by rounding.
    return sorted(moments, key=lambda moment: moment[0])


def _by_time(recording: Recording) -> list[tuple[int, AnyEvent]]:
    events = [(nanoseconds(event.time_s), event) for event in recording.events]
    return sorted(events, key=lambda pair: pair[0])


def _ticks(end_s: float, interval_s: float) -> Iterator[float]:
    # From 0 to the end, which is always a tick.
    yield from (k * interval_s for k in range(math.ceil(end_s / interval_s)))
    yield end_s


def _poses(robot: int, track: Track, options: ExportOptions) -> Iterator[Moment]:
    period_s = 1.0 / options.rate_hz
    standing_s = max(period_s, 1.0 / STANDING_HZ)
    last = -1
    for leg in track.legs:
        begin, end = float(leg[0]), float(leg[4])
        moves = bool((leg[1:4] != leg[5:]).any())
        step_s = period_s if moves else standing_s
        times = np.concatenate([[begin], inner_times(begin, end, step_s), [end]])
        found = poses_on(np.broadcast_to(leg, (len(times), 8)), times)
        for time_s, (x, y, heading) in zip(times.tolist(), found.tolist(), strict=True):
            if (now := nanoseconds(time_s)) > last:
                last = now
                yield now, Placed(robot, (x, y, heading))


def _bodies(recording: Recording) -> Iterator[Moment]:
    robots = range(len(recording.starts))
    flags: list[set[State]] = [set() for _ in robots]
    for fault in recording.spec.faults:
        if isinstance(fault, LateStart):
            flags[fault.robot].add("not started")
    for robot in robots:
        yield 0, Body(robot, _state(flags[robot]))
    for now, event in _by_time(recording):
        if not isinstance(event, Joined | FellSilent | CameBack | Died):
            continue  # A message may be the base station's, which is no body.
        own = flags[event.robot]
        before = _state(own)
        match event:
            case Joined():
                own.discard("not started")
            case FellSilent():
                own.add("silent")
            case CameBack():
                own.discard("silent")
            case Died():
                own.add("dead")
        if (state := _state(own)) != before:
            yield now, Body(event.robot, state)


def _state(flags: set[State]) -> State:
    order: tuple[State, ...] = ("dead", "not started", "silent")
    return next((state for state in order if state in flags), "on")


def _known_maps(
    recording: Recording, environment: Environment, grid: Grid, options: ExportOptions
) -> Iterator[Moment]:
    maps, events = KnownMaps(recording, environment, grid), _by_time(recording)
    done = 0
    for time_s in _ticks(recording.footer.time_s, options.map_interval_s):
        now = nanoseconds(time_s)
        while done < len(events) and events[done][0] <= now:
            maps.add(events[done][1])
            done += 1
        for robot, cells in maps.changed():
            yield now, KnownMap(robot, cells, grid.centres(frontier_of(cells)))


def _trees(recording: Recording, absent: frozenset[str]) -> Iterator[Moment]:
    places: dict[NodeName, Point] = {}
    nodes: dict[int, list[Point]] = defaultdict(list)
    edges: dict[int, list[tuple[float, ...]]] = defaultdict(list)
    for now, event in _by_time(recording):
        if not isinstance(event, NodeAdded):
            continue
        place = event.configuration[:2]
        places[event.robot, event.serial] = place
        nodes[event.robot].append(place)
        if event.parent in places and is_joined(event):
            edges[event.robot].append((*places[event.parent], *place))
        shown = [] if "nodes" in absent else nodes[event.robot]
        joined = [] if "edges" in absent else edges[event.robot]
        yield now, Tree(event.robot, _rows(shown, 2), _rows(joined, 4))


def _motions(recording: Recording) -> Iterator[Moment]:
    for motion in recording.of(Motion):
        yield nanoseconds(motion.time_s), Way(motion.robot, course_of(motion))


def _links(
    recording: Recording, environment: Environment, options: ExportOptions
) -> Iterator[Moment]:
    spec, robots = recording.spec.radio, len(recording.starts)
    base = recording.spec.base
    stations = np.array([] if base is None else [base.place]).reshape(-1, 2)
    members = robots + len(stations)
    if spec.reaches_everywhere or members < 2:
        return
    index = EdgeIndex(environment.edges, (spec.range_m or 12) / 3) if spec.walls_matter else None
    changes, done = list(_bodies(recording)), 0
    works = np.ones(members, np.bool_)
    one, two = np.triu_indices(members, 1)
    for time_s in _ticks(recording.footer.time_s, max(1.0 / options.rate_hz, 1.0 / STANDING_HZ)):
        now = nanoseconds(time_s)
        while done < len(changes) and changes[done][0] <= now:
            body = changes[done][1]
            assert isinstance(body, Body)
            works[body.robot] = body.state == "on"
            done += 1
        places = np.vstack([poses(recording, [time_s])[:, 0, :2], stations])
        both = works[one] & works[two]
        lines = np.hstack([places[one[both]], places[two[both]]])
        yield now, Links(lines[links_hold(spec, index, lines)] if len(lines) else lines)


def _coverage(recording: Recording, environment: Environment) -> Iterator[Moment]:
    curve = coverage_curve(recording, environment)
    columns = (curve[name].values for name in ("time_s", "coverage", "seen"))
    for time_s, coverage, seen in zip(*columns, strict=True):
        yield nanoseconds(float(time_s)), Covered(float(coverage), float(seen))


def _rows(rows: list[tuple[float, ...]] | list[Point], width: int) -> FloatArray:
    return np.array(rows, np.float64).reshape(-1, width)
