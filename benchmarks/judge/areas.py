"""Areas of a run by overlays of polygons: what was seen, covered, known to one, and lost."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from benchmarks.judge.views import FloatArray, Views
from multisrt.campaign.bodies import Body, bodies_of
from multisrt.events import (
    ArcClosed,
    ArcReopened,
    Died,
    Learned,
    MapComplete,
    NodeAdded,
    Sensed,
    Sent,
)
from multisrt.recording import Recording

GRID_M: Final = 1e-6
"""Corners of overlays are rounded to multiples of this, in metres: what is thinner vanishes."""

SPACINGS_M: Final = (1.6, 0.4, 0.1, 0.025)
"""Distances of viewpoints on the border of what a body can reach: the finer ones only where
something is left that they could see."""

CORNER_M: Final = 1e-3
"""Viewpoints are also the corners of that border that a simpler one needs, to within this: in
narrow gaps the view from a cusp is a view of its own."""

ROUND_SEGMENTS: Final = 128
"""Segments of a quarter of a circle, where a body passes a corner."""

BATCH: Final = 64
"""Number of views that are united before they are taken from what is unseen."""

SAMPLE_M: Final = 0.05
"""Distance of the points that stand for the borders of what is unseen, in metres."""

ENOUGH: Final = 2e-6
"""Share of free space that may be left unseen without more viewpoints."""

SUCCESS: Final = 0.95
"""Share of what is explorable that a run covers to be a success."""

KNOWN: Final = 0.99
"""Share of what the team covers in the end that a robot knows when its map is complete."""


def solid(geometry: BaseGeometry) -> BaseGeometry:
    """Return the polygons of a geometry, without the points and lines at which others touch."""
    if isinstance(geometry, Polygon | MultiPolygon):
        return geometry
    parts = shapely.get_parts(geometry)
    return MultiPolygon([part for part in parts if isinstance(part, Polygon)])


def minus(one: BaseGeometry, other: BaseGeometry) -> BaseGeometry:
    """Return what of one area lies outside of another."""
    return solid(shapely.difference(one, other, grid_size=GRID_M))


def both(one: BaseGeometry, other: BaseGeometry) -> BaseGeometry:
    """Return what two areas have in common."""
    return solid(shapely.intersection(one, other, grid_size=GRID_M))


def together(areas: Iterable[BaseGeometry]) -> BaseGeometry:
    """Return the union of areas."""
    return solid(shapely.union_all(list(areas), grid_size=GRID_M))


def area_of(corners: FloatArray) -> BaseGeometry:
    """Return the area within a ring of corners, in metres."""
    polygon = Polygon(corners)
    return polygon if polygon.is_valid else solid(shapely.make_valid(polygon))


class World:
    """The part of a world that a team is in, and what it can explore there.

    Parameters
    ----------
    component : Polygon
        The connected part of free space.
    """

    def __init__(self, component: Polygon) -> None:
        self.component = component
        self.views = Views(component)
        self._explorable: dict[tuple[str, float], BaseGeometry] = {}

    def explorable(self, recording: Recording) -> BaseGeometry:
        """Return what the team of a run could see from where its bodies can get to.

        Of a body that is not a disc, where the disc fits that is inscribed in it.
        """
        seen = []
        ranges: dict[str, float] = {}
        areas: dict[str, BaseGeometry] = {}
        for robot, body, start in zip(
            recording.spec.robots, bodies_of(recording.spec), recording.header.starts, strict=True
        ):
            reachable = self._reachable(body, start)
            name = shapely.to_wkb(reachable, hex=True)
            areas[name] = reachable
            ranges[name] = max(ranges.get(name, 0.0), robot.range_finder.range_m)
        for name, reachable in areas.items():
            key = name, ranges[name]
            if key not in self._explorable:
                self._explorable[key] = self._seen_from(reachable, ranges[name])
            seen.append(self._explorable[key])
        return together(seen)

    def _reachable(self, body: Body, start: Sequence[float]) -> BaseGeometry:
        eroded = self.component.buffer(1e-6 - body.inscribed_m, quad_segs=ROUND_SEGMENTS)
        here = shapely.Point(start[0], start[1])
        parts: list[BaseGeometry] = shapely.get_parts(eroded).tolist()
        return min(parts, key=lambda part: float(part.distance(here)))

    def _seen_from(self, reachable: BaseGeometry, range_m: float) -> BaseGeometry:
        unseen = minus(self.component, reachable)
        border = reachable.boundary
        corners = shapely.get_coordinates(border.simplify(CORNER_M))
        for spacing_m in SPACINGS_M:
            places = _spread(border, spacing_m)
            if spacing_m < SPACINGS_M[0]:
                places = np.concatenate([corners, places])
            places = self._in_sight(unseen, places, range_m)
            for first in range(0, len(places), BATCH):
                views = (
                    area_of(self.views.view(x, y, range_m))
                    for x, y in places[first : first + BATCH].tolist()
                )
                unseen = minus(unseen, together(views))
            if unseen.area <= ENOUGH * self.component.area:
                break
        return minus(self.component, unseen)

    def _in_sight(self, unseen: BaseGeometry, places: FloatArray, range_m: float) -> FloatArray:
        # The places from which something unseen may be in sight: what sees a piece sees its border.
        near = places[np.asarray(shapely.dwithin(unseen, shapely.points(places), range_m))]
        inner = unseen.intersection(self.component.buffer(-1e-4))
        pieces = [p for p in shapely.get_parts(inner) if isinstance(p, Polygon) and p.area > 1e-6]
        samples = _spread(shapely.boundary(MultiPolygon(pieces)), SAMPLE_M)
        if len(samples) < len(near):
            views = (
                area_of(self.views.view(x, y, range_m + SAMPLE_M)) for x, y in samples.tolist()
            )
            sighted = together(views).buffer(SAMPLE_M)
            shapely.prepare(sighted)
            near = near[np.asarray(shapely.contains_xy(sighted, near))]
        return near


def _spread(lines: BaseGeometry, spacing_m: float) -> FloatArray:
    # Points on lines, evenly spaced: the number on each is rounded up.
    found = [np.empty((0, 2))]
    for line in shapely.get_parts(lines):
        count = math.ceil(line.length / spacing_m)
        along = (np.arange(count) + 0.5) / count
        found.append(
            shapely.get_coordinates(shapely.line_interpolate_point(line, along, normalized=True))
        )
    return np.concatenate(found)


@dataclass(frozen=True, slots=True, kw_only=True)
class Areas:
    """What a run saw, covered and knew, in square metres.

    Attributes
    ----------
    explorable, seen, covered, overlap, lost, known_to_one : float
        At the end.
    known_to_one_m2s : float
        Time integral of what only one robot knew.
    times : (n,) array
        When a scan was taken or a node was noted (s).
    curve : (n,) array
        The area covered from then on.
    claims : list of (time_s, share)
        When robots last said that their map was complete, and which share they knew of what the
        team covered in the end, or of what a run covers at least to be a success.
    """

    explorable: float
    seen: float
    covered: float
    overlap: float
    lost: float
    known_to_one: float
    known_to_one_m2s: float
    times: FloatArray
    curve: FloatArray
    claims: list[tuple[float, float]]

    def covered_s(self, share: float) -> float:
        """Return when a share of what is explorable was covered (s); inf if it never was."""
        reached = np.flatnonzero(self.curve >= share * self.explorable)
        return float(self.times[reached[0]]) if len(reached) else math.inf

    def complete_s(self, share: float) -> float:
        """Return when a robot said that its map was complete and knew a share; else inf."""
        return next((time for time, known in self.claims if known >= share), math.inf)

    def integral_of_rest(self, end_s: float) -> float:
        """Return the time integral of the share not covered (s)."""
        times = np.concatenate([[0.0], self.times, [end_s]])
        rest = 1.0 - np.concatenate([[0.0], self.curve]) / self.explorable
        return float((np.diff(times) * rest).sum())


def areas(recording: Recording, world: World) -> Areas:
    """Measure what a run saw, covered and knew."""
    explorable = world.explorable(recording)
    scans = _views(recording, world)
    nodes = _node_regions(recording, scans)
    times, curve, left = _curve(recording, explorable, scans, nodes)
    robots = range(len(recording.spec.robots))
    by_robot = [
        both(explorable, together(area for event, area in scans if event.robot == robot))
        for robot in robots
    ]
    once: BaseGeometry = MultiPolygon()
    twice: BaseGeometry = MultiPolygon()
    for seen in by_robot:
        twice = together([twice, both(once, seen)])
        once = together([once, seen])
    covered_m2 = explorable.area - left.area
    known = _knowledge(recording, scans, nodes)
    enough_m2 = max(covered_m2, SUCCESS / KNOWN * explorable.area)
    claims = _claims(recording, known, once, enough_m2)
    dead = {event.robot for event in recording.of(Died)}
    kept = [by_robot[robot] for robot in robots if robot not in dead]
    kept += [area for _, robot, area in known if robot not in dead and area is not None]
    lost = minus(together(by_robot[robot] for robot in dead), together(kept))
    alone_m2, integral_m2s = _known_to_one(recording, known, once)
    return Areas(
        explorable=explorable.area,
        seen=once.area,
        covered=covered_m2,
        overlap=twice.area,
        lost=both(lost, once).area,
        known_to_one=alone_m2,
        known_to_one_m2s=integral_m2s,
        times=times,
        curve=curve,
        claims=claims,
    )


Scans = list[tuple[Sensed, BaseGeometry]]
Nodes = dict[tuple[int, int], BaseGeometry]
Knowledge = list[tuple[float, int, BaseGeometry | None]]
"""Time (s), robot, and what it came to know; None where it died."""


def _views(recording: Recording, world: World) -> Scans:
    finders = [robot.range_finder for robot in recording.spec.robots]
    scans: Scans = []
    for event in recording.of(Sensed):
        finder, (x, y, _) = finders[event.robot], event.configuration
        if finder.beams is None:
            corners = world.views.view(x, y, finder.range_m)
        else:
            corners = world.views.beams(x, y, finder.range_m, finder.beams)
        scans.append((event, area_of(corners)))
    return scans


def _node_regions(recording: Recording, scans: Scans) -> Nodes:
    # The regions of nodes, as far as the last scan at their places had shown them.
    views = iter(scans)
    looked: dict[int, list[tuple[float, float, BaseGeometry]]] = {}
    regions: Nodes = {}
    for event in recording.events:
        if isinstance(event, Sensed):
            _, view = next(views)
            looked.setdefault(event.robot, []).append((*event.configuration[:2], view))
        elif isinstance(event, NodeAdded):
            here = event.configuration[:2]
            at = [v for x, y, v in looked.get(event.robot, []) if math.dist((x, y), here) <= 1e-6]
            region = area_of(np.array(event.boundary))
            regions[event.robot, event.serial] = both(region, at[-1]) if at else MultiPolygon()
    return regions


def _curve(
    recording: Recording, explorable: BaseGeometry, scans: Scans, nodes: Nodes
) -> tuple[FloatArray, FloatArray, BaseGeometry]:
    # What is left uncovered shrinks, so that each step overlays little.
    left = explorable
    noters = {robot for robot, _ in nodes}
    views = iter(scans)
    times, curve = [], []
    for event in recording.events:
        if isinstance(event, Sensed):
            _, view = next(views)
            if event.robot not in noters:
                left = minus(left, view)
        elif isinstance(event, NodeAdded):
            left = minus(left, nodes[event.robot, event.serial])
        else:
            continue
        times.append(event.time_s)
        curve.append(explorable.area - left.area)
    return np.array(times), np.array(curve), left


def _knowledge(recording: Recording, scans: Scans, nodes: Nodes) -> Knowledge:
    noters = {robot for robot, _ in nodes}
    views = iter(scans)
    known: Knowledge = []
    # The nodes that each robot knows, and those that it has been sent or could have been.
    knows: dict[int, set[tuple[int, int]]] = {}
    told: dict[int, set[tuple[int, int]]] = {}
    for event in recording.events:
        own = knows.setdefault(event.robot, set())
        if isinstance(event, Sensed):
            _, view = next(views)
            if event.robot not in noters:
                known.append((event.time_s, event.robot, view))
        elif isinstance(event, NodeAdded):
            own.add((event.robot, event.serial))
            known.append((event.time_s, event.robot, nodes[event.robot, event.serial]))
        elif isinstance(event, Sent):
            for robot in event.reached:
                told.setdefault(robot, set()).update(own)
        elif isinstance(event, Learned):
            for name in event.nodes:
                if name in told.get(event.robot, ()):
                    own.add(name)
                    known.append((event.time_s, event.robot, nodes[name]))
        elif isinstance(event, Died):
            known.append((event.time_s, event.robot, None))
    return known


def _claims(
    recording: Recording, known: Knowledge, seen: BaseGeometry, needed_m2: float
) -> list[tuple[float, float]]:
    # The last word of each robot, unless an arc was blocked then.
    blocked: dict[int, set[object]] = {}
    last: dict[int, float] = {}
    for event in recording.events:
        own = blocked.setdefault(event.robot, set())
        if isinstance(event, ArcClosed) and event.reason == "blocked by a robot":
            own.add((event.node, event.arc))
        elif isinstance(event, ArcReopened):
            own.discard((event.node, event.arc))
        elif isinstance(event, MapComplete):
            last[event.robot] = math.inf if own else event.time_s
    claims = []
    for claimed_s, claimer in sorted((time_s, robot) for robot, time_s in last.items()):
        if math.isinf(claimed_s):
            break
        regions = [
            area
            for time_s, robot, area in known
            if robot == claimer and time_s <= claimed_s and area is not None
        ]
        share = both(together(regions), seen).area / needed_m2 if needed_m2 else 0.0
        claims.append((claimed_s, share))
        if share >= KNOWN + 1e-3:
            break
    return claims


def _known_to_one(
    recording: Recording, known: Knowledge, seen: BaseGeometry
) -> tuple[float, float]:
    # The area that only one robot knew at the end, and its time integral.
    holders = _Holders(seen)
    end_s, since_s, integral = recording.footer.time_s, 0.0, 0.0
    alone_m2 = 0.0
    for time_s, changes in itertools.groupby(known, key=lambda change: change[0]):
        integral += alone_m2 * (time_s - since_s)
        since_s = time_s
        for _, robot, area in changes:
            if area is None:
                holders.forget(robot)
            else:
                holders.learn(robot, area)
        alone_m2 = holders.alone_m2()
    return alone_m2, integral + alone_m2 * (end_s - since_s)


class _Holders:
    """The robots that know each part of an area.

    Parameters
    ----------
    whole : geometry
        The area.
    """

    def __init__(self, whole: BaseGeometry) -> None:
        self._whole = whole
        self._robots_by_area: dict[int, set[int]] = defaultdict(set)
        self._areas: dict[int, BaseGeometry] = {}
        self._unknown = whole
        self._alone: dict[int, BaseGeometry] = {}

    def learn(self, robot: int, area: BaseGeometry) -> None:
        """Add an area to what a robot knows."""
        holders = self._robots_by_area[id(area)]
        self._areas[id(area)] = area
        if robot in holders:
            return
        holders.add(robot)
        if len(holders) <= 2:
            # What two know entirely, a third one makes no difference to.
            self._take(robot, area)

    def forget(self, robot: int) -> None:
        """Remove all that a robot knows."""
        self._unknown, self._alone = self._whole, {}
        for key, holders in self._robots_by_area.items():
            holders.discard(robot)
            for holder in sorted(holders)[:2]:
                self._take(holder, self._areas[key])

    def alone_m2(self) -> float:
        """Return the area that only one robot knows."""
        return math.fsum(area.area for area in self._alone.values())

    def _take(self, robot: int, area: BaseGeometry) -> None:
        for other, alone in self._alone.items():
            if other != robot and alone.intersects(area):
                self._alone[other] = minus(alone, area)
        if self._unknown.intersects(area):
            fresh = both(self._unknown, area)
            self._unknown = minus(self._unknown, area)
            own = self._alone.get(robot, MultiPolygon())
            self._alone[robot] = together([own, fresh])
