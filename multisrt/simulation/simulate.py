"""The simulation: an interpreter of explorers' actions over a discrete-event clock.

It holds the truth. It moves bodies along their trajectories, takes their scans, carries their
messages, injects the faults of the spec, and checks every motion against the world and all other
bodies. It proceeds from event to event: the cost of a run depends on what happens in it, not on
how long that takes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from functools import lru_cache
from pathlib import Path

from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.collision import CollisionWorld
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.recording import Recorder, Recording, RunOutcome, atomic_write, header_of
from multisrt.robots.explorer import Explorer, RobotSelf
from multisrt.robots.registry import strategy
from multisrt.simulation.clock import Clock
from multisrt.simulation.faults import Faults, late_starts
from multisrt.simulation.interpreter import Interpreter, Surroundings
from multisrt.simulation.journal import Journal, Watcher
from multisrt.simulation.mail import Mail
from multisrt.simulation.motions import Motions
from multisrt.simulation.radio import Radio
from multisrt.simulation.random_streams import RandomStreams
from multisrt.simulation.robot import Robot
from multisrt.simulation.sensing import Sensing
from multisrt.simulation.starts import starts_of
from multisrt.simulation.traffic import Traffic
from multisrt.simulation.worlds import build_environment
from multisrt.spec import RunSpec


def simulate(
    spec: RunSpec,
    environment: Environment | None = None,
    *,
    path: str | Path | None = None,
    watch: Watcher | None = None,
    planning: Callable[[float], None] | None = None,
) -> Recording:
    """Simulate an exploration.

    Parameters
    ----------
    spec : RunSpec
        Everything that the run depends on.
    environment : Environment, optional
        The world that `spec.environment` describes, if it has been built already.
    path : path, optional
        File to which the recording is written while the run goes on.
    watch : callable, optional
        Called with every event as it is recorded.
    planning : callable, optional
        Called with the share that is done while a strategy that sees the truth plans the run.

    Returns
    -------
    Recording
        All that happened. An exploration that stalls or runs out of time is a result, too.

    Raises
    ------
    InvalidInputError
        If the spec cannot be run (the world, a start, the strategy or its options), or if `path`
        cannot be written.
    ExplorerDefect
        If an explorer yields something that it cannot do; it is an `InvalidInputError`, too.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, simulate
    >>> spec = RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1)
    >>> recording = simulate(spec)
    >>> recording.footer.outcome
    'complete'
    >>> simulate(spec).footer.digest == recording.footer.digest
    True
    """
    # Equal specs give equal runs, also where one has whole numbers and the other has fractions.
    spec = spec.canonical()
    chosen = strategy(spec.strategy)
    options = chosen.parse_options(spec.options)
    chosen.require_fit(spec)
    if environment is None:
        environment = build_environment(spec.environment)
    streams = RandomStreams(spec.seed)
    starts = starts_of(spec, environment, streams)
    team_range_m = max(robot.range_finder.range_m for robot in spec.robots)
    index = EdgeIndex(environment.edges, team_range_m / 3.0)
    radio = Radio(spec.radio, index, streams.of("radio"))
    joins = late_starts(spec.faults)
    orders: Sequence[object] = [None] * len(spec.robots)
    if chosen.plan is not None:
        orders = chosen.plan(spec, environment, starts, planning)
    explorers = [
        chosen.explorer(
            RobotSelf(
                robot=number,
                start=start,
                footprint=Footprint.parse(robot.footprint),
                kinematics=robot.drive.kinematics(),
                range_m=robot.range_finder.range_m,
                rng=streams.of("robots", number),
                team=len(spec.robots),
                radio=radio.datasheet(),
                time_s=joins.get(number, 0.0),
                team_range_m=team_range_m,
                orders=orders[number],
            ),
            options,
        )
        for number, (robot, start) in enumerate(zip(spec.robots, starts, strict=True))
    ]
    header = header_of(spec, environment, starts)
    world = _collision_world(environment)
    opened = nullcontext() if path is None else atomic_write(Path(path))
    with opened as file:
        journal = Journal(Recorder(header, file), watch)
        simulation = _Simulation(spec, world, index, radio, journal, starts)
        time_s, outcome, reason = simulation.run(explorers)
        return journal.finish(time_s, outcome, reason, chance=streams.are_drawn_from)


@lru_cache(maxsize=8)
def _collision_world(environment: Environment) -> CollisionWorld:
    # Solids are built once for many runs in one world.
    return CollisionWorld(environment.free)


class _Simulation:
    """One run."""

    def __init__(
        self,
        spec: RunSpec,
        world: CollisionWorld,
        index: EdgeIndex,
        radio: Radio,
        journal: Journal,
        starts: tuple[Configuration, ...],
    ) -> None:
        self.spec = spec
        self.clock = clock = Clock()
        self.journal = journal
        self.robots = robots = [
            Robot(number, robot, world.body(Footprint.parse(robot.footprint)), clock)
            for number, robot in enumerate(spec.robots)
        ]
        traffic = Traffic([robot.body for robot in robots], starts, index)
        sensing = Sensing(index, traffic, robots)
        self.motions = Motions(
            robots,
            world,
            traffic,
            sensing,
            clock=clock,
            journal=journal,
            max_time_s=spec.stop.max_time_s,
        )
        self.mail = Mail(robots, radio, spec.radio, traffic, clock=clock, journal=journal)
        self.faults = Faults(spec.faults, robots, self.motions, clock=clock, journal=journal)
        self.surroundings = Surroundings(
            clock=clock,
            journal=journal,
            sensing=sensing,
            motions=self.motions,
            mail=self.mail,
            faults=self.faults,
        )

    def run(self, explorers: list[Explorer]) -> tuple[float, RunOutcome, str]:
        """Return when the run ended (s), how, and why."""
        joins = late_starts(self.spec.faults)
        for robot in self.robots:
            if robot.number not in joins:
                # All are switched on before the first of them sends anything.
                self.faults.switch_on(robot)
        processes = [
            Interpreter(robot, explorer, self.surroundings).process(joins.get(robot.number))
            for robot, explorer in zip(self.robots, explorers, strict=True)
        ]
        for process in processes:
            self.clock.start(process)
        max_time_s = self.spec.stop.max_time_s
        try:
            while not self._is_over() and self.clock.next_s <= max_time_s:
                self.clock.step()
        finally:
            # Suspended processes would keep the robots' maps until garbage is collected.
            for process in processes:
                process.close()
        if not self._is_over() and max_time_s < self.clock.next_s < math.inf:
            self.motions.end_all(max_time_s)
            reason = f"the {max_time_s:g} s of the stop rule are over"
            return max_time_s, "out_of_time", reason
        return self.journal.last_s, *self._outcome()

    def _is_over(self) -> bool:
        # All are done or dead, and no message is on its way that could call one on.
        if self.motions.collision is not None:
            return True
        if self.mail.on_the_air > 0:
            return False
        for robot in self.robots:
            if robot.state == "dead":
                continue
            # One that is done and not on call waits for nothing.
            if robot.state != "done" or (robot.mailbox and robot.waits):
                return False
        return True

    def _outcome(self) -> tuple[RunOutcome, str]:
        if (collision := self.motions.collision) is not None:
            return "stalled", f"robot {collision.robot} {collision.account}"
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
