"""Who steps together: the groups of pre-engaged and of engaged robots (GPR and GER).

Source: Multi-SRT, paper section 2, "Construction of GPR/GER". Two robots are GPR-coupled when
their targets are nearer than twice the range of perception; a robot that stands has itself as
target. The GPR is the connected component of this relation, and the GER that of overlapping
local safe regions, once all have perceived. Both relations are symmetric, so that every member
finds the same group.

The paper leaves open how robots come to agree. Ours: a group is named by its members and the
number of the step that each is about to make (its key). Nobody goes on before all others have
said that they have come as far with the same key; so nobody moves by a group that another
member does not know, whatever the radio delays or loses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Mapping
from typing import TYPE_CHECKING, TypeVar

from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots.multi_srt.messages import Path, Phase, RobotState

if TYPE_CHECKING:
    from multisrt.robots.explorer import Action, Outcome
    from multisrt.robots.multi_srt.robot import SrtRobot

Member = TypeVar("Member")

REACHED: dict[Phase, int] = {"waiting": 0, "perceived": 1, "planned": 2, "moving": 3, "idle": 0}
"""How far a robot has come in its step."""


MOST_ROUNDS = 40
"""After so many rounds of questions in one step a robot goes on without who does not agree."""

IGNORED_S = 30.0
"""For so long it then leaves them out."""


class Regroup(Exception):
    """The group has changed since it was built: the step begins anew, without perceiving again."""


def are_coupled(a: RobotState, b: RobotState) -> bool:
    """Whether two robots may meet in their next steps (paper: GPR-coupled).

    Their targets are nearer to one another than their ranges together (2 R_p for equal robots).
    A path that is not straight (a car's) may also pass near to a robot without leading there:
    that couples, too.
    """
    at, there = a.target, b.target
    return (
        math.dist(at, there) < a.range_m + b.range_m
        or (a.phase == "moving" and _passes_near(a.path, there, b.range_m))
        or (b.phase == "moving" and _passes_near(b.path, at, a.range_m))
    )


def _passes_near(path: Path, place: tuple[float, float], range_m: float) -> bool:
    # Asked more than anything else: a generator would take as long again.
    for _, x, y, _ in path:  # noqa: SIM110
        if math.dist((x, y), place) < range_m:
            return True
    return False


def group_of(
    number: int,
    members: Mapping[int, Member],
    coupled: Callable[[Member, Member], bool],
) -> tuple[int, ...]:
    """Give the connected component of a robot under a symmetric relation, in rising order."""
    group = [number]
    rest = [other for other in sorted(members) if other != number]
    for one in group:
        if not rest:
            break
        near = [other for other in rest if coupled(members[one], members[other])]
        group += near
        rest = [other for other in rest if other not in near]
    return tuple(sorted(group))


def build_and_wait_gpr(robot: SrtRobot) -> Generator[Action, Outcome, tuple[int, ...]]:
    """BUILD_AND_WAIT_GPR: build the GPR, and wait until none of its members moves.

    Returns
    -------
    tuple of int
        The group, this robot among it; the team keeps its key.
    """
    team = robot.team
    if team.is_alone:
        return (team.number,)
    awaited: list[int] = []
    deadline = 0.0
    while True:
        gpr = team.gpr()
        moving = [n for n in gpr if n != team.number and team.states[n].phase == "moving"]
        if not moving:
            team.key = team.key_of(gpr)
            return gpr
        if moving != awaited:
            awaited = moving
            arrival_s = max(team.states[number].arrival_s for number in moving)
            deadline = max(arrival_s + robot.me.radio.latency_s, robot.time_s) + team.period_s
        yield from team.hear(max(0.0, deadline - robot.time_s))
        if robot.time_s >= deadline:
            yield from team.ask(moving)
            deadline = robot.time_s + team.period_s


def build_ger(robot: SrtRobot, gpr: tuple[int, ...]) -> Generator[Action, Outcome, tuple[int, ...]]:
    """BUILD_GER: when all of the GPR have perceived, find who among them is engaged.

    Raises
    ------
    Regroup
        If the GPR has changed meanwhile.
    """
    team = robot.team
    if team.is_alone:
        return gpr
    yield from _meet(robot, gpr, "perceived")
    if len(gpr) == 1:
        return gpr
    regions, unseen = {}, []
    for number in gpr:
        node = robot.here if number == team.number else team.states[number].node
        if node is not None and node in robot.map:
            regions[number] = robot.map[node].region
        elif node is not None:
            # A master that knows it has sent its orders already: they are engaged.
            unseen.append(number)
    return tuple(sorted([*group_of(team.number, regions, LocalSafeRegion.overlaps), *unseen]))


def agree(robot: SrtRobot, group: Iterable[int]) -> Generator[Action, Outcome, None]:
    """Tell the group what this robot plans, and hear what the others do.

    Raises
    ------
    Regroup
        If a member has left the group meanwhile.
    """
    yield from _meet(robot, group, "planned")


def _meet(robot: SrtRobot, group: Iterable[int], phase: Phase) -> Generator[Action, Outcome, None]:
    # Says that this robot has come so far, and waits until all others have.
    team = robot.team
    yield from team.announce(phase)
    others = [number for number in group if number != team.number]
    deadline = robot.time_s + team.period_s
    while True:
        pending = [number for number in others if not _has_come(robot, number, phase)]
        if not pending or team.key in team.orders:
            return
        if any(is_elsewhere(robot, n, phase) for n in pending) and (
            team.key_of(team.gpr()) != team.key
        ):
            raise Regroup
        yield from team.hear(max(0.0, deadline - robot.time_s))
        if robot.time_s >= deadline:
            late = [n for n in pending if not _has_come(robot, n, phase)]
            yield from team.ask(late + _disputed(robot, late))
            team.rounds += 1
            if team.rounds > MOST_ROUNDS:
                _go_on_without(robot, late)
            deadline = robot.time_s + team.period_s


def _go_on_without(robot: SrtRobot, late: list[int]) -> None:
    # Robots that hear one another, but not the same others, may never agree who is in the
    # group. Rather than wait for ever, one goes around the other, guarded by its protective stop.
    for number in late:
        robot.team.ignored_until_s[number] = robot.time_s + IGNORED_S
        robot.avoid(number)
    robot.team.rounds = 0


def _disputed(robot: SrtRobot, pending: list[int]) -> list[int]:
    # Members that those who are waited for leave out, or of whom they know another step: one
    # that stands idle may be dead, or have given way while this robot was out of reach.
    keys = [dict(robot.team.states[number].key) for number in pending]
    theirs = [other for other in keys if other]
    return [
        number
        for number, step in robot.team.key
        if number != robot.team.number
        and number not in pending
        and any(other.get(number) != step for other in theirs)
    ]


def _has_come(robot: SrtRobot, number: int, phase: Phase) -> bool:
    # A member that stands idle is always there, and so is one that has gone on with this group.
    team = robot.team
    state, step = team.states[number], dict(team.key)[number]
    if team.is_out(number) or (state.node is not None and state.node not in robot.map):
        return False
    if state.step == step and state.phase == "idle":
        return True
    return state.key == team.key and (
        (state.step == step and REACHED[state.phase] >= REACHED[phase])
        or _has_gone_on(state, step, phase)
    )


def is_elsewhere(robot: SrtRobot, number: int, phase: Phase) -> bool:
    """Whether a member does not step with this group: it is lost, gone, or in another one."""
    team = robot.team
    if team.is_out(number):
        return True
    state, step = team.states[number], dict(team.key)[number]
    if state.key == team.key:
        return state.step != step and not _has_gone_on(state, step, phase)
    return state.step != step or REACHED[state.phase] > 0


def _has_gone_on(state: RobotState, step: int, phase: Phase) -> bool:
    # Whoever moves still names the node at which the group was built; and nobody goes on
    # before those whose plans it needs have planned.
    return state.step == step + 1 and (phase == "planned" or state.phase == "moving")
