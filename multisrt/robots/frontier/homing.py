"""When a robot that goes to frontiers delivers its data, or meets the partner of its pair.

The parts of `multisrt.robots.homing` are joined here for such a robot. What it then does is an
errand: a drive to where the base station hears it, or to where it meets its partner. A robot that
is not heard where it should be goes to another such place before it gives up, until it hears the
base station again.
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
from multisrt.robots.frontier.home_paths import HomePaths
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.path_finder import PathFinder
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.frontier.team import Team
from multisrt.robots.homing.delivered_share import DeliveredShare
from multisrt.robots.homing.just_in_time import JustInTime
from multisrt.robots.homing.pairs import Pair, RendezvousMessage, Role, Stage

ELSEWHERE_M = 1.0
"""Distance in metres from where it found no path home at which a robot tries again."""


class FrontierHoming:
    """When and where a robot goes to deliver data.

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
        Its messages, from which it knows what the base station has.
    paths : PathFinder
        Its paths.
    bodies : Bodies
        Robots that block its paths.
    frontiers : Frontiers
        Its targets.

    Attributes
    ----------
    time : JustInTime
        Its travel times and deadline.
    chain : Chain or None
        Its part in a chain of relays, if there is one.
    pair : Pair
        Its part in a pair; alone unless the robots go in pairs.
    has_left_out : bool
        Whether a place was left out of a choice because there is no time for it, or because the
        chain does not reach it; to be reset before a choice.
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
        self._home_paths = HomePaths(me, map, paths, lambda: self._is_unheard)
        self.chain = (
            Chain(me, options, course, map, team, self._home_paths, self.time, frontiers)
            if options.home == "chain"
            else None
        )
        if options.home == "relays":
            team.pair = self.pair
            self.pair.knows_home = self._knows_path_home
        else:
            self.pair.part()
        self.has_left_out = False
        self._options = options
        self._map = map
        self._team = team
        self._bodies = bodies
        self._course = course
        self._delivered = DeliveredShare(map.entries, map.raster)
        # Until then there is time, wherever the robot drives: to go home, and to meet the partner.
        self._in_time_s = self._not_due_s = -math.inf
        self._judged: tuple[object, ...] = ()
        self._is_worthwhile = False
        # The robots whose bodies barred all paths home, and where this one was.
        self._barring: tuple[frozenset[int], Place] | None = None
        # When, and how often in succession, the robot was not heard where it should have been.
        self._unheard_s = -math.inf
        self._unheard = 0

    # When -----------------------------------------------------------------------------------

    def must_interrupt(self) -> bool:
        """Return whether the robot must end what it does, to go home or to meet its partner."""
        if self._team.carries and self.reason() is not None:
            return True
        return self.update_meeting()

    def reason(self) -> str | None:
        """Return why the robot is to go home now, in words; None if there is no reason.

        Whether the robot carries anything is not checked.
        """
        if not self._may_be_heard or (self.chain is not None and self._team.is_in_touch):
            return None
        if self._is_late():
            return f"the limit of {self.time.limit_s:g} s leaves time for the way home only"
        if (
            self._goes_if_worth
            and not self._team.is_in_touch
            and self._is_trip_worthwhile()
            and math.isfinite(self._home_paths.length_from(self._course.at[:2]))
        ):
            share = self._options.home_ratio
            return f"the base station knows less than {share:.0%} of what it knows"
        return None

    @property
    def _goes_if_worth(self) -> bool:
        if self._options.home != "relays" or self.pair.is_paired:
            return self._options.home == "worth"
        # Those that parted as no time was left for another rendezvous come home in time.
        return self.pair.lacks_partner or self._has_time_to_meet(self._course.at[:2])

    @property
    def _is_unheard(self) -> bool:
        """Whether the base station did not hear the robot where it should have, nor since."""
        return self._unheard > 0 and self._team.base_heard_s <= self._unheard_s

    @property
    def _may_be_heard(self) -> bool:
        """Whether the robot knows a place where it may be heard, and has not failed to be so."""
        if self._is_unheard and self._unheard > 1:
            return False
        barring = self._barring
        if barring is not None and self._is_barred(*barring):
            return False
        return self._home_paths.knows_contact

    def may_deliver(self) -> bool:
        """Return whether the robot carries something, and knows a path home."""
        return self._team.carries and self._knows_path_home()

    def _knows_path_home(self) -> bool:
        if not self._may_be_heard:
            return False
        return math.isfinite(self._home_paths.length_from(self._course.at[:2]))

    def fits(self, goal: Goal) -> bool:
        """Return whether the robot may choose a goal; see `only_fitting`."""
        fitting = self.only_fitting(np.array([goal.place]), np.array([goal.cost_m]))
        return bool(np.isfinite(fitting[0]))

    def in_time(self, places: FloatArray, costs_m: FloatArray) -> BoolArray:
        """Return whether there is time to go to places, and home from each.

        Parameters
        ----------
        places : (m, 2) array
            Places in passable cells, in metres.
        costs_m : (m,) array
            Lengths of the paths there in metres. They count at full speed, as a robot that is late
            turns back on the path.

        Returns
        -------
        (m,) array of bool
            True where no path home is known, which has to be found, and where the base station
            hears the robot.
        """
        if math.isinf(self.time.limit_s) or not self._may_be_heard:
            return np.ones(len(places), np.bool_)
        out_s = self._course.time_s + costs_m / self.time.speed_m_s
        lengths = self._home_paths.lengths(places)
        trips = zip(out_s.tolist(), lengths.tolist(), strict=True)
        return np.array(
            [m in (0.0, math.inf) or self._has_time(now_s, m) for now_s, m in trips], np.bool_
        )

    def only_fitting(self, places: FloatArray, costs_m: FloatArray) -> FloatArray:
        """Return the lengths of the paths to places, ``inf`` for those that it may not choose.

        It may not choose places that there is no time for; in a chain of relays, those from which
        the base station would not hear the robot. So all rules leave them out of their choices. The
        parameters are those of `in_time`.
        """
        # Paths home are kept; they must not lead around the bodies that block paths now.
        with self._map.raster.unblocked():
            return self._only_fitting(places, costs_m)

    def _only_fitting(self, places: FloatArray, costs_m: FloatArray) -> FloatArray:
        if self.chain is not None:
            fitting = self.chain.only_in_reach(places, costs_m)
            self.has_left_out |= bool((np.isfinite(costs_m) & ~np.isfinite(fitting)).any())
            return fitting
        late = np.isfinite(costs_m)
        late[late] = ~self.in_time(places[late], costs_m[late])
        self.has_left_out |= bool(late.any())
        return np.where(late, np.inf, costs_m)

    def _has_time(self, now_s: float, home_m: float) -> bool:
        # And for two more legs, before the end of which the robot does not check again.
        ahead_s = 2.0 * self._options.sense_period_s * self.time.max_slack_loss_rate
        return self.time.slack_s(now_s, home_m) >= ahead_s

    def _is_late(self) -> bool:
        now_s = self._course.time_s
        if now_s < self._in_time_s:
            return False
        home_m = self._home_paths.length_from(self._course.at[:2])
        if home_m in (0.0, math.inf):
            return False
        if not self._has_time(now_s, home_m):
            return True
        left_s = self.time.slack_s(now_s, home_m) / self.time.max_slack_loss_rate
        self._in_time_s = now_s + left_s - 2.0 * self._options.sense_period_s
        return False

    def _is_trip_worthwhile(self) -> bool:
        nodes = len(self._map.entries.nodes)
        judged = (nodes, self._team.base_has, self._team.base_beyond)
        if judged != self._judged:
            share = self._delivered.share(self._team.base_has, self._team.base_beyond)
            self._is_worthwhile = share < self._options.home_ratio
            self._judged = judged
        return self._is_worthwhile

    # Pairs ----------------------------------------------------------------------------------

    def update_meeting(self) -> bool:
        """Set out for the rendezvous if it is time; return whether the robot is on its way there.

        A relay is whenever it knows a path there.
        """
        pair = self.pair
        if pair.role is Role.ALONE:
            return False
        if pair.role is Role.RELAY:
            return self._knows_path_home() and self.knows_target()
        if pair.stage is Stage.UNTIL_DUE and self._is_due():
            pair.set_out()
        return pair.stage is not Stage.UNTIL_DUE

    def _is_due(self) -> bool:
        """Return whether an explorer has to set out now to meet its relay in time."""
        now_s = self._course.time_s
        if now_s < self._not_due_s or (self._team.has_nothing_overdue and self.hears_partner()):
            return False
        length_m = self._home_paths.length_between(self._course.at[:2], self.pair.target())
        travel_s = self.time.travel_time_s(length_m)
        left_s = (self.pair.rendezvous.due_s - now_s - travel_s) / self.time.max_slack_loss_rate
        self._not_due_s = now_s + left_s - 2.0 * self._options.sense_period_s
        return math.isfinite(travel_s) and left_s < 2.0 * self._options.sense_period_s

    def _partner_heard_s(self) -> float:
        """Return when a relay last heard its partner; ``-inf`` for other robots."""
        if self.pair.role is not Role.RELAY or self.pair.partner is None:
            return -math.inf
        return self._team.teammates.last_heard_s(self.pair.partner)

    def hears_partner(self) -> bool:
        """Return whether the partner was heard lately."""
        assert self.pair.partner is not None
        return self._team.hears(self.pair.partner)

    def may_dismiss_partner(self) -> bool:
        """Return whether the robot is an explorer that is in touch with its relay."""
        return self.pair.role is Role.EXPLORER and self.hears_partner()

    def knows_target(self) -> bool:
        """Return whether the robot knows a path to where it meets its partner."""
        here, there = self._course.at[:2], self.pair.target()
        return math.isfinite(self._home_paths.length_between(here, there))

    def meeting(self) -> Errand:
        """Return the errand to meet the partner, at the place of the present stage."""
        pair, wait_s = self.pair, self._options.home_wait_s
        rendezvous, stage = pair.rendezvous, pair.stage
        until_s, patience_s = rendezvous.due_s + wait_s, wait_s
        if stage is Stage.BACKUP:
            # Long enough for a partner that has waited, and comes from the other place.
            length_m = self._home_paths.length_between(rendezvous.place, rendezvous.backup)
            travel_s = self.time.travel_time_s(length_m) if math.isfinite(length_m) else 0.0
            patience_s += wait_s + travel_s
        return Errand(
            kind="meet",
            why=f"robot {pair.partner}, at {'the backup of ' * (stage is Stage.BACKUP)}"
            f"rendezvous {rendezvous.number}",
            goal=self._home_paths.goal_near(pair.target()),
            is_over=lambda: (
                pair.rendezvous.number != rendezvous.number
                or not pair.is_paired
                or (self._team.carries and self.reason() is not None)
            ),
            until_s=until_s,
            patience_s=patience_s,
            heard_s=self._partner_heard_s,
        )

    def propose(self, place: Place | None) -> RendezvousMessage:
        """Return an explorer's proposal for the next rendezvous, by where it goes next.

        It proposes none if there would be no time to deliver after that.
        """
        if place is not None and not self._has_time_to_meet(place):
            place = None
        trips_s = None if place is None else self._round_and_back_s(place)
        round_s = 0.0 if trips_s is None else trips_s[0]
        have = self._map.entries.counts()
        self._not_due_s = -math.inf
        return self.pair.propose(place, self._course.time_s, round_s, have, self._team.number)

    def _round_and_back_s(self, place: Place) -> tuple[float, float] | None:
        """Return how long a relay takes from here home and to a place, and back home from there.

        None if no path home is known.
        """
        paths, speed_m_s = self._home_paths, self._speed_of_slower()
        lengths_m = paths.length_from(self._course.at[:2]), paths.length_from(place)
        if not all(map(math.isfinite, lengths_m)):
            return None
        home_s, back_s = (self.time.travel_time_s(length, speed_m_s) for length in lengths_m)
        return home_s + back_s + self.time.reserve_s, back_s

    def _has_time_to_meet(self, place: Place) -> bool:
        """Return whether data can be delivered in time after another rendezvous at a place.

        True if no path home is known.
        """
        trips_s = self._round_and_back_s(place)
        if trips_s is None:
            return True
        round_s, back_s = trips_s
        due_s = self.pair.next_due_s(self._course.time_s, round_s)
        return due_s + back_s + self.time.reserve_s <= self.time.limit_s

    def _speed_of_slower(self) -> float:
        """Return the speed of the slower robot of the pair, in metres per second."""
        reports, partner = self._team.teammates.reports, self.pair.partner
        own_m_s = self.time.speed_m_s
        if partner is None or partner not in reports:
            return own_m_s
        return min(own_m_s, reports[partner].speed_m_s or own_m_s)

    # Where ----------------------------------------------------------------------------------

    def errand(self, why: str) -> Errand:
        """Return the errand to deliver what the robot carries."""
        return Errand(
            kind="home",
            why=why,
            goal=self._home_paths.goal_home(self._course.at[:2]),
            is_over=lambda: not self._team.carries,
            patience_s=self._options.home_wait_s,
        )

    def note_barred(self, at: Place) -> None:
        """Record that no path home is free from here.

        If bodies bar all paths, none is free until one of the bodies leaves; otherwise until the
        robot is elsewhere.
        """
        self._barring = frozenset(self._bodies.numbers()), at

    def _is_barred(self, bodies: frozenset[int], at: Place) -> bool:
        if bodies:
            return bodies <= {*self._bodies.numbers()}
        return math.dist(self._course.at[:2], at) < ELSEWHERE_M

    def note_unheard(self, now_s: float) -> None:
        """Record that nothing was heard of the base station where it should have been."""
        self._unheard = self._unheard + 1 if self._is_unheard else 1
        self._unheard_s = now_s
        # The path home may be longer now.
        self._in_time_s = -math.inf
