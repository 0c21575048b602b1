"""BUILD_MULTI_SRT: what one robot of a team does from beginning to end (Multi-SRT, Figure 1)."""

from __future__ import annotations

from multisrt.geometry.regions.shapes import Shape
from multisrt.planners.home_options import NO_TIME_LEFT
from multisrt.robots.explorer import Done, RobotSelf, Steps
from multisrt.robots.multi_srt.bring_home import bring_the_rest, bringing_home
from multisrt.robots.multi_srt.build_srt import build_srt, until_boxed_in
from multisrt.robots.multi_srt.homing import OutOfTime
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.robot import SrtRobot
from multisrt.robots.multi_srt.support import (
    Supported,
    ask_those_in_the_way,
    follow_orders,
    open_frontier,
    support_others,
)
from multisrt.robots.multi_srt.trees import segments_of
from multisrt.robots.naming import WALLED_IN, boxed_in_by, named_robots


class SrtExplorer:
    """Explores by Sensor-based Random Trees of balls, stars or radial regions, alone or in a team.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    shape : {"ball", "star", "radial"}
        Shape of its local safe regions.
    options : MultiSrtOptions
        The parameters.

    Attributes
    ----------
    robot : SrtRobot
        The robot and what it knows.
    is_out_of_time : bool
        Whether it has ended as there was no time for another target and the path home.
    """

    def __init__(self, me: RobotSelf, shape: Shape, options: MultiSrtOptions) -> None:
        self.robot = SrtRobot(me, shape, options)
        self.is_out_of_time = False

    def run(self) -> Steps:
        """BUILD_MULTI_SRT: extend the own tree, then those of others; then stand by."""
        robot, supported = self.robot, Supported()
        yield from robot.team.begin_step()
        yield from self.in_time(self.explore())
        if not robot.options.support:
            supported.left_m[robot.trees.root] = open_frontier(robot, robot.trees.root)
        while True:
            if not robot.team.is_alone and not self.is_out_of_time:
                yield from self.in_time(self.support(supported))
                yield from ask_those_in_the_way(robot)
                if robot.deferred.is_due() and not self.is_out_of_time:
                    continue
            known = robot.team.news()
            yield from bring_the_rest(robot, "it knows of nothing that is left to explore")
            if robot.team.news() != known and not self.is_out_of_time:
                continue
            if not (yield from robot.team.ask_again()):
                yield from robot.team.take((yield self.done()))
            yield from self.in_time(self.give_way())

    def explore(self) -> Steps:
        """Extend the own tree; deliver data meanwhile, and in the end."""
        robot = self.robot

        def build(resumes: bool) -> Steps:
            return until_boxed_in(robot, build_srt(robot, resumes=resumes))

        yield from bringing_home(robot, build, robot.trees.root)
        robot.at.tree = None
        yield from robot.team.rest()
        yield from bring_the_rest(robot, "it has explored its tree")

    def support(self, supported: Supported) -> Steps:
        """Extend the trees of others; deliver data meanwhile."""
        yield from bringing_home(self.robot, lambda _: support_others(self.robot, supported), None)

    def give_way(self) -> Steps:
        """Give way, if a master has ordered it; deliver data meanwhile."""
        yield from bringing_home(self.robot, lambda _: follow_orders(self.robot), None)

    def in_time(self, task: Steps) -> Steps:
        """Do a task; end it if there is no time for more."""
        robot = self.robot
        try:
            yield from task
        except OutOfTime:
            assert robot.homing is not None
            self.is_out_of_time, robot.homing.is_enabled = True, False
            robot.at.tree = None
            yield from robot.team.rest()

    def done(self) -> Done:
        """Return how it ended: all that it knows of is explored, or what was left and why."""
        robot, deferred = self.robot, self.robot.deferred
        if self.is_out_of_time:
            reason = f"{NO_TIME_LEFT} target and the way home"
            return Done(complete=False, reason=reason, on_call=robot.team.has_receivers)
        nodes = robot.map.open_nodes(robot.trees.root)
        frontier = [robot.map.frontier(node) for node in nodes]
        open_m = deferred.open_m(robot.trees.root)
        barred_m, barring = deferred.left()
        # With its third stage, the planner leaves frontier only if the robot was boxed in, which it
        # need not be any more: a path may have been found, but not to there.
        if open_m and (robot.progress.is_boxed_in or robot.options.complete):
            # Another robot may be an obstacle now that was none when this one gave up.
            walls = robot.is_walled_in and (robot.lacks_room or not robot.obstacles)
            boxed_in = WALLED_IN if walls else boxed_in_by(robot.obstacles.all)
            reason = f"{boxed_in}, with {open_m:.1f} m of frontier left open"
        elif open_m:
            reason = (
                f"the planner has no target, with {open_m:.1f} m of frontier left open at "
                f"{sum(map(deferred.has_frontier, nodes))} nodes"
            )
        elif barring:
            one, may_leave = len(barring) == 1, any(map(robot.team.roster.answers, barring))
            do_not = f"{'does' if one else 'do'} not {'give way' if may_leave else 'answer'}"
            reason = (
                f"{named_robots(barring)}, which {do_not}, {'stands' if one else 'stand'} in the "
                f"way to {barred_m:.1f} m of frontier; every other arc is explored or closed"
            )
        else:
            reason = "every frontier arc is explored or closed"
            if not robot.map.is_complete():
                others = sorted({node.robot for node in robot.map.open_nodes()})
                reason = (
                    "every frontier arc of its own tree is explored or closed; "
                    f"the open arcs of the {'tree' if len(others) == 1 else 'trees'} of "
                    f"{named_robots(others)} are left to other robots or out of reach"
                )
        return Done(
            complete=not open_m and not barring,
            reason=reason,
            frontier=tuple(segment for arcs in frontier for segment in segments_of(arcs)),
            on_call=robot.team.has_receivers,
        )
