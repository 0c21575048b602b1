"""The simulation: an interpreter of explorers' actions over a discrete-event clock.

It holds the truth. It moves bodies along their trajectories, senses for them, and checks every
motion against the world. It proceeds from event to event: what a run costs follows what
happens in it, not how long that takes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import simpy
from shapely import Polygon

from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Collision, Ended, Motion
from multisrt.explorer import Done, Explorer, Move, Moved, Note, Outcome, RobotSelf, Sense
from multisrt.geometry.collision import Body, CollisionWorld
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.edge_index import EdgeIndex
from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.geometry.footprint import Footprint
from multisrt.geometry.scan import take_scan
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.recording import Recorder, Recording, RunOutcome, header_of, written_whole
from multisrt.registry import strategy
from multisrt.spec import RobotSpec, RunSpec, build_environment, random_stream

Watcher = Callable[[AnyEvent], None]


def simulate(
    spec: RunSpec,
    environment: Environment | None = None,
    *,
    path: str | Path | None = None,
    watch: Watcher | None = None,
) -> Recording:
    """Run an exploration.

    Parameters
    ----------
    spec : RunSpec
        Everything that the run depends on.
    environment : Environment, optional
        The world that `spec.environment` describes, if it is at hand already.
    path : path, optional
        Where to write the recording as the run goes.
    watch : callable, optional
        Is given every event as it happens.

    Returns
    -------
    Recording
        All that happened. An exploration that stalls or runs out of time is a result, too.

    Raises
    ------
    InvalidInputError
        If the spec cannot be run: the world, a start, the strategy or its options.
    """
    chosen = strategy(spec.strategy)
    options = chosen.parse_options(spec.options)
    if len(spec.robots) > 1:
        raise InvalidInputError(
            f"{spec.strategy} explores with one robot; the spec has {len(spec.robots)}"
        )
    if environment is None:
        environment = build_environment(spec.environment)
    starts = tuple(
        start_of(robot, environment, spec.seed, number) for number, robot in enumerate(spec.robots)
    )
    header = header_of(spec, environment, starts)
    explorers = [
        chosen.explorer(
            RobotSelf(
                robot=number,
                start=start,
                footprint=Footprint.parse(robot.footprint),
                kinematics=robot.drive.kinematics(),
                range_m=robot.range_finder.range_m,
                rng=random_stream(spec.seed, "robots", number),
            ),
            options,
        )
        for number, (robot, start) in enumerate(zip(spec.robots, starts, strict=True))
    ]
    if path is None:
        return _Simulation(spec, environment, Recorder(header), watch).run(explorers, starts)
    with written_whole(Path(path)) as file:
        return _Simulation(spec, environment, Recorder(header, file), watch).run(explorers, starts)


def start_of(robot: RobotSpec, environment: Environment, seed: int, number: int) -> Configuration:
    """Give the configuration in which a robot starts.

    Raises
    ------
    ClearanceError
        If the body does not fit there; the message says the clearance and what it needs.
    InvalidInputError
        If no start is given and the body fits nowhere.
    """
    footprint = Footprint.parse(robot.footprint)
    if robot.start is not None:
        x, y = robot.start[:2]
        heading = robot.start[2] if len(robot.start) == 3 else 0.0
        start = Configuration(float(x), float(y), float(heading))
    elif environment.starts:
        start = Configuration(*environment.starts[0])
    else:
        start = _drawn_start(footprint, environment, random_stream(seed, "starts", number))
    environment.component(start.x, start.y)
    clearance = environment.clearance(start.x, start.y)
    if footprint.is_disc:
        fits = clearance > footprint.radius_m
        needed = f"more than {footprint.radius_m:g} m"
    else:
        fits = bool(shapely.contains_properly(environment.free, footprint.placed(start)))
        needed = (
            f"{footprint.inscribed_radius_m:.3g} to {footprint.circumscribed_radius_m:.3g} m, "
            "by its heading"
        )
    if not fits:
        raise ClearanceError(
            f"the body {footprint} does not fit at the start ({start.x:g}, {start.y:g}) of "
            f"{environment.name!r}: the clearance there is {clearance:.6g} m, and it needs "
            f"{needed}; choose another start or a smaller body",
            clearance,
        )
    return start


def _drawn_start(
    footprint: Footprint, environment: Environment, rng: np.random.Generator
) -> Configuration:
    # Uniform in the largest area where the body fits in any heading.
    radius = footprint.circumscribed_radius_m
    room = environment.free.buffer(-1.1 * radius)
    parts = [part for part in shapely.get_parts(room) if isinstance(part, Polygon)]
    parts = [part for part in parts if not part.is_empty]
    if not parts:
        raise InvalidInputError(
            f"the body {footprint} fits nowhere in {environment.name!r}: it needs a clearance of "
            f"{radius:.3g} m; choose a smaller body"
        )
    largest = max(parts, key=lambda part: part.area)
    shapely.prepare(largest)
    x0, y0, x1, y1 = largest.bounds
    while True:
        x, y = rng.uniform((x0, y0), (x1, y1))
        if shapely.contains_xy(largest, x, y):
            return Configuration(float(x), float(y))


@lru_cache(maxsize=8)
def _collision_world(environment: Environment) -> CollisionWorld:
    # Many runs in one world build its solids once.
    return CollisionWorld(environment.free)


class _Simulation:
    def __init__(
        self,
        spec: RunSpec,
        environment: Environment,
        recorder: Recorder,
        watch: Watcher | None,
    ) -> None:
        self.spec = spec
        self.recorder = recorder
        self.watch = watch
        self.clock = simpy.Environment()
        self.index = EdgeIndex(
            environment.edges, max(r.range_finder.range_m for r in spec.robots) / 3.0
        )
        self.world = _collision_world(environment)
        self.ends: list[Ended] = []
        self.out_of_time = False
        self.collision: Collision | None = None

    def run(self, explorers: list[Explorer], starts: tuple[Configuration, ...]) -> Recording:
        processes = [
            self.clock.process(self._drive(number, explorer, start))
            for number, (explorer, start) in enumerate(zip(explorers, starts, strict=True))
        ]
        self.clock.run(until=self.clock.all_of(processes))
        outcome, reason = self._outcome()
        # Now plus what was left of the time can be the time's end but for rounding.
        time = self.spec.stop.max_time_s if self.out_of_time else float(self.clock.now)
        return self.recorder.finish(time, outcome, reason)

    def _outcome(self) -> tuple[RunOutcome, str]:
        if self.collision is not None:
            return "stalled", f"robot {self.collision.robot} {self.collision.account}"
        if self.out_of_time:
            return "out_of_time", f"the {self.spec.stop.max_time_s:g} s of the stop rule are over"
        reasons = "; ".join(f"robot {end.robot}: {end.reason}" for end in self.ends)
        return ("complete" if all(end.complete for end in self.ends) else "stalled"), reasons

    def _drive(
        self, number: int, explorer: Explorer, start: Configuration
    ) -> Generator[Any, Any, None]:
        # One robot: carries out what its explorer yields, until that is done or time is up.
        robot = self.spec.robots[number]
        body = self.world.body(Footprint.parse(robot.footprint))
        configuration = start
        outcome: Outcome = None
        actions = explorer.run()
        while True:
            try:
                action = actions.send(outcome)
            except StopIteration:
                raise InvalidInputError(
                    f"the explorer of robot {number} stopped without a last action Done"
                ) from None
            outcome = None
            match action:
                case Sense():
                    outcome = take_scan(
                        self.index,
                        configuration,
                        float(self.clock.now),
                        robot.range_finder.range_m,
                        robot.range_finder.beams,
                    )
                case Move(trajectory):
                    _require_start(trajectory, configuration, number)
                    left = self.spec.stop.max_time_s - float(self.clock.now)
                    driven = trajectory if trajectory.duration_s <= left else trajectory.until(left)
                    self._record_motion(number, driven)
                    if not self._is_free(body, driven, number):
                        return
                    yield self.clock.timeout(driven.duration_s)
                    configuration = driven.end
                    if driven is not trajectory:
                        self.out_of_time = True
                        return
                    outcome = Moved(configuration=configuration, time_s=float(self.clock.now))
                case Note(event):
                    self._record(event)
                case Done(complete, reason, frontier):
                    end = Ended(
                        time_s=float(self.clock.now),
                        robot=number,
                        reason=reason,
                        complete=complete,
                        frontier=frontier,
                    )
                    self.ends.append(end)
                    self._record(end)
                    return
                case _:
                    raise InvalidInputError(
                        f"the explorer of robot {number} yielded {action!r}, which is no action"
                    )

    def _record(self, event: AnyEvent) -> None:
        self.recorder.record(event)
        if self.watch is not None:
            self.watch(event)

    def _record_motion(self, number: int, trajectory: Trajectory) -> None:
        now, end = float(self.clock.now), self.spec.stop.max_time_s
        waypoints = tuple(
            (min(now + w.time_s, end), w.x, w.y, w.heading) for w in trajectory.waypoints
        )
        self._record(Motion(time_s=now, robot=number, waypoints=waypoints))

    def _is_free(self, body: Body, trajectory: Trajectory, number: int) -> bool:
        for a, b in zip(trajectory.waypoints, trajectory.waypoints[1:], strict=False):
            if not self._leg_is_free(body, a, b):
                self.collision = Collision(
                    time_s=float(self.clock.now) + a.time_s,
                    robot=number,
                    configuration=(a.x, a.y, a.heading),
                    account=f"touched an obstacle on its way from ({a.x:.3f}, {a.y:.3f}) "
                    f"to ({b.x:.3f}, {b.y:.3f})",
                )
                self._record(self.collision)
                return False
        return True

    def _leg_is_free(self, body: Body, a: Waypoint, b: Waypoint) -> bool:
        start, end = Configuration(*a[1:]), Configuration(*b[1:])
        if a.heading == b.heading:
            return self.world.straight_motion_is_free(body, start, end)
        if (a.x, a.y) == (b.x, b.y):
            return self.world.rotation_is_free(body, start, b.heading - a.heading)
        return self.world.first_contact(body, start, end, b.heading - a.heading) is None


def _require_start(trajectory: Trajectory, configuration: Configuration, number: int) -> None:
    gap = trajectory.start.distance(configuration)
    turn = abs(math.remainder(trajectory.start.heading - configuration.heading, 2.0 * math.pi))
    if gap > 1e-9 or turn > 1e-9:
        raise InvalidInputError(
            f"the explorer of robot {number} yielded a trajectory from {trajectory.start}, "
            f"but the robot is at {configuration}"
        )
