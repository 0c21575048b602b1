"""Supervision of explorers while a run goes on: what they yield, keep and are allowed to know."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import NoReturn, ParamSpec, TypeVar

import msgspec
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import Event
from multisrt.geometry.numerics.arrays import builtin
from multisrt.geometry.regions.scan import ExactScan, LaserScan
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, standing_at
from multisrt.robots.code_places import place_of_yield, place_suffix
from multisrt.robots.defects import ExplorerDefect
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
    Steps,
    Stop,
    TimedOut,
)
from multisrt.simulation import plain, protocol
from multisrt.testing.code_reading import own_code_of
from multisrt.testing.fingerprint import fingerprint
from multisrt.testing.hidden_truth import named_by_code, path_to_truth, truth_named_by_code
from multisrt.testing.known_space import KnownSpace, seen_in
from multisrt.testing.motion_rules import pose, trajectory_flaw
from multisrt.testing.own_code import back_door, outside_in, place_of_frame
from multisrt.testing.watchdog import ComputesTooLong, Limits, Watchdog

MAX_ACTIONS_AT_ONCE = 1000
"""Actions at one moment by which time must pass."""

LAST_ACTIONS = 100
"""How many of the last actions are counted for a message."""

USUAL = "an explorer ends with Done, whatever happens"
"""What to do about an exception that does not tell more."""

SEARCHES = (1, 3, 10, 30, 100, 300, 1000, 3000)
"""Numbers of actions after which an explorer is searched for the truth."""


P = ParamSpec("P")
T = TypeVar("T")


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
    limits : Limits
        What ends an explorer that does not end.
    watchdog : Watchdog
        Calls explorers.
    only_known : bool
        Whether a body must stay in what its robot has sensed or may have been told of.

    Attributes
    ----------
    robots : list of SupervisedExplorer
        In the order of their numbers.
    defect : ExplorerDefect or None
        The first defect that was found.
    known : KnownSpace
        What the robots may know to be free.
    """

    def __init__(
        self,
        world: Environment,
        title: str,
        *,
        limits: Limits,
        watchdog: Watchdog,
        only_known: bool,
    ) -> None:
        self.world = world
        self.title = title
        self.limits = limits
        self.watchdog = watchdog
        self.only_known = only_known
        self.robots: list[SupervisedExplorer] = []
        self.defect: ExplorerDefect | None = None
        self.known = KnownSpace()

    def supervise(self, me: RobotSelf, explorer: Explorer) -> Explorer:
        """Return the supervised explorer that takes the place of an explorer."""
        self.robots.append(SupervisedExplorer(self, me, explorer))
        return self.robots[-1]

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
        self._known = supervision.known
        self._explorer = explorer
        self._actions: Steps | None = None
        self._at = me.start
        self._now_s = me.time_s
        self._moment = me.time_s, 0
        self._moving: tuple[Move, float] | None = None
        self._kept: list[tuple[str, object, bytes]] = [("its RobotSelf", me, fingerprint(me))]
        body = Sweep(me.footprint, standing_at(me.start))
        self._known.add(me.robot, body.shape.buffer(body.pad_m))

    def run(self) -> Steps:
        """Drive the inner explorer."""
        try:
            yield from self._run()
        except ExplorerDefect as defect:
            self._supervision.defect = defect
            raise

    def _run(self) -> Steps:
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

    def _begin(self) -> Steps:
        self._search()
        return self._called(protocol.begin, self._explorer, self.me.robot, USUAL)

    def _next(self, outcome: Outcome) -> Action:
        assert self._actions is not None
        self._require_progress()
        given = len(self._kept)
        if outcome is not None:
            self._keep(outcome)
        try:
            action = self._called(
                protocol.next_action,
                self._explorer,
                self._actions,
                outcome,
                self.me.robot,
                USUAL,
            )
        except ExplorerDefect as defect:
            # An attempt to write to a read-only array is a change of what was given.
            for what, _, _ in self._kept[given:]:
                if "read-only" in defect.what:
                    self._refuse_change(what, cause=defect.__cause__)
            raise
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

    def _called(self, what: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        # What a function returns that runs the explorer's own code.
        try:
            return self._supervision.watchdog.call(what, *args, **kwargs)
        except ComputesTooLong as late:
            cls = type(self._explorer)
            limit_s = self._supervision.limits.max_decision_s
            self._refuse(
                f"it has computed for {limit_s:g} s and yields nothing"
                + place_suffix(place_of_frame(cls, late.frame)),
                "see that every loop ends or yields, or give a larger "
                "max_decision_s (--max-decision)",
            )
        except ExplorerDefect as defect:
            if defect.is_refusal:
                self._refuse(defect.what, defect.remedy, defect.__cause__)
            # Code of this package refuses what the explorer's own code returns: a rule.
            self._refuse(f"{defect.where}: {defect.what}", defect.remedy, defect)

    def _require_progress(self) -> None:
        count, limits = len(self.turns), self._supervision.limits
        if count >= limits.max_actions:
            self._refuse(
                f"it yielded {count} actions and was not Done; {self.last_actions()}",
                "see that every exploration ends, or give a larger max_actions (--max-actions)",
            )
        moment_s, before = self._moment
        if moment_s != self._now_s:
            self._moment = self._now_s, count
        elif count - before >= MAX_ACTIONS_AT_ONCE:
            self._refuse(
                f"it yielded {count - before} actions at {self._now_s:g} s and lets no time pass; "
                f"{self.last_actions()}",
                "have it move, wait with a Receive that does not end at once, or end",
            )

    def last_actions(self) -> str:
        """Return what it yielded at last, in words."""
        kinds = [type(turn.action).__name__ for turn in self.turns[-LAST_ACTIONS:]]
        counts = ", ".join(f"{n} {kind}" for kind, n in Counter(kinds).most_common())
        return f"the last were {counts}"

    def _keep(self, outcome: Outcome) -> None:
        if isinstance(outcome, Received):
            for message in outcome.messages:
                kind = type(message).__name__
                what = f"a message ({kind}) of robot {message.sender} that it was sent"
                self._kept.append((what, message, fingerprint(message)))
            return
        names = {ExactScan: "a scan", LaserScan: "a scan", tuple: "a tuple of sightings"}
        name = names.get(type(outcome), f"a {type(outcome).__name__}")
        self._kept.append((f"{name} that it was sent", outcome, fingerprint(outcome)))

    def _take(self, action: Action, outcome: Outcome) -> None:
        # Updates what the robot knows: where it is, what it has seen, what it may have been told.
        if isinstance(outcome, ExactScan | LaserScan):
            self._now_s = outcome.time_s
            self._known.add(self.me.robot, seen_in(outcome))
        elif isinstance(outcome, Moved):
            move, set_out_s = self._moving or (None, 0.0)
            if move is not None and move.listen:
                # It may have sensed more on the way: what it has driven is what counts.
                self._require_known(move.trajectory.until(outcome.time_s - set_out_s))
            self._now_s, self._at, self._moving = outcome.time_s, outcome.configuration, None
        elif isinstance(outcome, Received):
            self._now_s = outcome.time_s
            self._known.hear(self.me.robot, outcome.messages)
        elif isinstance(outcome, TimedOut):
            self._now_s = outcome.time_s
        if isinstance(action, Done):
            self.is_done = False  # It was called on.

    # What it yields ----------------------------------------------------------------------

    def _check(self, action: Action) -> None:
        robot = self.me.robot
        with self._refusals(action):
            protocol.require_in_order(action, robot, moves=self._moving is not None)
            match action:
                case Sense() | Look() | Stop():
                    pass
                case Move():
                    move = plain.motion(action, robot)
                    self._check_move(move)
                    self._moving = move, self._now_s
                case Send():
                    self._check_send(action)
                case Receive():
                    wait_s = plain.timeout_s(action, robot)
                    if wait_s is not None and wait_s < 0.0:
                        self._refuse(
                            f"timeout_s of its Receive is {wait_s:g}",
                            "give 0 or more seconds, or None to wait for ever",
                        )
                case Note(event):
                    plain.event(event, robot, self._now_s)
                    self._check_types(event)
                case Done():
                    plain.ended(action, robot, self._now_s)
                    plain.is_on_call(action, robot)
                    self.is_done = True
                case _:
                    protocol.refuse_action(action, robot)
        if len(self.turns) in SEARCHES or isinstance(action, Done):
            self._search()

    def _check_types(self, event: Event) -> None:
        # What is recorded is read again with the types that its class declares.
        declared = plain.as_declared(event, self.me.robot)
        before, after = (msgspec.json.encode(e, enc_hook=builtin) for e in (event, declared))
        if before != after:
            self._refuse(
                f"its {type(event).__name__} has a whole number where its class declares a float",
                "write 1.0 or float(x): a recording is read with the declared types",
            )

    def _check_send(self, send: Send) -> None:
        plain.size_bytes(send.message, self.me.robot)
        to = plain.addressee(send.to, self.me.robot)
        if to is not None and to not in range(self.me.team):
            self._refuse(
                f"it sent a message to robot {to}",
                f"the team's robots are 0 to {self.me.team - 1}: give one of them, or None for all"
                if self.me.team > 1
                else "it is alone: give None for all that there may be",
            )
        self._known.tell(self.me.robot, send.message)
        what = f"a message ({type(send.message).__name__}) that it had sent"
        self._kept.append((what, send.message, fingerprint(send.message)))

    # Motion ------------------------------------------------------------------------------

    def _check_move(self, move: Move) -> None:
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
        rest = self._known.unknown_part(self.me.robot, sweep.shape, sweep.pad_m)
        if rest.is_empty:
            return
        place = shapely.point_on_surface(rest)
        self._refuse(
            f"on its way from {pose(trajectory.start)} to {pose(trajectory.end)} its body covers "
            f"{rest.area:.3g} m2 that it has neither sensed nor been told of, around "
            f"({place.x:.3f}, {place.y:.3f})",
            "move within what its scans show to be free; only_known=False (--anywhere) lets this "
            "pass",
        )

    # The truth ---------------------------------------------------------------------------

    def _search(self) -> None:
        cls = own_code_of(self._explorer)
        if door := back_door(cls):
            self._refuse(
                f"its code names {door}, by which it could reach the truth",
                "an explorer knows its scans, its messages and its RobotSelf, and that is all",
            )
        if files := outside_in(cls):
            self._refuse(
                f"its code names {files}, by which it could read files while it runs, such as the "
                "recording that is being written",
                "read what it needs, such as weights, when its module is imported or in __init__; "
                "log by the module logging, or put decisions on record with decided(...)",
            )
        found = truth_named_by_code(cls)
        if found is None:
            roots = {"explorer": self._explorer, "run()": self._actions, **named_by_code(cls)}
            found = path_to_truth(roots, self._supervision.world)
        if found is not None:
            path, what = found
            self._refuse(
                f"it reaches the truth: {path} is {what}",
                "an explorer knows its scans, its messages and its RobotSelf, and that is all",
            )

    # Refusals ----------------------------------------------------------------------------

    def _refuse(self, what: str, remedy: str, cause: BaseException | None = None) -> NoReturn:
        me = self.me
        who = "the robot" if me.team == 1 else f"robot {me.robot} of {me.team}"
        when = f"action {len(self.turns)}" if self.turns else "before its first action"
        where = f"{who} in {self._supervision.title}, {when}"
        raise ExplorerDefect(what, where, remedy) from cause

    def _refuse_change(self, what: str, cause: BaseException | None = None) -> NoReturn:
        self._refuse(
            f"{what} was changed",
            "copy what is to be changed: all that is given is kept",
            cause,
        )

    @contextmanager
    def _refusals(self, action: Action) -> Iterator[None]:
        # What the simulation refuses is told with the place in the run, and in the code.
        try:
            yield
        except ExplorerDefect as defect:
            if defect.is_refusal:
                noted = isinstance(action, Note)
                place = place_of_yield(type(self._explorer), self._actions) if noted else ""
                self._refuse(f"{defect.what}{place_suffix(place)}", defect.remedy)
            raise
