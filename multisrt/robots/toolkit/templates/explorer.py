"""A whole explorer: what a robot does, from its first scan to its last word.

multisrt check mine.py
multisrt explore museum --strategy mine.py --robots 3
multisrt why runs/museum-mine-0/recording.jsonl --all
"""

from typing import Any

import msgspec
import numpy as np

from multisrt.events import Learned
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
        How long the robot drives from scan to scan, in seconds.
    patience : int
        How often in a row other robots may stand in all its ways before it gives up.
    """

    leg_s: float = 1.0
    patience: int = 100


class News(Message, frozen=True):
    """What a robot has seen, and where it is."""

    nodes: tuple[Node, ...]
    place: tuple[float, float]


class Mine:
    """Drive to the nearest of the frontiers to which fewest robots are nearer."""

    def __init__(self, me: RobotSelf, options: Options) -> None:
        self.me, self.options = me, options
        self.at, self.time_s = me.start, me.time_s
        self.map = FrontierMap(me)
        self.others: dict[int, tuple[float, float]] = {}  # where each was last heard from

    def run(self) -> Steps:
        """Yield actions, and be sent what came of them."""
        barred = 0
        yield from self.look_around()
        while barred < self.options.patience:
            yield from self.listen(0.0)
            if not self.map.frontiers(self.at):
                # Done, but on call: others may send something that leads on.
                told: Any = yield Done(complete=True, reason="no frontier is left", on_call=True)
                yield from self.take(told)
                continue
            bodies: Any = yield Look()
            with self.map.around(bodies):
                goal = self.choose()
            if goal is not None:
                yield decided(self.me, self.time_s, "fewest are nearer, then the nearest", goal)
            has_gone = goal is not None and (yield from self.go(goal))
            barred = 0 if has_gone else barred + 1
            if not has_gone:
                yield from self.step_aside()
        yield Done(complete=False, reason="other robots stand in all ways")

    def choose(self) -> Frontier | None:
        """Return the frontier to go to, or None if other robots stand in all ways."""
        frontiers = self.map.frontiers(self.at)
        if not frontiers:
            return None
        costs = self.map.costs([self.at, *self.others.values()], frontiers)
        nearer = (costs[1:] < costs[0]).sum(axis=0)
        return frontiers[int(np.lexsort((costs[0], nearer))[0])]

    def go(self, goal: Frontier) -> Any:
        """Drive to a frontier until nothing is left to see; return False if robots bar the way."""
        while self.map.is_frontier(goal):
            path = yield from self.path_to(goal)
            moved = None if path is None else (yield from self.drive(path))
            if path is None or (moved is not None and moved.blocked_by is not None):
                return False
            if moved is None:  # It stands there, or does not fit through.
                self.map.give_up(goal)
                break
        return True

    def path_to(self, place: Any) -> Any:
        """Return the path to a place round the robots in sight, or None."""
        bodies: Any = yield Look()
        with self.map.around(bodies):
            return self.map.path(self.at, place)

    def drive(self, path: Any) -> Any:
        """Follow a path until the next scan; return how the motion ended, None if there is none."""
        assert self.map.region is not None
        way = trajectory_inside(self.me, self.at, path, self.map.region)
        if way is None:
            return None
        moved: Any = yield Move(trajectory=way.until(self.options.leg_s), guard_m=0.1)
        self.at, self.time_s = moved.configuration, moved.time_s
        yield from self.look_around()
        return moved

    def step_aside(self) -> Steps:
        """Let others pass: wait a little, and go back towards a place where a scan was taken."""
        yield from self.listen(self.me.rng.uniform(0.5, 2.0))
        nodes = list(self.map.entries.nodes.values())
        path = yield from self.path_to(nodes[self.me.rng.integers(len(nodes))])
        if path is not None and self.me.rng.random() < 0.5:
            yield from self.drive(path)

    def look_around(self) -> Steps:
        """Scan; put what is new on the map and on record, and tell the others."""
        scan: Any = yield Sense()
        node = self.map.add(scan)
        if node is not None:
            yield Note(node.added("root" if node.parent is None else "scan"))
            yield Send(News(nodes=(node,), place=self.at[:2], sender=self.me.robot))

    def listen(self, seconds: float) -> Steps:
        """Take messages for some time; 0: those that are there."""
        until_s = self.time_s + seconds
        told: Any = yield Receive(timeout_s=seconds)
        while isinstance(told, Received):
            yield from self.take(told)
            told = yield Receive(timeout_s=max(0.0, until_s - self.time_s))
        self.time_s = told.time_s

    def take(self, told: Received) -> Steps:
        """Add what others have seen to the map."""
        self.time_s = told.time_s
        for news in told.messages:
            if isinstance(news, News):
                self.others[news.sender] = news.place
                new = self.map.merge(news.nodes)
                if new:
                    yield Note(Learned(time_s=self.time_s, robot=self.me.robot, nodes=new))
