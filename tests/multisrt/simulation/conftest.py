"""Scripted robots, what they say, and the hall that they drive in."""

import math
from collections.abc import Callable, Generator, Iterable
from typing import Any, ClassVar

import msgspec
import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.recording import Recording
from multisrt.robots import registry
from multisrt.robots.explorer import Done, Move, Receive, RobotSelf, Send
from multisrt.robots.messages import Message
from multisrt.robots.strategy import Strategy
from multisrt.simulation.journal import Watcher
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec, StopRule

HALL = Environment("hall", shapely.box(0, 0, 10, 6))
STARTS = ((1.0, 1.0), (1.0, 3.0), (1.0, 5.0))

# Scripts may yield what is no action.
Acts = Generator[Any, Any, None]
Script = Iterable[Any] | Callable[[], Acts]


class NoOptions(msgspec.Struct, frozen=True, kw_only=True):
    pass


class Word(Message, frozen=True, kw_only=True):
    kind: ClassVar[str] = "word"
    text: str = ""


class Call(Word, frozen=True, kw_only=True):
    kind: ClassVar[str] = "call"

    @property
    def wakes(self) -> bool:
        return True


class Actor:
    """An explorer that follows a list of actions or a generator, and keeps the outcomes."""

    me: RobotSelf

    def __init__(self, script: Script) -> None:
        self.script = script
        self.told: list[Any] = []

    def run(self) -> Acts:
        acts = self.script() if callable(self.script) else iter(self.script)
        outcome = None
        while True:
            try:
                action = acts.send(outcome) if isinstance(acts, Generator) else next(acts)
            except StopIteration:
                return
            outcome = yield action
            self.told.append(outcome)


@pytest.fixture
def act(monkeypatch) -> Callable[..., tuple[Recording, list[Actor]]]:
    """Run robots by their scripts in a world; return the recording and the explorers."""

    def run(
        *scripts: Script,
        robots: Iterable[RobotSpec],
        world: Environment = HALL,
        max_time_s: float = 1000.0,
        stop: StopRule | None = None,
        watch: Watcher | None = None,
        **spec: Any,
    ) -> tuple[Recording, list[Actor]]:
        actors = [Actor(script) for script in scripts]

        def build(me: RobotSelf, options: NoOptions) -> Actor:
            actors[me.robot].me = me
            return actors[me.robot]

        strategy = Strategy(name="script", summary="", options=NoOptions, explorer=build)
        monkeypatch.setitem(registry._registry(), "script", strategy)
        run_spec = RunSpec(
            environment=inline(world),
            strategy="script",
            robots=tuple(robots),
            stop=stop or StopRule(max_time_s=max_time_s),
            **spec,
        )
        return simulate(run_spec, world, watch=watch), actors

    return run


@pytest.fixture
def play(act) -> Callable[..., tuple[Recording, list[list[Any]]]]:
    """Run robots by their scripts; return the recording and the outcomes of each."""

    def run(
        *scripts: Script, starts: Iterable[tuple[float, ...]] = STARTS, **more: Any
    ) -> tuple[Recording, list[list[Any]]]:
        robots = [RobotSpec(start=start) for start, _ in zip(starts, scripts, strict=False)]
        recording, actors = act(*scripts, robots=robots, **more)
        return recording, [actor.told for actor in actors]

    return run


@pytest.fixture
def drive(act) -> Callable[..., tuple[Recording, Actor]]:
    """Run one robot by its actions; return the recording and the explorer."""

    def run(*script: Any, robot: RobotSpec | None = None, **more: Any) -> tuple[Recording, Actor]:
        recording, actors = act(script, robots=[robot or RobotSpec(start=STARTS[0])], **more)
        return recording, actors[0]

    return run


@pytest.fixture(scope="session")
def hall() -> Environment:
    """A hall of 10 x 6 m."""
    return HALL


@pytest.fixture(scope="session")
def word() -> type[Word]:
    """A message with a text."""
    return Word


@pytest.fixture(scope="session")
def call() -> type[Call]:
    """A message with a text that wakes its receiver."""
    return Call


@pytest.fixture(scope="session")
def straight() -> Callable[..., Move]:
    """Build a motion along a straight line, at half a metre a second unless a time is given."""

    def build(
        x0: float,
        y0: float,
        x1: float,
        y1: float,
        *,
        heading: float = 0.0,
        seconds: float | None = None,
        **more: Any,
    ) -> Move:
        time = 2.0 * math.hypot(x1 - x0, y1 - y0) if seconds is None else seconds
        waypoints = Waypoint(0.0, x0, y0, heading), Waypoint(time, x1, y1, heading)
        return Move(trajectory=Trajectory(waypoints), **more)

    return build


@pytest.fixture(scope="session")
def sends_each_second() -> Callable[..., Script]:
    """Build a script that sends messages a second apart, the first after a second."""

    def build(*messages: Message) -> Script:
        def acts() -> Acts:
            for message in messages:
                yield Receive(1.0)
                yield Send(message)
            yield Done(complete=True, reason="enough")

        return acts

    return build
