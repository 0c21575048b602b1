"""The informed plan of a run: routes on the truth, and when each robot drives them."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import msgspec
import shapely
from shapely import Polygon

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.informed.driving import Drive, drive_along, stages_of
from multisrt.informed.explorer import Orders, Stage
from multisrt.informed.options import InformedOptions
from multisrt.informed.roadmap import Roadmap
from multisrt.informed.search import Progress, Routes, Search
from multisrt.informed.team import Member, Team
from multisrt.informed.timetable import GAP_M, STANDS, Course, NoTiming, timed
from multisrt.informed.views import Bits, Cells, Sensor, count
from multisrt.planners.motion.kinematics import Car
from multisrt.robots.naming import named_robots
from multisrt.spec import RobotSpec, RunSpec

EXTRA_SHARE = 0.001
"""Share beyond that asked for which is planned: cells are not exact."""

ITERATIONS = 1_500
"""Number of changes of the routes of a plan."""

EASY_PLACES = 6_000
"""Number of places above which iterations are reduced, which bounds the time in large worlds."""

MIN_ITERATIONS = 100


def plan(
    spec: RunSpec,
    environment: Environment,
    starts: Sequence[Configuration],
    progress: Progress | None = None,
) -> tuple[Orders, ...]:
    """Return what each robot of an informed team is to do.

    A pure function of its parameters but the last: the search is seeded by them.

    Parameters
    ----------
    spec : RunSpec
        The run; no robot is a car.
    environment : Environment
        The truth.
    starts : sequence of Configuration
        Where the robots start.
    progress : callable, optional
        Called with the share of the search that is done.

    Returns
    -------
    tuple of Orders
        For each robot.
    """
    options = msgspec.convert(dict(spec.options), InformedOptions, strict=False)
    return _Planner(spec.robots, environment, tuple(starts), options).orders(progress)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Body:
    """The properties of one robot that the plan uses."""

    start: Configuration
    radius_m: float
    component: Polygon
    sensor: Sensor
    robot: RobotSpec


class _Planner:
    """Plans one run."""

    def __init__(
        self,
        robots: Sequence[RobotSpec],
        environment: Environment,
        starts: tuple[Configuration, ...],
        options: InformedOptions,
    ) -> None:
        self._options = options
        reach = max(robot.range_finder.range_m for robot in robots)
        index = EdgeIndex(environment.edges, reach / 3.0)
        sensors: dict[tuple[float, int | None], Sensor] = {}
        exact: dict[float, Sensor] = {}
        self._bodies = []
        for robot, start in zip(robots, starts, strict=True):
            finder = (robot.range_finder.range_m, robot.range_finder.beams)
            self._bodies.append(
                _Body(
                    start=start,
                    radius_m=Footprint.parse(robot.footprint).circumscribed_radius_m,
                    component=environment.component(start.x, start.y),
                    sensor=sensors.setdefault(finder, Sensor(index, *finder)),
                    robot=robot,
                )
            )
        self._roadmaps = self._roadmaps_without(())
        # What there is to see does not depend on the number of beams.
        for body in self._bodies:
            reach_m = body.sensor.range_m
            exact.setdefault(reach_m, Sensor(index, reach_m, None))
        seen_from = dict.fromkeys(
            (roadmap.room, exact[body.sensor.range_m])
            for roadmap, body in zip(self._roadmaps, self._bodies, strict=True)
            if roadmap is not None
        )
        shown = [body.sensor.region(*body.start[:2]) for body in self._bodies]
        self._cells = Cells(environment.bounds, environment.area_m2, seen_from, shown)
        self._at_start = self._cells.none()
        for region in shown:
            self._at_start |= self._cells.within(region)
        text = f"{environment.digest} {starts} {tuple(robots)} {options}"
        self._target = 0
        self._seed = int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")

    def orders(self, progress: Progress | None) -> tuple[Orders, ...]:
        """Return what each robot is to do."""
        idle: set[int] = set()
        while True:
            routes, active, team = self._routes(idle, progress)
            drives = self._drives(routes, active, team)
            # Roadmaps lead around those that stand for good.
            moving = [k for k in range(len(drives)) if k not in idle]
            try:
                found = timed([self._course(k, drives[k]) for k in moving])
                break
            except NoTiming as failed:
                # It stands for good, and the others plan round it.
                standing = {k for k in moving if drives[k].motion.duration_s == 0.0}
                failing = moving[failed.robot]
                idle |= standing if failing in standing else {failing}
        timing_of = dict(zip(moving, found, strict=True))
        timings = [timing_of.get(k, STANDS) for k in range(len(drives))]
        stages = [stages_of(d, t) for d, t in zip(drives, timings, strict=True)]
        return self._cut(stages)

    def _roadmaps_without(self, idle: set[int] | tuple[()]) -> list[Roadmap | None]:
        # For each robot its roadmap; equal bodies in one part of the world share theirs.
        made: dict[tuple[bytes, float], Roadmap] = {}
        found: list[Roadmap | None] = []
        for number, body in enumerate(self._bodies):
            if number in idle:
                found.append(None)
                continue
            room = body.component.buffer(-body.radius_m)
            part = _part_of(room, body.start)
            key = (shapely.to_wkb(part), body.radius_m)
            if key not in made:
                starts = [
                    other.start
                    for k, other in enumerate(self._bodies)
                    if k not in idle
                    and other.radius_m == body.radius_m
                    and other.component == body.component
                    and shapely.to_wkb(_part_of(room, other.start)) == key[0]
                ]
                discs = [
                    (*self._bodies[k].start[:2], self._bodies[k].radius_m + GAP_M)
                    for k in sorted(idle)
                ]
                made[key] = Roadmap(body.component, body.radius_m, starts, discs)
            found.append(made[key])
        return found

    def _routes(
        self, idle: set[int], progress: Progress | None
    ) -> tuple[Routes, list[int], Team | None]:
        roadmaps = self._roadmaps_without(idle) if idle else self._roadmaps
        active, members, used = [], [], dict.fromkeys(roadmaps, 0)
        for number, (body, roadmap) in enumerate(zip(self._bodies, roadmaps, strict=True)):
            if roadmap is None:
                continue
            drive = body.robot.drive.kinematics()
            assert not isinstance(drive, Car)
            active.append(number)
            members.append(
                Member(
                    start=body.start,
                    kinematics=drive,
                    roadmap=roadmap,
                    node=used[roadmap],
                    sensor=body.sensor,
                )
            )
            used[roadmap] += 1
        if not active:
            return (), active, None
        team = Team(members, self._cells, self._options.home)
        possible = self._at_start.copy()
        for view in team.views:
            possible |= view
        share = min(1.0, self._options.share + EXTRA_SHARE)
        self._target = min(math.ceil(share * self._cells.count), count(possible))
        fewer = min(1.0, EASY_PLACES / max(1, len(team.places)))
        iterations = max(MIN_ITERATIONS, int(ITERATIONS * fewer))
        if idle:
            iterations //= 4
        search = Search(team, self._at_start, self._target, self._seed)
        found = search.run(round(iterations * self._options.effort), progress)
        return found.routes, active, team

    def _drives(self, routes: Routes, active: list[int], team: Team | None) -> list[Drive]:
        drives = [drive_along(body.start, None, []) for body in self._bodies]
        for robot, (route, number) in enumerate(zip(routes, active, strict=True)):
            assert team is not None
            member = team.members[robot]
            nodes = [member.node, *(team.node(robot, place) for place in route)]
            if self._options.home and route:
                nodes.append(member.node)
            legs = []
            for a, b in pairwise(nodes):
                tight = member.roadmap.tight(a, b)
                assert tight is not None
                legs.append(tight.corners)
            drives[number] = drive_along(member.start, member.kinematics, legs)
        return drives

    def _course(self, number: int, drive: Drive) -> Course:
        body = self._bodies[number]
        return Course(
            motion=drive.motion,
            radius_m=body.radius_m,
            speed_m_s=body.robot.drive.speed_m_s,
        )

    def _cut(self, stages: list[list[Stage]]) -> tuple[Orders, ...]:
        # All end when enough is seen, unless they drive home.
        scans = sorted(
            (stage.begin_s + stage.motion.duration_s, number, k)
            for number, own in enumerate(stages)
            for k, stage in enumerate(own)
            if stage.scans
        )
        seen: Bits = self._at_start.copy()
        end_s = 0.0
        for time_s, number, k in scans:
            if count(seen) >= self._target:
                break
            end_s = time_s
            x, y, _ = stages[number][k].motion.end
            seen |= self._cells.within(self._bodies[number].sensor.region(x, y))
        share = count(seen) / max(1, self._cells.count)
        complete = share >= self._options.share
        reason = (
            f"has driven the informed plan, by which {math.floor(1000 * share) / 10:g} % is seen"
        )
        shut_in = [
            number
            for number, roadmap in enumerate(self._roadmaps)
            if roadmap is not None and roadmap.shuts_in(self._bodies[number].start)
        ]
        if not complete and shut_in:
            have = "has no room to leave its start"
            if len(shut_in) > 1:
                have = "have no room to leave their starts"
            reason += f"; {named_robots(shut_in)} {have}"
        elif not complete:
            reason += ", and no place shows more"
        if not self._options.home:
            stages = [_until(own, end_s) for own in stages]
        return tuple(Orders(stages=tuple(own), complete=complete, reason=reason) for own in stages)


def _part_of(room: shapely.Geometry, start: Configuration) -> shapely.Geometry:
    here = shapely.Point(start.x, start.y)
    return min(shapely.get_parts(room), key=lambda part: float(part.distance(here)), default=room)


def _until(stages: Sequence[Stage], end_s: float) -> list[Stage]:
    # What a robot does up to a time.
    kept = []
    for stage in stages:
        if stage.begin_s >= end_s - 1e-9:
            break
        left_s = end_s - stage.begin_s
        if stage.motion.duration_s > left_s + 1e-9:
            stage = Stage(begin_s=stage.begin_s, motion=stage.motion.until(left_s), scans=True)
        kept.append(stage)
    return kept
