"""SUPPORT_OTHERS: a robot that is done with its own tree extends those of others (Figure 5).

Source: Multi-SRT, paper section 2, SUPPORT_OTHERS. Differs in:

- With a limited radio, where the paper has no support, a robot takes over the trees of robots that
  it has not heard from for long; with `support_in_contact` it also supports those of robots that it
  has just heard from.
- A robot that has extended another's tree goes home from where it stands, not by way of the root
  of that tree.
- A tree that the robot has supported before is selected again only if its open frontier is longer
  than what the robot left then, or if a body that blocked the path to a part of it is gone.
- With `no_place_after`, robots tell one another at which nodes they have found no place, and do
  not go there in support any more.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, field

from multisrt.events import Supports
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.frontier_arcs import total_length
from multisrt.planners.srt import Draws
from multisrt.robots.explorer import Action, Note, Outcome, Steps
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.build_srt import build_srt, take_steps, until_boxed_in
from multisrt.robots.multi_srt.messages import Order
from multisrt.robots.multi_srt.move_to import move_to
from multisrt.robots.multi_srt.planner import Choosing, on_the_way
from multisrt.robots.multi_srt.progress import Event
from multisrt.robots.multi_srt.robot import SrtRobot


@dataclass(slots=True)
class Supported:
    """A robot's findings on the trees that it could support.

    Attributes
    ----------
    left_m : dict of NodeId to float
        By tree that it has supported, the open frontier in metres that it could not extend.
    considered : tuple of NodeId
        The trees that it last found to need support.
    """

    left_m: dict[NodeId, float] = field(default_factory=dict)
    considered: tuple[NodeId, ...] = ()


def support_others(robot: SrtRobot, supported: Supported) -> Steps:
    """SUPPORT_OTHERS: extend others' trees until every other robot is done.

    With a limited radio only those that no other robot will extend: of robots that have not been
    heard from for `take_over_after_s`.
    """
    while True:
        tree = yield from select(robot, supported)
        if tree is not None:
            yield from until_boxed_in(robot, support(robot, tree))
            supported.left_m[tree] = open_frontier(robot, tree)
            yield from go_home(robot)
        elif exploration_running(robot):
            yield from wait_for_news(robot)
        else:
            return


def support(robot: SrtRobot, tree: NodeId) -> Steps:
    """Go to another robot's tree, and extend it."""
    yield from transfer_to(robot, entry(robot, tree), tree)
    yield from build_srt(robot, supports=True)


def go_home(robot: SrtRobot) -> Steps:
    """Go to the root of the robot's own tree, and tell that it stands."""
    yield from until_boxed_in(robot, transfer_to(robot, robot.trees.root, None))
    yield from robot.team.rest()


def entry(robot: SrtRobot, tree: NodeId) -> NodeId:
    """Return the node of a tree to which a robot goes to support it; see the option `entry`."""
    if robot.options.entry == "root":
        return tree
    route = robot.routes.to_nearest(
        robot.at.node,
        lambda node: robot.map.tree(node) == tree and robot.deferred.has_frontier(node),
    )
    return tree if route is None else route[-1]


def select(robot: SrtRobot, supported: Supported) -> Generator[Action, Outcome, NodeId | None]:
    """SELECT: of the trees that may need support (paper: I), choose one, or None.

    A tree may need support if its open frontier is at least `support_m` (paper: F bar) for each
    robot that is active in it; one that this robot has supported before, only if its open frontier
    is also longer than what was left of it then.
    """
    yield from robot.trees.reopen()
    yield from robot.trees.tell_when_complete()
    if robot.at.here is None:
        return None
    reopened = {robot.map.tree(node) for node in robot.trees.reopened}
    robot.trees.reopened.clear()
    for root in reopened:
        supported.left_m.pop(root, None)
    # Without support, a robot continues with its own tree if that has more frontier than it left:
    # arcs were opened again, or it has given way and added a node.
    roots = robot.map.roots() if robot.options.support else [robot.trees.root]
    open_m = {root: open_frontier(robot, root) for root in roots}
    active = {root: active_robots(robot, root) for root in open_m}
    candidates = tuple(
        root
        for root in open_m
        if open_m[root] > supported.left_m.get(root, 0.0)
        and may_need_support(robot, root, open_m[root], active[root])
    )
    if not candidates:
        return None
    robot.roadmap.extend()
    if robot.options.select == "most_recent":
        by_recency = sorted(candidates, key=lambda root: (-_last_extended_s(robot, root), root))
        candidates = tuple(by_recency)
    chosen = _choose(robot, candidates)
    if chosen is None and candidates == supported.considered:
        return None
    supported.considered = candidates
    yield Note(
        Supports(
            time_s=robot.at.time_s,
            robot=robot.me.robot,
            tree=None if chosen is None else chosen.robot,
            open_frontier_m={root.robot: length for root, length in open_m.items()},
            active_robots={root.robot: count for root, count in active.items()},
            candidates=tuple(root.robot for root in candidates),
        )
    )
    return chosen


def may_need_support(robot: SrtRobot, root: NodeId, open_m: float, active: int) -> bool:
    """Whether a tree with this open frontier and number of active robots may need support."""
    support_m = robot.options.support_m
    threshold_m = robot.me.range_m if support_m is None else support_m
    if open_m < threshold_m * active:
        return False
    if robot.has_unlimited_range or _take_over_s(robot, root) <= robot.at.time_s:
        return True
    return robot.options.support_in_contact and is_in_contact(robot, root)


def is_in_contact(robot: SrtRobot, root: NodeId) -> bool:
    """Whether a robot has just heard from all that work on a tree, and from its owner."""
    heard_s, since_s = robot.team.roster.heard_s, robot.at.time_s - robot.options.check_period_s
    return all(heard_s.get(n, -math.inf) >= since_s for n in _at_work(robot, root))


def _choose(robot: SrtRobot, candidates: tuple[NodeId, ...]) -> NodeId | None:
    # The first, or that of the closest root, of the trees to whose root there is a path.
    here, routes = robot.at.node, robot.routes
    if robot.options.select == "most_recent":
        chosen = next((root for root in candidates if routes.route(here, root) is not None), None)
    else:
        route = routes.to_nearest(here, lambda node: node in candidates)
        chosen = None if route is None else route[-1]
    if chosen is None and robot.bypass.to(lambda node: node in candidates) is not None:
        *others, last = candidates
        chosen = next((root for root in others if robot.bypass.to(root.__eq__)), last)
    return chosen


def open_frontier(robot: SrtRobot, root: NodeId) -> float:
    """OPEN_FRONTIER: total length in metres of the local frontiers of a tree's nodes.

    Without the arcs that the robot leaves for later, and, with `no_place_after`, without those of
    nodes at which robots like it have found no place.
    """
    if robot.options.no_place_after is None:
        return robot.deferred.open_m(root)
    return math.fsum(
        total_length(robot.deferred.frontier(node))
        for node in robot.map.open_nodes(root)
        if not robot.is_without_place(node)
    )


def active_robots(robot: SrtRobot, root: NodeId) -> int:
    """ACTIVE_ROBOTS: the number of other robots that extend a tree, as far as is known.

    With a limited radio, robots that were not heard from for `take_over_after_s` do not count.
    """
    roster = robot.team.roster
    return sum(
        state.tree == root
        for number, state in roster.states.items()
        if number not in roster.lost
        and (robot.has_unlimited_range or _gives_up_s(robot, number) > robot.at.time_s)
    )


def transfer_to(robot: SrtRobot, end: NodeId, tree: NodeId | None) -> Steps:
    """TRANSFER_TO: go to a node over the roadmap, every hop coordinated as a step.

    Where other robots stand in the way for good, a place before the node is near enough.

    Parameters
    ----------
    robot : SrtRobot
        The robot.
    end : NodeId
        The node.
    tree : NodeId or None
        Root of the tree in which the robot counts as active meanwhile.
    """
    robot.at.tree = tree

    def next_choice(frontier: FloatArray, draws: Draws) -> Choosing:
        here = robot.at.node
        yield from ()  # a planner may record events; this one has none
        robot.roadmap.extend()
        route = robot.routes.route(here, end)
        if here == end or (route is not None and is_near_enough(robot, route)):
            return "end", None
        return on_the_way(robot, end, "transfer")

    robot.progress.note(Event.NEW_TASK)
    robot.journey.begin("home" if end == robot.trees.root else "support")
    yield from robot.team.begin_step()
    yield from take_steps(robot, next_choice)


def is_near_enough(robot: SrtRobot, route: list[NodeId]) -> bool:
    """Whether the remainder of a path may be left out.

    It may if another robot stands at its end and has nothing to do that would take it away; or
    if the end is within sensing range and the robot makes no progress.
    """
    length_m = robot.routes.length_m(route)
    if robot.progress.is_hindered and length_m <= robot.me.range_m:
        return True
    end = robot.map[route[-1]].configuration
    reach_m = 2.0 * robot.planner.body.outer_radius_m + robot.options.guard_m
    states = robot.team.roster.states.values()
    standing = [state.place for state in states if state.phase == "idle"]
    standing += [(*sighting.configuration,) for sighting in robot.obstacles.silent.values()]
    return len(route) == 2 and any(math.dist(end[:2], place[:2]) < reach_m for place in standing)


def exploration_running(robot: SrtRobot) -> bool:
    """EXPLORATION_RUNNING: whether another robot has not yet reported that it is done."""
    roster = robot.team.roster
    if not robot.has_unlimited_range:
        # Without support nothing is taken over, and so there is nothing to wait for.
        return robot.options.support and math.isfinite(_next_take_over_s(robot))
    return any(
        number not in roster.lost
        and (number not in roster.states or roster.states[number].tree is not None)
        for number in robot.team.others
    )


def wait_for_news(robot: SrtRobot) -> Steps:
    """Stand by until there is news; ask robots not heard from for long, until they answer."""
    team, at = robot.team, robot.at
    if not robot.has_unlimited_range:
        news_s = max(at.time_s, _next_take_over_s(robot)) + robot.options.settle_s
        yield from stand_by(robot, news_s)
        return
    is_waiting = any(team.roster.is_to_answer(number) for number in _unheard(robot))
    until_s = at.time_s + (team.period_s if is_waiting else robot.options.check_period_s)
    yield from stand_by(robot, until_s)
    if at.time_s >= until_s:
        yield from team.ask(_unheard(robot))


def _unheard(robot: SrtRobot) -> list[int]:
    # The robots from which there has been nothing for long, and which are not presumed lost.
    roster, since_s = robot.team.roster, robot.at.time_s - robot.options.check_period_s
    return [
        number
        for number in robot.team.others
        if number not in roster.lost and roster.heard_s.get(number, 0.0) <= since_s
    ]


def ask_those_in_the_way(robot: SrtRobot) -> Steps:
    """Ask the robots that bar paths whether they are still there: those that stand may be dead."""
    team, roster = robot.team, robot.team.roster
    asked_s = robot.at.time_s
    pending = robot.deferred.to_ask()
    while pending:
        yield from team.ask(pending)
        yield from team.pause(team.period_s)
        heard_s = {number: roster.heard_s.get(number, 0.0) for number in pending}
        pending = [n for n in pending if roster.answers(n) and heard_s[n] < asked_s]


def stand_by(robot: SrtRobot, until_s: float) -> Steps:
    """Stand and listen, and give way where a master orders it, until there is news or until_s.

    Raises
    ------
    CalledHome
        If the robot is to deliver data; see `homing`.
    """
    news, homing = robot.team.news(), robot.homing
    while robot.at.time_s < until_s:
        due_s = math.inf if homing is None else homing.due_s()
        yield from robot.team.hear(max(0.0, min(until_s, due_s) - robot.at.time_s))
        yield from follow_orders(robot)
        if homing is not None and robot.at.here is not None:
            homing.raise_if_due()
        if robot.team.news() != news or robot.deferred.is_due():
            # More of it may follow at once.
            yield from robot.team.pause(robot.options.settle_s)
            yield from follow_orders(robot)
            return


def follow_orders(robot: SrtRobot) -> Steps:
    """Give way, if a master has ordered it; and go home again."""
    order = robot.team.order_for_me()
    if order is not None and order.order == "give way" and robot.at.here is not None:
        yield from _give_way(robot, order)


def _give_way(robot: SrtRobot, order: Order) -> Steps:
    yield from until_boxed_in(robot, move_to(robot, robot.journey.step_by(order, None)))
    yield from robot.team.rest()
    if robot.at.here is None:
        return
    route = robot.routes.route(robot.at.here, robot.trees.root)
    if route is not None and robot.routes.length_m(route) > robot.me.range_m:
        yield from robot.team.pause(robot.options.home_after_s)
        yield from go_home(robot)


def _last_extended_s(robot: SrtRobot, root: NodeId) -> float:
    return max(node.time_s for node in robot.map.nodes if robot.map.tree(node.id) == root)


def _take_over_s(robot: SrtRobot, root: NodeId) -> float:
    # With a limited radio: when a tree is free to be taken over from those that work on it. An
    # owner that stands idle and is in no tree has ended, unless it is heard again soon.
    roster, patience_s = robot.team.roster, robot.options.check_period_s
    times = []
    for number in _at_work(robot, root):
        state = roster.states[number]
        has_ended = state.phase == "idle" and state.tree is None
        heard_s = roster.heard_s.get(number, 0.0)
        times.append(heard_s + patience_s if has_ended else _gives_up_s(robot, number))
    return max(times, default=-math.inf)


def _at_work(robot: SrtRobot, root: NodeId) -> list[int]:
    # The owner of a tree and the robots that are active in it, as far as is known.
    roster = robot.team.roster
    return [
        number
        for number, state in roster.states.items()
        if number not in roster.lost and (number == root.robot or state.tree == root)
    ]


def _gives_up_s(robot: SrtRobot, number: int) -> float:
    # Until when a robot that was heard from is believed to continue with what it did.
    return robot.team.roster.heard_s.get(number, 0.0) + robot.options.take_over_after_s


def _next_take_over_s(robot: SrtRobot) -> float:
    # When the next tree of those that have open frontier is free to be taken over.
    open_trees = [root for root in robot.map.roots() if open_frontier(robot, root) > 0.0]
    times = [_take_over_s(robot, root) for root in open_trees]
    return min((time for time in times if time > robot.at.time_s), default=math.inf)
