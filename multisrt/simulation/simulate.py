"""The simulation: an interpreter of explorers' actions over a discrete-event clock.

It holds the truth. It moves bodies along their trajectories, senses for them, carries their
messages, lets go wrong what the spec says goes wrong, and checks every motion against the world
and all other bodies. It proceeds from event to event: what a run costs follows what happens in
it, not how long that takes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from contextlib import nullcontext
from functools import lru_cache, partial
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import simpy

from multisrt.environments.environment import Environment
from multisrt.events import (
    AnyEvent,
    Blocked,
    CameBack,
    Collision,
    Died,
    Ended,
    FellSilent,
    Joined,
    Motion,
    Organized,
    Sent,
)
from multisrt.geometry.bodies.collision import Body, CollisionWorld
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.recording import Recorder, Recording, RunOutcome, header_of, written_whole
from multisrt.robots.explorer import (
    Action,
    Done,
    Explorer,
    Look,
    Move,
    Moved,
    Note,
    Outcome,
    Receive,
    Received,
    RobotSelf,
    Send,
    Sense,
    Sighting,
    Stop,
    TimedOut,
)
from multisrt.robots.messages import Message
from multisrt.robots.registry import strategy
from multisrt.simulation.radio import Radio
from multisrt.simulation.starts import starts_of
from multisrt.simulation.traffic import Encounter, Traffic
from multisrt.simulation.worlds import build_environment
from multisrt.spec import Death, LateStart, RobotSpec, RunSpec, Silence, random_stream

Watcher = Callable[[AnyEvent], None]

PROMPT, LATE = 1, 2
"""Priorities of what happens at one moment: a timeout comes after all else."""

MOST_ACTIONS = 100_000
"""A robot that does more than this at one moment will never let time pass."""

ROUNDING_S = 1e-9
"""An arrival or an encounter may come earlier than it was foreseen by this."""


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
    # Specs that are equal run alike: also one with whole numbers where others have fractions.
    spec = spec.canonical()
    chosen = strategy(spec.strategy)
    options = chosen.parse_options(spec.options)
    chosen.require_fit(spec)
    if environment is None:
        environment = build_environment(spec.environment)
    starts = starts_of(spec, environment)
    index = EdgeIndex(environment.edges, max(r.range_finder.range_m for r in spec.robots) / 3.0)
    radio = Radio(spec.radio, index, random_stream(spec.seed, "radio"))
    joins = _joins(spec)
    explorers = [
        chosen.explorer(
            RobotSelf(
                robot=number,
                start=start,
                footprint=Footprint.parse(robot.footprint),
                kinematics=robot.drive.kinematics(),
                range_m=robot.range_finder.range_m,
                rng=random_stream(spec.seed, "robots", number),
                team=len(spec.robots),
                radio=radio.datasheet(),
                time_s=joins.get(number, 0.0),
                team_range_m=max(r.range_finder.range_m for r in spec.robots),
            ),
            options,
        )
        for number, (robot, start) in enumerate(zip(spec.robots, starts, strict=True))
    ]
    header = header_of(spec, environment, starts)
    world = _collision_world(environment)
    opened = nullcontext() if path is None else written_whole(Path(path))
    with opened as file:
        return _Simulation(spec, world, index, radio, Recorder(header, file), watch).run(
            explorers, starts
        )


@lru_cache(maxsize=8)
def _collision_world(environment: Environment) -> CollisionWorld:
    # Many runs in one world build its solids once.
    return CollisionWorld(environment.free)


def _joins(spec: RunSpec) -> dict[int, float]:
    # When the robots begin that come late.
    return {fault.robot: fault.time_s for fault in spec.faults if isinstance(fault, LateStart)}


class _Later(simpy.Event):  # type: ignore[misc]
    """Something that happens after a delay, at a moment's end where it must not forestall."""

    def __init__(
        self,
        clock: simpy.Environment,
        delay_s: float,
        then: Callable[[], None],
        priority: int = PROMPT,
    ) -> None:
        super().__init__(clock)
        self._ok = True
        self._value = None
        self.callbacks.append(lambda _: then())
        clock.schedule(self, priority, delay_s)


class _Robot:
    """One robot of the run, as the simulation sees it."""

    def __init__(self, number: int, spec: RobotSpec, body: Body, clock: simpy.Environment) -> None:
        self.number = number
        self.spec = spec
        self.body = body
        self.mailbox: list[Message] = []
        self.wake = clock.event()
        self.state: Literal["off", "on", "done", "dead"] = "off"
        self.hears = False
        self.acted_s = 0.0
        self.actions = 0
        self.set_out_s = 0.0
        self.arrival_s = 0.0
        self.encounter: Encounter | None = None
        self.move: Move | None = None
        self.waits = False
        self.doom: Death | None = None
        self.end: Ended | None = None

    def poke(self) -> None:
        """Have the robot see what happened."""
        if not self.wake.triggered:
            self.wake.succeed()


class _Dead(Exception):
    """Ends the process of a robot that died."""


class _Simulation:
    def __init__(
        self,
        spec: RunSpec,
        world: CollisionWorld,
        index: EdgeIndex,
        radio: Radio,
        recorder: Recorder,
        watch: Watcher | None,
    ) -> None:
        self.spec = spec
        self.world = world
        self.index = index
        self.radio = radio
        self.recorder = recorder
        self.watch = watch
        self.clock = simpy.Environment()
        self.now = 0.0
        self.robots = [
            _Robot(number, robot, world.body(Footprint.parse(robot.footprint)), self.clock)
            for number, robot in enumerate(spec.robots)
        ]
        self.on_the_air = 0
        self.places: dict[int, tuple[float, float]] = {}
        self.places_at_s = -1.0
        self.last_s = 0.0
        self.collision: Collision | None = None

    def run(self, explorers: list[Explorer], starts: tuple[Configuration, ...]) -> Recording:
        self.traffic = Traffic([robot.body for robot in self.robots], starts, self.index)
        joins = _joins(self.spec)
        for fault in self.spec.faults:
            self._foresee(fault)
        for robot in self.robots:
            if robot.number not in joins:
                # All are switched on before the first of them says anything.
                self._switch_on(robot)
        lives = [
            self._live(robot, explorer, joins.get(robot.number))
            for robot, explorer in zip(self.robots, explorers, strict=True)
        ]
        for life in lives:
            self.clock.process(life)
        max_time = self.spec.stop.max_time_s
        try:
            while not self._is_over() and (next_s := self.clock.peek()) <= max_time:
                self.now = float(next_s)
                self.clock.step()
        finally:
            # Whoever waits still would hold all that it knows until garbage is looked for.
            for life in lives:
                life.close()
        if not self._is_over() and max_time < self.clock.peek() < math.inf:
            return self._run_out_of_time(max_time)
        outcome, reason = self._outcome()
        return self.recorder.finish(self.last_s, outcome, reason)

    def _is_over(self) -> bool:
        # All are done or dead, and nothing is on its way that could call one on.
        if self.collision is not None:
            return True
        if self.on_the_air > 0:
            return False
        for robot in self.robots:
            if robot.state != "dead" and (robot.state != "done" or robot.mailbox):
                return False
        return True

    def _run_out_of_time(self, max_time: float) -> Recording:
        for robot in self.robots:
            if robot.move is not None:
                self._end_motion(robot, max_time)
        return self.recorder.finish(
            max_time, "out_of_time", f"the {max_time:g} s of the stop rule are over"
        )

    def _outcome(self) -> tuple[RunOutcome, str]:
        if self.collision is not None:
            return "stalled", f"robot {self.collision.robot} {self.collision.account}"
        living = [robot for robot in self.robots if robot.state != "dead"]
        if not living:
            return "stalled", "all robots died"
        waiting = [robot.number for robot in living if robot.state != "done" or robot.end is None]
        if waiting:
            return "stalled", f"robots {waiting} wait for a message that never comes"
        ends = [robot.end for robot in living if robot.end is not None]
        if len({end.reason for end in ends}) == 1 and len(ends) > 1:
            reasons = f"all robots: {ends[0].reason}"
        else:
            reasons = "; ".join(f"robot {end.robot}: {end.reason}" for end in ends)
        return ("complete" if all(end.complete for end in ends) else "stalled"), reasons

    # What a robot does -------------------------------------------------------------------

    def _live(
        self, robot: _Robot, explorer: Explorer, join_s: float | None
    ) -> Generator[Any, Any, None]:
        try:
            if join_s is not None:
                while self.now < join_s - ROUNDING_S:
                    self._later(join_s - self.now, robot.poke)
                    yield from self._sleep(robot)
                self._record(Joined(time_s=self.now, robot=robot.number))
                self._switch_on(robot)
            yield from self._drive(robot, explorer)
        except _Dead:
            pass

    def _drive(self, robot: _Robot, explorer: Explorer) -> Generator[Any, Any, None]:
        # Carries out what the explorer yields, until it is done for good.
        outcome: Outcome = None
        actions = explorer.run()
        while True:
            action = self._ask(robot, actions, outcome)
            outcome = None
            match action:
                # What is asked for most comes first.
                case Receive():
                    # What has come already need not be waited for.
                    if robot.mailbox and robot.move is None and robot.doom is None:
                        outcome = self._received(robot)
                    else:
                        outcome = yield from self._wait(robot, action.timeout_s)
                case Send():
                    self._send(robot, action.message, action.to)
                case Note():
                    self._record(action.event)
                    if isinstance(action.event, Organized):
                        self._doom(robot, "master")
                case Move():
                    if not self._begin_motion(robot, action):
                        return
                    if action.listen:
                        outcome = yield from self._wait(robot, None)
                    else:
                        outcome = yield from self._wait(robot, None, hears=False)
                case Sense():
                    outcome = take_scan(
                        self.index,
                        self.traffic.where(robot.number, self.now),
                        self.now,
                        robot.spec.range_finder.range_m,
                        robot.spec.range_finder.beams,
                    )
                case Look():
                    seen = self.traffic.in_sight(
                        robot.number, self.now, robot.spec.range_finder.range_m
                    )
                    outcome = tuple(self._sighting(other) for other in seen)
                case Stop():
                    if robot.move is None:
                        raise InvalidInputError(
                            f"the explorer of robot {robot.number} yielded Stop, but it stands"
                        )
                    outcome = self._end_motion(robot, self.now)
                case Done():
                    if robot.move is not None:
                        raise InvalidInputError(
                            f"the explorer of robot {robot.number} yielded Done while a motion "
                            "goes on; yield Receive to wait for its end, or Stop"
                        )
                    self._finish(robot, action)
                    if not action.on_call:
                        return
                    outcome = yield from self._wait(robot, None)
                    robot.state = "on"
                case _:
                    raise InvalidInputError(
                        f"the explorer of robot {robot.number} yielded {action!r}, "
                        "which is no action"
                    )
            if robot.state == "dead":
                raise _Dead
            if self.collision is not None:
                return

    def _ask(
        self, robot: _Robot, actions: Generator[Action, Outcome, None], outcome: Outcome
    ) -> Action:
        if robot.acted_s < self.now:
            robot.acted_s, robot.actions = self.now, 0
        if self.last_s < self.now:
            self.last_s = self.now
        robot.actions += 1
        if robot.actions > MOST_ACTIONS:
            raise InvalidInputError(
                f"the explorer of robot {robot.number} yielded {MOST_ACTIONS:,} actions at "
                f"{self.now:g} s and lets no time pass; have it move, or wait with a Receive "
                "that does not end at once"
            )
        try:
            return actions.send(outcome)
        except StopIteration:
            raise InvalidInputError(
                f"the explorer of robot {robot.number} stopped without a last action Done"
            ) from None

    def _finish(self, robot: _Robot, done: Done) -> None:
        end = Ended(
            time_s=self.now,
            robot=robot.number,
            reason=done.reason,
            complete=done.complete,
            frontier=done.frontier,
        )
        # One that is called on and has nothing new to say need not say it again.
        if robot.end is None or _said(robot.end) != _said(end):
            self._record(end)
        robot.end = end
        robot.state = "done"

    def _wait(
        self, robot: _Robot, timeout_s: float | None, hears: bool = True
    ) -> Generator[Any, Any, Moved | Received | TimedOut]:
        # Until a motion ends, messages come, or time is up; the last at a moment's end.
        times_out = None
        robot.waits = robot.move is None
        if robot.waits:
            self._doom(robot, "waiting")
        try:
            while True:
                if robot.state == "dead":
                    raise _Dead
                if (moved := self._motion_ended(robot)) is not None:
                    return moved
                if (hears and robot.mailbox) and (
                    robot.move is None or any(m.wakes for m in robot.mailbox)
                ):
                    return self._received(robot)
                if times_out is not None and times_out.processed:
                    return self._received(robot) if hears and robot.mailbox else TimedOut(self.now)
                if timeout_s is not None and times_out is None:
                    times_out = _Later(self.clock, max(0.0, timeout_s), robot.poke, LATE)
                yield from self._sleep(robot)
        finally:
            robot.waits = False

    def _received(self, robot: _Robot) -> Received:
        messages = tuple(robot.mailbox)
        robot.mailbox.clear()
        return Received(messages, self.now)

    def _sleep(self, robot: _Robot) -> Generator[Any, Any, None]:
        robot.wake = self.clock.event()
        yield robot.wake
        if robot.state == "dead":
            raise _Dead

    # Motion ------------------------------------------------------------------------------

    def _begin_motion(self, robot: _Robot, move: Move) -> bool:
        # False where it would touch an obstacle: a defect, which ends the run.
        if robot.move is not None:
            raise InvalidInputError(
                f"the explorer of robot {robot.number} yielded Move while a motion goes on; "
                "yield Receive to wait for its end, or Stop"
            )
        number, trajectory = robot.number, move.trajectory
        _require_start(trajectory, self.traffic.where(number, self.now), number)
        left = self.spec.stop.max_time_s - self.now
        if not self._is_free(
            robot, trajectory if trajectory.duration_s <= left else trajectory.until(left)
        ):
            return False
        robot.move, robot.set_out_s = move, self.now
        robot.arrival_s = self.now + trajectory.duration_s
        self.traffic.begin(number, self.now, trajectory, move.guard_m)
        self._later(trajectory.duration_s, robot.poke)
        self._foresee_encounter(robot)
        self._foresee_others(robot)
        if robot.doom is not None and robot.doom.when == "moving":
            self._later(trajectory.duration_s / 2.0, lambda: self._doom(robot, "moving"))
        return True

    def _foresee_encounter(self, robot: _Robot) -> None:
        robot.encounter = self.traffic.next_event(robot.number, self.now)
        if robot.encounter is not None:
            self._later(max(0.0, robot.encounter.time_s - self.now), robot.poke)

    def _foresee_others(self, robot: _Robot) -> None:
        for other in self.traffic.affected(robot.number):
            self._foresee_encounter(self.robots[other])

    def _motion_ended(self, robot: _Robot) -> Moved | None:
        if robot.move is None:
            return None
        met = robot.encounter
        if met is not None and met.time_s <= self.now + ROUNDING_S:
            if met.kind == "contact":
                self._collide(robot, met)
                raise _Dead
            moved = self._end_motion(robot, self.now)
            self._record(
                Blocked(
                    time_s=self.now,
                    robot=robot.number,
                    by=met.other,
                    configuration=(*moved.configuration,),
                )
            )
            return Moved(
                configuration=moved.configuration,
                time_s=self.now,
                blocked_by=self._sighting(met.other),
            )
        if self.now >= robot.arrival_s - ROUNDING_S:
            return self._end_motion(robot, robot.arrival_s)
        return None

    def _end_motion(self, robot: _Robot, time_s: float) -> Moved:
        assert robot.move is not None
        move, robot.move, robot.encounter = robot.move, None, None
        arrived = time_s >= robot.arrival_s - ROUNDING_S
        driven = move.trajectory if arrived else move.trajectory.until(time_s - robot.set_out_s)
        self.traffic.end(robot.number, max(time_s, robot.arrival_s) if arrived else time_s)
        end = self.spec.stop.max_time_s
        waypoints = tuple(
            (min(robot.set_out_s + w.time_s, end), w.x, w.y, w.heading) for w in driven.waypoints
        )
        self._record(
            Motion(
                time_s=robot.set_out_s,
                robot=robot.number,
                waypoints=waypoints,
                purpose=move.purpose,
            )
        )
        self._foresee_others(robot)
        return Moved(configuration=driven.end, time_s=self.now)

    def _is_free(self, robot: _Robot, trajectory: Trajectory) -> bool:
        legs = list(pairwise(trajectory.waypoints))
        # Where a disc turns in place, the legs before and after answer for it.
        turns = robot.body.footprint.is_disc
        moves = [(a, b) for a, b in legs if not (turns and (a.x, a.y) == (b.x, b.y))] or legs
        if all(self._leg_is_free(robot.body, a, b) for a, b in moves):
            return True
        a, b = next(leg for leg in legs if not self._leg_is_free(robot.body, *leg))
        self.collision = Collision(
            time_s=self.now + a.time_s,
            robot=robot.number,
            configuration=(a.x, a.y, a.heading),
            account=f"touched an obstacle on its way from ({a.x:.3f}, {a.y:.3f}) "
            f"to ({b.x:.3f}, {b.y:.3f})",
        )
        self.last_s = self.collision.time_s
        self._record(self.collision)
        return False

    def _leg_is_free(self, body: Body, a: Waypoint, b: Waypoint) -> bool:
        start, end = Configuration(*a[1:]), Configuration(*b[1:])
        if a.heading == b.heading:
            return self.world.straight_motion_is_free(body, start, end)
        if (a.x, a.y) == (b.x, b.y):
            return self.world.rotation_is_free(body, start, b.heading - a.heading)
        turn = b.heading - a.heading
        return self.world.first_contact(body, start, end, turn, arc=True) is None

    def _collide(self, robot: _Robot, met: Encounter) -> None:
        here = self.traffic.where(robot.number, self.now)
        there = self.traffic.where(met.other, self.now)
        self.collision = Collision(
            time_s=self.now,
            robot=robot.number,
            configuration=(*here,),
            account=f"touched robot {met.other} at ({there.x:.3f}, {there.y:.3f}) on its way "
            f"from ({here.x:.3f}, {here.y:.3f})",
        )
        for moving in self.robots:
            if moving.move is not None:
                self._end_motion(moving, self.now)
        self.last_s = max(self.last_s, self.now)
        self._record(self.collision)

    def _sighting(self, other: int) -> Sighting:
        return Sighting(
            robot=other,
            configuration=self.traffic.where(other, self.now),
            footprint=self.robots[other].body.footprint,
        )

    # Messages ----------------------------------------------------------------------------

    def _send(self, robot: _Robot, message: Message, to: int | None) -> None:
        deliveries: list[tuple[int, float]] = []
        lost: list[int] = []
        if robot.hears:
            deliveries, lost = self._deliveries(robot.number, to)
        self._record(
            Sent(
                time_s=self.now,
                robot=robot.number,
                kind=message.kind,
                size_bytes=message.size_bytes,
                reached=tuple(receiver for receiver, _ in deliveries),
                lost=tuple(lost),
            )
        )
        for receiver, delay_s in deliveries:
            if delay_s > 0.0:
                self.on_the_air += 1
                self._later(delay_s, partial(self._arrive, self.robots[receiver], message))
            else:
                self._deliver(self.robots[receiver], message)

    def _deliveries(self, sender: int, to: int | None) -> tuple[list[tuple[int, float]], list[int]]:
        # Asks the radio about those that are anywhere near: they are numbered among themselves.
        if self.radio.is_unlimited:
            working = [robot.hears for robot in self.robots]
            return self.radio.deliveries(sender, to, [], working)
        radio = self.spec.radio
        range_m = math.inf if radio.range_m is None else radio.range_m
        near = self.traffic.may_reach(sender, range_m, relayed=radio.multi_hop)
        if to is not None and to not in near:
            return [], []
        delivered, lost = self.radio.deliveries(
            near.index(sender),
            None if to is None else near.index(to),
            [self._place(robot) for robot in near],
            [self.robots[robot].hears for robot in near],
        )
        return [(near[k], delay) for k, delay in delivered], [near[k] for k in lost]

    def _place(self, robot: int) -> tuple[float, float]:
        # Where a robot is; much is said at one moment.
        if self.places_at_s != self.now:
            self.places_at_s = self.now
            self.places = {}
        if robot not in self.places:
            self.places[robot] = self.traffic.where(robot, self.now)[:2]
        return self.places[robot]

    def _arrive(self, robot: _Robot, message: Message) -> None:
        self.on_the_air -= 1
        self._deliver(robot, message)

    def _deliver(self, robot: _Robot, message: Message) -> None:
        if robot.hears:
            robot.mailbox.append(message)
            if robot.move is None or message.wakes:
                robot.poke()

    # Faults ------------------------------------------------------------------------------

    def _foresee(self, fault: Death | Silence | LateStart) -> None:
        robot = self.robots[fault.robot]
        if isinstance(fault, Death):
            self._later(fault.time_s, lambda: self._arm(robot, fault))
        elif isinstance(fault, Silence):
            self._later(fault.time_s, lambda: self._silence(robot))
            self._later(fault.time_s + fault.duration_s, lambda: self._come_back(robot))

    def _arm(self, robot: _Robot, fault: Death) -> None:
        robot.doom = fault
        for doing, so in (("any", True), ("moving", robot.move), ("waiting", robot.waits)):
            if so:
                self._doom(robot, doing)

    def _doom(self, robot: _Robot, doing: str) -> None:
        # Lets a robot die if that is what it was to be doing.
        if robot.doom is None or robot.doom.when != doing or robot.state == "dead":
            return
        if doing == "moving" and robot.move is None:
            return
        was: Literal["moving", "waiting", "master"] = (
            "master" if doing == "master" else "moving" if robot.move is not None else "waiting"
        )
        if robot.move is not None:
            self._end_motion(robot, self.now)
        robot.state, robot.hears = "dead", False
        robot.mailbox.clear()
        self.last_s = max(self.last_s, self.now)
        place = self.traffic.where(robot.number, self.now)
        self._record(Died(time_s=self.now, robot=robot.number, configuration=(*place,), doing=was))
        robot.poke()

    def _is_silent(self, number: int) -> bool:
        return any(
            fault.time_s <= self.now < fault.time_s + fault.duration_s
            for fault in self.spec.faults
            if isinstance(fault, Silence) and fault.robot == number
        )

    def _switch_on(self, robot: _Robot) -> None:
        robot.state, robot.hears = "on", True
        if self._is_silent(robot.number):
            self._silence(robot)

    def _silence(self, robot: _Robot) -> None:
        if robot.state in ("on", "done") and robot.hears:
            robot.hears = False
            self._record(FellSilent(time_s=self.now, robot=robot.number))

    def _come_back(self, robot: _Robot) -> None:
        if robot.state in ("on", "done") and not robot.hears and not self._is_silent(robot.number):
            robot.hears = True
            self._record(CameBack(time_s=self.now, robot=robot.number))

    # ---------------------------------------------------------------------------------------

    def _later(self, delay_s: float, then: Callable[[], None]) -> None:
        _Later(self.clock, delay_s, then)

    def _record(self, event: AnyEvent) -> None:
        self.recorder.record(event)
        if self.watch is not None:
            self.watch(event)


def _said(end: Ended) -> tuple[object, ...]:
    return end.reason, end.complete, end.frontier


def _require_start(trajectory: Trajectory, configuration: Configuration, number: int) -> None:
    start = trajectory.start
    turn = abs(math.remainder(start.heading - configuration.heading, 2.0 * math.pi))
    if start.distance(configuration) > 1e-9 or turn > 1e-9:
        raise InvalidInputError(
            f"the explorer of robot {number} yielded a trajectory from {start}, "
            f"but the robot is at {configuration}"
        )
