"""Going after a mate that is out of touch, so that the two share what is left to explore.

A robot compares two plans of routes over the frontiers that it knows (`team_routes`). Out of touch,
the mate goes over those alone that it knows; robots in touch go over all. If the two met, it could
go over all of them, too: their routes would begin at the place and time of the meeting. Only if the
routes then cost less, by the length of the longest and a tenth of the mean, is the mate pursued, to
where it most probably is when the robot can be there (`multisrt.planners.pursuit`). The pursuit is
over once the mate has what the robot knew, and in vain if it is not there until a while after that
time.

Source: M-TARE (repository `caochao39/mtare_planner`, `grid_world` and `pursuit_mdp`). Differs in:
targets are frontiers and not cells of 6 m; the route that a mate told is its path to its goal, and
goes on as this robot would plan it; cells of a route are as long as the robot drives in two steps,
so that the chain is as fast as the robot in the mean; one mate is pursued at a time, and not
sampled sets of them; a pursuit in vain is not repeated until the mate is heard again.
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
from multisrt.robots.homing.their_map import TheirMap
from multisrt.robots.knowledge import Counts
from multisrt.robots.listening import counts_beyond, have_of

MAX_TARGETS = 12
"""Number of frontiers, the nearest, over which routes are planned."""

MIN_GAIN_M = 1.0
"""Routes count as shorter only by more than this, in metres: both are found by local search."""

MAX_PURSUITS = 3
"""Number of pursuits of a mate that learned nothing by them, after which it is not pursued."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Quarry:
    """The mate that is pursued.

    Attributes
    ----------
    mate : int
        Its number.
    place : (x, y)
        Where to meet it, in metres.
    met_s : float
        When.
    carried : tuple of (robot, nodes, closings)
        What it is to know then.
    why : str
        Why it is pursued, in words.
    """

    mate: int
    place: Place
    met_s: float
    carried: Counts
    why: str


class Pursuit:
    """When a robot goes after a mate, and where.

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
        What brings its news home: this comes first.
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
        self._routes = PathLengths(me, map, paths)
        self._theirs: dict[int, TheirMap] = {}
        self._quarry: Quarry | None = None
        self._next_s = -math.inf
        # When each mate was pursued in vain, and how often with what it then
        # knew of others.
        self._vain_s: dict[int, float] = {}
        self._tries: dict[tuple[int, Counts], int] = {}

    # When -----------------------------------------------------------------------------------

    def errand(self) -> Errand | None:
        """Return the errand to meet a mate, if that is of use now; the present one goes on."""
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
            until_s=quarry.met_s,
            patience_s=self._options.pursue_wait_s,
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
        self._vain_s[quarry.mate] = self._course.time_s

    def _knows(self, quarry: Quarry) -> bool:
        have = have_of(self._team.mates.reports[quarry.mate].have)
        return not counts_beyond(quarry.carried, have)

    def _is_over(self, quarry: Quarry) -> bool:
        is_called = self._homing is not None and self._homing.calls(self._course)
        return is_called or self._knows(quarry)

    def _is_absent(self, report: RobotReport) -> bool:
        """Whether a robot is out of touch, and may be pursued."""
        mates, number = self._team.mates, report.robot
        return (
            not self._team.hears(number)
            and not mates.is_lost(number)
            and mates.last_heard_s(number) > self._vain_s.get(number, -math.inf)
            and self._tries.get(_learned(report), 0) < MAX_PURSUITS
        )

    # Whom -----------------------------------------------------------------------------------

    def _best_quarry(self) -> Quarry | None:
        mates = self._team.mates
        reports = [r for _, r in sorted(mates.reports.items()) if not mates.is_lost(r.robot)]
        absent = [report for report in reports if self._is_absent(report)]
        if not absent:
            return None
        targets = self._targets()
        known = {report.robot: self._known_to(report, targets) for report in reports}
        absent = [report for report in absent if not known[report.robot].all()]
        if not absent:
            return None
        table = RouteTable(self._routes, targets, reports, known, self._course)
        apart = table.apart()
        best: tuple[tuple[int, float], Quarry] | None = None
        for report in absent:
            found = self._meeting(report, table, apart)
            if found is None:
                continue
            place, met_s, passed = found
            before_m = (met_s - self._course.time_s) * self._speed_m_s
            together = table.together(report.robot, place, before_m, passed)
            cost = len(together.left_out), together.cost_m
            if self._is_gain(together, apart) and (best is None or cost < best[0]):
                count = int((~known[report.robot]).sum())
                best = (
                    cost,
                    Quarry(
                        mate=report.robot,
                        place=place,
                        met_s=met_s,
                        carried=self._map.entries.counts(),
                        why=f"robot {report.robot}, which does not know of {count} of "
                        f"{len(targets)} frontiers; the longest route becomes "
                        f"{together.longest_m:.1f} m instead of {apart.longest_m:.1f} m",
                    ),
                )
        if best is None:
            return None
        quarry = best[1]
        tried = _learned(mates.reports[quarry.mate])
        self._tries[tried] = self._tries.get(tried, 0) + 1
        return quarry

    def _is_gain(self, together: TeamRoutes, apart: TeamRoutes) -> bool:
        """Whether the routes after a meeting are better: fewer targets left out, or shorter."""
        if len(together.left_out) != len(apart.left_out):
            return len(together.left_out) < len(apart.left_out)
        gain_m = max(MIN_GAIN_M, self._options.pursue_gain * apart.cost_m)
        return together.cost_m < apart.cost_m - gain_m

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
        """Return which targets lie in what another robot knows; all for one in touch."""
        if self._team.hears(report.robot):
            return np.ones(len(targets), np.bool_)
        theirs = self._theirs.get(report.robot)
        if theirs is None:
            theirs = self._theirs[report.robot] = TheirMap(self._map.entries, self._map.raster)
        theirs.take(have_of(report.have))
        return np.array([theirs.raster.is_known(x, y) for x, y in targets.tolist()], np.bool_)

    # Where ----------------------------------------------------------------------------------

    def _meeting(
        self, report: RobotReport, table: RouteTable, apart: TeamRoutes
    ) -> tuple[Place, float, tuple[int, ...]] | None:
        """Return where and when to meet a mate, and the targets that it passes before."""
        options, now_s = self._options, self._course.time_s
        route, passes_m = table.route(report, apart.routes[table.row_of(report.robot)])
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
        """Return the steps, from a time on, in which the robot can be at places."""
        raster = self._map.raster
        near = [raster.passable_near(x, y, NEAR_BY_CELLS) for x, y in cells.tolist()]
        arrivals = np.full(len(cells), np.inf)
        with self._paths.around_bodies():
            field = self._paths.own_field()
            usable = [k for k, cell in enumerate(near) if cell is not None]
            if field is None or not usable:
                return arrivals
            centres = np.array([raster.centre_of(*cell) for cell in near if cell is not None])
            way_m = field.distance(indices_of(raster, centres))
            if self._homing is not None:
                way_m = self._homing.only_fitting(self._course, centres, way_m)
        since_now_s = self._course.time_s - since_s
        arrivals[usable] = (since_now_s + way_m / self._speed_m_s) / self._options.pursue_step_s
        return arrivals

    @property
    def _speed_m_s(self) -> float:
        return self._me.kinematics.speed_m_s


def _learned(report: RobotReport) -> tuple[int, Counts]:
    """Return a robot and what it knows of others; its own nodes are no use of a pursuit."""
    return report.robot, tuple(entry for entry in report.have if entry[0] != report.robot)
