"""How a robot that goes to frontiers brings its news home.

What the parts of `multisrt.robots.homing` need of such a robot is here: the way home over its
raster, and the drive there as an errand. The way home is the shortest over cells that are known to
be passable, to a node from which the base station surely hears the robot (`ContactPlaces`). It is
cut short where the base station hears the robot earlier. Where it does not hear it in the end, the
robot goes to such a place once more, the nearest one to the base station, before it gives up.
"""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.grids.distance_field import DistanceField
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.errands import Errand
from multisrt.robots.frontier.fields import NEAR_BY_CELLS, indices_of
from multisrt.robots.frontier.goal import Goal, Place, length_of
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.path_finder import PathFinder
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.frontier.team import Team
from multisrt.robots.homing.contact import ContactPlaces
from multisrt.robots.homing.just_in_time import JustInTime
from multisrt.robots.homing.pairs import AppointmentMessage, Pair, Role, Stage
from multisrt.robots.homing.worth import NewsWorth

STANDING_CELLS = 2
"""How far from a node the cell may be, in cells, at which a robot that goes there stands."""

TOUCH_PERIODS = 2.0
"""For so many periods of its reports a robot counts as in touch with the base station."""


def homing_of(
    me: RobotSelf, options: FrontierOptions, map: ScanMap, team: Team, paths: PathFinder
) -> FrontierHoming | None:
    """Return what brings a robot's news home; None if its options say that nothing does.

    Raises
    ------
    InvalidInputError
        If the time limit is too short.
    """
    if options.home == "never" or me.base is None:
        return None
    return FrontierHoming(me, options, map, team, paths)


class FrontierHoming:
    """When and where a robot goes to bring news home.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : FrontierOptions
        Its parameters.
    map : ScanMap
        What it knows.
    team : Team
        Its messages, which tell what the base station knows.
    paths : PathFinder
        Its paths.

    Attributes
    ----------
    time : JustInTime
        How long ways last, and when the time is over.
    pair : Pair
        What it does in its pair; alone unless the robots go in pairs.
    """

    def __init__(
        self,
        me: RobotSelf,
        options: FrontierOptions,
        map: ScanMap,
        team: Team,
        paths: PathFinder,
    ) -> None:
        self.time = JustInTime.of(me, options)
        assert me.base is not None
        self.pair = Pair(
            me.robot, me.team, base=me.base, period_s=options.home_period_s, now_s=me.time_s
        )
        if options.home == "relays":
            team.pair = self.pair
        else:
            self.pair.part()
        self._paths = paths
        self._options = options
        self._map = map
        self._team = team
        self._contact = ContactPlaces(me)
        self._worth = NewsWorth(map.entries, map.raster)
        # By place where the robot is heard, the passable cell next to it.
        self._standing: dict[Place, tuple[int, int]] = {}
        self._sources: dict[Place, None] = {}
        self._field: DistanceField | None = None
        self._revision = -1
        # Until then there is time, wherever the robot drives: to go home, and to meet the mate.
        self._in_time_s = self._not_due_s = -math.inf
        self._judged: tuple[object, ...] = ()
        self._is_worth_it = False
        # Since when nothing was heard of the base station where it should have been.
        self._unheard_s: list[float] = []

    # When -----------------------------------------------------------------------------------

    def calls(self, course: Course) -> bool:
        """Whether the robot is to end what it does: to go home now, or to meet its mate."""
        if self._team.carries and self.reason(course) is not None:
            return True
        return self.meets_now(course)

    def reason(self, course: Course) -> str | None:
        """Return why the robot is to go home now, in words; None if there is no reason.

        It does not ask whether the robot carries anything.
        """
        if not self.knows_way:
            return None
        if self._is_late(course):
            return f"the limit of {self.time.limit_s:g} s leaves time for the way home only"
        if self._goes_if_worth and not self.is_in_touch(course) and self._is_worth():
            share = self._options.home_ratio
            return f"the base station knows less than {share:.0%} of what it knows"
        return None

    @property
    def _goes_if_worth(self) -> bool:
        home = self._options.home
        return home == "worth" or (home == "relays" and not self.pair.is_paired)

    def is_in_touch(self, course: Course) -> bool:
        """Whether the base station was heard lately: it acknowledges news at once."""
        lately_s = TOUCH_PERIODS * self._options.report_period_s
        return course.time_s <= self._team.base_heard_s + lately_s

    @property
    def knows_way(self) -> bool:
        """Whether it knows of a place where the base station hears it."""
        if len(self._unheard_s) > 1 and self._team.base_heard_s <= self._unheard_s[-1]:
            return False
        self._contact.update(self._map.entries)
        return len(self._contact.places) > 0

    def fits(self, course: Course, goal: Goal) -> bool:
        """Whether there is time to go to a goal and home from there.

        True if no way home is known: it has to be found. The way to the goal counts at full speed,
        as a robot that is late on it turns back before.
        """
        if not self.knows_way:
            return True
        [home_m] = self.lengths(np.array([goal.place])).tolist()
        return math.isinf(home_m) or self._has_time(
            course.time_s + goal.cost_m / self.time.speed_m_s, home_m
        )

    def _has_time(self, now_s: float, home_m: float) -> bool:
        # And for two legs more, before the end of which the robot does not ask again.
        ahead_s = 2.0 * self._options.sense_period_s * self.time.losing
        return self.time.slack_s(now_s, home_m) >= ahead_s

    def _is_late(self, course: Course) -> bool:
        now_s = course.time_s
        if now_s < self._in_time_s:
            return False
        home_m = self.length_from(course.at[:2])
        if math.isinf(home_m):
            return False
        if not self._has_time(now_s, home_m):
            return True
        left_s = self.time.slack_s(now_s, home_m) / self.time.losing
        self._in_time_s = now_s + left_s - 2.0 * self._options.sense_period_s
        return False

    def _is_worth(self) -> bool:
        if not self._team.carries:
            self._is_worth_it = False
            return False
        judged = (self._map.entries.counts(), self._team.base_has)
        if not self._is_worth_it and judged != self._judged:
            ratio = self._worth.ratio(self._team.base_has)
            self._is_worth_it = ratio < self._options.home_ratio
            self._judged = judged
        return self._is_worth_it

    # Pairs ----------------------------------------------------------------------------------

    def meets_now(self, course: Course) -> bool:
        """Whether the robot is on an errand of its pair, or has to set out for one."""
        pair = self.pair
        if pair.role is Role.ALONE:
            return False
        if pair.role is Role.RELAY:
            return self.knows_target(course)
        if pair.stage is Stage.UNTIL_DUE and self._is_due(course):
            pair.set_out()
        return pair.stage is not Stage.UNTIL_DUE

    def _is_due(self, course: Course) -> bool:
        """Whether an explorer has to set out now to meet its relay in time."""
        now_s = course.time_s
        if now_s < self._not_due_s or (self.hears_mate(now_s) and not self._team.carries):
            return False
        way_s = self.time.way_s(self._length_between(course.at[:2], self.pair.target()))
        left_s = (self.pair.appointment.due_s - now_s - way_s) / self.time.losing
        self._not_due_s = now_s + left_s - 2.0 * self._options.sense_period_s
        return math.isfinite(way_s) and left_s < 2.0 * self._options.sense_period_s

    def hears_mate(self, now_s: float) -> bool:
        """Whether the mate was heard lately."""
        assert self.pair.mate is not None
        heard_s = self._team.mates.last_heard_s(self.pair.mate)
        return now_s <= heard_s + TOUCH_PERIODS * self._options.report_period_s

    def knows_target(self, course: Course) -> bool:
        """Whether the robot knows a way to where it meets its mate."""
        return math.isfinite(self._length_between(course.at[:2], self.pair.target()))

    def meeting(self, course: Course) -> Errand:
        """Return the errand to meet the mate, at the place of the present stage."""
        pair, wait_s = self.pair, self._options.home_wait_s
        number, stage = pair.appointment.number, pair.stage
        until_s, patience_s = pair.appointment.due_s + wait_s, wait_s
        if stage is Stage.BACKUP:
            # Long enough for a mate that has waited, and comes from the other place.
            between_m = self._length_between(pair.appointment.place, pair.appointment.backup)
            patience_s += wait_s + (self.time.way_s(between_m) if between_m < math.inf else 0.0)
        return Errand(
            kind="meet",
            why=f"robot {pair.mate}, at {'the backup of ' * (stage is Stage.BACKUP)}"
            f"appointment {number}",
            goal=self._goal_near(pair.target()),
            is_over=lambda: pair.appointment.number != number
            or not pair.is_paired
            or (self._team.carries and self.reason(course) is not None),
            until_s=until_s,
            patience_s=patience_s,
        )

    def propose(self, course: Course, goal: Goal | None) -> AppointmentMessage:
        """Return an explorer's proposal for the next appointment, by where it goes next."""
        round_s = 0.0
        place = None if goal is None else goal.place
        if place is not None:
            home_m = self.length_from(course.at[:2]), self.length_from(place)
            if all(map(math.isfinite, home_m)):
                round_s = sum(map(self.time.way_s, home_m)) + self.time.reserve_s
        have = self._map.entries.counts()
        self._not_due_s = -math.inf
        return self.pair.propose(place, course.time_s, round_s, have, self._team.number)

    def _goal_near(self, place: Place) -> Goal | None:
        """Return the passable cell nearest to a place as a goal, around bodies."""
        cell = self._map.raster.passable_near(*place, NEAR_BY_CELLS)
        if cell is None:
            return None
        x, y = self._map.raster.centre_of(*cell)
        with self._paths.around_bodies():
            field = self._paths.own_field()
            if field is None:
                return None
            if not math.isfinite(field.distance(indices_of(self._map.raster, np.array([(x, y)])))[0]):
                return None
            return self._paths.goal_at(field, x, y)

    def _length_between(self, here: Place, there: Place) -> float:
        """Return the length of the path between two places, without regard to bodies."""
        field = self._paths.field(*there)
        cell = self._map.raster.passable_near(*here, NEAR_BY_CELLS)
        if field is None or cell is None:
            return math.inf
        centre = np.array([self._map.raster.centre_of(*cell)])
        return float(field.distance(indices_of(self._map.raster, centre))[0])

    # Where ----------------------------------------------------------------------------------

    def errand(self, course: Course, why: str) -> Errand:
        """Return the errand to deliver what the robot carries."""
        return Errand(
            kind="home",
            why=why,
            goal=self._goal(course),
            is_over=lambda: not self._team.carries,
            patience_s=self._options.home_wait_s,
        )

    def note_unheard(self, now_s: float) -> None:
        """Record that nothing was heard of the base station where it should have been."""
        if self._team.base_heard_s > max(self._unheard_s, default=-math.inf):
            self._unheard_s.clear()
        self._unheard_s.append(now_s)

    def lengths(self, places: FloatArray) -> FloatArray:
        """Return the lengths of the ways home from places.

        Parameters
        ----------
        places : (m, 2) array
            Places in passable cells, in metres.

        Returns
        -------
        (m,) array
            Metres, at most by the diagonal of a cell too long; ``inf`` where none is known.
        """
        field = self._home_field()
        if field is None:
            return np.full(len(places), np.inf)
        return field.distance(indices_of(self._map.raster, places))

    def length_from(self, place: Place) -> float:
        """Return the length of the way home from where the robot stands, in metres."""
        if self._contact.hears(*place):
            return 0.0
        cell = self._map.raster.passable_near(*place, NEAR_BY_CELLS)
        if cell is None:
            return math.inf
        centre = self._map.raster.centre_of(*cell)
        return math.dist(place, centre) + float(self.lengths(np.array([centre]))[0])

    def _goal(self, course: Course) -> Goal | None:
        """Return where to go for the base station to hear the robot, around bodies."""
        raster, here = self._map.raster, course.at[:2]
        if self._contact.hears(*here) and not self._unheard_s:
            return Goal(*here, np.array([here]), 0.0)
        places = list(self._standing_places())
        nearest = self._end_of_way(here)
        if self._unheard_s:
            places = [min(places, key=lambda place: math.dist(place, self._contact.base))]
        paths = self._paths
        with paths.around_bodies():
            field = paths.own_field()
            if field is None:
                return None
            if nearest is not None and not self._unheard_s:
                [cost_m] = field.distance(indices_of(raster, np.array([nearest])))
                if math.isfinite(cost_m):
                    return self._cut(paths.goal_at(field, *nearest))
            costs = field.distance(indices_of(raster, np.array(places).reshape(-1, 2)))
            if not np.isfinite(costs).any():
                return None
            return self._cut(paths.goal_at(field, *places[int(np.argmin(costs))]))

    def _end_of_way(self, here: Place) -> Place | None:
        """Return the place to which the way home leads, without regard to bodies."""
        field = self._home_field()
        cell = self._map.raster.passable_near(*here, NEAR_BY_CELLS)
        if field is None or cell is None:
            return None
        index = indices_of(self._map.raster, np.array([self._map.raster.centre_of(*cell)]))
        if not math.isfinite(field.distance(index)[0]):
            return None
        x, y = shortest_path(field, index[0])[0].tolist()
        return x, y

    def _cut(self, goal: Goal) -> Goal:
        """Return a goal whose path ends where the base station hears the robot on the way."""
        if self._unheard_s:
            return goal
        path = goal.path
        for k in range(1, len(path)):
            (ax, ay), (bx, by) = path[k - 1].tolist(), path[k].tolist()
            leg_m = math.dist((ax, ay), (bx, by))
            steps = max(1, math.ceil(leg_m / self._map.raster.cell_m))
            for step in range(1, steps + 1):
                share = step / steps
                x, y = ax + share * (bx - ax), ay + share * (by - ay)
                if self._contact.hears(x, y):
                    cut = np.vstack([path[:k], [(x, y)]])
                    return Goal(x, y, cut, length_of(cut))
        return goal

    def _home_field(self) -> DistanceField | None:
        """Return the distances from the places where the base station hears the robot."""
        raster = self._map.raster
        if self._revision == raster.revision and self._field is not None:
            return self._field
        places = self._standing_places()
        if not places:
            return None
        kept, changed = self._field, raster.changed_since(self._revision)
        if kept is None or kept.passable is not raster.passable or places != self._sources:
            kept = DistanceField(
                raster.passable, raster.cell_m, list(places), x0=raster.x0, y0=raster.y0
            )
        elif changed is not None:
            kept.repair(raster.window_of(changed))
        self._field, self._revision, self._sources = kept, raster.revision, places
        return kept

    def _standing_places(self) -> dict[Place, None]:
        """Return the places at which a robot stands that goes to where it is heard."""
        raster = self._map.raster
        self._contact.update(self._map.entries)
        cells = [*self._standing.values()]
        if cells:
            rows, columns = raster.indices_of(cells)
            still = raster.passable[rows, columns].tolist()
            pairs = zip(self._standing.items(), still, strict=True)
            self._standing = {place: cell for (place, cell), stands in pairs if stands}
        for place in self._contact.places:
            if place not in self._standing:
                cell = raster.passable_near(*place, STANDING_CELLS)
                if cell is not None:
                    self._standing[place] = cell
        return {raster.centre_of(*cell): None for cell in self._standing.values()}
