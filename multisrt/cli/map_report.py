"""Findings of the check of a map, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from multisrt.cli.reach import MAX_AREAS, areas, around
from multisrt.environments.area_text import area_text, extent_text

if TYPE_CHECKING:
    from shapely import Polygon

    from multisrt.analysis.clearance_tree import Passage
    from multisrt.analysis.map_check import MapCheck

MAX_PASSAGES = 5
"""Number of passages, or groups of equally wide ones, that are listed."""

MAX_PLACES = 3
"""Number of equally wide passages whose places are listed."""


def report(check: MapCheck) -> Iterator[str]:
    """Return the lines that describe a world and how it suits a body.

    Parameters
    ----------
    check : MapCheck
        The check of the world.

    Examples
    --------
    >>> import shapely
    >>> from multisrt.analysis.map_check import check_map
    >>> from multisrt.environments.environment import Environment
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> wall = shapely.box(4, 0, 4.2, 1.8) | shapely.box(4, 2.2, 4.2, 4)
    >>> rooms = Environment("two rooms", shapely.box(0, 0, 8.2, 4) - wall)
    >>> for line in report(check_map(rooms, Footprint.disc(0.25))):
    ...     print(line.replace(": a disc", ":\\n  a disc"))
    two rooms: 8.2 x 4 m, 32.08 m2 free, 12 vertices
    free space: 1 part
    narrowest passage: 0.4 m wide at (4.07, 2.00), 16.03 m2 behind it
    largest body that reaches 95 % of it:
      a disc of 0.2 m in radius, limited by the passage at (4.07, 2.00)
    the body disc:0.25 reaches 50 % of it; out of reach: 16.1 m2 at (6.15, 2.00)
    the passage at (4.07, 2.00) is 0.4 m wide: bodies up to 0.2 m in radius pass
    """
    world = check.environment
    vertices = f"{len(world.edges)} vertices"
    if check.superfluous_vertices:
        vertices += f", {check.superfluous_vertices} of them on straight lines"
    yield f"{world.name}: {extent_text(world.bounds, world.area_m2)}, {vertices}"
    if world.cleaning:
        yield f"cleaned: {world.cleaning}"
    if world.layers is not None:
        yield str(world.layers)
    yield f"free space: {areas(world)}{_parts_of_starts(check)}{_parts_of_obstacles(check)}"
    if said := around(world, check.main):
        yield said
    here = "it" if len(check.parts) == 1 else f"the part of {area_text(check.main.area)} m2"
    if check.passages:
        first = check.passages[0]
        yield (
            f"narrowest passage: {_metres(first.width_m)} wide at {_place(first)}, "
            f"{area_text(first.beyond_m2)} m2 behind it"
        )
    else:
        yield "narrowest passage: none, it is nowhere narrower than on both sides"
    limit = check.largest.limit
    why = f"limited by the passage at {_place(limit)}" if limit else "limited by narrow places"
    yield (
        f"largest body that reaches {100.0 * check.share:.3g} % of {here}: a disc of "
        f"{_metres(check.largest.radius_m)} in radius, {why}"
    )
    reached = f"the body {check.footprint} reaches {100.0 * check.reached_share:.3g} % of {here}"
    yield reached + (
        f"; out of reach: {_listed_areas(check.unreachable)}" if check.unreachable else ""
    )
    yield from _blocking(check.blocking)
    if check.tight:
        from multisrt.analysis.map_check import SPARE_M

        yield (
            f"tight for it: {_places(check.tight)}, {_metres(check.tight[0].width_m)} wide or "
            f"little more: strategies may need up to {100.0 * SPARE_M:g} cm to spare on either side"
        )


def _parts_of_starts(check: MapCheck) -> str:
    if not check.start_parts:
        return ""
    used = sorted(set(check.start_parts))
    if len(check.parts) == 1:
        return f", with all {check.kind_of_start}s"
    sizes = ", ".join(area_text(check.parts[number].area) for number in used)
    return (
        f"; the {check.kind_of_start}s are in {'that' if len(used) == 1 else 'those'} of {sizes} m2"
    )


def _parts_of_obstacles(check: MapCheck) -> str:
    if len(check.parts) == 1 or not check.environment.outlined_obstacles:
        return ""
    return "; others may be the insides of obstacles drawn as outlines"


def _listed_areas(found: Sequence[Polygon]) -> str:
    from multisrt.analysis.map_check import place_in

    text = ", ".join(
        f"{area_text(area.area, 3)} m2 at {place_in(area)}" for area in found[:MAX_AREAS]
    )
    rest = found[MAX_AREAS:]
    if not rest:
        return text
    more = area_text(sum(area.area for area in rest), 3)
    return f"{text}, and {more} m2 in {len(rest)} other places"


def _blocking(passages: Sequence[Passage]) -> Iterator[str]:
    by_width: dict[str, list[Passage]] = {}
    for passage in passages:
        by_width.setdefault(_metres(passage.width_m), []).append(passage)
    # The widest first, since a slightly smaller body passes these.
    for width, group in list(reversed(by_width.items()))[:MAX_PASSAGES]:
        yield (
            f"{_places(group)} {'are' if len(group) > 1 else 'is'} {width} wide: "
            f"bodies up to {_metres(group[0].width_m / 2.0)} in radius pass"
        )
    if len(by_width) > MAX_PASSAGES:
        more = sum(len(group) for group in list(by_width.values())[:-MAX_PASSAGES])
        yield f"{more} other passages are narrower"


def _places(passages: Sequence[Passage]) -> str:
    places = ", ".join(_place(passage) for passage in passages[:MAX_PLACES])
    if more := len(passages[MAX_PLACES:]):
        places += f" and {more} other{'s' * (more > 1)}"
    return f"the passage{'s' * (len(passages) > 1)} at {places}"


def _place(passage: Passage) -> str:
    x, y = passage.centre
    return f"({x:.2f}, {y:.2f})"


def _metres(metres: float) -> str:
    return f"{metres:.3g} m" if metres < 1000.0 else f"{metres:,.0f} m"
