"""Strategies of strangers: scripts in JSON of what explorers yield, and the runs in which they do.

A script is ``{"first": [...], "again": [...], "rounds": 3}``: actions that are yielded once, and
actions that are yielded again and again; ``"built"`` is evaluated when the explorer is built. A
value is made of an object with a key ``make``, such as ``{"make": "Move", "trajectory": {"make":
"way", "places": [[1, 0]]}}``; `MAKERS` lists what there is besides the actions and events. So
anything that a generator may yield is a tree that can be damaged, and a strategy that broke the
simulation can be kept as a file.

What no script does is to compute for ever within one decision, or to swallow the processor in one:
the simulation calls the code of explorers and cannot stop it. `multisrt.testing.check_explorer`
and the limits of experiments do.
"""

from __future__ import annotations

import builtins
import json
import math
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final, get_args

import numpy as np
import shapely

from benchmarks.fuzz.trees import Tree
from multisrt.campaign.invariants import INVARIANTS, JudgedRun
from multisrt.environments.environment import Environment
from multisrt.events import Collision, NotedEvent
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.recording import Recording, RunOutcome
from multisrt.robots.explorer import Action, Done, Moved, RobotSelf, Steps
from multisrt.robots.messages import Message
from multisrt.robots.registry import registered
from multisrt.robots.strategy import Strategy
from multisrt.robots.toolkit import trajectory
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import BaseSpec, RadioSpec, RobotSpec, RunSpec, StopRule

NAME: Final = "scripted"
"""Name of the strategy of all scripts."""

WORLD: Final = Environment(
    "two rooms", shapely.box(0, 0, 6, 3).difference(shapely.box(2.9, 0, 3.1, 2))
)
ROBOTS: Final = (RobotSpec(start=(1.0, 1.0, 0.0)), RobotSpec(start=(5.0, 1.0, 0.0)))

MAX_TIME_S: Final = 60.0
"""Simulated time after which a run ends."""

MAX_YIELDS: Final = 2000
"""Upper bound of what a script yields before its end; `for ever` alone is not bounded."""


class Words(Message, frozen=True):
    """A message with any content."""

    content: Any = None


class Call(Message, frozen=True):
    """A message with any content that wakes."""

    wakes = True
    content: Any = None


class Nameless(Message, frozen=True):
    """A message whose kind is no name."""

    kind = 5  # type: ignore[assignment]


class Sleepless(Message, frozen=True):
    """A message that cannot say whether it wakes."""

    @property
    def wakes(self) -> bool:
        """Raise an error."""
        raise KeyError("no text")


class Weightless(Message, frozen=True):
    """A message without a size."""

    @property
    def size_bytes(self) -> int:
        """Raise an error."""
        raise KeyError("no text")


class Scripted:
    """Yields what its script says."""

    content: bytes = b""

    def __init__(self, me: RobotSelf) -> None:
        self.me = me
        self.at = me.start
        self.now_s = me.time_s
        self._yielded = 0
        if b'"built"' in self.content:
            self.made(json.loads(self.content)["built"])

    def run(self) -> Steps:
        """Yield the actions of the script, and at last that it is done."""
        script = json.loads(self.content)
        for tree in script["first"]:
            yield from self._yielding(tree)
        for _ in range(min(int(script["rounds"]), MAX_YIELDS)):
            for tree in script["again"]:
                yield from self._yielding(tree)
                if self._yielded > MAX_YIELDS:
                    return
        yield Done(complete=False, reason="the script is over")

    def _yielding(self, tree: Tree) -> Iterator[Any]:
        while True:
            outcome: Any = yield self.made(tree)
            self._yielded += 1
            self.now_s = getattr(outcome, "time_s", self.now_s)
            if isinstance(outcome, Moved):
                self.at = outcome.configuration
            if not (isinstance(tree, dict) and tree.get("for ever")):
                return

    def made(self, tree: Tree) -> Any:
        """Return what a tree of a script describes."""
        if isinstance(tree, list):
            return tuple(map(self.made, tree))
        if not isinstance(tree, dict):
            return tree
        fields = {name: self.made(value) for name, value in tree.items() if name != "for ever"}
        name = fields.pop("make", None)
        if isinstance(name, str) and name in KINDS:
            return KINDS[name](**fields)
        if isinstance(name, str) and name in EVENTS:
            return EVENTS[name](**{"time_s": self.now_s, "robot": self.me.robot} | fields)
        if isinstance(name, str) and name in MAKERS:
            return MAKERS[name](self, fields)
        return fields


KINDS: Final[dict[str, Callable[..., Any]]] = {
    kind.__name__: kind
    for kind in (
        *(*get_args(Action), Trajectory, Waypoint, Configuration),
        *(Message, Words, Call, Nameless, Sleepless, Weightless),
    )
}
"""Actions and what they are made of, by name."""

EVENTS: Final[dict[str, Callable[..., Any]]] = {
    kind.__name__: kind for kind in (*get_args(NotedEvent), Collision)
}
"""Events by name; time and robot are those of the explorer if they are not given."""


def _way(explorer: Scripted, fields: dict[str, Any]) -> Trajectory:
    x, y, _ = explorer.at
    places = [(x + dx, y + dy) for dx, dy in fields["places"]]
    return trajectory(explorer.me.kinematics, explorer.at, places)


def _onward(explorer: Scripted, fields: dict[str, Any]) -> Trajectory:
    # A straight line, at a constant speed, as no drive may be able to go.
    x, y, heading = explorer.at
    end = Waypoint(fields["time_s"], x + fields["dx"], y + fields["dy"], heading + fields["turn"])
    return Trajectory((Waypoint(0.0, x, y, heading), end))


def _raise(explorer: Scripted, fields: dict[str, Any]) -> None:
    kind: Any = getattr(builtins, str(fields.get("error")), None)
    text = fields.get("text", "")
    # Errors for want of memory would be taken for those of the reader.
    is_error = isinstance(kind, type) and issubclass(kind, Exception | SystemExit)
    raise kind(text) if is_error and kind is not MemoryError else ValueError(text)


def _own_list(explorer: Scripted, fields: dict[str, Any]) -> list[Any]:
    made: list[Any] = [fields]
    made.append(made)
    return made


def _deep(explorer: Scripted, fields: dict[str, Any]) -> Any:
    made: Any = None
    for _ in range(2_000):
        made = (made,)
    return made


class _Rude:
    """An object that cannot be printed."""

    def __repr__(self) -> str:
        raise KeyError("no text")


def _generator(explorer: Scripted, fields: dict[str, Any]) -> Any:
    return (k for k in range(3))


@np.errstate(over="ignore")
def _single(value: Any) -> np.float32:
    return np.float32(value)


MAKERS: Final[dict[str, Callable[[Scripted, dict[str, Any]], Any]]] = {
    "way": _way,
    "onward": _onward,
    "raise": _raise,
    "own list": _own_list,
    "deep": _deep,
    "generator": _generator,
    "here": lambda explorer, fields: explorer.at,
    "near": lambda explorer, fields: (explorer.at.x + fields["dx"], explorer.at.y + fields["dy"]),
    "x": lambda explorer, fields: explorer.at.x,
    "y": lambda explorer, fields: explorer.at.y,
    "heading": lambda explorer, fields: explorer.at.heading,
    "now": lambda explorer, fields: explorer.now_s,
    "me": lambda explorer, fields: explorer.me,
    "number": lambda explorer, fields: explorer.me.robot,
    "nan": lambda explorer, fields: math.nan,
    "inf": lambda explorer, fields: math.inf,
    "object": lambda explorer, fields: object(),
    "rude": lambda explorer, fields: _Rude(),
    "function": lambda explorer, fields: _way,
    "class": lambda explorer, fields: Done,
    "bytes": lambda explorer, fields: b"\xff" * 100,
    "set": lambda explorer, fields: {1, "a"},
    "list": lambda explorer, fields: list(fields.get("of", ())),
    "array": lambda explorer, fields: np.array(fields.get("of", (1.0, math.nan))),
    "objects": lambda explorer, fields: np.array([None, object()], dtype=object),
    "many": lambda explorer, fields: np.zeros(1_000_000),
    "long": lambda explorer, fields: "long " * 100_000,
    "numpy": lambda explorer, fields: _single(fields.get("of", 0.1)),
    "whole": lambda explorer, fields: 10**400,
    "complex": lambda explorer, fields: 1j,
}
"""What else there is, by name."""

NAMES: Final = tuple(json.dumps({"make": name}).encode() for name in (*MAKERS, *KINDS, *EVENTS))
"""The dictionary of scripts."""

REFUSALS: Final = ("robot ", f"'{NAME}'", " s: ")
"""What every refusal says: the robot, its strategy and the time."""


def run_script(path: Path, *, radio: bool = False) -> Recording:
    """Return the recording of a run of a script.

    Parameters
    ----------
    path : Path
        The script.
    radio : bool
        Whether the radio has a range and delays, and there is a base station.
    """

    class Own(Scripted):
        """Yields what the script of this file says."""

        content = path.read_bytes()

    spec = RunSpec(
        environment=inline(WORLD),
        strategy=NAME,
        robots=ROBOTS,
        stop=StopRule(max_time_s=MAX_TIME_S, max_idle_s=30.0),
        radio=RadioSpec(range_m=3.0, latency_s=0.5) if radio else RadioSpec(),
        base=BaseSpec(x=1.0, y=2.5) if radio else None,
    )
    with registered(Strategy.of(Own, name=NAME)):
        return simulate(spec, WORLD)


def flaw_of_run(recording: Recording) -> str:
    """Return what is wrong with a run: a motion through a wall, or a recording that is not read.

    A collision ends a run, and its recording says so: robots may drive into a wall, not through.
    """
    run = JudgedRun(recording=recording, environment=WORLD)
    if recording.footer.outcome not in get_args(RunOutcome) or not recording.footer.reason:
        return f"the outcome is {recording.footer.outcome!r}: {recording.footer.reason!r}"
    for name in ("motion-continuous", "no-collision"):
        is_told = name == "no-collision" and recording.of(Collision)
        if not is_told and (violation := INVARIANTS[name](run)):
            return str(violation)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.jsonl"
        recording.save(path)
        try:
            again = Recording.load(path)
        except InvalidInputError as error:
            return f"its recording cannot be read: {error}"
    return "" if again.events == recording.events else "its recording is read as another"
