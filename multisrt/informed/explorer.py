"""One robot of an informed team: it drives the stages that it was given, and scans after each."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import ExactScan, LaserScan
from multisrt.informed.options import InformedOptions
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.explorer import (
    Action,
    Done,
    Move,
    Moved,
    Note,
    Outcome,
    Receive,
    RobotSelf,
    Sense,
    Steps,
    TimedOut,
)
from multisrt.robots.knowledge import Node, NodeId

GUARD_M = 0.02
"""Guard distance of the protective stop in metres, below the distance that is planned."""

RETRY_S, MAX_RETRIES = 0.5, 240
"""Waiting time of a robot whose path is blocked, in seconds, and maximum number of waits."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """A motion that a robot is to make.

    Attributes
    ----------
    begin_s : float
        When, in seconds since the robot began.
    motion : Trajectory
        The motion.
    scans : bool
        Whether it takes a scan at the end.
    """

    begin_s: float
    motion: Trajectory
    scans: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Orders:
    """The orders of one robot.

    Attributes
    ----------
    stages : tuple of Stage
        Its motions in order.
    complete : bool
        Whether all robots together see what they are to see.
    reason : str
        What they see, in words.
    """

    stages: tuple[Stage, ...]
    complete: bool
    reason: str


class InformedExplorer:
    """Drives its stages on time.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself; its `orders` are those of the plan.
    options : InformedOptions
        Options of the strategy, which the plan has heeded.

    Raises
    ------
    InvalidInputError
        If it was given no orders.
    """

    def __init__(self, me: RobotSelf, options: InformedOptions) -> None:
        if not isinstance(me.orders, Orders):
            raise InvalidInputError(
                f"robot {me.robot} of the strategy 'informed' has no orders; they come from its "
                "plan, which `simulate` makes"
            )
        self._me = me
        self._orders = me.orders
        self._made = 0
        self._retries = 0

    def run(self) -> Steps:
        """Yield actions and be sent their outcomes."""
        me, orders = self._me, self._orders
        yield from self._scan()
        now_s = me.time_s
        for stage in orders.stages:
            begin_s = me.time_s + stage.begin_s
            now_s = yield from self._wait(now_s, begin_s)
            left = stage.motion
            while True:
                outcome = yield Move(trajectory=left, guard_m=GUARD_M if me.team > 1 else None)
                assert isinstance(outcome, Moved)
                driven_s, now_s = outcome.time_s - now_s, outcome.time_s
                if outcome.blocked_by is None:
                    break
                self._retries += 1
                if self._retries > MAX_RETRIES:
                    other = outcome.blocked_by.robot
                    yield Done(complete=False, reason=f"robot {other} stands in the way")
                    return
                left = left.after(driven_s)
                now_s = yield from self._wait(now_s, now_s + RETRY_S)
            if stage.scans:
                yield from self._scan()
        yield Done(complete=orders.complete, reason=orders.reason)

    def _wait(self, now_s: float, until_s: float) -> Generator[Action, Outcome, float]:
        while until_s > now_s:
            outcome = yield Receive(until_s - now_s)
            if isinstance(outcome, TimedOut):
                return outcome.time_s
        return now_s

    def _scan(self) -> Steps:
        scan = yield Sense()
        assert isinstance(scan, ExactScan | LaserScan)
        serial = self._made
        self._made += 1
        node = Node(
            id=NodeId(self._me.robot, serial),
            configuration=scan.configuration,
            region=local_safe_region(scan, "radial"),
            parent=NodeId(self._me.robot, serial - 1) if serial else None,
            time_s=scan.time_s,
        )
        yield Note(node.added("scan" if serial else "root"))
