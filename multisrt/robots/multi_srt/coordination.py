"""CHECK_FEASIBILITY and COORDINATE: robots whose paths conflict.

Source: Multi-SRT, paper section 2, "GER path feasibility check" and "Coordination". The master
is the robot of the highest number. Differs in:

- A robot that stands idle is never master, but the highest of those that make a step.
- A master that does not answer is presumed lost, the group is rebuilt without it, and the next
  highest is master.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

from multisrt.events import Coordinated, Organized
from multisrt.geometry.configuration import Configuration
from multisrt.robots.explorer import Action, Note, Outcome, Send
from multisrt.robots.multi_srt.alternatives import KnownAlternatives
from multisrt.robots.multi_srt.conflicts import Conflicts, Prospect
from multisrt.robots.multi_srt.engagement import Regroup, is_elsewhere
from multisrt.robots.multi_srt.messages import OrdersMessage, motion_of
from multisrt.robots.multi_srt.organize import Arrangement, organize
from multisrt.robots.multi_srt.progress import Event
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.multi_srt.targets import Step


@dataclass(frozen=True, slots=True)
class Feasibility:
    """Which robots of a group can move at once (paper: G_f and G_u).

    Attributes
    ----------
    group : tuple of int
        All robots of the group.
    feasible, unfeasible : tuple of int
        Those whose paths conflict with no other, and the rest.
    conflicts : Conflicts
        Which conflict with which.
    """

    group: tuple[int, ...]
    feasible: tuple[int, ...]
    unfeasible: tuple[int, ...]
    conflicts: Conflicts


def check_feasibility(robot: SrtRobot, group: tuple[int, ...]) -> Feasibility:
    """CHECK_FEASIBILITY: find the conflicts of prospective paths, bodies that stay included."""
    prospects = {}
    for number in group:
        state = robot.team.state_of(number)
        prospects[number] = Prospect(
            robot=number,
            footprint=robot.team.footprint(number),
            motion=motion_of(state.path),
            frontier_m=state.frontier_m,
            waited=state.waited,
        )
    conflicts = Conflicts(prospects, robot.options.guard_m)
    unfeasible = tuple(sorted({number for pair in conflicts.pairs for number in pair}))
    feasible = tuple(number for number in group if number not in unfeasible)
    return Feasibility(group, feasible, unfeasible, conflicts)


def coordinate(
    robot: SrtRobot, checked: Feasibility, step: Step | None
) -> Generator[Action, Outcome, Step | None]:
    """COORDINATE: as the master, organise the group; else wait for the orders of the master.

    Parameters
    ----------
    robot : SrtRobot
        The robot.
    checked : Feasibility
        The conflicts of its group.
    step : Step or None
        What it has planned; None: to stay.

    Returns
    -------
    Step or None
        What it does now; None: it waits.

    Raises
    ------
    Regroup
        If the master does not answer, or the group has changed meanwhile.
    """
    team = robot.team
    states = team.roster.states
    master = max(n for n in checked.group if n == team.number or states[n].phase != "idle")
    message = team.order_message
    if message is None:
        if master == team.number:
            message = yield from _organize(robot, checked)
        else:
            message = yield from _orders_of(robot, master)
    order = message.order_for(team.number)
    if order is None:
        raise AssertionError(f"robot {message.sender} left robot {team.number} out of its orders")
    after = robot.journey.step_by(order, step)
    if order.order != "keep":
        robot.progress.note(Event.SETBACK)
    x, y, _ = robot.at.q_act
    yield Note(
        Coordinated(
            time_s=robot.at.time_s,
            robot=team.number,
            ger=checked.group,
            master=message.sender,
            feasible=message.feasible,
            unfeasible=message.unfeasible,
            target=(x, y) if step is None else _place(step.motion.end),
            order=order.order,
            new_target=(x, y) if after is None else _place(after.motion.end),
        )
    )
    return after


def _organize(robot: SrtRobot, checked: Feasibility) -> Generator[Action, Outcome, OrdersMessage]:
    team = robot.team
    arrangement = organize(checked.conflicts, KnownAlternatives(robot))
    yield Note(_organized(robot, checked, arrangement))
    message = OrdersMessage(
        sender=team.number,
        key=team.status.key,
        orders=tuple(arrangement.orders.items()),
        feasible=checked.feasible,
        unfeasible=checked.unfeasible,
    )
    team.orders = message
    yield Send(message)
    return message


def _orders_of(robot: SrtRobot, master: int) -> Generator[Action, Outcome, OrdersMessage]:
    team, at = robot.team, robot.at
    deadline = at.time_s + team.period_s
    while (message := team.order_message) is None:
        if is_elsewhere(robot, master, "planned") and team.has_regrouped():
            raise Regroup
        yield from team.hear(max(0.0, deadline - at.time_s))
        if at.time_s >= deadline and team.order_message is None:
            yield from team.ask([master])
            deadline = at.time_s + team.period_s
    return message


def _organized(robot: SrtRobot, checked: Feasibility, arrangement: Arrangement) -> Organized:
    prospects = checked.conflicts.prospects
    return Organized(
        time_s=robot.at.time_s,
        robot=robot.team.number,
        feasible=checked.feasible,
        unfeasible=checked.unfeasible,
        before={number: prospect.target for number, prospect in prospects.items()},
        after=arrangement.targets,
        orders={number: order.order for number, order in arrangement.orders.items()},
        conflicts=checked.conflicts.pairs,
        deadlock=arrangement.is_deadlock,
    )


def _place(configuration: Configuration) -> tuple[float, float]:
    return configuration.x, configuration.y
