"""Check whether a world suits a body: separate parts, narrow passages, and areas out of reach."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import shapely
from shapely import Polygon

from multisrt.analysis.clearance_tree import (
    CORNER_SHARE,
    LargestBody,
    Passage,
    clearance_tree,
)
from multisrt.environments.cleaning import CleaningOptions, cleaned
from multisrt.environments.environment import Environment
from multisrt.environments.formats.geojson import degrees_hint
from multisrt.environments.parts import Enclosing, inside, parts_of, start_in, surrounding
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.simulation.rooms import body_fits, misfit, needed_clearance

SHARE: Final = 0.95
"""Default share of the main part that a body is to reach."""

MIN_MAIN_SHARE: Final = 0.9
"""Minimum share of free space in the main part; with less, the check reports a problem."""

MIN_BEYOND_M2: Final = 1.0
"""Minimum area behind a passage that is listed, in square metres."""

MIN_BEYOND_SHARE: Final = 0.01
"""The same as a share of the main part, if that is less."""

MAX_STARTS_LISTED: Final = 3
"""Number of starts with the same problem that are listed; the others are counted."""

ARC_ERROR_M: Final = 1e-4
"""Maximum distance between arcs and the chords that replace them, in metres."""

RADIUS_PRECISION: Final = 1e-4
"""Precision of the largest disc that fits anywhere, as a share of a side of the part."""

SPARE_M: Final = 0.05
"""A body that passes with less than this on either side passes tightly, in metres."""

ROUNDING_M: Final = 1e-6
"""Bodies are taken smaller by this, in metres, so that they pass a gap that just fits."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapCheck:
    """Findings of `check_map`.

    Attributes
    ----------
    environment : Environment
        The world.
    footprint : Footprint
        The body. If it is not a disc, its largest inscribed disc is checked, which passes
        wherever the body does.
    share : float
        Share of the main part that a body is to reach.
    parts : tuple of Polygon
        The separate parts of free space, the largest first.
    around : Enclosing or None
        The part that lies around others, such as the paper around a floor plan; see
        `multisrt.environments.parts.surrounding`.
    given_starts : tuple of Configuration
        Where robots are to start, in metres and radians; empty if the suggested starts count.
    main : Polygon
        The main part, which is checked: that of the first start, or else the largest that does not
        lie around others.
    start_parts : tuple of int
        For each of `starts`, the index in `parts` of the part that it is in.
    superfluous_vertices : int
        Number of vertices that lie on the line between their neighbours.
    passages : tuple of Passage
        Passages of the main part with enough area behind them, the narrowest first; one for each
        gap, where several are nearer to each other than the diameter of the body.
    largest : LargestBody
        The largest disc that reaches `share` of the main part.
    reachable : tuple of Polygon
        Positions that the reference point of the body can reach in the main part.
    unreachable : tuple of Polygon
        Areas of the main part that the body does not cover from there, the largest first, except
        for the remainders in corners of 90 degrees or more.
    """

    environment: Environment
    footprint: Footprint
    share: float
    parts: tuple[Polygon, ...]
    around: Enclosing | None
    given_starts: tuple[Configuration, ...]
    main: Polygon
    start_parts: tuple[int, ...]
    superfluous_vertices: int
    passages: tuple[Passage, ...]
    largest: LargestBody
    reachable: tuple[Polygon, ...]
    unreachable: tuple[Polygon, ...]

    @property
    def starts(self) -> tuple[tuple[float, float], ...]:
        """The starts that were given, or else the suggested ones, as (x, y) in metres."""
        return tuple((x, y) for x, y, _ in self.given_starts) or self.environment.starts

    @property
    def kind_of_start(self) -> str:
        """What a start is called: ``"start"`` if it was given, else ``"suggested start"``."""
        return "start" if self.given_starts else "suggested start"

    @property
    def reached_share(self) -> float:
        """Share of the main part that the body reaches."""
        if not self.reachable:
            return 0.0
        left = sum(area.area for area in self.unreachable)
        return max(0.0, 1.0 - left / self.main.area)

    @property
    def blocking(self) -> tuple[Passage, ...]:
        """The passages that the body does not pass, the narrowest first."""
        width = 2.0 * (self.footprint.inscribed_radius_m - ROUNDING_M)
        return tuple(passage for passage in self.passages if passage.width_m < width)

    @property
    def tight(self) -> tuple[Passage, ...]:
        """The passages that the body passes with less than `SPARE_M` on either side.

        Strategies may not find paths through them: those that bid for frontiers plan on the cells
        of a raster, and keep a margin.
        """
        width = 2.0 * (self.footprint.inscribed_radius_m + SPARE_M)
        narrow = (passage for passage in self.passages if passage.width_m < width)
        return tuple(narrow)[len(self.blocking) :]

    @property
    def problems(self) -> tuple[str, ...]:
        """Problems of the world for the body, one sentence each; empty if it suits the body."""
        layers = self.environment.layers
        return tuple(
            filter(
                None,
                (
                    "" if layers is None else layers.problem,
                    self._problem_of_parts(),
                    self._problem_of_reach(),
                    *self._problems_of_starts(),
                ),
            )
        )

    def _problem_of_parts(self) -> str:
        share = self.main.area / self.environment.area_m2
        if self.environment.outlined_obstacles and self.main is self.parts[0]:
            return ""  # the others are insides of obstacles
        if self.given_starts or share >= MIN_MAIN_SHARE:  # a start that is given chooses its part
            return ""
        said = f"only {100.0 * share:.1f} % of free space is in one part with "
        said += "the suggested start" if self.environment.starts else place_in(self.main)
        if self.around is not None and self.around.area is not self.main:
            return f"{said}; the area around the walls is free, too: make it occupied"
        if self.around is not None:
            return (
                f"{said}, which lies around others along the border of the map: if it is the page "
                f"around a building, make it occupied, or explore with --start "
                f"{start_in(self.around.inside[0])}; else open doors between the parts"
            )
        return f"{said}: open doors between the parts, or leave the other parts out"

    def _problem_of_reach(self) -> str:
        if not self.reachable:
            hint = degrees_hint(self.environment)
            return (
                f"the body {self.footprint} fits nowhere in the main part: the largest disc there "
                f"has a radius of {_largest_radius_m(self.main):.3g} m{'; ' * bool(hint)}{hint}"
            )
        if self.reached_share >= self.share:
            return ""
        return (
            f"the body {self.footprint} reaches {100.0 * self.reached_share:.1f} % of the main "
            "part: take a smaller body, or widen passages"
        )

    def _problems_of_starts(self) -> list[str]:
        kind = self.kind_of_start
        apart, narrow = [], []
        for (x, y), number in zip(self.starts, self.start_parts, strict=True):
            if number != self.start_parts[0]:
                apart.append((x, y))
            elif not self.given_starts and not body_fits(
                self.environment, self.footprint, Configuration(x, y)
            ):
                narrow.append((self.environment.clearance(x, y), x, y))
        found = []
        if apart:
            verb = "is" if len(apart) == 1 else "are"
            found.append(f"the {_listed(apart, kind)} {verb} in another part than the first")
        found += [
            str(misfit(self.environment, self.footprint, start))
            for start in self.given_starts
            if not body_fits(self.environment, self.footprint, start)
        ]
        if narrow:
            walls = "the nearest wall is" if len(narrow) == 1 else "the nearest walls are"
            nearest, farthest = (f"{of(narrow)[0]:.3g}" for of in (min, max))
            distances = nearest if nearest == farthest else f"{nearest} to {farthest}"
            found.append(
                f"at the {_listed([place for _, *place in narrow], kind)} the body "
                f"{self.footprint} does not fit: {walls} at {distances} m, and it needs "
                f"{needed_clearance(self.footprint)}"
            )
        return found


def _listed(places: Sequence[Sequence[float]], kind: str) -> str:
    """Return starts of a kind as words, of many the first ones."""
    texts = [f"({x:g}, {y:g})" for x, y in places[:MAX_STARTS_LISTED]]
    if more := len(places) - len(texts):
        texts.append(f"{more} more")
    listed = texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"
    return f"{kind}{'s' * (len(places) > 1)} {listed}"


def check_map(
    environment: Environment,
    footprint: Footprint,
    *,
    share: float = SHARE,
    starts: Sequence[Configuration] = (),
) -> MapCheck:
    """Check whether a world suits a body, and where it does not.

    Parameters
    ----------
    environment : Environment
        The world.
    footprint : Footprint
        The body.
    share : float, optional
        Share of the main part that a body is to reach, above 0 and at most 1.
    starts : sequence of Configuration, optional
        Where robots are to start, in metres and radians, instead of the suggested starts. The part
        of the first is the main part, whatever its size.

    Returns
    -------
    MapCheck
        The findings; `MapCheck.problems` is empty if the world suits the body.

    Raises
    ------
    InvalidInputError
        If the share is out of range, or a start is not finite.
    ClearanceError
        If a given start is not in free space; the message gives the nearest place where the body
        fits.

    Examples
    --------
    Two rooms of 4 x 4 m with a door of 0.4 m:

    >>> wall = shapely.box(4, 0, 4.2, 1.8) | shapely.box(4, 2.2, 4.2, 4)
    >>> rooms = Environment("two rooms", shapely.box(0, 0, 8.2, 4) - wall)
    >>> check = check_map(rooms, Footprint.disc(0.25))
    >>> round(check.largest.radius_m, 6), round(check.reached_share, 2)
    (0.2, 0.5)
    >>> print(*check.problems)
    the body disc:0.25 reaches 50.0 % of the main part: take a smaller body, or widen passages
    >>> left = check_map(rooms, Footprint.disc(0.25), share=0.4, starts=[Configuration(1.0, 2.0)])
    >>> left.unreachable[0].contains(shapely.Point(6.0, 2.0)), left.problems
    (True, ())
    """
    if not 0.0 < share <= 1.0:
        raise InvalidInputError(f"the share is {share:g}; it must be above 0 and at most 1")
    for start in starts:
        if not all(map(math.isfinite, start)):
            raise InvalidInputError(f"a start is finite, not {tuple(start)}")
        if not environment.contains(start.x, start.y):
            raise misfit(environment, footprint, start)
    parts, given = parts_of(environment), tuple(starts)
    places = tuple((x, y) for x, y, _ in given) or environment.starts
    main = environment.component(*places[0]) if places else inside(environment)[0]
    tree = clearance_tree(main)
    reachable = _reachable(places[:1], main, footprint.inscribed_radius_m)
    _, cleaning = cleaned(environment.free, CleaningOptions())
    return MapCheck(
        environment=environment,
        footprint=footprint,
        share=share,
        parts=parts,
        around=surrounding(environment),
        given_starts=given,
        main=main,
        start_parts=tuple(parts.index(environment.component(*place)) for place in places),
        superfluous_vertices=cleaning.removed_vertices,
        passages=tree.passages(
            min(MIN_BEYOND_M2, MIN_BEYOND_SHARE * main.area),
            apart_m=2.0 * footprint.inscribed_radius_m,
        ),
        largest=tree.largest_body(share),
        reachable=reachable,
        unreachable=_unreachable(main, reachable, footprint.inscribed_radius_m),
    )


def place_in(area: Polygon) -> str:
    """Return a point inside an area as text, in metres."""
    point = shapely.point_on_surface(area)
    return f"({point.x:.2f}, {point.y:.2f})"


def _largest_radius_m(main: Polygon) -> float:
    # Of the discs that fit anywhere, whatever they reach.
    tolerance = RADIUS_PRECISION * math.sqrt(main.area)
    return float(shapely.maximum_inscribed_circle(main, tolerance=tolerance).length)


def _reachable(
    starts: Sequence[tuple[float, float]], main: Polygon, radius_m: float
) -> tuple[Polygon, ...]:
    # From the first start, or else where the body reaches the most.
    room = main.buffer(ROUNDING_M - radius_m, quad_segs=_segments(radius_m))
    areas = [area for area in shapely.get_parts(room) if not area.is_empty]
    if not areas:
        return ()
    if not starts:
        return (max(areas, key=lambda area: float(area.area)),)
    start = shapely.Point(starts[0])
    return (min(areas, key=lambda area: float(area.distance(start))),)


def _unreachable(
    main: Polygon, reachable: tuple[Polygon, ...], radius_m: float
) -> tuple[Polygon, ...]:
    if not reachable:
        return (main,)
    swept = reachable[0].buffer(radius_m, quad_segs=_segments(radius_m))
    left = shapely.get_parts(main.difference(swept))
    areas = [
        area
        for area in left[shapely.area(left) > CORNER_SHARE * radius_m**2]
        if area.geom_type == "Polygon"
    ]
    return tuple(sorted(areas, key=lambda area: -float(area.area)))


def _segments(radius_m: float) -> int:
    # Number of segments of a quarter of a circle.
    half = math.acos(max(0.0, 1.0 - ARC_ERROR_M / radius_m))
    return max(4, math.ceil(math.pi / 4.0 / half))
