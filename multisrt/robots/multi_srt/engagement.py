"""BUILD_AND_WAIT_GPR and BUILD_GER: how robots come to agree on who steps together.

Source: Multi-SRT, paper section 2, "Construction of GPR/GER"; differs in: the paper leaves open
how robots agree. Here a group is named by its members and the number of the step that each is
about to make (its key). A member continues when all others have said that they have reached the
same phase with the same key; so no robot moves by a group that another member does not know,
whatever messages are delayed or lost. There are three exceptions:

- A member that stands idle in the step that the key names need not say anything.
- The orders of a master end the waiting: it had the plans of all when it gave them.
- After `max_rounds` rounds of questions a robot leaves those that have not confirmed out of its
  groups for `left_out_s`, and goes around them.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable

from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots.explorer import Action, Outcome, Steps
from multisrt.robots.multi_srt.groups import group_of
from multisrt.robots.multi_srt.messages import Phase, RobotState
from multisrt.robots.multi_srt.robot import SrtRobot

REACHED: dict[Phase, int] = {"waiting": 0, "perceived": 1, "planned": 2, "moving": 3, "idle": 0}
"""Order of the phases of a step."""


class Regroup(Exception):
    """The group has changed since it was built: the step begins again, without perceiving again."""


def build_and_wait_gpr(robot: SrtRobot) -> Generator[Action, Outcome, tuple[int, ...]]:
    """BUILD_AND_WAIT_GPR: build the GPR, and wait until none of its members moves.

    Returns
    -------
    tuple of int
        The group, this robot among it; its key is set in the team's status.
    """
    team, at = robot.team, robot.at
    if team.is_alone:
        return (team.number,)
    states = team.roster.states
    awaited: list[int] = []
    deadline = 0.0
    while True:
        gpr = team.gpr()
        moving = [n for n in gpr if n != team.number and states[n].phase == "moving"]
        if not moving:
            team.status.key = team.key_of(gpr)
            return gpr
        if moving != awaited:
            awaited = moving
            arrival_s = max(states[number].arrival_s for number in moving)
            deadline = max(arrival_s + robot.me.radio.latency_s, at.time_s) + team.period_s
        yield from team.hear(max(0.0, deadline - at.time_s))
        if at.time_s >= deadline:
            yield from team.ask(moving)
            deadline = at.time_s + team.period_s


def build_ger(robot: SrtRobot, gpr: tuple[int, ...]) -> Generator[Action, Outcome, tuple[int, ...]]:
    """BUILD_GER: when all of the GPR have perceived, find those that are engaged.

    Returns
    -------
    tuple of int
        The group of engaged robots, this robot among it.

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
        node = team.state_of(number).node
        if node is not None and node in robot.map:
            regions[number] = robot.map[node].region
        elif node is not None:
            # A master that knows this node has sent its orders already: they are engaged.
            unseen.append(number)
    return tuple(sorted([*group_of(team.number, regions, LocalSafeRegion.overlaps), *unseen]))


def agree(robot: SrtRobot, group: Iterable[int]) -> Steps:
    """Send the group what this robot plans, and wait for the plans of the others.

    Raises
    ------
    Regroup
        If a member has left the group meanwhile.
    """
    yield from _meet(robot, group, "planned")


def _meet(robot: SrtRobot, group: Iterable[int], phase: Phase) -> Steps:
    # Announce that this robot has reached a phase, and wait until all others have.
    team, at = robot.team, robot.at
    yield from team.announce(phase)
    others = [number for number in group if number != team.number]
    deadline = at.time_s + team.period_s
    while True:
        pending = [number for number in others if not _has_come(robot, number, phase)]
        if not pending or team.order_message is not None:
            return
        if any(is_elsewhere(robot, n, phase) for n in pending) and team.has_regrouped():
            raise Regroup
        yield from team.hear(max(0.0, deadline - at.time_s))
        if at.time_s >= deadline:
            late = [n for n in pending if not _has_come(robot, n, phase)]
            yield from team.ask(late + _disputed(robot, late))
            if robot.progress.has_asked_enough():
                _go_on_without(robot, late)
            deadline = at.time_s + team.period_s


def _go_on_without(robot: SrtRobot, late: list[int]) -> None:
    # Robots that hear one another, but not the same others, may never agree on the group. Rather
    # than wait forever, this one goes around them, guarded by its protective stop.
    for number in late:
        robot.team.roster.left_out_until_s[number] = robot.at.time_s + robot.options.left_out_s
        robot.avoid(number)


def _disputed(robot: SrtRobot, pending: list[int]) -> list[int]:
    # Members that those who are waited for do not count as members, or in another step: one that
    # stands idle may have died, or have given way while this robot was out of reach.
    team = robot.team
    keys = [dict(team.roster.states[number].key) for number in pending]
    theirs = [other for other in keys if other]
    return [
        number
        for number, step in team.status.key
        if number != team.number
        and number not in pending
        and any(other.get(number) != step for other in theirs)
    ]


def _has_come(robot: SrtRobot, number: int, phase: Phase) -> bool:
    # A member that stands idle is always there, and so is one that has gone on with this group.
    team = robot.team
    state, step = team.roster.states[number], dict(team.status.key)[number]
    if team.roster.is_out(number) or (state.node is not None and state.node not in robot.map):
        return False
    if state.step == step and state.phase == "idle":
        return True
    return state.key == team.status.key and (
        (state.step == step and REACHED[state.phase] >= REACHED[phase])
        or _has_gone_on(state, step, phase)
    )


def is_elsewhere(robot: SrtRobot, number: int, phase: Phase) -> bool:
    """Whether a member does not step with this group: presumed lost, gone, or in another one."""
    team = robot.team
    if team.roster.is_out(number):
        return True
    state, step = team.roster.states[number], dict(team.status.key)[number]
    if state.key == team.status.key:
        return state.step != step and not _has_gone_on(state, step, phase)
    return state.step != step or REACHED[state.phase] > 0


def _has_gone_on(state: RobotState, step: int, phase: Phase) -> bool:
    # A member that moves still names the node at which the group was built; and no member moves
    # before all those whose plans it needs have planned.
    return state.step == step + 1 and (phase == "planned" or state.phase == "moving")
