"""Pursuit of a teammate that is out of touch, so that the two share what is left to explore.

A robot compares two plans of routes over the frontiers that it knows (`team_routes`). In the first
the teammate, which is out of touch, visits only frontiers that it knows itself; robots in touch
visit any. In the second the two meet, so that the teammate may visit any, too, and their routes
begin at the place and time of the meeting. The teammate is pursued only if the second plan leaves
out fewer frontiers or, with equally many, costs clearly less: the longest route plus a tenth of the
mean. The robot drives to where the teammate most probably is when the robot can be there
(`multisrt.planners.pursuit`). A pursuit succeeds once the teammate has what the robot knew, and
fails if it has not come some time after the predicted meeting.

Source: M-TARE (repository `caochao39/mtare_planner`, `grid_world` and `pursuit_mdp`). Differs in:
targets are frontiers, not cells of 6 m; the route of a teammate is its reported path to its goal,
and from there the route that this robot plans for it; the cells of a route are as long as the robot
drives in two steps, so that on its route the Markov chain is on average as fast as the robot (with
the default probabilities); one teammate is pursued at a time, not sampled sets of them; a pursuit
in vain is not repeated until the teammate is heard again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.planners.assignment.team_routes import TeamRoutes
from multisrt.planners.pursuit import Meeting, best_meeting, presence
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.errands import Errand
from multisrt.robots.frontier.fields import NEAR_BY_CELLS, indices_of
from multisrt.robots.frontier.frontiers import Frontiers
from multisrt.robots.frontier.goal import Place
from multisrt.robots.frontier.homing import FrontierHoming
from multisrt.robots.frontier.messages import RobotReport
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.path_finder import PathFinder
from multisrt.robots.frontier.pursuit_routes import PathLengths, RouteTable, cells_of
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.frontier.team import Team
from multisrt.robots.homing.known_by_other import KnownByOther
from multisrt.robots.knowledge import Counts
from multisrt.robots.listening import counts_beyond, have_of

MAX_TARGETS = 12
"""Maximum number of frontiers over which routes are planned: the nearest."""

MIN_GAIN_M = 1.0
"""Minimum decrease of the cost of the routes in metres: both plans are found by local search."""

MAX_PURSUITS = 3
"""Number of pursuits without effect after which a teammate is not pursued any more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Quarry:
    """A teammate that is pursued, and where.

    Attributes
    ----------
    teammate : int
        Number of the teammate.
    place : (x, y)
        Place of the meeting in metres.
    met_s : float
        Time of the meeting in seconds.
    carried : tuple of (robot, nodes, closings)
        What the teammate has to know after it.
    why : str
        Why it is pursued, in words.
    """

    teammate: int
    place: Place
    met_s: float
    carried: Counts
    why: str


class Pursuit:
    """When a robot has to pursue a teammate, and where.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : FrontierOptions
        Its parameters.
    course : Course
        Where it is.
    map : ScanMap
        What it knows.
    team : Team
        Its messages, and the last reports of the others.
    paths : PathFinder
        Its paths.
    frontiers : Frontiers
        Its targets.
    homing : FrontierHoming or None
        What delivers its data, which has priority.
    """

    def __init__(
        self,
        me: RobotSelf,
        options: FrontierOptions,
        course: Course,
        map: ScanMap,
        team: Team,
        paths: PathFinder,
        frontiers: Frontiers,
        homing: FrontierHoming | None,
    ) -> None:
        self._me = me
        self._options = options
        self._course = course
        self._map = map
        self._team = team
        self._paths = paths
        self._frontiers = frontiers
        self._homing = homing
        self._lengths = PathLengths(me, map, paths)
        self._known: dict[int, KnownByOther] = {}
        self._quarry: Quarry | None = None
        self._next_s = -math.inf
        # When each teammate was last pursued in vain, and how often it was pursued with the same
        # knowledge of others.
        self._vain_s: dict[int, float] = {}
        self._tries: dict[tuple[int, Counts], int] = {}

    # When -----------------------------------------------------------------------------------

    def errand(self) -> Errand | None:
        """Return the errand to meet a teammate, the present one first; None if there is none."""
        now_s = self._course.time_s
        if self._quarry is None and now_s >= self._next_s:
            self._next_s = now_s + self._options.pursue_step_s
            self._quarry = self._best_quarry()
        quarry = self._quarry
        if quarry is None:
            return None
        goal = self._paths.goal_near(quarry.place)
        if goal is None:
            self.note_end()
            return None
        made = Errand(
            kind="pursue",
            why=quarry.why,
            goal=goal,
            is_over=lambda: self._is_over(quarry),
            until_s=quarry.met_s + self._options.pursue_wait_s,
        )
        if made.is_over() or made.is_late(now_s):
            self.note_end()
            return None
        return made

    def note_end(self) -> None:
        """Record that the pursuit is over, perhaps in vain."""
        quarry, self._quarry = self._quarry, None
        if quarry is None or self._knows(quarry):
            return
        self._vain_s[quarry.teammate] = self._course.time_s

    def _knows(self, quarry: Quarry) -> bool:
        have = have_of(self._team.teammates.reports[quarry.teammate].have)
        return not counts_beyond(quarry.carried, have)

    def _is_over(self, quarry: Quarry) -> bool:
        is_called = self._homing is not None and self._homing.must_interrupt()
        return is_called or self._knows(quarry)

    def _is_absent(self, report: RobotReport) -> bool:
        """Return whether a robot is out of touch, and may be pursued."""
        teammates, number = self._team.teammates, report.robot
        return (
            not self._team.hears(number)
            and not teammates.is_lost(number)
            and teammates.last_heard_s(number) > self._vain_s.get(number, -math.inf)
            and self._tries.get(_learned(report), 0) < MAX_PURSUITS
        )

    # Whom -----------------------------------------------------------------------------------

    def _best_quarry(self) -> Quarry | None:
        teammates = self._team.teammates
        reports = [
            r for _, r in sorted(teammates.reports.items()) if not teammates.is_lost(r.robot)
        ]
        absent = [report for report in reports if self._is_absent(report)]
        if not absent:
            return None
        targets = self._targets()
        known = {report.robot: self._known_to(report, targets) for report in reports}
        absent = [report for report in absent if not known[report.robot].all()]
        if not absent:
            return None
        table = RouteTable(self._lengths, targets, reports, known, self._course, self._speed_m_s)
        separate = table.separate_routes()
        best: tuple[tuple[int, float], Quarry] | None = None
        for report in absent:
            found = self._meeting(report, table, separate)
            if found is None:
                continue
            place, met_s, passed = found
            before_m = (met_s - self._course.time_s) * self._speed_m_s
            joint = table.routes_after_meeting(report.robot, place, before_m, passed)
            cost = len(joint.left_out), joint.cost_m
            if self._is_gain(joint, separate) and (best is None or cost < best[0]):
                count = int((~known[report.robot]).sum())
                best = (
                    cost,
                    Quarry(
                        teammate=report.robot,
                        place=place,
                        met_s=met_s,
                        carried=self._map.entries.counts(),
                        why=f"robot {report.robot}, which does not know of {count} of "
                        f"{len(targets)} frontiers; the longest route becomes "
                        f"{joint.longest_m:.1f} m instead of {separate.longest_m:.1f} m",
                    ),
                )
        if best is None:
            return None
        quarry = best[1]
        tried = _learned(teammates.reports[quarry.teammate])
        self._tries[tried] = self._tries.get(tried, 0) + 1
        return quarry

    def _is_gain(self, joint: TeamRoutes, separate: TeamRoutes) -> bool:
        """Return whether the routes after a meeting leave out fewer targets, or cost less."""
        if len(joint.left_out) != len(separate.left_out):
            return len(joint.left_out) < len(separate.left_out)
        gain_m = max(MIN_GAIN_M, self._options.pursue_gain * separate.cost_m)
        return joint.cost_m < separate.cost_m - gain_m

    def _targets(self) -> FloatArray:
        """Return the nearest frontiers that the robot can reach, ``(m, 2)`` metres."""
        targets = self._frontiers.targets()
        with self._paths.around_bodies():
            field = self._paths.own_field()
            if field is None or not len(targets):
                return np.empty((0, 2))
            costs = field.distance(indices_of(self._map.raster, targets))
        nearest = np.argsort(costs, kind="stable")[:MAX_TARGETS]
        reached: FloatArray = targets[nearest[np.isfinite(costs[nearest])]]
        return reached

    def _known_to(self, report: RobotReport, targets: FloatArray) -> BoolArray:
        """Return which targets another robot knows; all if it is in touch."""
        if self._team.hears(report.robot):
            return np.ones(len(targets), np.bool_)
        known = self._known.get(report.robot)
        if known is None:
            known = self._known[report.robot] = KnownByOther(self._map.entries, self._map.raster)
        known.take(have_of(report.have))
        return np.array([known.raster.is_known(x, y) for x, y in targets.tolist()], np.bool_)

    # Where ----------------------------------------------------------------------------------

    def _meeting(
        self, report: RobotReport, table: RouteTable, separate: TeamRoutes
    ) -> tuple[Place, float, tuple[int, ...]] | None:
        """Return where and when to meet a teammate, and the targets that it passes before."""
        options, now_s = self._options, self._course.time_s
        route, passes_m = table.route(report, separate.routes[table.row_of(report.robot)])
        step_m = self._speed_m_s * options.pursue_step_s
        cells, at_m = cells_of(route, 2.0 * step_m)
        arrivals = self._arrivals(cells, report.time_s)
        chances = presence(
            len(cells), options.pursue_steps, stay=options.pursue_stay, leave=options.pursue_leave
        )
        found: Meeting | None = best_meeting(arrivals, chances)
        if found is None:
            return None
        x, y = cells[found.cell].tolist()
        passed = tuple(target for target, m in passes_m if m <= at_m[found.cell])
        met_s = max(now_s, report.time_s + found.step * options.pursue_step_s)
        return (x, y), met_s, passed

    def _arrivals(self, cells: FloatArray, since_s: float) -> FloatArray:
        """Return the numbers of steps since a time after which the robot can be at places."""
        raster = self._map.raster
        near = [raster.passable_near(x, y, NEAR_BY_CELLS) for x, y in cells.tolist()]
        arrivals = np.full(len(cells), np.inf)
        with self._paths.around_bodies():
            field = self._paths.own_field()
            usable = [k for k, cell in enumerate(near) if cell is not None]
            if field is None or not usable:
                return arrivals
            centres = np.array([raster.centre_of(*cell) for cell in near if cell is not None])
            costs_m = field.distance(indices_of(raster, centres))
            if self._homing is not None:
                costs_m = self._homing.only_fitting(centres, costs_m)
        since_now_s = self._course.time_s - since_s
        arrivals[usable] = (since_now_s + costs_m / self._speed_m_s) / self._options.pursue_step_s
        return arrivals

    @property
    def _speed_m_s(self) -> float:
        return self._me.kinematics.speed_m_s


def _learned(report: RobotReport) -> tuple[int, Counts]:
    """Return a robot and its counts of nodes of others, the only ones that a pursuit tells it."""
    return report.robot, tuple(entry for entry in report.have if entry[0] != report.robot)
