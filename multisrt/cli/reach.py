"""The separate parts of a world, and in which of them robots start, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from multisrt.environments.area_text import area_text

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from shapely import Polygon

    from multisrt.environments.environment import Environment

MIN_SHARE = 0.9
"""Share of free space; if the robots can reach less, the summary says so."""

PAGE = "if it is the page around a building"
"""Beginning of the remedy where it is not sure what a part is."""

MAX_AREAS = 5
"""Number of parts that are listed by size."""


def by_option(place: str) -> str:
    """Return how `multisrt explore` is told to start at a place ``X,Y``.

    Examples
    --------
    >>> by_option("7.00,7.00")
    'explore the inside with --start 7.00,7.00'
    """
    return f"explore the inside with --start {place}"


def areas(environment: Environment) -> str:
    """Return how many separate parts a world has, and how large they are.

    Examples
    --------
    >>> import shapely
    >>> from multisrt.environments.environment import Environment
    >>> two = shapely.union_all([shapely.box(0, 0, 2, 2), shapely.box(3, 0, 6, 2)])
    >>> areas(Environment("two rooms", two))
    '2 separate parts (6, 4 m2)'
    >>> areas(Environment("a room", shapely.box(0, 0, 2, 2)))
    '1 part'
    """
    from multisrt.environments.parts import parts_of

    sizes = [part.area for part in parts_of(environment)]
    if len(sizes) == 1:
        return "1 part"
    listed = ", ".join(area_text(size) for size in sizes[:MAX_AREAS])
    return f"{len(sizes)} separate parts ({listed}{', ...' * (len(sizes) > MAX_AREAS)} m2)"


def around(environment: Environment, here: Polygon | None = None) -> str:
    """Return a note on the part of a world that lies around others; empty if there is none.

    Where it may be a page around a building as well as a hall with closed rooms, it says how to
    start inside.

    Parameters
    ----------
    environment : Environment
        The world.
    here : Polygon, optional
        The part in which robots start, if that is known; inside, nothing is said of how to.

    Examples
    --------
    >>> import shapely
    >>> from multisrt.environments.environment import Environment
    >>> wall = shapely.box(1, 1, 9, 9) - shapely.box(2, 2, 8, 8)
    >>> plan = Environment.from_outline("plan", shapely.box(0, 0, 10, 10), [wall])
    >>> around(plan)
    'the part of 36 m2 lies around the others: it touches the border of the map'
    """
    from multisrt.environments.parts import enclosing, start_in, surrounding

    found = surrounding(environment)
    if found is None:
        return ""
    said = (
        f"the part of {area_text(found.area.area)} m2 lies around "
        f"{'the others' if len(found.inside) + 1 == len(environment.components) else 'others'}: "
        "it touches the border of the map"
    )
    if enclosing(environment) is not None or (here is not None and here is not found.area):
        return said
    return f"{said}; {PAGE}, {by_option(start_in(found.inside[0]))}"


def elsewhere(
    environment: Environment,
    start: Sequence[float],
    remedy: Callable[[str], str] = by_option,
) -> str:
    """Return a note if a team starts in a minor one of several parts; empty if it does not.

    Parameters
    ----------
    environment : Environment
        The world.
    start : (x, y, ...)
        Where a robot starts, in metres; all robots of a team start in the same part.
    remedy : callable, optional
        Takes a place ``X,Y`` and returns how robots are made to start there.

    Returns
    -------
    str
        How many parts there are, which of them is that of the team, whether it or another lies
        around others, and where the largest of those is.

    Examples
    --------
    >>> import shapely
    >>> from multisrt.environments.environment import Environment
    >>> two = shapely.union_all([shapely.box(0, 0, 2, 2), shapely.box(3, 0, 6, 2)])
    >>> rooms = Environment("two rooms", two)
    >>> elsewhere(rooms, (1.0, 1.0, 0.0)).partition("; ")[0]
    'free space has 2 separate parts (6, 4 m2), and the start is in that of 4 m2 (40 %)'
    >>> elsewhere(rooms, (1.0, 1.0, 0.0)).partition("; ")[2]
    'the largest has 6 m2, e.g. at (4.50, 1.00)'
    """
    from multisrt.environments.parts import enclosing, inside, start_in, surrounding

    here = environment.component(*start[:2])
    share = here.area / environment.area_m2
    outside = surrounding(environment)
    starts_outside = outside is not None and outside.area is here
    if share >= MIN_SHARE and not starts_outside:
        return ""
    said = (
        f"free space has {areas(environment)}, and the start is in that of "
        f"{area_text(here.area)} m2 ({100.0 * share:.0f} %)"
    )
    if outside is not None and starts_outside:
        largest = outside.inside[0]
        said += (
            f", which lies around others and touches the border of the map; the largest "
            f"inside has {area_text(largest.area)} m2, e.g. at {_place(largest)}"
        )
        is_page = enclosing(environment) is not None
        return said if is_page else f"{said}; {PAGE}, {remedy(start_in(largest))}"
    largest = inside(environment)[0]
    if here.area < largest.area:
        said += f"; the largest has {area_text(largest.area)} m2, e.g. at {_place(largest)}"
    if outside is not None and outside.area.area > here.area:
        said += f"; that of {area_text(outside.area.area)} m2 lies around others"
    return said


def _place(area: Polygon) -> str:
    point = area.representative_point()
    return f"({point.x:.2f}, {point.y:.2f})"
