"""Places from which a robot sees the frontier arcs that it could not draw a target for."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection
from functools import cache

import numpy as np
from shapely.geometry.base import BaseGeometry

from multisrt.events import ClosingReason
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.planners.motion.car import MAX_CHECKS, Checks
from multisrt.planners.srt import SrtPlanner
from multisrt.planners.viewing import CLOSE_BY, Refusal, ViewingPlace, arc_points
from multisrt.robots.explorer import RobotSelf
from multisrt.robots.knowledge import Node, NodeId
from multisrt.robots.multi_srt.bypass import Bypass
from multisrt.robots.multi_srt.targets import Barred, NewPlace

WIDEST_WINDOW = 1.5
"""Half width of the widest window in which a place is looked for, in sensing ranges."""

MAX_VAIN_PLANS = 4
"""Questions of a car in one window that used up their plans in vain, after which only shortest
curves are tried."""

SPOTS_AROUND = 2.0
"""Half width of the square around a spot in which looks at it show something, in spots."""


class Views:
    """Finds places that see a frontier arc, and counts how often every spot was looked at.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    planner : SrtPlanner
        Its planner.
    bypass : Bypass
        Its paths off the roadmap.
    max_views : int
        How many times arcs in one spot are looked at before they are given up.

    Attributes
    ----------
    drawn_out : set of NodeId
        Nodes at which the robot has stood and found no target by drawing or approaching.
    """

    def __init__(self, me: RobotSelf, planner: SrtPlanner, bypass: Bypass, max_views: int) -> None:
        self.drawn_out: set[NodeId] = set()
        self._me = me
        self._planner = planner
        self._bypass = bypass
        self._routes = bypass.routes
        self._map = bypass.map
        self._max_views = max_views
        self._looked: Counter[tuple[int, int]] = Counter()
        self._known_m2: dict[tuple[int, int], float] = {}
        self._last_choice: tuple[tuple[int, int], NodeId] | None = None
        self._last_counted: tuple[int, int] | None = None

    def viewing_place(self, node: NodeId, arc: FloatArray) -> NewPlace | Barred | ClosingReason:
        """Return a place from which an arc can be seen, or what bars it, or why there is none.

        Parameters
        ----------
        node : NodeId
            The node whose frontier the arc is part of.
        arc : (k, 4) array
            Its segments x0, y0, x1, y1 in metres.
        """
        here, spot = self._bypass.at.node, self._spot(arc)
        x, y, *_ = arc_points(arc, self._planner.d_min_m)[0]
        if self._looked[spot] >= self._max_views and not self._has_shown_more(spot):
            # Not so near as it could be without the bodies, if these bar better places.
            refused = self._refused("seen from near", arc, x, y)
            if isinstance(refused, Barred):
                del self._looked[spot]
            return refused
        found = self._view(arc, x, y)
        if isinstance(found, str) and self._routes.obstacles:
            found = self._view(arc, x, y, past_bodies=True)
        if isinstance(found, str):
            return self._refused(found, arc, x, y)
        target = self._leading_to(node, *found) or self._from_joined(node, arc, found[1])
        if target is None:
            return self._barred("not reachable", found)
        # A robot that had to wait may choose the same again: it has not looked meanwhile.
        again = self._last_choice == (spot, here)
        self._last_choice = spot, here
        self._count(spot, not target.is_interim and not again)
        return target

    def _leading_to(self, node: NodeId, place: ViewingPlace, start: NodeId) -> NewPlace | None:
        # What leads on to a place over the roadmap and straight from a node; or off the roadmap.
        routes = self._routes
        route = routes.route(self._bypass.at.node, start)
        last = np.array([[*self._map[start].configuration[:2], place.x, place.y]])
        if route is not None and routes.obstacles.are_passed_by(last)[0]:
            return NewPlace(place.x, place.y, "complete", tuple(route), place.roomy, node)
        return self._bypass.to_place(place.x, place.y, node)

    def _from_joined(self, node: NodeId, arc: FloatArray, start: NodeId) -> NewPlace | None:
        # What leads to another place than that straight from a node, if the roadmap does not lead
        # to that node: straight from one to which it leads.
        roadmap = self._routes.roadmap.graph
        joined = roadmap.lengths([self._bypass.at.node], self._routes.passable)
        if start in joined:
            return None
        x, y, *_ = arc_points(arc, self._planner.d_min_m)[0]
        found = self._view(arc, x, y, among=joined)
        return None if isinstance(found, str) else self._leading_to(node, *found)

    def off_the_roadmap(self, node: NodeId, arc: FloatArray) -> NewPlace | None:
        """Return what leads on to a view of an arc where no straight path from a node does.

        For example, the only node that sees the arc is so narrow that the body cannot turn there.
        The path leaves the roadmap elsewhere; see `Bypass`.
        """
        if self._routes.roadmap.is_car:
            return None
        (x, y, *_), window = arc_points(arc, self._planner.d_min_m)[0], self._windows()[-1]

        @cache
        def leads(place: tuple[float, float]) -> bool:
            return self._bypass.first_leg(goal=place) is not None

        obstacles = self._routes.obstacles
        found = self._planner.viewing_place(
            arc,
            self._map.known_space(x, y, window),
            self._me.range_m,
            self._map.near(x, y, math.sqrt(2.0) * window),
            lambda _, *place: leads(place),
            obstacles.berths if obstacles else None,
        )
        if isinstance(found, str):
            return None
        target = self._bypass.to_place(found.x, found.y, node)
        if target is not None:
            self._count(self._spot(arc), not target.is_interim)
        return target

    def forget_look(self) -> None:
        """Do not count the last place as a look: the robot stops before it, or does not go."""
        if self._last_counted is not None:
            self._looked[self._last_counted] -= 1
            self._last_counted = None

    def _spot(self, arc: FloatArray) -> tuple[int, int]:
        # The spot in which the middle of an arc lies: looks are counted by spot.
        spot_m = self._planner.d_min_m
        x, y, *_ = arc_points(arc, spot_m)[0]
        return round(x / spot_m), round(y / spot_m)

    def _count(self, spot: tuple[int, int], counts: bool) -> None:
        if counts and not self._looked[spot]:
            self._known_m2[spot] = self._known_around(spot)
        self._looked[spot] += counts
        self._last_counted = spot if counts else None

    def _has_shown_more(self, spot: tuple[int, int]) -> bool:
        # Whether looks at a spot have shown as much as a square of `d_min_m`; they count anew then.
        if self._known_around(spot) < self._known_m2[spot] + self._planner.d_min_m**2:
            return False
        del self._looked[spot]
        return True

    def _known_around(self, spot: tuple[int, int]) -> float:
        # Area that is known near a spot, in square metres.
        spot_m = self._planner.d_min_m
        x, y = (spot_m * i for i in spot)
        return float(self._map.local_union(x, y, SPOTS_AROUND * spot_m).area)

    def _view(
        self,
        arc: FloatArray,
        x: float,
        y: float,
        *,
        past_bodies: bool = False,
        among: Collection[NodeId] | None = None,
    ) -> tuple[ViewingPlace, NodeId] | Refusal:
        # A place that sees an arc around x, y, and the node, of some or all, from which it is
        # reached.
        obstacles = self._routes.obstacles
        refusal: Refusal = "too narrow"
        for window in self._windows():
            near = self._map.near(x, y, math.sqrt(2.0) * window)
            if among is not None:
                near = [node for node in near if node.id in among]
            if window < self._me.range_m and not self._planner.may_find_path(x, y, window, near):
                continue
            found = self._planner.viewing_place(
                arc,
                self._map.known_space(x, y, window),
                min(window, self._me.range_m),
                near,
                self._leads(near, self._map.local_union(x, y, window))
                if self._routes.roadmap.is_car
                else None,
                obstacles.berths if obstacles else None,
                past_bodies=past_bodies,
            )
            # A window wider than the sensing range holds no more places, only more paths.
            if not isinstance(found, str):
                return found, near[found.node].id
            refusal = found
            if refusal != "not reachable" and window >= self._me.range_m:
                break
        return refusal

    def _refused(
        self, reason: ClosingReason, arc: FloatArray, x: float, y: float
    ) -> Barred | ClosingReason:
        # Why an arc cannot be seen: the reason, unless bodies bar the best place that sees it.
        if not self._routes.obstacles:
            return reason
        with self._routes.obstacles.ignored():
            found = self._view(arc, x, y)
        return reason if isinstance(found, str) else self._barred(reason, found)

    def _barred(
        self, reason: ClosingReason, found: tuple[ViewingPlace, NodeId]
    ) -> Barred | ClosingReason:
        # What stands in the way to a place; the reason, if no body does.
        (x, y, *_), start = found
        route = self._routes.roadmap.path(self._bypass.at.node, start)
        if route is not None:
            bodies = self._routes.bodies_on(route, (x, y))
        else:
            leads = self._bypass.leads_without_bodies(goal=(x, y))
            bodies = self._routes.obstacles.all if leads else {}
        return Barred(bodies) if bodies else reason

    def _leads(self, near: list[Node], known: BaseGeometry) -> Callable[[int, float, float], bool]:
        vain_plans = 0

        def leads(k: int, x: float, y: float) -> bool:
            nonlocal vain_plans
            checks = Checks(MAX_CHECKS if vain_plans < MAX_VAIN_PLANS else 0)
            found = self._routes.roadmap.leads(near[k], known, x, y, checks)
            vain_plans += not found and checks.are_used_up
            return found

        return leads

    def _windows(self) -> list[float]:
        # Half widths of the windows in which a place is looked for: near the arc first, which is
        # cheap and mostly enough; at last wide enough for the path to a place at sensing range.
        outer_m = self._planner.body.outer_radius_m
        widest = WIDEST_WINDOW * self._me.range_m + outer_m
        windows = [CLOSE_BY * outer_m]
        while windows[-1] < widest:
            windows.append(2.0 * windows[-1])
        return [min(window, widest) for window in windows]
