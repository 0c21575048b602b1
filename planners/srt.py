"""The planner of Sensor-based Random Trees: where a robot looks next.

Three stages: *draw* a candidate towards the local frontier, *approach* the nearest frontier arc,
and *complete* the exploration from places that see a remaining arc.

Source: Multi-SRT, paper section 2 (PLANNER), and Oriolo et al. 2004. Differs in:

- Only *draw* is the papers'. Without the other two stages an exploration does not finish; a door
  that is seen edge-on, for instance, has no direction in which a candidate could be drawn.
- Candidates are drawn in the same way for ball, star and radial regions: in the direction of a
  point of the local frontier, at a share of the distance to the region's boundary there. SRT-Star
  identifies the cone of a candidate; here cones only shape the boundary, whose distance in a
  direction is the depth of the cone there.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.random import Generator

from multisrt.geometry.bodies.clearance import paths_keep_clear
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics import libm
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.distances import (
    distance_to_boundary,
    distance_to_segments,
    inside,
    nearest_point,
    nearest_points,
)
from multisrt.geometry.numerics.kernel import kernel
from multisrt.geometry.regions.known_space import KnownSpace
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Kinematics
from multisrt.planners.motion.steering import reach, reach_fan
from multisrt.planners.srt_options import SrtOptions
from multisrt.planners.viewing import (
    MAX_ASKED,
    REFUSALS,
    Leads,
    PlaceFinder,
    Questions,
    Refusal,
    ViewingPlace,
    Viewpoint,
    arc_points,
    lattice,
)

APPROACH_DIRECTIONS: Final = 72
"""Number of directions in which the approach looks for a place, besides those to the frontier."""

INWARD_M: Final = 1e-4
"""Distance inside the known region from which a frontier arc is looked at, in metres."""

LATTICE_STEPS: Final = (0.25, 0.125)
"""Steps of the lattices of viewing places, as shares of `d_min_m`, or of the body's width if it is
smaller. The finer is used where all places on the other have been looked from."""


Accept = Callable[[float, float], str | None]
"""Returns why a candidate at x, y is refused; None to accept it."""


@dataclass(slots=True)
class Draws:
    """The candidates looked at from a node, and why they were refused.

    Attributes
    ----------
    drawn : int
        Number of candidates drawn (stage 1).
    refused : dict of str to int
        Number of refused candidates by reason, those of stage 2 included.
    candidates : list of (x, y, reason)
        The refused candidates of both stages in order.
    arcs : list of (x, y, area_m2, way_m, value)
        With ``choice="gain"``: the arcs that were compared, the highest value first.
    """

    drawn: int = 0
    refused: dict[str, int] = field(default_factory=dict)
    candidates: list[tuple[float, float, str]] = field(default_factory=list)
    arcs: list[tuple[float, float, float, float, float]] = field(default_factory=list)

    def refuse(self, x: float, y: float, reason: str) -> None:
        """Record a refused candidate."""
        self.refused[reason] = self.refused.get(reason, 0) + 1
        self.candidates.append((x, y, reason))


class SrtPlanner:
    """Chooses the next place of one robot from its region and frontier.

    Parameters
    ----------
    body, kinematics
        The body that moves, and how.
    options : SrtOptions
        The parameters.
    d_min_m : float
        Minimum distance of a candidate from every node in metres.

    Examples
    --------
    A robot in the middle of a square of 8 m, all of whose right side is frontier:

    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> from multisrt.planners.motion.kinematics import Holonomic
    >>> body = PlanningBody(Footprint.disc(0.25), margin_m=0.02)
    >>> planner = SrtPlanner(body, Holonomic(), SrtOptions(), d_min_m=0.5)
    >>> square = np.array([[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]])
    >>> region = LocalSafeRegion(
    ...     x=0.0, y=0.0, range_m=6.0, boundary=square, tags=np.zeros(4, np.int8)
    ... )
    >>> place, draws = planner.draw(
    ...     Configuration(0.0, 0.0, 0.0),
    ...     region,
    ...     frontier=np.array([[4.0, -4.0, 4.0, 4.0]]),
    ...     others=np.zeros((1, 2)),
    ...     other_regions=[],
    ...     rng=np.random.default_rng(1),
    ... )
    >>> draws.drawn, round(place[0], 3)  # at alpha = 0.8 of the distance
    (1, 3.2)
    """

    def __init__(
        self, body: PlanningBody, kinematics: Kinematics, options: SrtOptions, d_min_m: float
    ) -> None:
        self.body = body
        self.kinematics = kinematics
        self.options = options
        self.d_min_m = d_min_m
        self._finder = PlaceFinder(body, kinematics, options.completion_spacing * d_min_m)

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
            Configuration of the robot.
        region : LocalSafeRegion
            Its local safe region there.
        frontier : (m, 4) array
            Segments of the local frontier in metres.
        others : (n, 2) array
            Positions of all nodes near by.
        other_regions : list of LocalSafeRegion
            Their regions, which exclude candidates with ``frontier_bias=False``.
        rng : numpy.random.Generator
            The robot's own random stream.
        accept : callable, optional
            Asked last about a candidate.

        Returns
        -------
        place : (x, y) or None
            The accepted candidate.
        draws : Draws
            The candidates drawn and refused.
        """
        draws = Draws()
        biased = self.options.frontier_bias
        if biased and not len(frontier):
            return None, draws
        arcs = _Arcs(frontier)
        for _ in range(self.options.max_draws):
            draws.drawn += 1
            if biased:
                x, y = arcs.random_point(rng)
                direction = math.atan2(y - at.y, x - at.x)
            else:
                direction = rng.random() * 2.0 * math.pi
            x, y, reason = self._candidate(at, region, direction, others)
            if reason is None and not biased:
                covered = any(inside(other.boundary, x, y) for other in other_regions)
                reason = "in another region" if covered else None
            if reason is None and accept is not None:
                reason = accept(x, y)
            if reason is None:
                return (x, y), draws
            draws.refuse(x, y, reason)
        return None, draws

    def _candidate(
        self, at: Configuration, region: LocalSafeRegion, direction: float, others: FloatArray
    ) -> tuple[float, float, str | None]:
        """Return the candidate in a direction, and why it is refused; None if it is not."""
        ux, uy = math.cos(direction), math.sin(direction)
        rho = distance_to_boundary(region.boundary, at.x, at.y, ux, uy)
        wanted = self.options.alpha * rho
        distance = 0.0
        if wanted >= self.d_min_m:
            distance = reach(self.body, self.kinematics, region.boundary, at, direction, wanted)
        if distance < self.d_min_m:
            # The body has no room to move; the candidate is recorded where it was drawn.
            return at.x + wanted * ux, at.y + wanted * uy, "no room"
        x, y = at.x + distance * ux, at.y + distance * uy
        return x, y, "near a node" if nearest_point(others, x, y) < self.d_min_m else None

    def approach(
        self,
        at: Configuration,
        region: LocalSafeRegion,
        arcs: list[FloatArray],
        others: FloatArray,
        accept: Accept | None = None,
        draws: Draws | None = None,
    ) -> tuple[float, float] | None:
        """Stage 2: return the place nearest to a frontier arc that the robot can reach straight.

        The place is nearer to its arc than the robot by at least half of `d_min_m`, and at least
        `d_min_m` from every node.

        Parameters
        ----------
        at, region, others
            As in `draw`.
        arcs : list of (k, 4) array
            The arcs of the local frontier.
        accept : callable, optional
            Asked last about a place. If it is refused, the next nearest is tried that is not close
            to a refused one, up to `max_draws` places.
        draws : Draws, optional
            Collects the refused places.

        Returns
        -------
        (x, y) or None
        """
        if not arcs:
            return None
        ends = np.vstack([(arc[0, :2], arc[-1, 2:], arc[len(arc) // 2, :2]) for arc in arcs])
        directions = np.concatenate(
            [
                np.arange(APPROACH_DIRECTIONS) * (2.0 * math.pi / APPROACH_DIRECTIONS),
                libm.arctan2(ends[:, 1] - at.y, ends[:, 0] - at.x),
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
        # For every place the nearest arc and its distance.
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
        # Neighbours of a refused place are usually refused for the same reason.
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
        leads: Leads | None = None,
        bodies: FloatArray | None = None,
        *,
        past_bodies: bool = False,
    ) -> ViewingPlace | Refusal:
        """Stage 3: return a place in the known region from which a frontier arc is seen.

        Parameters
        ----------
        arc : (k, 4) array
            Segments of the arc.
        known : KnownSpace
            The known space in a window around the arc.
        within_m : float
            Maximum distance of the place from a point of the arc in metres.
        nodes : sequence of Viewpoint
            All nodes near by.
        leads : callable, optional
            For a body that does not drive straight: whether a path leads from a node, given by its
            index, to a place x, y and back; asked at most `MAX_ASKED` times.
        bodies : (m, 3) array, optional
            x, y and required distance of bodies that stand in the way for good.
        past_bodies : bool
            Whether the path to the place may lead past them nevertheless.

        Returns
        -------
        ViewingPlace or str
            The place and the path there, or why there is none; see `Refusal`.
        """
        found: ViewingPlace | Refusal = "seen from near"
        questions = None if leads is None else Questions(leads, MAX_ASKED)
        unit_m = min(self.d_min_m, self.body.footprint.width_m)
        for step in LATTICE_STEPS:
            if found == "seen from near":
                places = lattice(within_m, step * unit_m)
                found = self._place_on(
                    places, arc, known, nodes, questions, bodies, past_bodies=past_bodies
                )
        return found

    def _place_on(
        self,
        around: FloatArray,
        arc: FloatArray,
        known: KnownSpace,
        nodes: Sequence[Viewpoint],
        questions: Questions | None,
        bodies: FloatArray | None,
        *,
        past_bodies: bool,
    ) -> ViewingPlace | Refusal:
        # A place out of those around the points of an arc.
        reasons: list[Refusal] = []
        for x, y, left_x, left_y in arc_points(arc, self.d_min_m):
            x_inside, y_inside = x + left_x * INWARD_M, y + left_y * INWARD_M
            if not known.holds(np.array([[x_inside, y_inside]]))[0]:
                continue
            places = np.array([x, y]) + around
            places = places[known.sees(x_inside, y_inside, places)]
            # Places with room for the whole margin come first.
            room = known.clearances(places, self.body.ample_radius_m)
            ample = room >= self.body.ample_radius_m
            narrower = (room >= self.body.roomy_radius_m) & ~ample
            places = np.vstack([places[ample], places[narrower]])
            # The border may have gaps of 0.1 mm, through which places outside are in sight.
            places = places[known.holds(places)]
            if bodies is not None:
                places = places[paths_keep_clear(np.hstack([places, places]), bodies)]
            in_the_way = None if past_bodies else bodies
            found = self._finder.first_place(places, known, nodes, questions, in_the_way)
            if not isinstance(found, str):
                return found
            reasons.append(found)
        return max(reasons, key=REFUSALS.index, default="too narrow")

    def may_find_path(
        self, x: float, y: float, half_width_m: float, nodes: Sequence[Viewpoint]
    ) -> bool:
        """Whether `viewing_place` could find a path in a square window; cheap to compute.

        Parameters
        ----------
        x, y, half_width_m : float
            Centre of the window and half of its width in metres.
        nodes : sequence of Viewpoint
            All nodes near by.

        Returns
        -------
        bool
            False only if no path begins in the window: at a node with room for any heading inside
            it, or at a narrow node.
        """
        return self._finder.may_begin(x, y, half_width_m, nodes)


class _Arcs:
    """The segments of a frontier, from which points are drawn uniformly over their length."""

    def __init__(self, segments: FloatArray) -> None:
        lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
        self._segments, self._lengths = segments.tolist(), lengths.tolist()
        self._along = lengths.cumsum().tolist()

    def random_point(self, rng: Generator) -> tuple[float, float]:
        position = rng.random() * self._along[-1]
        k = min(bisect_right(self._along, position), len(self._along) - 1)
        t = 1.0 - (self._along[k] - position) / self._lengths[k]
        x0, y0, x1, y1 = self._segments[k]
        return x0 + t * (x1 - x0), y0 + t * (y1 - y0)


@kernel
def _along_rays(
    x: float, y: float, directions: FloatArray, limits: FloatArray, first: float, step: float
) -> FloatArray:
    """Return places on rays from a point: from `first` on at equal steps, and the rays' ends."""
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
