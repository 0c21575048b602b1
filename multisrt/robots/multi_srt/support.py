"""SUPPORT_OTHERS: a robot that is done with its own tree helps to extend others' (Figure 5)."""

from __future__ import annotations

import math
from collections.abc import Generator

from multisrt.events import Supports
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.srt import Draws
from multisrt.robots.exploration_map import NodeId
from multisrt.robots.explorer import Action, Note, Outcome
from multisrt.robots.multi_srt.build_srt import (
    MOST_WAITS,
    Plan,
    as_far_as_it_gets,
    build_srt,
    move_to,
    on_the_way,
    take_steps,
)
from multisrt.robots.multi_srt.messages import Order
from multisrt.robots.multi_srt.robot import SrtRobot

Steps = Generator[Action, Outcome, None]

CHECK_S = 30.0
"""A robot that waits for others asks them after this time whether they are still there."""

MOMENT_S = 1.0
"""News that come within this time are looked at together."""

AWAY_S = 5.0
"""A robot that gave way and is out of sight of its home goes there again after this time."""


def support_others(robot: SrtRobot) -> Steps:
    """SUPPORT_OTHERS: extend others' trees until every other robot is done.

    With a limited radio only what nobody else will do: the frontier of robots that have not
    been heard of for a long time (`take_over_after_s`).
    """
    while True:
        tree = yield from select(robot)
        if tree is not None:
            yield from as_far_as_it_gets(robot, support(robot, tree))
            robot.tried[tree] = open_frontier(robot, tree)
            yield from as_far_as_it_gets(robot, transfer_to(robot, robot.root, None))
            yield from robot.team.rest()
        elif exploration_running(robot):
            yield from wait_for_news(robot)
        else:
            return


def support(robot: SrtRobot, tree: NodeId) -> Steps:
    """Extend another robot's tree."""
    yield from transfer_to(robot, tree, tree)
    robot.purpose, robot.completing = "support", True
    yield from build_srt(robot)


def select(robot: SrtRobot) -> Generator[Action, Outcome, NodeId | None]:
    """SELECT: of the trees that may need support (paper: I), choose one.

    A tree may need it if its open frontier is at least `support_m` (paper: F bar) for each robot
    that is active in it.
    """
    yield from robot.tell_when_complete()
    if not robot.options.support or robot.here is None:
        return None
    known, options = robot.map, robot.options
    open_m = {root: open_frontier(robot, root) for root in known.roots()}
    active = {root: active_robots(robot, root) for root in open_m}
    threshold = robot.me.range_m if options.support_m is None else options.support_m
    candidates = [
        root
        for root in open_m
        if open_m[root] > robot.tried.get(root, 0.0)
        and open_m[root] >= threshold * active[root]
        and (robot.is_unlimited or not _is_cared_for(robot, root))
    ]
    if not candidates:
        return None
    robot.ways.extend()
    if options.select == "most_recent":
        candidates.sort(key=lambda root: (-_last_extended_s(robot, root), root))
        chosen = next((r for r in candidates if robot.way(robot.here, r) is not None), None)
    else:
        way = robot.ways.to_nearest(robot.here, lambda node: node in candidates, robot.is_passable)
        chosen = None if way is None else way[-1]
    if chosen is None and robot.bypass(lambda node: node in candidates) is not None:
        *others, last = candidates
        chosen = next((r for r in others if robot.bypass(r.__eq__) is not None), last)
    if chosen is None and tuple(candidates) == robot.considered:
        return None
    robot.considered = tuple(candidates)
    yield Note(
        Supports(
            time_s=robot.time_s,
            robot=robot.me.robot,
            tree=None if chosen is None else chosen.robot,
            open_frontier_m={root.robot: length for root, length in open_m.items()},
            active_robots={root.robot: count for root, count in active.items()},
            candidates=tuple(root.robot for root in candidates),
        )
    )
    return chosen


def open_frontier(robot: SrtRobot, root: NodeId) -> float:
    """OPEN_FRONTIER: sum of the local frontiers of a tree's nodes, in metres."""
    return robot.map.open_frontier_m(root)


def active_robots(robot: SrtRobot, root: NodeId) -> int:
    """ACTIVE_ROBOTS: how many robots extend a tree, as far as is known.

    With a limited radio those that were not heard of for long count no more.
    """
    team = robot.team
    return sum(
        state.tree == root
        for number, state in team.states.items()
        if number not in team.lost
        and (robot.is_unlimited or _gives_up_s(robot, number) > robot.time_s)
    )


def transfer_to(robot: SrtRobot, end: NodeId, tree: NodeId | None) -> Steps:
    """TRANSFER_TO: go to a node over the roadmap, every hop coordinated as a step.

    Where others stand in the way for good, a place before the node is near enough.

    Parameters
    ----------
    robot : SrtRobot
        Who goes.
    end : NodeId
        Where to.
    tree : NodeId or None
        The tree in which it counts as active meanwhile.
    """
    robot.tree = tree
    robot.purpose = "home" if end == robot.root else "support"

    def way_on(robot: SrtRobot, frontier: FloatArray, draws: Draws) -> Plan:
        assert robot.here is not None
        yield from ()  # a planner may put events on record; this one has none
        robot.ways.extend()
        way = robot.way(robot.here, end)
        if robot.here == end or (way is not None and is_near_enough(robot, way)):
            return "end", None
        return on_the_way(robot, end, "transfer")

    robot.target = None
    yield from robot.team.begin_step()
    yield from take_steps(robot, way_on)


def is_near_enough(robot: SrtRobot, way: list[NodeId]) -> bool:
    """Whether what is left of a way need not be gone.

    Another robot stands at its end, and has nothing to do that would take it away; or the end
    is within range and the robot was told to wait time after time.
    """
    if robot.team.troubles >= MOST_WAITS and robot.way_length_m(way) <= robot.me.range_m:
        return True
    at = robot.map[way[-1]].configuration
    reach = 2.0 * robot.body.outer_radius_m + robot.options.guard_m
    standing = [state.place for state in robot.team.states.values() if state.phase == "idle"]
    standing += [(*sighting.configuration,) for sighting in robot.bodies.values()]
    return len(way) == 2 and any(math.dist(at[:2], place[:2]) < reach for place in standing)


def exploration_running(robot: SrtRobot) -> bool:
    """EXPLORATION_RUNNING: whether another robot has not yet reported that it is done."""
    team = robot.team
    if not robot.is_unlimited:
        return math.isfinite(_next_take_over_s(robot))
    return any(
        number not in team.lost
        and (number not in team.states or team.states[number].tree is not None)
        for number in team.others
    )


def wait_for_news(robot: SrtRobot) -> Steps:
    """Stand by until something new was heard; ask now and then who was not heard of for long."""
    team = robot.team
    if robot.is_unlimited:
        until = robot.time_s + CHECK_S
    else:
        until = max(robot.time_s, _next_take_over_s(robot)) + MOMENT_S
    yield from stand_by(robot, until)
    if robot.is_unlimited and robot.time_s >= until:
        yield from team.ask(
            n
            for n in team.others
            if n not in team.lost and team.heard_s.get(n, 0.0) <= robot.time_s - CHECK_S
        )


def stand_by(robot: SrtRobot, until_s: float) -> Steps:
    """Stand, listen and give way where a master orders it, until news have come or time is up."""
    news = robot.team.news()
    while robot.time_s < until_s:
        yield from robot.team.hear(until_s - robot.time_s)
        yield from obey(robot)
        if robot.team.news() != news:
            # What else comes at this time is looked at together.
            yield from robot.team.pause(MOMENT_S)
            yield from obey(robot)
            return


def obey(robot: SrtRobot) -> Steps:
    """Give way, if a master has ordered it; and go home again."""
    order = robot.team.order_for_me()
    if order is not None and order.order == "give way" and robot.here is not None:
        yield from as_far_as_it_gets(robot, _give_way(robot, order))


def _give_way(robot: SrtRobot, order: Order) -> Steps:
    yield from move_to(robot, robot.step_by(order, None))
    yield from robot.team.rest()
    if robot.here is None:
        return
    way = robot.way(robot.here, robot.root)
    if way is not None and robot.way_length_m(way) > robot.me.range_m:
        yield from robot.team.pause(AWAY_S)
        yield from transfer_to(robot, robot.root, None)
        yield from robot.team.rest()


def _last_extended_s(robot: SrtRobot, root: NodeId) -> float:
    return max(node.time_s for node in robot.map.nodes if robot.map.tree(node.id) == root)


def _is_cared_for(robot: SrtRobot, root: NodeId) -> bool:
    # With a limited radio: whether a robot that works on a tree was heard of lately.
    return _take_over_s(robot, root) > robot.time_s


def _take_over_s(robot: SrtRobot, root: NodeId) -> float:
    team = robot.team
    times = [
        _gives_up_s(robot, number)
        for number, state in team.states.items()
        if number not in team.lost and (number == root.robot or state.tree == root)
    ]
    return max(times, default=-math.inf)


def _gives_up_s(robot: SrtRobot, number: int) -> float:
    # Until when a robot that was heard of is believed to go on with what it did.
    return robot.team.heard_s.get(number, 0.0) + robot.options.take_over_after_s


def _next_take_over_s(robot: SrtRobot) -> float:
    # When the next tree of those that still have frontier is free to be taken over.
    open_trees = [root for root in robot.map.roots() if robot.map.open_frontier_m(root) > 0.0]
    times = [_take_over_s(robot, root) for root in open_trees]
    return min((time for time in times if time > robot.time_s), default=math.inf)
