"""How a robot of the SRT family delivers its data: over its roadmap, from node to node.

The path home leads over the trees: a robot goes to the nearest node from which the base station is
certain to hear it. Steps are not interrupted, so at every node the robot checks whether it has to
go home, and before it takes a target whether there is time for that and for the path home from
there. Targets for which there is no time are left out of its choices. Every hop may begin with a
turn, which counts as half a turn.
"""

from __future__ import annotations

import math
from typing import NoReturn

from multisrt.events import Decided
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.explorer import Note, RobotSelf, Steps
from multisrt.robots.homing.contact import ContactPlaces
from multisrt.robots.homing.delivered_share import DeliveredShare
from multisrt.robots.homing.just_in_time import JustInTime
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.routes import Routes
from multisrt.robots.multi_srt.targets import NewPlace, Target
from multisrt.robots.multi_srt.team import Team
from multisrt.robots.multi_srt.whereabouts import Whereabouts

CELL_M = 0.1
"""Width in metres of the cells in which areas are counted, unless the body is smaller."""

LATE_S = 1e-3
"""A robot that waits until it has to go home sets out this much later, in seconds."""


class CalledHome(Exception):
    """The robot has to interrupt what it does, and go home."""


class OutOfTime(Exception):
    """The robot has nothing to deliver, and no time for another target and the path home."""


class SrtHoming:
    """When a robot has to go home, and to which node.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself; it has a base station.
    options : MultiSrtOptions
        Its parameters.
    at : Whereabouts
        Where it is.
    known : ExplorationMap
        Its map.
    routes : Routes
        Its routes.
    team : Team
        Its messages, from which it knows what the base station has.

    Attributes
    ----------
    is_enabled : bool
        Whether the robot may be called home; not while it goes home, or has ended.
    goes_home : bool
        Whether it goes home.
    has_left_out : bool
        Whether a target was left out of a choice, as there is no time for it; to be reset before a
        choice.
    """

    def __init__(
        self,
        me: RobotSelf,
        options: MultiSrtOptions,
        at: Whereabouts,
        known: ExplorationMap,
        routes: Routes,
        team: Team,
    ) -> None:
        self.is_enabled = True
        self.goes_home = False
        self.has_left_out = False
        self._time = JustInTime.of(me, options)
        self._contact = ContactPlaces(me)
        self._options = options
        self._at = at
        self._map = known
        self._routes = routes
        self._team = team
        cell_m = min(CELL_M, me.footprint.width_m)
        self._raster = Occupancy(cell_m, me.footprint.circumscribed_radius_m)
        self._painted = 0
        self._delivered = DeliveredShare(known.entries, self._raster)
        self._unheard_s: float | None = None
        # How often in succession bodies barred the way home, and when it is tried again.
        self._times_barred, self._again_s = 0, -math.inf

    @property
    def has_delivered(self) -> bool:
        """Whether the robot goes home and there is nothing left to deliver."""
        return self.goes_home and not self._team.carries

    @property
    def carries_area(self) -> bool:
        """Whether what the robot carries shows area that the base station does not know."""
        return self._team.carries and self._delivered_share() < 1.0

    def due_s(self) -> float:
        """Return the time in seconds at which the robot has to go home if it stays until then.

        Returns
        -------
        float
            ``inf`` if it may stay for good.
        """
        if not self.is_enabled or self._at.here is None or not self.may_deliver:
            return math.inf
        route = self.route_from(self._at.here)
        now_s = self._at.time_s
        return math.inf if route is None else now_s + self._slack_s(now_s, route) + LATE_S

    def raise_if_due(self) -> None:
        """Raise `CalledHome` if the robot has to go home now.

        Raises
        ------
        CalledHome
            If only the time for the path home is left, or the trip is worthwhile; with the reason
            in words.
        """
        if not self.is_enabled or not self.may_deliver:
            return
        route = self.route_from(self._at.node)
        if route is None:
            return
        if self._slack_s(self._at.time_s, route) < 0.0:
            limit_s = self._time.limit_s
            raise CalledHome(f"the limit of {limit_s:g} s leaves time for the way home only")
        ratio = self._options.home_ratio
        if self._options.home == "worth" and len(route) > 1 and self._delivered_share() < ratio:
            raise CalledHome(f"the base station knows less than {ratio:.0%} of what it knows")

    def raise_unless_fits(self, target: Target) -> None:
        """Raise as `raise_out_of_time` unless there is time for a target and the path home."""
        if not self.fits(target):
            self.raise_out_of_time()

    def raise_out_of_time(self) -> NoReturn:
        """Raise the exception of a robot that has no time for another target.

        Raises
        ------
        CalledHome
            If the robot carries something.
        OutOfTime
            If it carries nothing.
        """
        if self._team.carries:
            raise CalledHome("there is no time for another target and the way home")
        raise OutOfTime

    def leaves_out(self, target: Target) -> bool:
        """Return whether a target is left out of a choice as there is no time for it; record it."""
        is_late = not self.fits(target)
        self.has_left_out |= is_late
        return is_late

    def fits(self, target: Target) -> bool:
        """Return whether there is time for a target and the path home from there.

        True if no path home is known, and for a robot that goes home or has ended.
        """
        if not self.is_enabled or math.isinf(self._time.limit_s) or not self._may_be_heard:
            return True
        route = self.route_from(target.route[-1])
        if route is None:
            return True
        there, beyond_m = list(target.route), 0.0
        if isinstance(target, NewPlace):
            x, y, _ = self._map[there[-1]].configuration
            beyond_m = math.dist((x, y), (target.x, target.y))
        out_m = self._routes.length_m(there) + beyond_m
        out_s = out_m / self._time.speed_m_s + len(there) * self._time.half_turn_s
        return self._slack_s(self._at.time_s + out_s, route, beyond_m) >= 0.0

    @property
    def may_deliver(self) -> bool:
        """Whether the robot carries something, and may be heard somewhere."""
        return self._team.carries and self._may_be_heard

    @property
    def _may_be_heard(self) -> bool:
        unheard_s = self._unheard_s
        if unheard_s is not None and self._team.base_heard_s <= unheard_s:
            return False
        if self._at.time_s < self._again_s:
            return False
        self._contact.update(self._map.entries)
        return len(self._contact.nodes) > 0

    def is_home(self) -> bool:
        """Return whether the robot is at a node where the base station hears it."""
        return self._at.here in self._contact.nodes

    def route_from(self, node: NodeId) -> list[NodeId] | None:
        """Return the route from a node to the nearest one where the base station hears the robot.

        Returns
        -------
        list of NodeId or None
            None if there is none, or bodies bar it.
        """
        self._contact.update(self._map.entries)
        return self._routes.to_nearest(node, self._contact.nodes.__contains__)

    def _slack_s(self, now_s: float, route: list[NodeId], before_m: float = 0.0) -> float:
        turns_s = max(0, len(route) - 1) * self._time.half_turn_s
        length_m = before_m + self._routes.length_m(route)
        return self._time.slack_s(now_s + turns_s, length_m)

    def _delivered_share(self) -> float:
        nodes = self._map.entries.nodes
        for node in list(nodes.values())[self._painted :]:
            self._raster.add(node.region)
        self._painted = len(nodes)
        return self._delivered.share(self._team.base_has, self._team.base_beyond)

    def deliver(self) -> Steps:
        """Report until the base station has acknowledged all, for at most `home_wait_s`."""
        team, at = self._team, self._at
        until_s = at.time_s + self._options.home_wait_s
        while team.carries and at.time_s < until_s:
            yield from team.rest()
            yield from team.ask_base()
            yield from team.pause(team.period_s)
        self._unheard_s = at.time_s if team.carries else None
        self._times_barred = 0

    def note_barred(self) -> None:
        """Record that bodies bar the way home: it is tried again after a while.

        After `home_wait_s`; if it is barred again, after twice as long, and so on.
        """
        self._again_s = self._at.time_s + self._options.home_wait_s * 2.0**self._times_barred
        self._times_barred += 1

    def decision_note(self, why: str) -> Note:
        """Return the action that records why the robot goes home."""
        route = self.route_from(self._at.node)
        place = None if route is None else self._map[route[-1]].configuration[:2]
        text, number = f"goes home: {why}", self._team.number
        return Note(Decided(time_s=self._at.time_s, robot=number, text=text, goal=place))
