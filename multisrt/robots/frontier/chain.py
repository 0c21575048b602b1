"""Chains of robots that keep the base station in touch while one of them explores.

The *front* is the robot of the lowest number that is not presumed lost. Once it has nothing to do,
the next robot takes over; after the last one, it is the first one's turn again. The front goes only
to frontiers from which a chain of relays, at most as many as there are other robots, reaches the
base station, and waits until the relays are in place (`multisrt.planners.relay_chain`). Its reports
tell which robot stands where. The other robots explore where the base station, or a called relay at
its place, is certain to hear them. A robot that is called goes to its place and stays until the
front calls it elsewhere or lets it go, which it does as soon as its chain is shorter, or it has
nothing to do. No robot waits forever: a relay that is late and was not heard for a while is
presumed lost, and one that is heard but late three times is not called any more; a front that was
not heard for a while is presumed lost, and the next robot is the front.

Source: see `multisrt.planners.relay_chain`. Differs in: which places are certain to be linked is
computed from the robot's own map, not from measured signals: by the range of the radio less a
margin, and where walls matter by a line of sight over cells known to be free. Between two goals the
front may be out of touch for a moment, as only its goals are checked.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import pairwise, takewhile

import numpy as np

from multisrt.geometry.grids.occupancy.layers import FREE
from multisrt.geometry.grids.sight import in_sight
from multisrt.geometry.numerics.arrays import BoolArray, FloatArray
from multisrt.geometry.numerics.distances import length_of
from multisrt.planners.relay_chain import relay_places
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.errands import Errand
from multisrt.robots.frontier.frontiers import Frontiers
from multisrt.robots.frontier.goal import Goal, Place
from multisrt.robots.frontier.home_paths import HomePaths
from multisrt.robots.frontier.messages import ChainLink
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.scan_map import ScanMap
from multisrt.robots.frontier.team import Team, link_of
from multisrt.robots.homing.just_in_time import JustInTime

IN_PLACE_M = 1.0
"""Maximum distance in metres between a relay that is in place and its place."""

CLEAR_M = 1.5
"""Minimum distance in metres of new relays from the front, where possible."""

ROOM_M = 0.8
ROOM_SHARE = 0.55
"""Radius of the disc around a relay, in metres, and the minimum passable share of it for others to
get past."""

MAX_LATE = 3
"""Number of times a robot was late after which it is not called any more."""

MAX_UNHEARD = 10
"""Multiple of `home_wait_s` after which a relay on its path presumes an unheard front lost."""

STEP_M = 0.25
"""Maximum distance between places along a path, in metres."""


class Chain:
    """One robot's part in the chain.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself; it has a base station.
    options : FrontierOptions
        Its parameters.
    course : Course
        Where it is.
    map : ScanMap
        What it knows.
    team : Team
        Its messages.
    home_paths : HomePaths
        Its paths home.
    time : JustInTime
        Its travel times.
    frontiers : Frontiers
        Its targets.
    """

    def __init__(
        self,
        me: RobotSelf,
        options: FrontierOptions,
        course: Course,
        map: ScanMap,
        team: Team,
        home_paths: HomePaths,
        time: JustInTime,
        frontiers: Frontiers,
    ) -> None:
        assert me.base is not None
        self._me = me
        self._base: Place = me.base
        self._link_m = options.home_link * me.radio.range_m
        self._options = options
        self._course = course
        self._map = map
        self._team = team
        self._home_paths = home_paths
        self._time = time
        self._frontiers = frontiers
        # Which front it follows, and since when.
        self._follows: int | None = None
        self._follows_since_s = -math.inf
        # The goal for which relays were called.
        self._called_for: Place | None = None
        # How often each robot was called and did not come in time.
        self._late: Counter[int] = Counter()

    # Roles ----------------------------------------------------------------------------------

    @property
    def others(self) -> list[int]:
        """The robots that were heard and are not presumed lost, by number."""
        teammates = self._team.teammates
        return [number for number in sorted(teammates.reports) if not teammates.is_lost(number)]

    @property
    def _relays(self) -> list[int]:
        """The robots that may be called, by number: all that were not late too often."""
        return [number for number in self.others if self._late[number] < MAX_LATE]

    @property
    def _may_lead(self) -> list[int]:
        """The robots that did not find themselves with nothing to do as the front."""
        reports = self._team.teammates.reports
        own = [] if self._team.passes_front else [self._me.robot]
        return own + [number for number in self.others if not reports[number].passes_front]

    @property
    def front(self) -> int:
        """Number of the robot that explores at the front."""
        return min(self._may_lead or [self._me.robot, *self.others])

    @property
    def is_front(self) -> bool:
        """Whether this robot is the front."""
        return self.front == self._me.robot

    def _told(self) -> tuple[ChainLink, ...] | None:
        """Return the links that the front told last."""
        return None if self.is_front else self._team.teammates.reports[self.front].links

    @property
    def is_led(self) -> bool:
        """Whether another robot is the front, and may have something to do."""
        return not self.is_front and len(self._may_lead) > 0

    @property
    def own_link(self) -> Place | None:
        """Where this robot is to stand as a relay; None if it is not called."""
        if self.is_front:
            return None
        return link_of(self._team.teammates.reports[self.front], self._me.robot)

    # Choosing -------------------------------------------------------------------------------

    def only_in_reach(self, places: FloatArray, costs_m: FloatArray) -> FloatArray:
        """Return the lengths of paths to places, ``inf`` where the base station would not hear.

        Parameters
        ----------
        places : (m, 2) array
            Places in passable cells, in metres.
        costs_m : (m,) array
            Lengths of the paths there in metres.

        Returns
        -------
        (m,) array
            As they are, if no path home is known: it has to be found.
        """
        if not self._home_paths.knows_contact:
            return costs_m
        reached = np.isfinite(costs_m)
        for k in np.flatnonzero(reached).tolist():
            x, y = places[k].tolist()
            reached[k] = self._reaches((x, y))
        return np.where(reached, costs_m, np.inf)

    def _reaches(self, place: Place) -> bool:
        links = self._standing() if self.is_front else self._told() or ()
        anchors = [self._base, *(link.place for link in links)]
        if any(self.linked(np.array([place]), anchor)[0] for anchor in anchors):
            return True
        if not self.is_front:
            return False
        if math.dist(place, self._base) > self._link_m * (len(self._relays) + 1):
            return False
        return self._places_for(place) is not None

    def _standing(self) -> tuple[ChainLink, ...]:
        """Return the links of the front, up to the first whose robot may not be called."""
        relays = self._relays
        return tuple(takewhile(lambda link: link.robot in relays, self._team.links or ()))

    def _places_for(self, place: Place) -> tuple[Place, ...] | None:
        """Return where relays stand for a goal; None if there are too few.

        If the relays would be too few along the path from home, those that are called stay, up to
        one that hears the goal. No relay is needed if no path is known: it has to be found.
        """
        if self.linked(np.array([place]), self._base)[0]:
            return ()
        kept = [link.place for link in self._standing()]
        path = self._home_paths.path_from_home(place)
        places = None
        if path is not None:
            places = relay_places(
                _points_along(path, STEP_M),
                self._base,
                self.linked,
                max_relays=len(self._relays),
                kept=kept,
                clear_of=self._course.at[:2],
                clear_m=CLEAR_M,
                roomy=self._have_room,
            )
        if places is not None:
            return places
        for count, anchor in enumerate(kept, 1):
            if self.linked(np.array([place]), anchor)[0]:
                return tuple(kept[:count])
        return () if path is None else None

    def _have_room(self, places: FloatArray) -> BoolArray:
        """Return at which places, ``(n, 2)``, a relay leaves room for others to pass."""
        raster, whole = self._map.raster, math.pi * (ROOM_M / self._map.raster.cell_m) ** 2
        around = [raster.passable_centres(x, y, ROOM_M) - (x, y) for x, y in places.tolist()]
        cells = [np.count_nonzero(np.hypot(*near.T) <= ROOM_M) for near in around]
        return np.array(cells) > ROOM_SHARE * whole

    def linked(self, places: FloatArray, at: Place) -> BoolArray:
        """Return which places are certain to be linked with a place, ``(n,)``.

        They are within the range of the radio less a margin and, where walls matter, in sight of
        the place over cells that are known to be free.
        """
        near: BoolArray = np.hypot(*(places - np.array(at)).T) <= self._link_m
        if not self._me.radio.walls_matter or not near.any():
            return near
        raster = self._map.raster
        if not raster.is_known(*at):
            return np.zeros(len(places), np.bool_)
        known = np.array([raster.is_known(x, y) for x, y in places.tolist()], np.bool_)
        near &= known
        if not near.any():
            return near
        [seen_from], indices = raster.indices_at(np.array([at])), raster.indices_at(places[near])
        # Sight depends on the cells between the two only.
        low = np.minimum(seen_from, indices.min(axis=0))
        high = np.maximum(seen_from, indices.max(axis=0)) + 1
        free = raster.cells[low[0] : high[0], low[1] : high[1]] == FREE
        row, column = (seen_from - low).tolist()
        # The cell of a base station beside a wall is occupied, and it is in free space.
        free[row, column] = True
        near[near] = [
            in_sight(free, column + 0.5, row + 0.5, c, r) for r, c in (indices - low).tolist()
        ]
        return near

    # The front ------------------------------------------------------------------------------

    def call(self, goal: Goal) -> Errand | None:
        """Call the relays that a goal needs; return the errand to wait for them, if any is late."""
        places = self._places_for(goal.place)
        if places is None:
            # It is out of reach, and the robot goes there to find a path home.
            places = tuple(link.place for link in self._standing())
        self._team.passes_front = False
        self._team.links = self._assigned(places)
        late = self._not_in_place()
        if not late:
            return None
        self._called_for = goal.place
        travel_s = [self._travel_time_s(link) for link in late]
        named = ", ".join(str(link.robot) for link in late)
        return Errand(
            kind="wait",
            why=f"for {'robots' if len(late) > 1 else 'robot'} {named} to come to "
            f"{'their places' if len(late) > 1 else 'its place'}",
            goal=self._waiting_place(),
            is_over=lambda: not self._not_in_place(),
            until_s=self._course.time_s + max(travel_s) + self._options.home_wait_s,
        )

    def _waiting_place(self) -> Goal:
        """Return where the front waits for its relays: here, if it is linked with one of them.

        Otherwise, as they leave for other places, it goes back towards the nearest of these, or the
        base station, until it is linked with it.
        """
        here, stays = self._course.at[:2], self._here()
        anchors = [*(link.place for link in reversed(self._team.links or ())), self._base]
        if any(self.linked(np.array([here]), anchor)[0] for anchor in anchors):
            return stays
        goals = [(self._home_paths.goal_near(anchor), anchor) for anchor in anchors]
        ways = [(goal, anchor) for goal, anchor in goals if goal is not None]
        if not ways:
            return stays
        goal, anchor = min(ways, key=lambda way: way[0].cost_m)
        points = _points_along(goal.path, self._map.raster.cell_m)
        linked = self.linked(points, anchor)
        path = points[: int(np.argmax(linked)) + 1] if linked.any() else points
        x, y = path[-1].tolist()
        return Goal(x, y, path, length_of(path))

    def take_called_for(self) -> Place | None:
        """Return the goal of the last call, once, if this is the front and all are in place."""
        place, self._called_for = self._called_for, None
        are_there = self.is_front and self._team.links and not self._not_in_place()
        return place if are_there else None

    def note_missed(self) -> list[int]:
        """Record that relays did not come; return the numbers of those presumed lost."""
        now_s, teammates = self._course.time_s, self._team.teammates
        late = [link.robot for link in self._not_in_place()]
        self._late.update(late)
        lost = [n for n in late if teammates.last_heard_s(n) < now_s - self._options.home_wait_s]
        for number in lost:
            teammates.note_lost(number, now_s)
        return lost

    def let_go(self) -> None:
        """Let all relays go, as the front has nothing to do."""
        self._team.links = self._called_for = None

    def pass_front(self) -> None:
        """Leave the front to the next robot, as this one has nothing to do there."""
        self._team.passes_front = True

    def _assigned(self, places: Sequence[Place]) -> tuple[ChainLink, ...]:
        """Return who stands where: who is there stays, others come from the nearest place."""
        free = self._relays
        before = {link.place: link.robot for link in self._team.links or () if link.robot in free}
        held = {place: before[place] for place in places if place in before}
        for number in held.values():
            free.remove(number)
        reports, links = self._team.teammates.reports, []
        for place in places:
            if place not in held:
                nearest = min(
                    free,
                    key=lambda n: (self._home_paths.length_between(reports[n].place[:2], place), n),
                )
                held[place] = nearest
                free.remove(nearest)
            links.append(ChainLink(robot=held[place], place=place))
        return tuple(links)

    def _not_in_place(self) -> list[ChainLink]:
        reports = self._team.teammates.reports
        return [
            link
            for link in self._team.links or ()
            if not self._team.hears(link.robot)
            or math.dist(reports[link.robot].place[:2], link.place) > IN_PLACE_M
        ]

    def _travel_time_s(self, link: ChainLink) -> float:
        report = self._team.teammates.reports[link.robot]
        length_m = self._home_paths.length_between(report.place[:2], link.place)
        if math.isinf(length_m):
            return 0.0
        return self._time.travel_time_s(length_m, report.speed_m_s)

    # A relay --------------------------------------------------------------------------------

    def follow(self) -> Errand | None:
        """Return the errand of a relay: to stand at its place while the front is heard."""
        place = self.own_link
        if place is None:
            return None
        front, wait_s = self.front, self._options.home_wait_s
        why = f"stands at ({place[0]:.1f}, {place[1]:.1f}) for robot {front}"
        unheard_s = self._unheard_s(front)
        if unheard_s >= MAX_UNHEARD * wait_s:
            # It is kept from its place, as by robots that do not let it pass.
            return self._serve(front, why, self._here(), 0.0)
        goal = self._home_paths.goal_near(place)
        if goal is not None:
            return self._serve(front, why, goal, wait_s)
        # Where all paths are barred it waits for one: its front goes on without it in the end.
        patience_s = wait_s if unheard_s < wait_s else 0.0
        return self._serve(
            front, why, None, patience_s, lambda: self._home_paths.goal_near(place) is not None
        )

    def stand_by(self) -> Errand | None:
        """Return the errand of a robot that has no goal: to wait until the front calls it.

        One that is jammed stands by though it is called.
        """
        if not self.is_led:
            return None
        front, wait_s = self.front, self._options.home_wait_s
        revision = self._map.raster.revision
        patience_s = wait_s if self._unheard_s(front) < wait_s else 0.0
        return self._serve(
            front,
            f"waits to be called by robot {front}",
            self._here(),
            patience_s,
            # It may have a goal, with what is new.
            lambda: self._has_goal_since(revision),
        )

    def _serve(
        self,
        front: int,
        why: str,
        goal: Goal | None,
        patience_s: float,
        may_leave: Callable[[], bool] = lambda: False,
    ) -> Errand:
        """Return an errand for a front, which is over when that needs the robot no more."""
        called = self.own_link
        return Errand(
            kind="link",
            why=why,
            goal=goal or self._here(),
            is_barred=goal is None,
            is_over=lambda: (
                self.front != front or not self.is_led or self.own_link != called or may_leave()
            ),
            patience_s=patience_s,
            heard_s=lambda: self._team.teammates.last_heard_s(front),
        )

    def _here(self) -> Goal:
        at = self._course.at[:2]
        return Goal(*at, np.array([at]), 0.0)

    def _unheard_s(self, front: int) -> float:
        """Return for how long a front was not heard, or the robot has followed it if that is less.

        Who stays where it is and is interrupted again and again gets no new patience each time.
        """
        now_s = self._course.time_s
        if self._follows != front:
            self._follows, self._follows_since_s = front, now_s
        return now_s - max(self._team.teammates.last_heard_s(front), self._follows_since_s)

    def _has_goal_since(self, revision: int) -> bool:
        """Return whether the map is new since a revision and there is a frontier in reach."""
        if self._map.raster.revision == revision:
            return False
        places = [(x, y) for x, y in self._frontiers.targets().tolist()]
        return any(self._reaches(place) for place in places)

    def note_unheard(self) -> int | None:
        """Presume the front lost if it was not heard for long; return its number."""
        front, now_s = self._follows, self._course.time_s
        heard_s = -math.inf if front is None else self._team.teammates.last_heard_s(front)
        if front is None or now_s < heard_s + self._options.home_wait_s:
            return None
        self._team.teammates.note_lost(front, now_s)
        return front


def _points_along(path: FloatArray, step_m: float) -> FloatArray:
    """Return places along a path that are at most so far apart, ``(n, 2)`` metres."""
    points = [path[:1]]
    for a, b in pairwise(path):
        count = max(1, math.ceil(math.dist(a, b) / step_m))
        shares = np.arange(1, count + 1)[:, None] / count
        points.append(a + shares * (b - a))
    return np.vstack(points)
