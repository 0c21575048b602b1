"""Routes over the roadmap that keep off the bodies of other robots."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.exploration_map import ExplorationMap
from multisrt.robots.explorer import Sighting
from multisrt.robots.knowledge import NodeId
from multisrt.robots.multi_srt.obstacles import Obstacles
from multisrt.robots.multi_srt.roadmap import Passable, SrtRoadmap
from multisrt.robots.multi_srt.whereabouts import Whereabouts

Place = tuple[float, float]
"""x and y in metres."""


class Routes:
    """Shortest routes between nodes, as far as no other body blocks them.

    Parameters
    ----------
    at : Whereabouts
        Where the robot is.
    known : ExplorationMap
        Its map.
    roadmap : SrtRoadmap
        Its roadmap.
    obstacles : Obstacles
        Bodies to keep off.
    """

    def __init__(
        self, at: Whereabouts, known: ExplorationMap, roadmap: SrtRoadmap, obstacles: Obstacles
    ) -> None:
        self.at = at
        self.map = known
        self.roadmap = roadmap
        self.obstacles = obstacles

    def route(self, start: NodeId, end: NodeId) -> list[NodeId] | None:
        """Return the shortest route between two nodes, both included, or None."""
        own = self.roadmap.me.robot
        if start.robot != own or end.robot != own:
            self.roadmap.extend()
        return self.roadmap.path(start, end, self.passable)

    def to_nearest(self, start: NodeId, wanted: Callable[[NodeId], bool]) -> list[NodeId] | None:
        """Return the route to the nearest wanted node of the roadmap, or None."""
        return self.roadmap.to_nearest(start, wanted, self.passable)

    def length_m(self, route: list[NodeId]) -> float:
        """Return the length of a route in metres."""
        places = [self.map[node].configuration for node in route]
        return math.fsum(a.distance(b) for a, b in itertools.pairwise(places))

    def bodies_on(self, route: list[NodeId], beyond: Place | None = None) -> dict[int, Sighting]:
        """Return the bodies, by robot, on a route and on the path from its end to a place."""
        places = [self.map[node].configuration[:2] for node in route]
        places += [places[-1] if beyond is None else beyond]
        return self.obstacles.on(np.hstack([places[:-1], places[1:]]))

    @property
    def passable(self) -> Passable | None:
        """Whether no body blocks an edge, as `is_passable`; None where no body stands anywhere."""
        return self.is_passable if self.obstacles else None

    def is_passable(self, a: NodeId, b: NodeId) -> bool:
        """Whether no body blocks the straight path between two nodes."""
        if not self.obstacles:
            return True
        (ax, ay, _), (bx, by, _) = self.map[a].configuration, self.map[b].configuration
        if a == self.at.here:
            return self.goes_straight(bx, by)
        return bool(self.obstacles.are_passed_by(np.array([[ax, ay, bx, by]]))[0])

    def goes_straight(self, x: float, y: float) -> bool:
        """Whether no body blocks the straight path from the current configuration to a place."""
        q = self.at.q_act
        line = Trajectory((Waypoint(0.0, *q), Waypoint(1.0, x, y, q.heading)))
        return self.obstacles.blocking(q, line) is None
