"""A whole explorer: everything that a robot does, from its first scan to its end.

multisrt check mine.py
multisrt explore museum --strategy mine.py --robots 3
multisrt why runs/museum-mine-0 --all
"""

from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from multisrt.events import Learned, MapComplete
from multisrt.robots.explorer import (
    Done,
    Look,
    Move,
    Note,
    Receive,
    Received,
    RobotSelf,
    Send,
    Sense,
    Steps,
)
from multisrt.robots.knowledge import Node
from multisrt.robots.toolkit import Frontier, FrontierMap, Message, decided, trajectory_inside


class Options(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters, to be set with --option NAME=VALUE.

    Attributes
    ----------
    leg_s : float
        Driving time between two scans, in seconds.
    patience : int
        Number of successive attempts blocked by other robots before it gives up.
    """

    leg_s: float = 1.0
    patience: int = 100


class News(Message, frozen=True):
    """What a robot has seen, and where it is."""

    node: Node
    place: tuple[float, float]


class Mine:
    """Drive to the nearest frontier among those to which the fewest robots are nearer."""

    def __init__(self, me: RobotSelf, options: Options) -> None:
        self.me, self.options = me, options
        self.at, self.time_s = me.start, me.time_s
        self.map = FrontierMap(me)
        self.others: dict[int, tuple[float, float]] = {}  # last reported places
        self.knows_all = False

    def run(self) -> Steps:
        """Yield actions, and receive their outcomes."""
        barred = 0
        while barred < self.options.patience:
            yield from self.look_around()
            frontiers = self.map.frontiers(self.at)
            if not frontiers:
                if not self.knows_all:  # Recorded once, until new data is received.
                    self.knows_all = True
                    yield Note(MapComplete(time_s=self.time_s, robot=self.me.robot))
                # Done, but on call: data from others may open new frontiers.
                told = yield Done(complete=True, reason="no frontier is left", on_call=True)
                yield from self.take(told)
                continue
            bodies: Any = yield Look()
            with self.map.around(bodies):
                goal, costs = self.choose(frontiers)
                path = self.map.path(self.at, goal)
            has_gone = False
            if path is not None:
                reason = "the nearest of those to which fewest are nearer"
                yield decided(self.me, self.time_s, reason, goal, frontiers, path_m=costs)
                has_gone = yield from self.go(goal, path)
            barred = 0 if has_gone else barred + 1
            # While others are in the way, wait a little before trying again.
            yield from self.listen(0.0 if has_gone else self.me.rng.uniform(1.0, 3.0))
        yield Done(complete=False, reason="other robots block all paths")

    def choose(self, frontiers: tuple[Frontier, ...]) -> tuple[Frontier, NDArray[np.float64]]:
        """Return the frontier to go to, and the length of the path to each in metres."""
        costs = self.map.costs([self.at, *self.others.values()], frontiers)
        nearer = (costs[1:] < costs[0]).sum(axis=0)
        return frontiers[int(np.lexsort((costs[0], nearer))[0])], costs[0]

    def go(self, goal: Frontier, path: Any) -> Any:
        """Follow a path until the next scan; return False if another robot was in the way."""
        assert self.map.region is not None
        motion = trajectory_inside(self.me, self.at, path, self.map.region)
        if motion is None:  # Already there with nothing new to see, or too narrow.
            self.map.give_up(goal)
            return True
        moved: Any = yield Move(trajectory=motion.until(self.options.leg_s), guard_m=0.1)
        self.at = moved.configuration
        return moved.blocked_by is None

    def look_around(self) -> Steps:
        """Scan; add what is new to the map, record it, and inform the others."""
        scan: Any = yield Sense()
        self.time_s = scan.time_s
        node = self.map.add(scan)
        if node is not None:
            self.knows_all = False
            yield Note(node.added("root" if node.parent is None else "scan"))
            yield Send(News(node=node, place=self.at[:2], sender=self.me.robot))

    def listen(self, seconds: float) -> Steps:
        """Wait for messages, at most for some time."""
        yield from self.take((yield Receive(timeout_s=seconds)))

    def take(self, told: Any) -> Steps:
        """Add to the map what others have seen."""
        for news in told.messages if isinstance(told, Received) else ():
            if isinstance(news, News):
                self.others[news.sender] = news.place
                new = self.map.merge([news.node])
                if new:
                    self.knows_all = False
                    yield Note(Learned(time_s=told.time_s, robot=self.me.robot, nodes=new))
