"""Places from which a frontier arc is seen, and the paths there from nodes (stage 3 of SRT)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Final, Literal, NamedTuple, Protocol

import numpy as np

from multisrt.geometry.bodies.clearance import paths_keep_clear
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.distances import inside, nearest_points
from multisrt.geometry.regions.known_space import KnownSpace
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car, Kinematics
from multisrt.planners.motion.steering import steer

Refusal = Literal["too narrow", "not reachable", "seen from near"]
"""Why an arc has no viewing place: the body fits in no place that sees it; it would fit, but no
known path leads there; all such places have been looked from."""

REFUSALS: Final[tuple[Refusal, ...]] = ("too narrow", "not reachable", "seen from near")

CLOSE_BY: Final = 6.0
"""Viewing places are first looked for within this many radii of the body."""

NEAREST_NODES: Final = 12
"""Number of nodes, the nearest, from which a path to a place is looked for."""

FIRST_PLACES: Final = 4
"""Number of places in the first batch; one of them mostly has a path."""

BATCH_PATHS: Final = 64 * NEAREST_NODES
"""Number of paths in each further batch."""

MAX_ASKED: Final = 24
"""Bounds the questions whether a path leads to a place, for each arc and window."""

ASKED_NODES: Final = 4
"""Number of nodes, the nearest, of which it is asked for each place."""

MAX_POINTS: Final = 7
"""Maximum number of points along an arc from which it is looked at."""

Leads = Callable[[int, float, float], bool]
"""Whether a path leads from a node, given by its index, to a place x, y and back."""


class Questions:
    """A limited number of questions whether a path leads to a place.

    Parameters
    ----------
    leads : callable
        Answers them; see `Leads`.
    times : int
        How many may be asked.
    """

    def __init__(self, leads: Leads, times: int) -> None:
        self._leads = leads
        self._left = times

    @property
    def are_used_up(self) -> bool:
        """Whether no question is left."""
        return self._left <= 0

    def ask(self, node: int, x: float, y: float) -> bool:
        """Return whether a path leads to a place; False if no question is left."""
        if self.are_used_up:
            return False
        self._left -= 1
        return self._leads(node, x, y)


class Viewpoint(Protocol):
    """A node, as far as the planner is concerned."""

    @property
    def configuration(self) -> Configuration:
        """Configuration at which the scan was taken."""

    @property
    def region(self) -> LocalSafeRegion:
        """Local safe region around it."""


class ViewingPlace(NamedTuple):
    """A place without a node, and the path there.

    Attributes
    ----------
    x, y : float
        The place in metres.
    node : int
        Index of the node from which the path is straight.
    roomy : bool
        Whether there is room for any heading all along the path.
    """

    x: float
    y: float
    node: int
    roomy: bool


class PlaceFinder:
    """Finds paths from nodes to new places in known space.

    Parameters
    ----------
    body, kinematics
        The body that moves, and how.
    spacing_m : float
        Minimum distance of a place from every node in metres.
    """

    def __init__(self, body: PlanningBody, kinematics: Kinematics, spacing_m: float) -> None:
        self.body = body
        self.kinematics = kinematics
        self.spacing_m = spacing_m

    def first_place(
        self,
        places: FloatArray,
        known: KnownSpace,
        nodes: Sequence[Viewpoint],
        questions: Questions | None = None,
        bodies: FloatArray | None = None,
    ) -> ViewingPlace | Refusal:
        """Return the first of some places that has a path from a node.

        A path is straight, with room for any heading; from a narrow node, inside what it sees.

        Parameters
        ----------
        places : (p, 2) array
            Places in metres in order of preference.
        known : KnownSpace
            The known space around them.
        nodes : sequence of Viewpoint
            All nodes near by.
        questions : Questions, optional
            If given, they decide whether a path leads to a place, for a body that does not drive
            straight. No place is asked about that is nearer than `spacing_m` to one to which no
            path leads.
        bodies : (m, 3) array, optional
            x, y and required distance of bodies that paths must not pass.

        Returns
        -------
        ViewingPlace or str
            The place and its path, or why there is none.
        """
        if not len(places):
            return "too narrow"
        spots = np.array([node.configuration[:2] for node in nodes]).reshape(-1, 2)
        places = places[nearest_points(spots, places) >= self.spacing_m]
        if not len(places):
            return "seen from near"
        if questions is not None:
            return self._first_asked_for(places, spots, questions)
        return self._first_straight(places, known, nodes, spots, bodies)

    def may_begin(
        self, x: float, y: float, half_width_m: float, nodes: Sequence[Viewpoint]
    ) -> bool:
        """Whether a path may begin in a square window; see `SrtPlanner.may_find_path`."""
        inner = half_width_m - self.body.roomy_radius_m
        return isinstance(self.kinematics, Car) or any(
            max(abs(node.configuration.x - x), abs(node.configuration.y - y)) < inner
            or self._is_narrow(node)
            for node in nodes
        )

    def _first_straight(
        self,
        places: FloatArray,
        known: KnownSpace,
        nodes: Sequence[Viewpoint],
        spots: FloatArray,
        bodies: FloatArray | None,
    ) -> ViewingPlace | Refusal:
        radius_m = self.body.roomy_radius_m
        roomy = known.holds(spots) & (known.clearances(spots, radius_m) >= radius_m)
        begins = np.flatnonzero(
            [r or self._is_narrow(n) for r, n in zip(roomy, nodes, strict=True)]
        )
        if not len(begins):
            return "not reachable"
        done, batch = 0, FIRST_PLACES
        while done < len(places):
            some = places[done : done + batch]
            apart = np.hypot(*(spots[begins] - some[:, None]).transpose(2, 0, 1))
            nearest = begins[np.argsort(apart, axis=1, kind="stable")[:, :NEAREST_NODES]]
            paths = np.dstack([spots[nearest], np.repeat(some[:, None], nearest.shape[1], 1)])
            passes = np.ones(len(paths) * nearest.shape[1], np.bool_)
            if bodies is not None:
                passes = paths_keep_clear(paths.reshape(-1, 4), bodies)
            clear = known.passes(paths.reshape(-1, 4), radius_m) & passes
            clear = clear.reshape(nearest.shape) & roomy[nearest]
            narrow = passes.reshape(nearest.shape) & ~roomy[nearest]
            for i in np.flatnonzero((clear | narrow).any(axis=1)).tolist():
                x, y = some[i].tolist()
                for j, k in enumerate(nearest[i].tolist()):
                    if clear[i, j]:
                        return ViewingPlace(x, y, k, roomy=True)
                    if narrow[i, j] and self._leaves_a_narrow_node(nodes[k], x, y):
                        return ViewingPlace(x, y, k, roomy=False)
            done, batch = done + batch, BATCH_PATHS // nearest.shape[1]
        return "not reachable"

    def _first_asked_for(
        self, places: FloatArray, spots: FloatArray, questions: Questions
    ) -> ViewingPlace | Refusal:
        while len(places) and not questions.are_used_up:
            x, y = places[0].tolist()
            distances = np.hypot(spots[:, 0] - x, spots[:, 1] - y)
            for k in np.argsort(distances, kind="stable")[:ASKED_NODES].tolist():
                if questions.ask(k, x, y):
                    return ViewingPlace(x, y, k, roomy=False)
            apart = np.hypot(*(places[1:] - places[0]).T) >= self.spacing_m
            places = places[1:][apart]
        return "not reachable"

    def _is_narrow(self, node: Viewpoint) -> bool:
        return not self.body.has_room(node.region.boundary, node.configuration)

    def _leaves_a_narrow_node(self, node: Viewpoint, x: float, y: float) -> bool:
        assert not isinstance(self.kinematics, Car)
        boundary, at = node.region.boundary, node.configuration
        # Most places lie outside what the node sees, which takes far less time to find.
        if not inside(boundary, x, y):
            return False
        return steer(self.body, self.kinematics, boundary, at, x, y) is not None


def arc_points(arc: FloatArray, spacing: float) -> list[tuple[float, float, float, float]]:
    """Return points along an arc, each with the unit vector into the arc's region.

    Parameters
    ----------
    arc : (k, 4) array
        Segments of the arc in metres, the region on their left.
    spacing : float
        Distance between points in metres; larger where more than `MAX_POINTS` would fit.

    Returns
    -------
    list of (x, y, left_x, left_y)
        The middle of the arc first, then outwards.

    Examples
    --------
    >>> arc_points(np.array([[0.0, 0.0, 2.0, 0.0]]), 0.5)[0]
    (1.0, 0.0, -0.0, 1.0)
    """
    lengths = np.hypot(arc[:, 2] - arc[:, 0], arc[:, 3] - arc[:, 1])
    along = np.cumsum(lengths)
    whole = float(along[-1])
    pairs = min(MAX_POINTS // 2, int(0.5 * whole / spacing))
    step = max(spacing, whole / MAX_POINTS)
    points = []
    for k in range(-pairs, pairs + 1):
        position = 0.5 * whole + k * step
        i = min(int(np.searchsorted(along, position)), len(arc) - 1)
        t = 1.0 - (along[i] - position) / lengths[i]
        dx, dy = (arc[i, 2:] - arc[i, :2]).tolist()
        x, y = (arc[i, :2] + t * (arc[i, 2:] - arc[i, :2])).tolist()
        points.append((x, y, -dy / float(lengths[i]), dx / float(lengths[i])))
    return sorted(points, key=lambda point: abs(points.index(point) - pairs))


@lru_cache(maxsize=16)
def lattice(radius: float, step: float) -> FloatArray:
    """Return the points of a square lattice within a radius of the origin, the nearest first."""
    n = math.ceil(radius / step)
    offsets = np.arange(-n, n + 1) * step
    points = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
    distances = np.hypot(points[:, 0], points[:, 1])
    order = np.argsort(distances, kind="stable")
    result: FloatArray = points[order[distances[order] <= radius]]
    result.setflags(write=False)
    return result
