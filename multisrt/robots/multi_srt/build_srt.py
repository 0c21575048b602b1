"""BUILD_SRT: how one robot of a team extends a tree (Multi-SRT, Figure 2).

The procedures carry the names of the paper, and `take_steps` has its lines in their order:

=========================  ===============================================
procedure                  module
=========================  ===============================================
BUILD_MULTI_SRT            `build_multi_srt`
BUILD_SRT                  `build_srt`, here
BUILD_AND_WAIT_GPR         `engagement`
PERCEIVE, MOVE_TO          `move_to`
ADD                        `trees`
BUILD_GER                  `engagement`
LOCAL_FRONTIER             here; the test is in `local_frontiers`, with
                           `geometry.regions.arc_pieces`
PLANNER                    `planner`, with `planners.srt`
CHECK_FEASIBILITY          `coordination`, with `conflicts`
COORDINATE, ORGANIZE       `coordination`, `organize`
SUPPORT_OTHERS             `support`
=========================  ===============================================

Differs in: at a node that is known already the robot neither perceives nor adds a node.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import cast

from msgspec import UNSET

from multisrt.events import Decision
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.frontier_arcs import total_length
from multisrt.planners.srt import Draws
from multisrt.robots.explorer import Action, Look, Note, Outcome, Sighting, Steps
from multisrt.robots.multi_srt.coordination import check_feasibility, coordinate
from multisrt.robots.multi_srt.engagement import Regroup, agree, build_and_wait_gpr, build_ger
from multisrt.robots.multi_srt.messages import path_of
from multisrt.robots.multi_srt.move_to import add_here, go_on, move_to
from multisrt.robots.multi_srt.planner import Found, Planner, TargetChooser
from multisrt.robots.multi_srt.progress import BoxedIn, Event, State
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.multi_srt.targets import NewPlace, Step

EXPLORING = ("draw", "approach", "complete", "gain", "nearest_open", "bypass")
"""Choices of targets at which there is something to see, or on the way to such targets."""


def build_srt(robot: SrtRobot, *, supports: bool = False, resumes: bool = False) -> Steps:
    """BUILD_SRT: extend a tree until the planner has no target.

    In its own tree the robot is at the root then; in support, where it explored the last frontier.

    Parameters
    ----------
    robot : SrtRobot
        The robot; `robot.at.tree` is the tree.
    supports : bool
        Whether the tree is extended in support, where the third stage of the planner begins at
        once.
    resumes : bool
        Whether it was extended before, and the robot comes from elsewhere: it goes to an open node
        then, not back to the root.
    """
    robot.progress.note(Event.NEW_TASK)
    robot.journey.begin("support" if supports else "explore")
    yield from take_steps(robot, Planner(robot, completing=supports or resumes))


def until_boxed_in(robot: SrtRobot, steps: Steps) -> Steps:
    """Take steps until they are done, or the robot is boxed in."""
    try:
        yield from steps
    except BoxedIn:
        robot.journey.target = None


def take_steps(robot: SrtRobot, choose: TargetChooser) -> Steps:
    """Take step after step, as BUILD_SRT does, until the planner has no target.

    Raises
    ------
    BoxedIn
        If the robot cannot get anywhere.
    """
    while True:
        if robot.journey.interrupted is not None:
            yield from go_on(robot, robot.journey.interrupted)
            yield from robot.team.begin_step()
        try:
            gpr = yield from build_and_wait_gpr(robot)
            if robot.at.here is None:
                yield from add_here(robot)
                robot.journey.resume()
            robot.journey.note_here()
            yield from look(robot)
            ger = yield from build_ger(robot, gpr)
            frontier = local_frontier(robot)
            is_done, step = yield from decide(robot, choose, frontier, gpr, ger)
            if is_done:
                return
            if len(ger) > 1:
                checked = check_feasibility(robot, ger)
                if checked.unfeasible or robot.team.order_message is not None:
                    step = yield from coordinate(robot, checked, step)
        except Regroup:
            continue
        yield from move_to(robot, step)
        if robot.progress.is_boxed_in:
            yield from add_here(robot)
            raise BoxedIn


def look(robot: SrtRobot) -> Steps:
    """Notice which bodies are in sight, and ask robots that are not where they said to be.

    Raises
    ------
    Regroup
        If a robot was asked: its answer, or its silence, may change the group.
    """
    team = robot.team
    if team.is_alone:
        return
    seen = cast(tuple[Sighting, ...], (yield Look()))
    robot.notice(seen)
    elsewhere = [sighting.robot for sighting in seen if team.roster.is_news(sighting)]
    if elsewhere:
        yield from team.ask(elsewhere)
        yield from team.pause(team.round_trip_s)
        raise Regroup


def local_frontier(robot: SrtRobot) -> FloatArray:
    """LOCAL_FRONTIER: the part ``(m, 4)`` of the current region's boundary in no other region.

    Without the arcs that the robot leaves for later.
    """
    return robot.deferred.frontier(robot.at.node)


def decide(
    robot: SrtRobot,
    choose: TargetChooser,
    frontier: FloatArray,
    gpr: tuple[int, ...],
    ger: tuple[int, ...],
) -> Generator[Action, Outcome, tuple[bool, Step | None]]:
    """Choose a target, unless the robot is still on its way to one; and inform the group.

    Returns
    -------
    is_done : bool
        Whether there is nothing left to do (paper: q_target is NULL).
    step : Step or None
        The next motion; None: it stays for now.

    Raises
    ------
    BoxedIn
        If no path was found too many times in a row.
    CalledHome, OutOfTime
        If the robot is to deliver data, or has no time for more; see `homing`.
    """
    team, journey, progress = robot.team, robot.journey, robot.progress
    frontier_m = total_length(frontier)
    if robot.homing is not None:
        robot.homing.raise_if_due()
        if robot.homing.has_delivered:
            journey.target = None
    if team.status.waited >= robot.options.max_waits:
        journey.target = None
    if progress.state is State.JAMMED:
        robot.avoid_idle_robots()
    target = journey.target if _is_worth_it(robot) else None
    if target is None:
        draws = Draws()
        yield from robot.trees.reopen()
        yield from robot.trees.tell_when_complete()
        found = yield from choose(frontier, draws)
        choice, target = found
        if choice == "stay":
            progress.note(Event.NO_PATH)
            if progress.is_boxed_in:
                raise BoxedIn
        elif target is not None:
            progress.note(Event.PATH)
        yield Note(_decision(robot, found, frontier_m, draws, (gpr, ger)))
        if robot.homing is not None and target is not None and choice in EXPLORING:
            robot.homing.raise_unless_fits(target)
        if choice == "end":
            yield from team.rest()
            return True, None
    if target is not None:
        target = journey.past_here(target)
    journey.target = target
    seeks = isinstance(target, NewPlace)
    step = None if target is None else journey.step_to(target, frontier_m * seeks)
    if not team.is_alone:
        team.status.path = ((0.0, *robot.at.q_act),) if step is None else path_of(step.motion)
        team.status.frontier_m = 0.0 if step is None else step.frontier_m
        if len(ger) > 1:
            yield from agree(robot, ger)
    return False, step


def _decision(
    robot: SrtRobot,
    found: Found,
    frontier_m: float,
    draws: Draws,
    groups: tuple[tuple[int, ...], tuple[int, ...]],
) -> Decision:
    choice, target = found
    return Decision(
        time_s=robot.at.time_s,
        robot=robot.team.number,
        node=robot.at.node,
        frontier_m=frontier_m,
        choice=choice,
        target=robot.journey.place_of(target),
        draws=draws.drawn,
        refused=draws.refused,
        candidates=tuple(draws.candidates),
        arcs=tuple(draws.arcs) if draws.arcs else UNSET,
        gpr=groups[0],
        ger=groups[1],
    )


def _is_worth_it(robot: SrtRobot) -> bool:
    # Whether the target has a frontier still, and the path there is free.
    target = robot.journey.target
    if target is None or target.route[0] != robot.at.here:
        return False
    aim = target.aim
    if aim is not None and (robot.is_without_place(aim) or not robot.trees.may_extend(aim)):
        return False
    hops = zip(target.route, target.route[1:], strict=False)
    return all(robot.routes.is_passable(a, b) for a, b in hops)
