"""The planner of Sensor-based Random Trees: where a robot looks next.

Source: Multi-SRT, paper section 2 (PLANNER) and Oriolo et al. 2004. Three stages: *draw* is the
papers'; *approach* and *complete* are ours, and without them an exploration does not finish
(a door that is seen edge-on has no direction in which a candidate could be drawn).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal, NamedTuple, Protocol

import msgspec
import numpy as np
from numpy.random import Generator

from multisrt.geometry.bodies.clearance import keep_off
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.distances import (
    distance_to_boundary,
    distance_to_segments,
    inside,
    nearest_point,
    nearest_points,
)
from multisrt.geometry.numerics.kernel import FloatArray, kernel
from multisrt.geometry.regions.known_space import KnownSpace
from multisrt.geometry.regions.safe_region import CONTACT_TOLERANCE_M, LocalSafeRegion
from multisrt.planners.motion.body import HAIR_M, PlanningBody
from multisrt.planners.motion.kinematics import Car, Kinematics
from multisrt.planners.motion.steering import reach, reach_fan, steer

Refusal = Literal["too narrow", "not reachable", "seen from near"]
"""Why no place opens a frontier arc: the body fits nowhere from where it could be seen; it
would fit, but no known way leads there; it has been looked at from every such place."""

REFUSALS: tuple[Refusal, ...] = ("too narrow", "not reachable", "seen from near")

NEAREST_NODES = 12
"""From so many nodes a way to a place is looked for."""

FEW_PLACES, MANY_WAYS = 4, 64 * NEAREST_NODES
"""For so few places a way is looked for at first, and so many ways are looked at at once then."""

MOST_ASKED = 24
"""So many times at each point of an arc it is asked whether a way leads to a place."""

FAN = 72
"""Directions in which the approach looks for a place, besides those to the frontier itself."""

CLOSE_BY = 6.0
"""Viewing places are first looked for within this many radii of the body."""

INWARD_M = 1e-4
"""How far inside the known region a frontier arc is looked at from."""


class SrtOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of an SRT explorer; the paper's own where it names them.

    Attributes
    ----------
    alpha : float
        A candidate lies at this share of the distance to the region's boundary (paper: alpha).
    max_draws : int
        How many candidates are drawn at a node before it is given up (paper: I_max).
    d_min_m : float or None
        Least distance of a candidate from every node; None: the body's width.
    frontier_bias : bool
        Draw towards the local frontier (Multi-SRT); False: uniform directions, candidates in
        no other region (single-robot SRT).
    gaps_count : bool
        Whether radial pieces behind corners are frontier.
    approach : bool
        Use the second stage: the reachable place nearest to a frontier arc.
    complete : bool
        Use the third stage: look at every arc left from wherever it can be seen.
    backtrack : {"parent", "nearest_open"}
        With nothing to do at a node, go step by step to the parent, as the paper does, or over
        the roadmap to the nearest node that has a frontier.
    cones : int
        How many cones a star has.
    contact_tolerance_m : float
        A star's or ball's arc is at an obstacle where a reading ends this close behind it.
    margin_m : float
        How far the body stays away from the border of what it knows, where it has the room.
    completion_spacing : float
        In the third stage, least distance from all nodes as a share of `d_min_m`.
    max_views : int
        In the third stage, how many times arcs in one spot, as wide as `d_min_m`, are looked at
        before they are given up.
    """

    alpha: float = 0.8
    max_draws: int = 10
    d_min_m: float | None = None
    frontier_bias: bool = True
    gaps_count: bool = True
    approach: bool = True
    complete: bool = True
    backtrack: Literal["parent", "nearest_open"] = "parent"
    cones: int = 16
    contact_tolerance_m: float = CONTACT_TOLERANCE_M
    margin_m: float = 0.02
    completion_spacing: float = 0.5
    max_views: int = 3

    def __post_init__(self) -> None:
        for name, ok, allowed in (
            ("alpha", 0.0 < self.alpha <= 1.0, "above 0 and at most 1"),
            ("max_draws", self.max_draws >= 1, "at least 1"),
            ("d_min_m", self.d_min_m is None or 0.0 < self.d_min_m < math.inf, "positive"),
            ("cones", self.cones >= 3, "at least 3"),
            ("contact_tolerance_m", 0.0 <= self.contact_tolerance_m < math.inf, "0 or more"),
            ("margin_m", 5.0 * HAIR_M <= self.margin_m < math.inf, f"at least {5.0 * HAIR_M:g}"),
            ("max_views", self.max_views >= 1, "at least 1"),
            ("completion_spacing", 0.0 < self.completion_spacing < math.inf, "positive"),
        ):
            if not ok:
                raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be {allowed}")


Accept = Callable[[float, float], str | None]
"""Says why a place is refused that is a candidate otherwise; None: it is accepted."""


@dataclass(slots=True)
class Draws:
    """How many candidates were drawn at a node, and why they were refused.

    Attributes
    ----------
    drawn : int
        How many there were.
    refused : dict
        Why they were refused, with how often.
    candidates : list of (x, y, reason)
        Those that were refused, in their order.
    """

    drawn: int = 0
    refused: dict[str, int] = field(default_factory=dict)
    candidates: list[tuple[float, float, str]] = field(default_factory=list)

    def refuse(self, x: float, y: float, reason: str) -> None:
        """Count a candidate that was refused."""
        self.refused[reason] = self.refused.get(reason, 0) + 1
        self.candidates.append((x, y, reason))


class Viewpoint(Protocol):
    """What the planner needs to know of a node."""

    @property
    def configuration(self) -> Configuration:
        """Where the scan was taken."""

    @property
    def region(self) -> LocalSafeRegion:
        """What is surely free around it."""


class Way(NamedTuple):
    """A place without a node, and how to get there.

    Attributes
    ----------
    x, y : float
        The place.
    node : int
        Number of the node from which the way is straight.
    roomy : bool
        Whether there is room for any heading all along the way.
    """

    x: float
    y: float
    node: int
    roomy: bool


class SrtPlanner:
    """Chooses the next place of one robot from its current region and frontier.

    Parameters
    ----------
    body, kinematics
        What moves, and how.
    options : SrtOptions
        The parameters.
    d_min_m : float
        Least distance of a candidate from every node.
    """

    def __init__(
        self, body: PlanningBody, kinematics: Kinematics, options: SrtOptions, d_min_m: float
    ) -> None:
        self.body = body
        self.kinematics = kinematics
        self.options = options
        self.d_min_m = d_min_m

    def draw(
        self,
        at: Configuration,
        region: LocalSafeRegion,
        frontier: FloatArray,
        others: FloatArray,
        other_regions: list[LocalSafeRegion],
        rng: Generator,
        accept: Accept | None = None,
    ) -> tuple[tuple[float, float] | None, Draws]:
        """Stage 1: draw candidates until one is accepted.

        Parameters
        ----------
        at : Configuration
            Where the robot stands.
        region : LocalSafeRegion
            What it sees from there.
        frontier : (m, 4) array
            The local frontier.
        others : (n, 2) array
            The places of all nodes near by.
        other_regions : list of LocalSafeRegion
            Their regions, where candidates must lie in none of them (`frontier_bias=False`).
        rng : numpy.random.Generator
            The robot's own stream.
        accept : callable, optional
            Asked last about a candidate: why it is refused, or None.

        Returns
        -------
        place : (x, y) or None
            The candidate accepted.
        draws : Draws
            What was drawn and refused.
        """
        draws = Draws()
        biased = self.options.frontier_bias
        if biased and not len(frontier):
            return None, draws
        lengths = np.hypot(frontier[:, 2] - frontier[:, 0], frontier[:, 3] - frontier[:, 1])
        along, pieces = lengths.cumsum().tolist(), frontier.tolist()
        for _ in range(self.options.max_draws):
            draws.drawn += 1
            if biased:
                # A point of the frontier, uniform over its length: an arc with probability
                # proportional to its length, and a point on it uniformly.
                position = rng.random() * along[-1]
                k = min(bisect_right(along, position), len(along) - 1)
                t = 1.0 - (along[k] - position) / float(lengths[k])
                x0, y0, x1, y1 = pieces[k]
                direction = math.atan2(y0 + t * (y1 - y0) - at.y, x0 + t * (x1 - x0) - at.x)
            else:
                direction = rng.random() * 2.0 * math.pi
            ux, uy = math.cos(direction), math.sin(direction)
            rho = distance_to_boundary(region.boundary, at.x, at.y, ux, uy)
            wanted = self.options.alpha * rho
            distance = (
                reach(self.body, self.kinematics, region.boundary, at, direction, wanted)
                if wanted >= self.d_min_m
                else 0.0
            )
            x, y = at.x + distance * ux, at.y + distance * uy
            reason: str | None = None
            if distance < self.d_min_m:
                # The body does not get anywhere: the candidate is where it was drawn.
                x, y, reason = at.x + wanted * ux, at.y + wanted * uy, "no room"
            elif nearest_point(others, x, y) < self.d_min_m:
                reason = "near a node"
            elif not biased and any(inside(other.boundary, x, y) for other in other_regions):
                reason = "in another region"
            elif accept is not None:
                reason = accept(x, y)
            if reason is None:
                return (x, y), draws
            draws.refuse(x, y, reason)
        return None, draws

    def approach(
        self,
        at: Configuration,
        region: LocalSafeRegion,
        arcs: list[FloatArray],
        others: FloatArray,
        accept: Accept | None = None,
        draws: Draws | None = None,
    ) -> tuple[float, float] | None:
        """Stage 2: the place straight from here that lies nearest to a frontier arc.

        It is taken if it lies clearly nearer to its arc than the robot does, by half of
        `d_min_m`, and `d_min_m` from every node.

        Parameters
        ----------
        at, region, others
            As in `draw`.
        arcs : list of (k, 4) array
            The local frontier.
        accept : callable, optional
            Asked last about a place: why it is refused, or None. The next nearest is taken
            then, not close to one that was refused, of at most `max_draws`.
        draws : Draws, optional
            Where refusals are counted.
        """
        if not arcs:
            return None
        ends = np.vstack([(arc[0, :2], arc[-1, 2:], arc[len(arc) // 2, :2]) for arc in arcs])
        directions = np.concatenate(
            [
                np.arange(FAN) * (2.0 * math.pi / FAN),
                np.arctan2(ends[:, 1] - at.y, ends[:, 0] - at.x),
            ]
        )
        limits = reach_fan(
            self.body, self.kinematics, region.boundary, at, directions, region.range_m
        )
        candidates = _along_rays(at.x, at.y, directions, limits, self.d_min_m, self.d_min_m / 4.0)
        candidates = candidates[nearest_points(others, candidates) >= self.d_min_m]
        if not len(candidates):
            return None
        here = np.array([[at.x, at.y]])
        # Of every place the arc that lies nearest to it, and how near.
        nearest = np.full(len(candidates), math.inf)
        number = np.zeros(len(candidates), np.int64)
        for k, arc in enumerate(arcs):
            distances = distance_to_segments(candidates, arc)
            clearly = distance_to_segments(here, arc)[0] - 0.5 * self.d_min_m
            nearer = distances < np.minimum(clearly, nearest)
            nearest[nearer], number[nearer] = distances[nearer], k
        order = np.lexsort((number, nearest))
        places = candidates[order[: np.count_nonzero(nearest < math.inf)]]
        return self._first_accepted(places, accept, Draws() if draws is None else draws)

    def _first_accepted(
        self, places: FloatArray, accept: Accept | None, draws: Draws
    ) -> tuple[float, float] | None:
        # Neighbours of a place that is refused mostly are for the same reason: they are skipped.
        for _ in range(self.options.max_draws):
            if not len(places):
                return None
            x, y = places[0].tolist()
            reason = None if accept is None else accept(x, y)
            if reason is None:
                return x, y
            draws.refuse(x, y, reason)
            apart = np.hypot(places[:, 0] - x, places[:, 1] - y) >= 0.5 * self.d_min_m
            places = places[apart]
        return None

    def viewing_place(
        self,
        arc: FloatArray,
        known: KnownSpace,
        within_m: float,
        nodes: Sequence[Viewpoint],
        leads: Callable[[int, float, float], bool] | None = None,
        bodies: FloatArray | None = None,
        *,
        past_bodies: bool = False,
    ) -> Way | Refusal:
        """Stage 3: a place in the known region from which the body can see a frontier arc.

        Parameters
        ----------
        arc : (k, 4) array
            The arc's segments.
        known : KnownSpace
            What is known in a window around the arc.
        within_m : float
            How far from the arc's middle to look for places.
        nodes : sequence of Viewpoint
            All nodes near by.
        leads : callable, optional
            Whether a way leads from a node, given by its number, to a place and back, for a
            body that does not drive straight; asked at most `MOST_ASKED` times.
        bodies : (m, 3) array, optional
            Of bodies that stand for good x, y and how far off the body has to be.
        past_bodies : bool
            Whether the way to the place may lead past them all the same.

        Returns
        -------
        Way
            The place, and how to get there; or
        str
            Why there is none; see `Refusal`.
        """
        reasons: list[Refusal] = []
        for x, y, left_x, left_y in arc_points(arc, self.d_min_m):
            x_inside, y_inside = x + left_x * INWARD_M, y + left_y * INWARD_M
            if not known.holds(np.array([[x_inside, y_inside]]))[0]:
                continue
            places = np.array([x, y]) + _lattice(within_m, self.d_min_m / 4.0)
            places = places[known.sees(x_inside, y_inside, places)]
            # Where there is room for the whole margin, that is better.
            room = known.clearances(places, self.body.ample_radius_m)
            ample = room >= self.body.ample_radius_m
            narrower = (room >= self.body.roomy_radius_m) & ~ample
            places = np.vstack([places[ample], places[narrower]])
            if bodies is not None:
                places = places[keep_off(np.hstack([places, places]), bodies)]
            in_the_way = None if past_bodies else bodies
            found = self._place_with_a_way(places, known, nodes, leads, in_the_way)
            if not isinstance(found, str):
                return found
            reasons.append(found)
        return max(reasons, key=REFUSALS.index, default="too narrow")

    def may_find_way(
        self, x: float, y: float, half_width_m: float, nodes: Sequence[Viewpoint]
    ) -> bool:
        """Whether `viewing_place` could find a way in a square window; cheap to ask before.

        A way begins at a node with room for any heading inside the window, or at a narrow node.

        Parameters
        ----------
        x, y, half_width_m : float
            The window's middle and half of its width.
        nodes : sequence of Viewpoint
            All nodes near by.
        """
        inner = half_width_m - self.body.roomy_radius_m
        return isinstance(self.kinematics, Car) or any(
            max(abs(node.configuration.x - x), abs(node.configuration.y - y)) < inner
            or self._is_narrow(node)
            for node in nodes
        )

    def _place_with_a_way(
        self,
        places: FloatArray,
        known: KnownSpace,
        nodes: Sequence[Viewpoint],
        leads: Callable[[int, float, float], bool] | None,
        bodies: FloatArray | None,
    ) -> Way | Refusal:
        # The first place that is not close to a node and has a straight way from one: with room
        # for any heading or, from a narrow node, inside what it sees.
        if not len(places):
            return "too narrow"
        spots = np.array([node.configuration[:2] for node in nodes]).reshape(-1, 2)
        spaced = nearest_points(spots, places) >= self.options.completion_spacing * self.d_min_m
        places = places[spaced]
        if not len(places):
            return "seen from near"
        if leads is not None:
            return self._place_asked_for(places, spots, leads)
        least = self.body.roomy_radius_m
        roomy = known.holds(spots) & (known.clearances(spots, least) >= least)
        # A way begins where there is room for any heading, or in a narrow place that is seen.
        begins = np.flatnonzero(
            [r or self._is_narrow(n) for r, n in zip(roomy, nodes, strict=True)]
        )
        if not len(begins):
            return "not reachable"
        done, many = 0, FEW_PLACES
        while done < len(places):
            # Mostly one of the first will do; if not, many are asked about at once.
            some = places[done : done + many]
            apart = np.hypot(*(spots[begins] - some[:, None]).transpose(2, 0, 1))
            nearest = begins[np.argsort(apart, axis=1, kind="stable")[:, :NEAREST_NODES]]
            ways = np.dstack([spots[nearest], np.repeat(some[:, None], nearest.shape[1], 1)])
            clear = known.passes(ways.reshape(-1, 4), least)
            if bodies is not None:
                clear &= keep_off(ways.reshape(-1, 4), bodies)
            clear = clear.reshape(nearest.shape) & roomy[nearest]
            for i in np.flatnonzero(clear.any(axis=1) | ~roomy[nearest].all(axis=1)).tolist():
                x, y = some[i].tolist()
                for k, is_clear in zip(nearest[i].tolist(), clear[i].tolist(), strict=True):
                    if is_clear:
                        return Way(x, y, k, roomy=True)
                    if not roomy[k] and self._leaves_a_narrow_node(nodes[k], x, y):
                        return Way(x, y, k, roomy=False)
            done, many = done + many, MANY_WAYS // nearest.shape[1]
        return "not reachable"

    def _place_asked_for(
        self,
        places: FloatArray,
        spots: FloatArray,
        leads: Callable[[int, float, float], bool],
    ) -> Way | Refusal:
        asked = 0
        for x, y in places.tolist():
            distances = np.hypot(spots[:, 0] - x, spots[:, 1] - y)
            for k in np.argsort(distances, kind="stable")[:NEAREST_NODES].tolist():
                if asked == MOST_ASKED:
                    return "not reachable"
                asked += 1
                if leads(k, x, y):
                    return Way(x, y, k, roomy=False)
        return "not reachable"

    def _is_narrow(self, node: Viewpoint) -> bool:
        return not self.body.has_room(node.region.boundary, node.configuration)

    def _leaves_a_narrow_node(self, node: Viewpoint, x: float, y: float) -> bool:
        assert not isinstance(self.kinematics, Car)
        boundary, at = node.region.boundary, node.configuration
        return steer(self.body, self.kinematics, boundary, at, x, y) is not None


def arc_points(arc: FloatArray, spacing: float) -> list[tuple[float, float, float, float]]:
    """Give points along an arc, its middle first, each with the unit vector into its region.

    They are `spacing` apart, but not more than seven.
    """
    lengths = np.hypot(arc[:, 2] - arc[:, 0], arc[:, 3] - arc[:, 1])
    along = np.cumsum(lengths)
    whole = float(along[-1])
    pairs = min(3, int(0.5 * whole / spacing))
    step = max(spacing, whole / 7.0)
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
def _lattice(radius: float, step: float) -> FloatArray:
    # Points around the origin, the nearest first; the same few lattices serve every arc.
    n = math.ceil(radius / step)
    offsets = np.arange(-n, n + 1) * step
    points = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
    distances = np.hypot(points[:, 0], points[:, 1])
    order = np.argsort(distances, kind="stable")
    result: FloatArray = points[order[distances[order] <= radius]]
    result.setflags(write=False)
    return result


@kernel
def _along_rays(
    x: float, y: float, directions: FloatArray, limits: FloatArray, first: float, step: float
) -> FloatArray:
    # Places on rays from a point: from `first` on at equal steps, and at the rays' ends.
    counts = np.zeros(directions.shape[0], np.int64)
    for k in range(directions.shape[0]):
        if limits[k] >= first:
            counts[k] = int(np.ceil((limits[k] - first) / step)) + 1
    places = np.empty((counts.sum(), 2))
    n = 0
    for k in range(directions.shape[0]):
        ux, uy = math.cos(directions[k]), math.sin(directions[k])
        for i in range(counts[k]):
            distance = min(first + i * step, limits[k])
            places[n, 0], places[n, 1] = x + distance * ux, y + distance * uy
            n += 1
    return places
