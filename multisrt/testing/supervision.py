"""Supervision of explorers while a run goes on: what they yield, keep and are allowed to know."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import NoReturn

import msgspec
import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from multisrt.environments.environment import Environment
from multisrt.events import Event
from multisrt.geometry.numerics.arrays import builtin
from multisrt.geometry.regions.scan import ExactScan, LaserScan, Scan
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, standing_at
from multisrt.robots.defects import ExplorerDefect, brief
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
from multisrt.simulation.plain import as_declared
from multisrt.testing.fingerprint import fingerprint
from multisrt.testing.hidden_truth import named_by_code, truth_named_by_code, way_to_truth
from multisrt.testing.motion_rules import is_number, pose, trajectory_flaw

UNKNOWN_TOLERANCE_M = 0.005
"""Distance by which a body may reach beyond what was sensed: chords stand for arcs in both."""

SEARCHES = (1, 3, 10, 30, 100, 300, 1000, 3000)
"""Numbers of actions after which an explorer is searched for the truth."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """One turn of an explorer.

    Attributes
    ----------
    outcome : Outcome
        What it was sent.
    action : Action
        What it then yielded.
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
        The truth.
    title : str
        Name of the run in messages.
    max_actions : int
        Number of actions by which an explorer must be done.
    only_known : bool
        Whether a body must stay in what its robot has sensed or may have been told of.

    Attributes
    ----------
    robots : list of SupervisedExplorer
        In the order of their numbers.
    defect : ExplorerDefect or None
        The first defect that was found.
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
        """Return the supervised explorer that takes the place of an explorer."""
        self.robots.append(SupervisedExplorer(self, me, explorer))
        return self.robots[-1]

    def add_region(self, region: BaseGeometry) -> int:
        """Keep a region that a robot sensed; return the bit that stands for it."""
        self.regions.append(region)
        return 1 << (len(self.regions) - 1)

    def tell(self, message: Message, known: int) -> None:
        """Note what the sender of a message knew: the message may contain all of it."""
        before = self._told.get(id(message), (message, 0))[1]
        self._told[id(message)] = message, before | known

    def told(self, message: Message) -> int:
        """Return the regions that a message may contain, as bits."""
        return self._told.get(id(message), (message, 0))[1]

    def finish(self) -> None:
        """Check that nothing that was given or sent has been changed by the end of the run.

        Raises
        ------
        ExplorerDefect
            If something has been.
        """
        for robot in self.robots:
            robot.check_kept()


class SupervisedExplorer:
    """An explorer that checks each action of another one, and then yields it.

    Attributes
    ----------
    me : RobotSelf
        What the robot knows of itself.
    turns : list of Turn
        What the explorer was sent and yielded.
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
            # An attempt to write to a read-only array is a change of what was given.
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
        # Updates what the robot knows: where it is, what it has seen, what it may have been told.
        if isinstance(outcome, ExactScan | LaserScan):
            self._now_s = outcome.time_s
            self._known |= self._supervision.add_region(_seen(outcome))
        elif isinstance(outcome, Moved):
            move, set_out_s = self._moving or (None, 0.0)
            if move is not None and move.listen:
                # It may have sensed more on the way: what it has driven is what counts.
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
                if timeout_s is not None and not (is_number(timeout_s) and timeout_s >= 0.0):
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
                self._check_types(event)
            case Done():
                if self._moving is not None:
                    self._refuse("it was Done while it moved", "wait for Moved, or yield Stop")
                self.is_done = True
            case _:
                self._refuse(
                    f"it yielded {brief(action)}, which is no action",
                    "yield instances of Sense, Look, Move, Stop, Send, Receive, Note and Done",
                )
        if len(self.turns) in SEARCHES or isinstance(action, Done):
            self._search()

    def _check_types(self, event: Event) -> None:
        # What is recorded is read again with the types that its class declares.
        try:
            declared = as_declared(event, self.me.robot)
        except ExplorerDefect as defect:
            self._refuse(defect.what, defect.remedy)
        before, after = (msgspec.json.encode(e, enc_hook=builtin) for e in (event, declared))
        if before != after:
            self._refuse(
                f"its {type(event).__name__} has a whole number where its class declares a float",
                "write 1.0 or float(x): a recording is read with the declared types",
            )

    def _check_send(self, send: Send) -> None:
        if not isinstance(send.message, Message):
            self._refuse(
                f"it sent {brief(send.message)}, which is no message",
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
        flaw = trajectory_flaw(trajectory, self._at, self.me.kinematics)
        if flaw is not None:
            self._refuse(*flaw)
        if not move.listen:
            self._require_known(trajectory)

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
        # Slits between adjacent regions come from rounding.
        if rest.buffer(-0.5 * UNKNOWN_TOLERANCE_M).is_empty:
            return
        place = shapely.point_on_surface(rest)
        self._refuse(
            f"on its way from {pose(trajectory.start)} to {pose(trajectory.end)} its body covers "
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


def _seen(scan: Scan) -> BaseGeometry:
    # The region that a scan shows to be free; for a laser the polygon of the ends of its beams.
    if isinstance(scan, ExactScan):
        polygon = shapely.Polygon(scan.boundary)
    else:
        reach = np.where(np.isfinite(scan.ranges), scan.ranges, scan.range_m)
        angle = 2.0 * np.pi * np.arange(len(reach)) / len(reach)
        x, y, _ = scan.configuration
        ends = np.column_stack([x + reach * np.cos(angle), y + reach * np.sin(angle)])
        polygon = shapely.Polygon(ends)
    return polygon if polygon.is_valid else shapely.make_valid(polygon)
