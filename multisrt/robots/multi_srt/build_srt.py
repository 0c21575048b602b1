"""BUILD_SRT: how one robot of a team extends a tree (paper 003, Figure 2).

The procedures carry the paper's names and stand in its order. Each takes the robot that it works
for; what it knows is all there is.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import replace
from typing import Literal, cast

from multisrt.events import Choice, Decision, Purpose
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.frontier_arcs import total_length
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import Scan
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.planners.srt import Draws
from multisrt.robots.exploration_map import NodeId
from multisrt.robots.explorer import Action, Look, Move, Moved, Note, Outcome, Sense, Sighting
from multisrt.robots.multi_srt.coordination import check_feasibility, coordinate
from multisrt.robots.multi_srt.engagement import Regroup, agree, build_and_wait_gpr, build_ger
from multisrt.robots.multi_srt.organize import path_of
from multisrt.robots.multi_srt.robot import MOST_TRIES, KnownNode, NewPlace, SrtRobot, Step, Target
from multisrt.robots.multi_srt.ways import OutAndBack

Steps = Generator[Action, Outcome, None]
Plan = Generator[Action, Outcome, tuple[Choice, Target | None]]
Planner = Callable[[SrtRobot, FloatArray, Draws], Plan]

MOST_WAITS = 3
"""A robot that was told to wait so often in a row plans anew."""


MOST_STOPS = 3
"""A robot with more protective stops of late stands aside: two may stop one another for ever."""


class BoxedIn(Exception):
    """The robot cannot get anywhere: bodies that do not answer stand all around."""


def build_srt(robot: SrtRobot) -> Steps:
    """BUILD_SRT: extend a tree until its frontier is explored and the robot is at its root."""
    yield from take_steps(robot, planner)


def as_far_as_it_gets(robot: SrtRobot, steps: Steps) -> Steps:
    """Take steps until they are done, or bodies that do not answer stand all around."""
    try:
        yield from steps
    except BoxedIn:
        robot.target = None


def take_steps(robot: SrtRobot, plan: Planner) -> Steps:
    """Step after step, as BUILD_SRT has them, until the planner has no target."""
    while True:
        try:
            gpr = yield from build_and_wait_gpr(robot)
            if robot.here is None:
                region = yield from perceive(robot)
                yield from robot.add(region)
                robot.resume()
            yield from look(robot)
            ger = yield from build_ger(robot, gpr)
            frontier = local_frontier(robot)
            more, step = yield from decide(robot, plan, frontier, gpr, ger)
            if not more:
                return
            if len(ger) > 1:
                checked = check_feasibility(robot, ger)
                if checked.unfeasible or robot.team.key in robot.team.orders:
                    step = yield from coordinate(robot, checked, step)
        except Regroup:
            continue
        yield from move_to(robot, step)


def perceive(robot: SrtRobot) -> Generator[Action, Outcome, LocalSafeRegion]:
    """PERCEIVE: look round, and take what is surely free."""
    scan = cast(Scan, (yield Sense()))
    robot.time_s = scan.time_s
    return local_safe_region(
        scan,
        robot.shape,
        cones=robot.options.cones,
        contact_tolerance_m=robot.options.contact_tolerance_m,
    )


def look(robot: SrtRobot) -> Steps:
    """Notice who stands around without answering, and ask who is not where it said to be.

    Raises
    ------
    Regroup
        If somebody was asked: its answer, or its silence, may change the group.
    """
    team = robot.team
    if team.is_alone:
        return
    seen = cast(tuple[Sighting, ...], (yield Look()))
    robot.notice(seen)
    elsewhere = [sighting.robot for sighting in seen if team.is_news(sighting)]
    if elsewhere:
        yield from team.ask(elsewhere)
        yield from team.pause(team.round_trip_s)
        raise Regroup


def local_frontier(robot: SrtRobot) -> FloatArray:
    """LOCAL_FRONTIER: of the current region, what lies in no region of any known tree."""
    assert robot.here is not None
    return robot.map.frontier(robot.here)


def decide(
    robot: SrtRobot,
    plan: Planner,
    frontier: FloatArray,
    gpr: tuple[int, ...],
    ger: tuple[int, ...],
) -> Generator[Action, Outcome, tuple[bool, Step | None]]:
    """Plan, unless the robot is on its way to a target still; and tell the group.

    Returns
    -------
    more : bool
        Whether there is anything left to do (paper: q_target is not NULL).
    step : Step or None
        The next motion; None: it stays for now.
    """
    team, here = robot.team, robot.here
    assert here is not None
    frontier_m = total_length(frontier)
    if team.waited >= MOST_WAITS:
        robot.target = None
    if team.troubles >= MOST_TRIES:
        robot.avoid_who_stands()
    target = robot.target if _is_worth_it(robot) else None
    if target is None:
        draws = Draws()
        yield from robot.tell_when_complete()
        choice, target = yield from plan(robot, frontier, draws)
        if choice == "stay":
            robot.boxed_in += 1
            if robot.is_boxed_in:
                raise BoxedIn
        elif target is not None:
            robot.boxed_in = 0
        yield Note(
            Decision(
                time_s=robot.time_s,
                robot=team.number,
                node=here,
                frontier_m=frontier_m,
                choice=choice,
                target=place_of(robot, target),
                draws=draws.drawn,
                refused=draws.refused,
                candidates=tuple(draws.candidates),
                gpr=gpr,
                ger=ger,
            )
        )
        if choice == "end":
            yield from team.rest()
            return False, None
    if target is not None:
        target = robot.past_here(target)
    robot.target = target
    seeks = isinstance(target, NewPlace)
    step = None if target is None else robot.step_to(target, frontier_m * seeks)
    if not team.is_alone:
        team.path = ((0.0, *robot.q_act),) if step is None else path_of(step.motion)
        team.frontier_m = 0.0 if step is None else step.frontier_m
        if len(ger) > 1:
            yield from agree(robot, ger)
    return True, step


def planner(robot: SrtRobot, frontier: FloatArray, draws: Draws) -> Plan:
    """PLANNER: the next target from the current node, by its three stages."""
    here = robot.here
    assert here is not None
    node = robot.map[here]
    x, y, _ = node.configuration
    biased = robot.options.frontier_bias
    if len(frontier) or not biased:
        others = robot.map.places_near(x, y, robot.me.range_m + robot.d_min_m)
        near = [] if biased else robot.map.near(x, y, 2.0 * robot.me.range_m)
        regions = [other.region for other in near if other.id != here]
        place, drawn = robot.planner.draw(
            robot.q_act,
            node.region,
            frontier,
            others,
            regions,
            robot.me.rng,
            accept=robot.refuse,
        )
        draws.drawn, draws.refused, draws.candidates = (
            drawn.drawn,
            drawn.refused,
            drawn.candidates,
        )
        if place is not None:
            return "draw", NewPlace(*place, "draw", (here,))
        if robot.options.approach and len(frontier):
            place = robot.planner.approach(
                robot.q_act,
                node.region,
                robot.map.frontier_arcs(here),
                others,
                accept=robot.refuse,
                draws=draws,
            )
            if place is not None:
                return "approach", NewPlace(*place, "approach", (here,))
    steps_back = robot.options.backtrack == "parent" and not robot.completing
    if steps_back and node.parent is not None and here != robot.tree:
        way = robot.way(here, node.parent)
        if way is not None:
            return "parent", KnownNode(tuple(way))
    return (yield from _what_is_left(robot, here))


def _what_is_left(robot: SrtRobot, here: NodeId) -> Plan:
    # Over the roadmap: to a node with a frontier, or to a place that opens one; at last home.
    robot.exhausted.add(here)
    robot.ways.extend()
    supports = robot.tree != robot.root
    if robot.options.backtrack == "nearest_open" or (supports and not robot.options.complete):
        way = robot.ways.to_nearest(
            here, lambda n: n not in robot.exhausted and robot.may_extend(n), robot.is_passable
        )
        if way is not None:
            return "nearest_open", KnownNode(tuple(way), way[-1])
    if robot.options.complete:
        robot.completing = True
        while (way := robot.way_to_nearest_open(here)) is not None:
            for arc in robot.map.frontier_arcs(way[-1]):
                found = robot.viewing_place(here, way[-1], arc)
                if isinstance(found, NewPlace):
                    return "bypass" if found.stage == "bypass" else "complete", found
                if way[-1] not in robot.exhausted:
                    # Another robot's node: from there this one has drawn no place yet.
                    return "nearest_open", KnownNode(tuple(way), way[-1])
                yield from robot.close(way[-1], arc, found)
        round_them = robot.bypass(robot.may_extend)
        if round_them is not None:
            return "bypass", round_them
        for node in robot.map.open_nodes(robot.tree):
            # No robot that answers stands in the way for long; these do.
            joined = robot.ways.way(here, node) is not None
            for arc in robot.map.frontier_arcs(node):
                yield from robot.close(
                    node, arc, "blocked by a robot" if joined else "not reachable"
                )
        yield from robot.tell_when_complete()
    assert robot.tree is not None
    if here == robot.tree or supports:
        return "end", None
    return on_the_way(robot, robot.tree, "home")


def on_the_way(
    robot: SrtRobot, end: NodeId, choice: Literal["home", "transfer"]
) -> tuple[Choice, Target | None]:
    """Go to a node over the roadmap, or round who stands there, or stay for now."""
    assert robot.here is not None
    way = robot.way(robot.here, end)
    if way is not None:
        return choice, KnownNode(tuple(way))
    round_them = robot.bypass(lambda node: node == end)
    return ("stay", None) if round_them is None else ("bypass", round_them)


def move_to(robot: SrtRobot, step: Step | None) -> Steps:
    """MOVE_TO: follow a step's motion, and answer those who ask meanwhile.

    Without a step the robot waits: until the others of its group have gone, or if nobody goes
    for a time of its own, so that the same robots do not try the same again.
    """
    team = robot.team
    if step is None:
        team.step += 1
        team.rounds = 0
        team.waited += 1
        team.path, team.frontier_m = (), 0.0
        yield from team.announce("waiting")
        if not any(team.states[n].phase == "moving" for n, _ in team.key if n != team.number):
            yield from pause_a_while(robot)
        return
    robot.came = step
    robot.target = step.rest
    team.step += 1
    team.rounds = team.waited = 0
    team.path, team.frontier_m = path_of(step.motion), 0.0
    team.arrival_s = robot.time_s + step.motion.duration_s
    yield from team.announce("moving")
    moved = yield from follow(robot, step)
    robot.avoided.clear()
    if moved.blocked_by is None:
        robot.here = step.node
        robot.stops = max(0.0, robot.stops - 0.5)
    else:
        robot.stops += 1.0
        yield from stop_here(robot, step, moved)
    team.path = ()
    if robot.here is not None and step.purpose != "give way" and step.stage != "coordinate":
        # Whoever is sent to and fro comes into trouble all the same.
        team.troubles = max(0.0, team.troubles - 0.5)
    stopped_again = moved.blocked_by is not None and robot.stops > MOST_STOPS
    team.troubles += stopped_again
    if step.purpose == "give way" or stopped_again:
        yield from stand_aside(robot)
    yield from team.begin_step()


def pause_a_while(robot: SrtRobot) -> Steps:
    """Let a time of the robot's own pass, so that the same robots do not try the same again."""
    yield from robot.team.pause(robot.options.pause_s * (0.25 + 0.75 * robot.me.rng.random()))


def stand_aside(robot: SrtRobot) -> Steps:
    """Having given way, stand idle for a while, so that the other can pass without asking."""
    if robot.here is None:
        yield from robot.add((yield from perceive(robot)))
    yield from robot.team.rest()
    share = 0.5 + 0.5 * robot.me.rng.random()
    yield from robot.team.pause(robot.options.pause_s * share * (1 + robot.team.troubles))


def follow(robot: SrtRobot, step: Step) -> Generator[Action, Outcome, Moved]:
    """Drive, listening; on the way to a new place also looking round, where that is wanted."""
    whole, began_s = step.motion, robot.time_s
    sections = [whole]
    if robot.options.sense == "moving" and step.node is None:
        sections = whole.sections(robot.options.sense_period_s)
    for number, section in enumerate(sections):
        if number:
            region = yield from perceive(robot)
            yield from robot.add_passing(region, step, whole.until(robot.time_s - began_s))
        moved = yield from drive(robot, section, step.purpose or robot.purpose)
        if moved.blocked_by is not None:
            break
    return moved


def drive(
    robot: SrtRobot, motion: Trajectory, purpose: Purpose
) -> Generator[Action, Outcome, Moved]:
    """Make a motion, listening."""
    alone = robot.team.is_alone
    outcome = yield Move(
        trajectory=motion,
        purpose=purpose,
        guard_m=None if alone else robot.options.guard_m,
        listen=not alone,
    )
    moved = yield from robot.team.take(outcome)
    while moved is None:
        moved = yield from robot.team.hear(None)
    robot.q_act, robot.time_s = moved.configuration, moved.time_s
    return moved


def stop_here(robot: SrtRobot, step: Step, moved: Moved) -> Steps:
    """After a protective stop: the place is a new one, from which the robot plans anew.

    A car that cannot reverse has no way back from there: it waits, and goes on.

    Raises
    ------
    BoxedIn
        If the way stays blocked for such a car.
    """
    whole, team = step.motion, robot.team
    robot.target = None
    driven_s = moved.time_s - (team.arrival_s - whole.duration_s)
    for _ in range(MOST_TRIES):
        if moved.blocked_by is not None:
            robot.heed(moved.blocked_by)
        if robot.can_reverse or moved.blocked_by is None:
            break
        yield from pause_a_while(robot)
        motion = whole.after(driven_s)
        team.path, team.arrival_s = path_of(motion), robot.time_s + motion.duration_s
        yield from team.announce("moving")
        began_s = robot.time_s
        moved = yield from follow(robot, replace(step, way=OutAndBack(motion)))
        driven_s += moved.time_s - began_s
    else:
        robot.boxed_in = MOST_TRIES + 1
        raise BoxedIn
    if moved.blocked_by is None:
        robot.here = step.node
        return
    driven = whole.until(driven_s)
    if driven.length_m > 0.0 or robot.q_act != whole.start:
        back = driven.reversed() if robot.is_car else None
        robot.came = replace(step, way=OutAndBack(driven, back), stage="coordinate")
        robot.here = None
        return
    # Who could not even begin lets some time pass, and plans around whoever stands there.
    robot.avoided[moved.blocked_by.robot] = moved.blocked_by
    yield from team.rest()
    yield from pause_a_while(robot)


def place_of(robot: SrtRobot, target: Target | None) -> tuple[float, float] | None:
    """Give the place of a target."""
    if target is None:
        return None
    if isinstance(target, NewPlace):
        return target.x, target.y
    x, y, _ = robot.map[target.way[-1]].configuration
    return x, y


def _is_worth_it(robot: SrtRobot) -> bool:
    # Whether a target over several steps is still worth going to, and its way still free.
    target = robot.target
    if target is None or target.way[0] != robot.here:
        return False
    if target.aim is not None and not robot.may_extend(target.aim):
        return False
    return all(robot.is_passable(a, b) for a, b in zip(target.way, target.way[1:], strict=False))
