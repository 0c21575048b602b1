"""MOVE_TO: how a robot makes a step, and what it does when it is stopped or ordered to wait."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from typing import cast

from multisrt.events import Purpose
from multisrt.geometry.regions.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.regions.scan import Scan
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.robots.explorer import Action, Move, Moved, Outcome, Sense, Steps
from multisrt.robots.multi_srt.messages import path_of
from multisrt.robots.multi_srt.progress import BoxedIn, Event
from multisrt.robots.multi_srt.roadmap import OutAndBack
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.multi_srt.targets import Interrupted, Step


def perceive(robot: SrtRobot) -> Generator[Action, Outcome, LocalSafeRegion]:
    """PERCEIVE: take a scan, and reconstruct the local safe region from it."""
    scan = cast(Scan, (yield Sense()))
    robot.at.time_s = scan.time_s
    return local_safe_region(
        scan,
        robot.shape,
        cones=robot.options.cones,
        contact_tolerance_m=robot.options.contact_tolerance_m,
    )


def move_to(robot: SrtRobot, step: Step | None) -> Steps:
    """MOVE_TO: follow the motion of a step, and answer questions meanwhile.

    Without a step the robot waits: until the others of its group have gone; or if none of them
    goes, for a random time, so that the same robots do not try the same again.
    """
    if step is None:
        yield from wait(robot)
        return
    team, progress = robot.team, robot.progress
    robot.journey.came = step
    robot.journey.target = step.rest
    team.status.step += 1
    progress.begin_step()
    team.status.waited, team.status.frontier_m = 0, 0.0
    yield from set_out(robot, step.motion)
    moved = yield from follow(robot, step)
    robot.obstacles.avoided.clear()
    was_stopped = moved.blocked_by is not None
    if was_stopped:
        progress.note(Event.SETBACK)
        yield from stop_here(robot, step, moved)
    else:
        robot.at.here = step.node
        if step.order is None and robot.journey.is_at_new_place:
            progress.note(Event.NEW_PLACE)
    team.status.path = ()
    if step.gives_way or (was_stopped and progress.is_hindered):
        yield from stand_aside(robot)
    yield from team.begin_step()


def wait(robot: SrtRobot) -> Steps:
    """Make no motion in this step."""
    team = robot.team
    team.status.step += 1
    team.status.waited += 1
    robot.progress.begin_step()
    team.status.path, team.status.frontier_m = (), 0.0
    yield from team.announce("waiting")
    if not team.roster.is_any_moving(team.companions):
        yield from pause_a_while(robot)


def set_out(robot: SrtRobot, motion: Trajectory) -> Steps:
    """Inform the team that a motion begins."""
    status = robot.team.status
    status.path, status.arrival_s = path_of(motion), robot.at.time_s + motion.duration_s
    yield from robot.team.announce("moving")


def pause_a_while(robot: SrtRobot) -> Steps:
    """Let a quarter of `pause_s` to all of it pass, at random, and listen meanwhile."""
    yield from robot.team.pause(robot.options.pause_s * (0.25 + 0.75 * robot.me.rng.random()))


def add_here(robot: SrtRobot) -> Steps:
    """Add the place where the robot arrived, or was stopped, as a node, unless it is one."""
    if robot.at.here is None:
        region = yield from perceive(robot)
        yield from robot.trees.add(region, robot.journey.came)


def stand_aside(robot: SrtRobot) -> Steps:
    """Stand idle for a while, so that another robot passes without asking this one to step."""
    yield from add_here(robot)
    yield from robot.team.rest()
    share = 0.5 + 0.5 * robot.me.rng.random()
    yield from robot.team.pause(robot.options.pause_s * share * robot.progress.backoff)


def follow(robot: SrtRobot, step: Step) -> Generator[Action, Outcome, Moved]:
    """Make the motion of a step; on the way to a new place also take scans, where wanted."""
    whole, began_s = step.motion, robot.at.time_s
    sections = [whole]
    if robot.options.sense == "moving" and step.node is None:
        sections = whole.sections(robot.options.sense_period_s)
    for number, section in enumerate(sections):
        if number:
            region = yield from perceive(robot)
            driven = whole.until(robot.at.time_s - began_s)
            yield from robot.trees.add_passing(region, step, driven)
        purpose: Purpose = "give way" if step.gives_way else robot.journey.purpose
        moved = yield from drive(robot, section, purpose)
        if moved.blocked_by is not None:
            break
    return moved


def drive(
    robot: SrtRobot, motion: Trajectory, purpose: Purpose
) -> Generator[Action, Outcome, Moved]:
    """Make one motion, and listen meanwhile."""
    team = robot.team
    outcome = yield Move(
        trajectory=motion,
        purpose=purpose,
        guard_m=None if team.is_alone else robot.options.guard_m,
        listen=team.has_receivers,
    )
    moved = yield from team.take(outcome)
    while moved is None:
        moved = yield from team.hear(None)
    robot.at.q_act, robot.at.time_s = moved.configuration, moved.time_s
    return moved


def stop_here(robot: SrtRobot, step: Step, moved: Moved) -> Steps:
    """After a protective stop, plan again from where the robot stands.

    A car that cannot reverse cannot return from there: it waits, and continues.

    Raises
    ------
    BoxedIn
        If the path stays blocked for such a car.
    """
    whole, at = step.motion, robot.at
    robot.journey.target = None
    driven_s = moved.time_s - (robot.team.status.arrival_s - whole.duration_s)
    assert moved.blocked_by is not None
    robot.heed(moved.blocked_by)
    if not robot.roadmap.can_reverse:
        yield from go_on(robot, Interrupted(step, driven_s))
        return
    driven = whole.until(driven_s)
    if driven.length_m > 0.0 or at.q_act != whole.start:
        back = driven.reversed() if robot.roadmap.is_car else None
        came = replace(step, out_and_back=OutAndBack(driven, back), stage="coordinate")
        robot.journey.came, at.here = came, None
        return
    # The motion was stopped before it began: let some time pass, and plan around that body.
    robot.obstacles.avoided[moved.blocked_by.robot] = moved.blocked_by
    yield from robot.team.rest()
    yield from pause_a_while(robot)


def go_on(robot: SrtRobot, motion: Interrupted) -> Steps:
    """Continue a motion from which a car cannot return, when what blocks it has left.

    Raises
    ------
    BoxedIn
        If it stays blocked. The motion is the first that the car makes when it takes up another
        task: it is at no node, from which another motion could begin.
    """
    step, driven_s = motion
    robot.journey.came, robot.journey.target = step, None
    blocked = True
    while blocked:
        robot.progress.note(Event.NO_PATH)
        if robot.progress.is_boxed_in:
            if robot.at.q_act != step.motion.start:
                robot.journey.interrupted = Interrupted(step, driven_s)
            raise BoxedIn
        yield from pause_a_while(robot)
        rest = step.motion.after(driven_s)
        yield from set_out(robot, rest)
        began_s = robot.at.time_s
        moved = yield from follow(robot, replace(step, out_and_back=OutAndBack(rest)))
        driven_s += moved.time_s - began_s
        blocked = moved.blocked_by is not None
        if moved.blocked_by is not None:
            robot.heed(moved.blocked_by)
    robot.journey.interrupted = None
    robot.progress.note(Event.PATH)
    robot.at.here = step.node
