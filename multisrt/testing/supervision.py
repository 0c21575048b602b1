"""Supervising an explorer while a run goes on: what it yields, keeps and is allowed to know."""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Generator
from itertools import pairwise
from typing import Any, NoReturn

import msgspec
import numpy as np
import shapely
from numpy.random import Generator as RandomGenerator
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.events import Event
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import MultiSrtError
from multisrt.geometry.regions.scan import ExactScan, LaserScan, Scan
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import (
    NO_TURN_RAD,
    Trajectory,
    Waypoint,
    leg_length,
    standing_at,
)
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
    Stop,
    TimedOut,
)
from multisrt.robots.messages import Message
from multisrt.testing.hidden_truth import named_by_code, truth_named_by_code, way_to_truth

LIMIT_TOLERANCE = 1e-6
"""By this share a body may exceed its speed, its turn rate and its curvature: rounding."""

ASIDE_TOLERANCE_M = 1e-6
"""So far a body that drives along its heading may come off that line: rounding."""

START_TOLERANCE = 1e-9
"""A trajectory begins within this of where the robot is, in metres and radians."""

UNKNOWN_TOLERANCE_M = 0.005
"""So far a body may reach beyond what was sensed: chords stand for arcs in both."""

SEARCHES = (1, 3, 10, 30, 100, 300, 1000, 3000)
"""After so many actions it is asked whether the explorer holds the truth."""


class ExplorerDefect(MultiSrtError, AssertionError):
    """An explorer does what the contract of explorers does not allow.

    Attributes
    ----------
    what : str
        What it did.
    where : str
        In which run, which robot, at which action.
    remedy : str
        What to change.
    """

    def __init__(self, what: str, where: str, remedy: str) -> None:
        super().__init__(what, where, remedy)
        self.what = what
        self.where = where
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{self.where}: {self.what}; {self.remedy}"


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """One turn of an explorer: what it was sent, and what it then yielded.

    Attributes
    ----------
    outcome : Outcome
        What it was sent.
    action : Action
        What it yielded.
    print : bytes
        Fingerprint of the action.
    """

    outcome: Outcome
    action: Action
    print: bytes


class Supervision:
    """Supervises all explorers of one run.

    Parameters
    ----------
    world : Environment
        The truth, to recognise it.
    title : str
        What messages call the run.
    max_actions : int
        After so many actions an explorer ought to be done.
    only_known : bool
        Whether a body has to stay in what its robot sensed or may have been told of.

    Attributes
    ----------
    robots : list of SupervisedExplorer
        In the order of their numbers.
    defect : ExplorerDefect or None
        The first that was found.
    """

    def __init__(
        self, world: Environment, title: str, *, max_actions: int, only_known: bool
    ) -> None:
        self.world = world
        self.title = title
        self.max_actions = max_actions
        self.only_known = only_known
        self.robots: list[SupervisedExplorer] = []
        self.defect: ExplorerDefect | None = None
        self.regions: list[BaseGeometry] = []
        self._told: dict[int, tuple[Message, int]] = {}

    def supervise(self, me: RobotSelf, explorer: Explorer) -> Explorer:
        """Put an explorer under supervision; what comes back takes its place."""
        self.robots.append(SupervisedExplorer(self, me, explorer))
        return self.robots[-1]

    def add_region(self, region: BaseGeometry) -> int:
        """Keep a region that someone sensed; give the bit that stands for it."""
        self.regions.append(region)
        return 1 << (len(self.regions) - 1)

    def tell(self, message: Message, known: int) -> None:
        """Remember what the sender of a message knew: its message may say all of it."""
        before = self._told.get(id(message), (message, 0))[1]
        self._told[id(message)] = message, before | known

    def told(self, message: Message) -> int:
        """Give what a message may say."""
        return self._told.get(id(message), (message, 0))[1]

    def finish(self) -> None:
        """Check that nothing that was given or sent was changed until the end.

        Raises
        ------
        ExplorerDefect
            If something was.
        """
        for robot in self.robots:
            robot.check_kept()


class SupervisedExplorer:
    """An explorer that is watched: it yields what the inner one yields, once that is checked.

    Attributes
    ----------
    me : RobotSelf
        The robot.
    turns : list of Turn
        What it was sent and yielded.
    is_done : bool
        Whether its last action was `Done`.
    """

    def __init__(self, supervision: Supervision, me: RobotSelf, explorer: Explorer) -> None:
        self.me = me
        self.turns: list[Turn] = []
        self.is_done = False
        self._supervision = supervision
        self._explorer = explorer
        self._actions: Generator[Action, Outcome, None] | None = None
        self._at = me.start
        self._now_s = me.time_s
        self._moving: tuple[Move, float] | None = None
        self._kept: list[tuple[str, object, bytes]] = [("its RobotSelf", me, fingerprint(me))]
        body = Sweep(me.footprint, standing_at(me.start))
        self._known = supervision.add_region(body.shape.buffer(body.pad_m))

    def run(self) -> Generator[Action, Outcome, None]:
        """Drive the inner explorer."""
        try:
            yield from self._run()
        except ExplorerDefect as defect:
            self._supervision.defect = defect
            raise

    def _run(self) -> Generator[Action, Outcome, None]:
        self._actions = self._begin()
        outcome: Outcome = None
        while True:
            action = self._next(outcome)
            mark = fingerprint(action)
            self.turns.append(Turn(outcome=outcome, action=action, print=mark))
            self._check(action)
            outcome = yield action
            self._take(action, outcome)

    def check_kept(self) -> None:
        """Check that what the robot was given, and what it sent, is as it was."""
        for what, thing, mark in self._kept:
            if fingerprint(thing) != mark:
                self._refuse_change(what)

    # What goes in and out ----------------------------------------------------------------

    def _begin(self) -> Generator[Action, Outcome, None]:
        self._search()
        try:
            actions = self._explorer.run()
        except Exception as error:
            self._refuse_error(error)
        if not hasattr(actions, "send"):
            self._refuse(
                f"run() gave a {type(actions).__name__}, not a generator",
                "write run() as a generator: it yields actions and is sent their outcomes",
            )
        return actions

    def _next(self, outcome: Outcome) -> Action:
        assert self._actions is not None
        if len(self.turns) >= self._supervision.max_actions:
            self._refuse(
                f"it yielded {len(self.turns)} actions and was not Done",
                "see that every exploration ends, or give a larger max_actions",
            )
        given = len(self._kept)
        if outcome is not None:
            self._keep(outcome)
        try:
            action = self._actions.send(outcome)
        except StopIteration:
            self._refuse("run() ended without a last action Done", "yield Done at the end")
        except ExplorerDefect:
            raise
        except Exception as error:
            # An array that is read-only tells of the same defect as one that was changed.
            for what, _, _ in self._kept[given:]:
                if "read-only" in str(error):
                    self._refuse_change(what)
            self._refuse_error(error)
        for what, thing, mark in (self._kept[0], *self._kept[given:]):
            if fingerprint(thing) != mark:
                self._refuse_change(what)
        if self.turns and fingerprint(self.turns[-1].action) != self.turns[-1].print:
            self._refuse(
                f"the {type(self.turns[-1].action).__name__} that it had yielded was changed "
                "afterwards",
                "build a new action, trajectory or message instead of changing one",
            )
        return action

    def _keep(self, outcome: Outcome) -> None:
        if isinstance(outcome, Received):
            for message in outcome.messages:
                what = f"a message ({message.kind}) of robot {message.sender} that it was sent"
                self._kept.append((what, message, fingerprint(message)))
            return
        names = {ExactScan: "a scan", LaserScan: "a scan", tuple: "a tuple of sightings"}
        name = names.get(type(outcome), f"a {type(outcome).__name__}")
        self._kept.append((f"{name} that it was sent", outcome, fingerprint(outcome)))

    def _take(self, action: Action, outcome: Outcome) -> None:
        # What the robot knows now: where it is, what it has seen, what it may have been told.
        if isinstance(outcome, ExactScan | LaserScan):
            self._now_s = outcome.time_s
            self._known |= self._supervision.add_region(_seen(outcome))
        elif isinstance(outcome, Moved):
            move, set_out_s = self._moving or (None, 0.0)
            if move is not None and move.listen:
                # On the way it may have sensed more: it is judged by what it has driven.
                self._require_known(move.trajectory.until(outcome.time_s - set_out_s))
            self._now_s, self._at, self._moving = outcome.time_s, outcome.configuration, None
        elif isinstance(outcome, Received):
            self._now_s = outcome.time_s
            for message in outcome.messages:
                self._known |= self._supervision.told(message)
        elif isinstance(outcome, TimedOut):
            self._now_s = outcome.time_s
        if isinstance(action, Done):
            self.is_done = False  # It was called on.

    # What it yields ----------------------------------------------------------------------

    def _check(self, action: Action) -> None:
        match action:
            case Sense() | Look():
                pass
            case Move():
                self._check_move(action)
                self._moving = action, self._now_s
            case Stop():
                if self._moving is None:
                    self._refuse("it yielded Stop, but it stands", "Stop ends a motion: Move first")
            case Send():
                self._check_send(action)
            case Receive(timeout_s):
                if timeout_s is not None and not (_is_number(timeout_s) and timeout_s >= 0.0):
                    self._refuse(
                        f"it yielded Receive with timeout_s={timeout_s!r}",
                        "give 0 or more seconds, or None to wait for ever",
                    )
            case Note(event):
                if not isinstance(event, Event) or event.robot != self.me.robot:
                    self._refuse(
                        f"it put {event!r} on record",
                        f"give Note an event of multisrt.events with robot={self.me.robot}",
                    )
            case Done():
                if self._moving is not None:
                    self._refuse("it was Done while it moved", "wait for Moved, or yield Stop")
                self.is_done = True
            case _:
                self._refuse(
                    f"it yielded {_brief(action)}, which is no action",
                    "yield instances of Sense, Look, Move, Stop, Send, Receive, Note and Done",
                )
        if len(self.turns) in SEARCHES or isinstance(action, Done):
            self._search()

    def _check_send(self, send: Send) -> None:
        if not isinstance(send.message, Message):
            self._refuse(
                f"it sent {_brief(send.message)}, which is no message",
                "derive a class from multisrt.robots.messages.Message",
            )
        if send.to is not None and send.to not in range(self.me.team):
            self._refuse(
                f"it sent a message to robot {send.to!r}",
                f"the team's robots are 0 to {self.me.team - 1}; None is all of them",
            )
        try:
            _ = send.message.size_bytes
        except (TypeError, ValueError, OverflowError) as error:
            self._refuse(
                f"it sent a message that cannot be written: {error}",
                "messages hold numbers, text, tuples, structures and read-only numpy arrays",
            )
        self._supervision.tell(send.message, self._known)
        what = f"a message ({send.message.kind}) that it had sent"
        self._kept.append((what, send.message, fingerprint(send.message)))

    # Motion ------------------------------------------------------------------------------

    def _check_move(self, move: Move) -> None:
        if self._moving is not None:
            self._refuse(
                "it yielded Move while a motion goes on",
                "yield Receive to wait for the motion's end, or Stop",
            )
        trajectory = move.trajectory
        if not isinstance(trajectory, Trajectory):
            self._refuse(f"it yielded Move with {_brief(trajectory)}", "give Move a Trajectory")
        self._check_waypoints(trajectory)
        for a, b in pairwise(trajectory.waypoints):
            self._check_leg(a, b)
        if not move.listen:
            self._require_known(trajectory)

    def _check_waypoints(self, trajectory: Trajectory) -> None:
        waypoints = trajectory.waypoints
        if not isinstance(waypoints, tuple) or not waypoints:
            self._refuse(
                f"the trajectory's waypoints are {_brief(waypoints)}",
                "give a tuple of at least one Waypoint",
            )
        for number, waypoint in enumerate(waypoints):
            is_one = isinstance(waypoint, Waypoint)
            if not is_one or not all(_is_number(value) for value in waypoint):
                self._refuse(
                    f"waypoint {number} of its trajectory is {_brief(waypoint)}",
                    "waypoints are Waypoint(time_s, x, y, heading) with finite numbers",
                )
        times = [waypoint.time_s for waypoint in waypoints]
        for number, (before_s, after_s) in enumerate(pairwise([0.0, *times])):
            if after_s < before_s or (number == 0 and after_s != 0.0):
                self._refuse(
                    f"waypoint {number} of its trajectory is at {after_s:g} s, after "
                    f"{before_s:g} s",
                    "times of a trajectory count from 0 at its start and never fall",
                )
        start, at = trajectory.start, self._at
        turn = abs(math.remainder(start.heading - at.heading, 2.0 * math.pi))
        if start.distance(at) > START_TOLERANCE or turn > START_TOLERANCE:
            self._refuse(
                f"its trajectory begins at {_pose(start)}, but the robot is at {_pose(at)}",
                "begin where the last Moved says that the robot is, heading included",
            )

    def _check_leg(self, a: Waypoint, b: Waypoint) -> None:
        # Speed, rate of turning, and what the kind of drive cannot do at all.
        drive, way = self.me.kinematics, f"from {_pose(a[1:])} to {_pose(b[1:])}"
        length, turn, time_s = leg_length(a, b), abs(b.heading - a.heading), b.time_s - a.time_s
        most_m = drive.speed_m_s * time_s * (1.0 + LIMIT_TOLERANCE) + START_TOLERANCE
        if length > most_m:
            self._refuse(
                f"it drives {length:.6g} m {way} in {time_s:.6g} s",
                f"its kinematics allow {drive.speed_m_s:g} m/s",
            )
        turns = turn > NO_TURN_RAD
        if isinstance(drive, Differential) and turn > (
            drive.turn_rate_rad_s * time_s * (1.0 + LIMIT_TOLERANCE) + START_TOLERANCE
        ):
            self._refuse(
                f"it turns by {turn:.6g} rad {way} in {time_s:.6g} s",
                f"its kinematics allow {drive.turn_rate_rad_s:g} rad/s",
            )
        if isinstance(drive, Holonomic):
            if turns:
                self._refuse(f"it turns {way}", "a holonomic body keeps its heading")
            return
        middle = 0.5 * (a.heading + b.heading)
        dx, dy = b.x - a.x, b.y - a.y
        ahead = dx * math.cos(middle) + dy * math.sin(middle)
        aside = abs(dy * math.cos(middle) - dx * math.sin(middle))
        if aside > ASIDE_TOLERANCE_M:
            self._refuse(
                f"it moves sideways, by {aside:.3g} m, {way}",
                "its kinematics drive along the heading: turn first",
            )
        if isinstance(drive, Car):
            least_m = turn * drive.turning_radius_m * (1.0 - LIMIT_TOLERANCE)
            if turns and length < least_m - START_TOLERANCE:
                self._refuse(
                    f"its curve is too tight {way}",
                    f"the car's turning radius is {drive.turning_radius_m:g} m",
                )
            if ahead < -ASIDE_TOLERANCE_M and not drive.reverse:
                self._refuse(f"it drives backwards {way}", "this car drives forwards only")

    def _require_known(self, trajectory: Trajectory) -> None:
        if not self._supervision.only_known:
            return
        sweep = Sweep(self.me.footprint, trajectory)
        rest: BaseGeometry = sweep.shape.buffer(sweep.pad_m - UNKNOWN_TOLERANCE_M)
        known, regions = self._known, self._supervision.regions
        for number in range(len(regions) - 1, -1, -1):
            if rest.is_empty:
                return
            if known >> number & 1 and shapely.intersects(regions[number], rest):
                rest = rest.difference(regions[number])
        # Slits between regions that meet are rounding.
        if rest.buffer(-0.5 * UNKNOWN_TOLERANCE_M).is_empty:
            return
        place = shapely.point_on_surface(rest)
        self._refuse(
            f"on its way from {_pose(trajectory.start)} to {_pose(trajectory.end)} its body covers "
            f"{rest.area:.3g} m2 that it has neither sensed nor been told of, around "
            f"({place.x:.3f}, {place.y:.3f})",
            "move within what its scans show to be free; only_known=False lets this pass",
        )

    # The truth ---------------------------------------------------------------------------

    def _search(self) -> None:
        cls = type(self._explorer)
        found = truth_named_by_code(cls)
        if found is None:
            roots = {"explorer": self._explorer, "run()": self._actions, **named_by_code(cls)}
            found = way_to_truth(roots, self._supervision.world)
        if found is not None:
            way, what = found
            self._refuse(
                f"it gets at the truth: {way} is {what}",
                "an explorer knows its scans, its messages and its RobotSelf, and that is all",
            )

    # Refusals ----------------------------------------------------------------------------

    def _refuse(self, what: str, remedy: str, cause: Exception | None = None) -> NoReturn:
        me = self.me
        who = "the robot" if me.team == 1 else f"robot {me.robot} of {me.team}"
        where = f"{who} in {self._supervision.title}, action {len(self.turns)}"
        raise ExplorerDefect(what, where, remedy) from cause

    def _refuse_change(self, what: str) -> NoReturn:
        self._refuse(f"{what} was changed", "copy what is to be changed: all that is given is kept")

    def _refuse_error(self, error: Exception) -> NoReturn:
        self._refuse(
            f"it raised {type(error).__name__}: {error}",
            "an explorer ends with Done, whatever happens",
            error,
        )


def fingerprint(value: object) -> bytes:
    """Give a digest of a value: equal values have equal ones, in whatever objects.

    Streams of random numbers do not count: to draw from one changes it.
    """
    return _digest(value, {})


def _digest(value: Any, known: dict[int, bytes]) -> bytes:
    # What occurs more than once is looked at once; what holds itself ends there.
    kind = type(value)
    digest = hashlib.sha256(f"<{kind.__module__}.{kind.__qualname__}>".encode())
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic):
        digest.update(repr(value).encode())
        return digest.digest()
    if id(value) in known:
        return known[id(value)]
    known[id(value)] = digest.digest()
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest.update(f"{value.dtype}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, BaseGeometry):
        digest.update(shapely.to_wkb(value))
    elif isinstance(value, Footprint):
        digest.update(str(value).encode())
    elif isinstance(value, set | frozenset):
        digest.update(b"".join(sorted(_digest(item, known) for item in value)))
    elif not isinstance(value, RandomGenerator | type):
        for part in _parts(value):
            digest.update(_digest(part, known))
    known[id(value)] = digest.digest()
    return known[id(value)]


def _parts(value: Any) -> list[Any]:
    # What a value consists of, in order, and how many parts that are.
    if isinstance(value, tuple | list):
        return [len(value), *value]
    if isinstance(value, np.ndarray):
        return [value.shape, *value.ravel().tolist()]
    if isinstance(value, dict):
        return [len(value), *(part for item in value.items() for part in item)]
    if isinstance(value, msgspec.Struct):
        return [getattr(value, name) for name in value.__struct_fields__]
    if dataclasses.is_dataclass(value):
        return [getattr(value, field.name) for field in dataclasses.fields(value)]
    return [part for item in getattr(value, "__dict__", {}).items() for part in item]


def _seen(scan: Scan) -> BaseGeometry:
    # What a scan shows to be free; of a laser as much as the ends of its beams allow.
    if isinstance(scan, ExactScan):
        polygon = shapely.Polygon(scan.boundary)
    else:
        reach = np.where(np.isfinite(scan.ranges), scan.ranges, scan.range_m)
        angle = 2.0 * np.pi * np.arange(len(reach)) / len(reach)
        x, y, _ = scan.configuration
        ends = np.column_stack([x + reach * np.cos(angle), y + reach * np.sin(angle)])
        polygon = shapely.Polygon(ends)
    return polygon if polygon.is_valid else shapely.make_valid(polygon)


def _is_number(value: object) -> bool:
    is_real = isinstance(value, int | float | np.integer | np.floating)
    return is_real and math.isfinite(value)  # type: ignore[arg-type]


def _pose(configuration: Configuration | tuple[float, ...]) -> str:
    return "({:.3f}, {:.3f}, {:.3f})".format(*configuration)


def _brief(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
