"""Breaking off a task to deliver data, and going on with it."""

from __future__ import annotations

from collections.abc import Callable

from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.srt import Draws
from multisrt.robots.explorer import Steps
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.build_srt import take_steps, until_boxed_in
from multisrt.robots.multi_srt.homing import CalledHome, SrtHoming
from multisrt.robots.multi_srt.planner import Choosing, on_the_way
from multisrt.robots.multi_srt.progress import Event
from multisrt.robots.multi_srt.robot import SrtRobot


def bringing_home(robot: SrtRobot, task: Callable[[bool], Steps], tree: NodeId | None) -> Steps:
    """Do a task; each time that the robot is called home, deliver, and begin the task again.

    Parameters
    ----------
    robot : SrtRobot
        The robot.
    task : callable
        Returns the steps of the task, from wherever the robot is, given whether it was begun
        before.
    tree : NodeId or None
        Root of the tree that it extends then; see `Whereabouts.tree`.

    Raises
    ------
    OutOfTime
        If there is no time for another target.
    """
    resumes = False
    while True:
        try:
            yield from task(resumes)
        except CalledHome as call:
            assert robot.homing is not None
            yield from go_home(robot, robot.homing, str(call))
            robot.at.tree, resumes = tree, True
        else:
            return


def bring_the_rest(robot: SrtRobot, why: str) -> Steps:
    """Go home with what the robot carries when it has nothing else to do.

    Not for data that shows nothing new: it gains such by giving way to others at home.
    """
    homing = robot.homing
    if homing is None or robot.at.here is None or not homing.may_deliver:
        return
    # The answer to what was said last may be on its way.
    yield from robot.team.pause(robot.team.round_trip_s)
    if homing.carries_area and homing.route_from(robot.at.node) is not None:
        yield from go_home(robot, homing, why)


def go_home(robot: SrtRobot, homing: SrtHoming, why: str) -> Steps:
    """Go to the nearest node where the base station hears the robot, and deliver.

    It ends on the way once all is acknowledged, or if bodies bar it.
    """
    yield homing.decision_note(why)
    was_enabled, homing.is_enabled = homing.is_enabled, False
    homing.goes_home = True
    robot.at.tree = None

    def next_choice(frontier: FloatArray, draws: Draws) -> Choosing:
        yield from ()  # a planner may record events; this one has none
        if not robot.team.carries or homing.is_home():
            return "end", None
        robot.roadmap.extend()
        route = homing.route_from(robot.at.node)
        return ("stay", None) if route is None else on_the_way(robot, route[-1], "home")

    robot.progress.note(Event.NEW_TASK)
    robot.journey.begin("home")
    yield from robot.team.begin_step()
    yield from until_boxed_in(robot, take_steps(robot, next_choice))
    if robot.team.carries and not homing.is_home():
        homing.note_barred()
    else:
        yield from homing.deliver()
    homing.is_enabled, homing.goes_home = was_enabled, False
