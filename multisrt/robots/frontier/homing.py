"""When a robot that goes to frontiers brings its news home, or meets the mate of its pair.

What the parts of `multisrt.robots.homing` need of such a robot is here. What it does then is an
errand: a drive to where the base station hears it, or where it meets its mate. A robot that is not
heard where it should be goes to another such place before it gives up, until it hears the base
station again.
"""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.frontier.bodies import Bodies
from multisrt.robots.frontier.chain import Chain
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.errands import Errand
from multisrt.robots.frontier.frontiers import Frontiers
from multisrt.robots.frontier.goal import Goal, Place
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.path_finder import PathFinder
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.frontier.team import Team
from multisrt.robots.frontier.ways import Ways
from multisrt.robots.homing.just_in_time import JustInTime
from multisrt.robots.homing.pairs import AppointmentMessage, Pair, Role, Stage
from multisrt.robots.homing.worth import NewsWorth

ELSEWHERE_M = 1.0
"""A robot that found no way home tries again this far from there, in metres."""


class FrontierHoming:
    """When and where a robot goes to bring news home.

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
        Its messages, which tell what the base station knows.
    paths : PathFinder
        Its paths.
    bodies : Bodies
        Robots that stand in its way.
    frontiers : Frontiers
        Its targets.

    Attributes
    ----------
    time : JustInTime
        How long ways last, and when the time is over.
    chain : Chain or None
        Its part in a chain of relays, if there is one.
    pair : Pair
        What it does in its pair; alone unless the robots go in pairs.
    has_left_out : bool
        Whether a place was left out of a choice, as there is no time for it, or it is out of reach
        of the chain; to be reset before a choice.
    """

    def __init__(
        self,
        me: RobotSelf,
        options: FrontierOptions,
        course: Course,
        map: ScanMap,
        team: Team,
        paths: PathFinder,
        bodies: Bodies,
        frontiers: Frontiers,
    ) -> None:
        self.time = JustInTime.of(me, options)
        assert me.base is not None
        self.pair = Pair(
            me.robot, me.team, base=me.base, period_s=options.home_period_s, now_s=me.time_s
        )
        self._ways = Ways(me, map, paths)
        self.chain = (
            Chain(me, options, course, map, team, self._ways, self.time, frontiers)
            if options.home == "chain"
            else None
        )
        if options.home == "relays":
            team.pair = self.pair
        else:
            self.pair.part()
        self.has_left_out = False
        self._options = options
        self._map = map
        self._team = team
        self._bodies = bodies
        self._course = course
        self._worth = NewsWorth(map.entries, map.raster)
        # Until then there is time, wherever the robot drives: to go home, and to meet the mate.
        self._in_time_s = self._not_due_s = -math.inf
        self._judged: tuple[object, ...] = ()
        self._is_worth_it = False
        # The robots whose bodies barred all ways home, and where this one was.
        self._barring: tuple[frozenset[int], Place] | None = None
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
        if not self._may_be_heard or (self.chain is not None and self._team.is_in_touch):
            return None
        if self._is_late(course):
            return f"the limit of {self.time.limit_s:g} s leaves time for the way home only"
        if (
            self._goes_if_worth
            and not self._team.is_in_touch
            and self._is_worth()
            and math.isfinite(self._ways.length_from(course.at[:2]))
        ):
            share = self._options.home_ratio
            return f"the base station knows less than {share:.0%} of what it knows"
        return None

    @property
    def _goes_if_worth(self) -> bool:
        home = self._options.home
        return home == "worth" or (home == "relays" and not self.pair.is_paired)

    @property
    def _may_be_heard(self) -> bool:
        """Whether a place is known where the base station hears the robot, that is not in vain."""
        unheard, barring = self._unheard_s, self._barring
        if len(unheard) > 1 and self._team.base_heard_s <= unheard[-1]:
            return False
        if barring is not None and self._is_barred(*barring):
            return False
        return self._ways.lead_home

    def may_deliver(self, course: Course) -> bool:
        """Whether the robot carries something, and knows a way home."""
        return (
            self._team.carries
            and self._may_be_heard
            and math.isfinite(self._ways.length_from(course.at[:2]))
        )

    def fits(self, course: Course, goal: Goal) -> bool:
        """Whether the robot may choose a goal; see `only_fitting`."""
        fitting = self.only_fitting(course, np.array([goal.place]), np.array([goal.cost_m]))
        return bool(np.isfinite(fitting[0]))

    def in_time(self, course: Course, places: FloatArray, costs_m: FloatArray) -> BoolArray:
        """Return whether there is time to go to places, and home from each.

        Parameters
        ----------
        course : Course
            Where the robot is.
        places : (m, 2) array
            Places in passable cells, in metres.
        costs_m : (m,) array
            Lengths of the paths there, in metres. They count at full speed, as a robot that is late
            on one turns back before.

        Returns
        -------
        (m,) array of bool
            True where no way home is known, which has to be found, and where the base station hears
            the robot anyway.
        """
        if math.isinf(self.time.limit_s) or not self._may_be_heard:
            return np.ones(len(places), np.bool_)
        out_s = course.time_s + costs_m / self.time.speed_m_s
        ways = zip(out_s.tolist(), self._ways.lengths(places).tolist(), strict=True)
        return np.array(
            [m in (0.0, math.inf) or self._has_time(now_s, m) for now_s, m in ways], np.bool_
        )

    def only_fitting(self, course: Course, places: FloatArray, costs_m: FloatArray) -> FloatArray:
        """Return the lengths of the paths to places, ``inf`` for those that it may not choose.

        These are places that there is no time for; in a chain of relays, those from which the base
        station would not hear the robot. This is what leaves them out of the robot's choices,
        whatever its rule is. The parameters are those of `in_time`.
        """
        # Ways home are kept, and are not to lead around the bodies that are in the way now.
        with self._map.raster.unblocked():
            return self._only_fitting(course, places, costs_m)

    def _only_fitting(self, course: Course, places: FloatArray, costs_m: FloatArray) -> FloatArray:
        if self.chain is not None:
            fitting = self.chain.only_in_reach(places, costs_m)
            self.has_left_out |= bool((np.isfinite(costs_m) & ~np.isfinite(fitting)).any())
            return fitting
        late = np.isfinite(costs_m)
        late[late] = ~self.in_time(course, places[late], costs_m[late])
        self.has_left_out |= bool(late.any())
        return np.where(late, np.inf, costs_m)

    def _has_time(self, now_s: float, home_m: float) -> bool:
        # And for two legs more, before the end of which the robot does not ask again.
        ahead_s = 2.0 * self._options.sense_period_s * self.time.losing
        return self.time.slack_s(now_s, home_m) >= ahead_s

    def _is_late(self, course: Course) -> bool:
        now_s = course.time_s
        if now_s < self._in_time_s:
            return False
        home_m = self._ways.length_from(course.at[:2])
        if home_m in (0.0, math.inf):
            return False
        if not self._has_time(now_s, home_m):
            return True
        left_s = self.time.slack_s(now_s, home_m) / self.time.losing
        self._in_time_s = now_s + left_s - 2.0 * self._options.sense_period_s
        return False

    def _is_worth(self) -> bool:
        nodes = len(self._map.entries.nodes)
        judged = (nodes, self._team.base_has, self._team.base_beyond)
        if judged != self._judged:
            ratio = self._worth.ratio(self._team.base_has, self._team.base_beyond)
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
            pair.knows_home = pair.knows_home or (
                self._may_be_heard and math.isfinite(self._ways.length_from(course.at[:2]))
            )
            return pair.knows_home and self.knows_target(course)
        if pair.stage is Stage.UNTIL_DUE and self._is_due(course):
            pair.set_out()
        return pair.stage is not Stage.UNTIL_DUE

    def _is_due(self, course: Course) -> bool:
        """Whether an explorer has to set out now to meet its relay in time."""
        now_s = course.time_s
        is_linked = self._team.is_in_touch or not self._team.carries
        if now_s < self._not_due_s or (is_linked and self.hears_mate()):
            return False
        way_s = self.time.way_s(self._ways.length_between(course.at[:2], self.pair.target()))
        left_s = (self.pair.appointment.due_s - now_s - way_s) / self.time.losing
        self._not_due_s = now_s + left_s - 2.0 * self._options.sense_period_s
        return math.isfinite(way_s) and left_s < 2.0 * self._options.sense_period_s

    def _mate_heard_s(self) -> float:
        """Return when a relay last heard its mate: as long as it does there is no hurry."""
        if self.pair.role is not Role.RELAY or self.pair.mate is None:
            return -math.inf
        return self._team.mates.last_heard_s(self.pair.mate)

    def hears_mate(self) -> bool:
        """Whether the mate was heard lately."""
        assert self.pair.mate is not None
        return self._team.hears(self.pair.mate)

    def may_dismiss_mate(self) -> bool:
        """Whether the robot is an explorer whose relay hears it."""
        return self.pair.role is Role.EXPLORER and self.hears_mate()

    def knows_target(self, course: Course) -> bool:
        """Whether the robot knows a way to where it meets its mate."""
        return math.isfinite(self._ways.length_between(course.at[:2], self.pair.target()))

    def meeting(self, course: Course) -> Errand:
        """Return the errand to meet the mate, at the place of the present stage."""
        pair, wait_s = self.pair, self._options.home_wait_s
        number, stage = pair.appointment.number, pair.stage
        until_s, patience_s = pair.appointment.due_s + wait_s, wait_s
        if stage is Stage.BACKUP:
            # Long enough for a mate that has waited, and comes from the other place.
            between_m = self._ways.length_between(pair.appointment.place, pair.appointment.backup)
            patience_s += wait_s + (self.time.way_s(between_m) if between_m < math.inf else 0.0)
        return Errand(
            kind="meet",
            why=f"robot {pair.mate}, at {'the backup of ' * (stage is Stage.BACKUP)}"
            f"appointment {number}",
            goal=self._ways.goal_near(pair.target()),
            is_over=lambda: (
                pair.appointment.number != number
                or not pair.is_paired
                or (self._team.carries and self.reason(course) is not None)
            ),
            until_s=until_s,
            patience_s=patience_s,
            heard_s=self._mate_heard_s,
        )

    def propose(self, course: Course, place: Place | None) -> AppointmentMessage:
        """Return an explorer's proposal for the next appointment, by where it goes next."""
        round_s = 0.0
        if place is not None:
            home_m = self._ways.length_from(course.at[:2]), self._ways.length_from(place)
            if all(map(math.isfinite, home_m)):
                round_s = sum(map(self.time.way_s, home_m)) + self.time.reserve_s
        have = self._map.entries.counts()
        self._not_due_s = -math.inf
        return self.pair.propose(place, course.time_s, round_s, have, self._team.number)

    # Where ----------------------------------------------------------------------------------

    def errand(self, course: Course, why: str) -> Errand:
        """Return the errand to deliver what the robot carries."""
        return Errand(
            kind="home",
            why=why,
            goal=self._ways.goal_home(course, once_more=len(self._unheard_s) > 0),
            is_over=lambda: not self._team.carries,
            patience_s=self._options.home_wait_s,
        )

    def note_barred(self, at: Place) -> None:
        """Record that no way home is free from here.

        If bodies are in the way, there is none until one of them goes; else until the robot is
        elsewhere.
        """
        self._barring = frozenset(self._bodies.numbers()), at

    def _is_barred(self, bodies: frozenset[int], at: Place) -> bool:
        if bodies:
            return bodies <= {*self._bodies.numbers()}
        return math.dist(self._course.at[:2], at) < ELSEWHERE_M

    def note_unheard(self, now_s: float) -> None:
        """Record that nothing was heard of the base station where it should have been."""
        if self._team.base_heard_s > max(self._unheard_s, default=-math.inf):
            self._unheard_s.clear()
        self._unheard_s.append(now_s)
