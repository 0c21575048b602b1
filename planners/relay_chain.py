"""Places of relays that link the place to which a robot goes with the base station.

The relays stand on the path from the base station to that place. Each stands at the last place of
the path that is certain to be linked with the one before, until the end of the path is linked; if
there is one shortly before where others can pass it, and the relays suffice, it stands there. The
greedy placement at last places uses the fewest relays if links reach up to a fixed distance along
the path. If the path is extended, its first relays stay where they are, so that they stand while
the front advances.

Source: M. N. Rooker and A. Birk, Multi-robot exploration under the constraints of wireless
networking, Control Engineering Practice 15 (2007), where robots go to frontiers only together with
a chain of others to the base station; Y. Pei, M. W. Mutka and N. Xi, Coordinated multi-robot
real-time exploration with connectivity and bandwidth awareness, ICRA 2010, where relays are placed
for a front by a Steiner minimum tree with bounded edges. Differs in: there is one front at a time,
so the tree is a path, and its relays are placed greedily along the path home and not anywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from multisrt.geometry.numerics.arrays import BoolArray, FloatArray

Place = tuple[float, float]

Linked = Callable[[FloatArray, Place], BoolArray]
"""Returns which of some places ``(n, 2)`` are certain to be linked with a place."""

Roomy = Callable[[FloatArray], BoolArray]
"""Returns at which of some places ``(n, 2)`` a robot that stands there can be passed."""

BACK_M = 3.0
"""Maximum distance in metres along the path by which a relay stands nearer for the sake of room."""

NEAR_PATH_M = 1.0
"""Maximum distance in metres between the path and a relay that keeps its place."""


def relay_places(
    path: FloatArray,
    base: Place,
    linked: Linked,
    *,
    max_relays: int,
    kept: Sequence[Place] = (),
    clear_of: Place | None = None,
    clear_m: float = 0.0,
    roomy: Roomy | None = None,
) -> tuple[Place, ...] | None:
    """Return the places of relays that link the end of a path with the base station.

    Parameters
    ----------
    path : (n, 2) array
        Places along the path in metres, the first linked with the base station.
    base : (x, y)
        Where the base station is, in metres.
    linked : callable
        Returns which places are linked with a place.
    max_relays : int
        Number of relays available.
    kept : sequence of (x, y)
        Present places of relays, from the base station on. The first of them are kept as long as
        each is linked with the one before and the path passes it.
    clear_of : (x, y), optional
        Present place of the front in metres.
    clear_m : float
        Distance in metres that new relays keep from the front, if possible.
    roomy : callable, optional
        Returns where relays can be passed: new ones stand there, if such a place is near and the
        relays suffice.

    Returns
    -------
    tuple of (x, y) or None
        The places from the base station on, empty if no relay is needed; None if the relays are
        too few.

    Examples
    --------
    A path of 30 m along a line, links of 9 m, the base station at its beginning:

    >>> path = np.column_stack([np.arange(0.0, 31.0), np.zeros(31)])
    >>> linked = lambda places, at: np.hypot(*(places - at).T) <= 9.0
    >>> relay_places(path, (0.0, 0.0), linked, max_relays=3)
    ((9.0, 0.0), (18.0, 0.0), (27.0, 0.0))
    >>> relay_places(path, (0.0, 0.0), linked, max_relays=2) is None
    True
    >>> relay_places(path[:10], (0.0, 0.0), linked, max_relays=2)
    ()
    """
    for passable in (roomy, None) if roomy is not None else (None,):
        for staying in (kept, ()) if kept else ((),):
            found = _placed(path, base, linked, max_relays, staying, clear_of, clear_m, passable)
            if found is not None:
                return found
    return None


def _placed(
    path: FloatArray,
    base: Place,
    linked: Linked,
    max_relays: int,
    kept: Sequence[Place],
    clear_of: Place | None,
    clear_m: float,
    roomy: Roomy | None,
) -> tuple[Place, ...] | None:
    at, first, places = base, 0, list[Place]()
    while True:
        ahead = linked(path[first:], at)
        if ahead[-1]:
            return tuple(places)
        if len(places) == max_relays:
            return None
        following = None
        if len(places) < len(kept):
            following = _kept(path, at, linked, kept[len(places)], first)
        if following is None:
            if roomy is not None:
                ahead = _up_to_room(path[first:], ahead, roomy, is_first=not places)
            following = _farthest(path, ahead, first, clear_of, clear_m, is_first=not places)
        if following is None:
            return None
        at, first = following
        places.append(at)


def _kept(
    path: FloatArray, at: Place, linked: Linked, place: Place, first: int
) -> tuple[Place, int] | None:
    """Return the place of a relay and the index at which the path passes it, if it is kept."""
    away = np.hypot(*(path[first:] - place).T)
    nearest = int(np.argmin(away))
    if nearest == 0 or away[nearest] > NEAR_PATH_M or not linked(np.array([place]), at)[0]:
        return None
    return place, first + nearest


def _up_to_room(path: FloatArray, ahead: BoolArray, roomy: Roomy, *, is_first: bool) -> BoolArray:
    """Return the linked places up to the last with room among those near the last of all."""
    usable = np.flatnonzero(ahead)
    usable = usable[usable >= (0 if is_first else 1)]
    if not len(usable):
        return ahead
    usable = usable[(usable[-1] - usable) * _spacing(path) <= BACK_M]
    good = usable[roomy(path[usable])]
    if not len(good):
        return ahead
    kept = ahead.copy()
    kept[int(good[-1]) + 1 :] = False
    return kept


def _farthest(
    path: FloatArray,
    ahead: BoolArray,
    first: int,
    clear_of: Place | None,
    clear_m: float,
    *,
    is_first: bool,
) -> tuple[Place, int] | None:
    """Return the last place of the path that is linked, or one clear of the front."""
    usable = np.flatnonzero(ahead)
    if not is_first:
        usable = usable[usable > 0]
    if not len(usable):
        return None
    index = first + int(usable[-1])
    if clear_of is not None:
        off = np.hypot(*(path[first + usable] - clear_of).T) >= clear_m
        off &= np.abs(first + usable - index) * _spacing(path) <= 2.0 * clear_m
        if off.any():
            index = first + int(usable[np.flatnonzero(off)[-1]])
    x, y = path[index].tolist()
    return (x, y), index


def _spacing(path: FloatArray) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).max()) if len(path) > 1 else 0.0
