"""Right of way: who goes on where robots meet.

Source: J. A. Álvarez Jáuregui, "Algoritmo descentralizado para la exploración multi-robot de
escenarios 2D" (2018), section 3.2.7 and Algorithm 5. A robot looks into a sector about its
heading; a mate in it makes it wait, unless that mate is inactive. Face to face the first to see
the other becomes the leader and goes on, the others wait, and the leader's flag falls when its
sector is clear. Differs in what the rules leave open:

- *Face to face* is whoever waits for one another, also three in a ring; each such group has one
  leader, of two that raise their flag at once the one with the lower number.
- A mate that stands where the own path leads is seen also outside the sector.
- A leader goes round those that stand in its way. Where it finds no way round, they leave its
  path (`place_aside`); who has no place to go to becomes the leader itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np

from multisrt.geometry.configuration import Configuration, wrap_angle
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.distances import distance_to_segments
from multisrt.geometry.numerics.kernel import FloatArray

SECTOR_RAD: Final = math.radians(15.0)
"""How far to either side of its heading a robot looks for mates."""

NEARER_M: Final = 1e-6
"""A way that leads to a mate by less does not."""

Action = Literal["go", "wait", "detour", "retreat"]
"""Go on; stand until the others are gone; plan a way round those that stand in the way; leave
the leader's path."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Party:
    """A robot that meets others, as all of them know it.

    Attributes
    ----------
    robot : int
        Its number.
    configuration : Configuration
        Where it is; its heading is where it goes or wants to go.
    path : (k, 2) array
        What is left of its path, from where it is on; a single place if it has none.
    radius_m : float
        Radius of its body.
    leader : bool
        Whether it has raised its flag.
    inactive : bool
        Whether it has finished or is lost: an obstacle, no more.
    stuck : bool
        Whether it found no way round those that stand in its way.
    cornered : bool
        Whether it found no place off the leader's path.
    """

    robot: int
    configuration: Configuration
    path: FloatArray
    radius_m: float
    leader: bool = False
    inactive: bool = False
    stuck: bool = False
    cornered: bool = False


class Ruling(NamedTuple):
    """What a robot is to do, and why.

    Attributes
    ----------
    action : str
        What.
    leader : bool
        Whether its flag is up from now on.
    because_of : tuple of int
        The robots that it waits for, goes round, or gives way to, in ascending order.
    """

    action: Action
    leader: bool
    because_of: tuple[int, ...]


def right_of_way(
    me: Party,
    others: Sequence[Party],
    conflict_radius_m: float,
    *,
    margin_m: float = 0.0,
    sector_rad: float = SECTOR_RAD,
) -> Ruling:
    """Decide whether a robot goes on.

    Parameters
    ----------
    me : Party
        The robot that decides: the first to do so sees first.
    others : sequence of Party
        The mates that it knows of, in any order.
    conflict_radius_m : float
        How far ahead mates matter.
    margin_m : float
        What shall stay free between two bodies.
    sector_rad : float
        Half of the opening of the sector.

    Raises
    ------
    InvalidInputError
        If two robots have the same number.
    """
    team = sorted((me, *others), key=lambda party: party.robot)
    if len({party.robot for party in team}) < len(team):
        raise InvalidInputError(
            f"robots have numbers of their own, not {[party.robot for party in team]}"
        )

    def blocks(party: Party, mate: Party) -> bool:
        near = party.radius_m + mate.radius_m + margin_m
        return stands_in_the_way(party.path, mate.configuration, near, conflict_radius_m)

    def sees(party: Party, mate: Party) -> bool:
        return party is not mate and (
            is_in_sector(party.configuration, mate.configuration, conflict_radius_m, sector_rad)
            or blocks(party, mate)
        )

    # 1. An inactive mate is an obstacle: it matters where it stands in the way.
    active = [party for party in team if not party.inactive]
    seen = [mate for mate in active if sees(me, mate)]
    parked = [mate for mate in team if mate.inactive and mate is not me and blocks(me, mate)]
    if not seen:
        return Ruling("detour" if parked else "go", False, _numbers(parked))

    # 2. Mates that do not wait for this one will go by themselves.
    conflict = _conflict(me, active, sees)
    beyond = [mate for mate in seen if mate not in conflict]
    if beyond:
        return Ruling("wait", me.leader and len(conflict) > 1, _numbers(beyond))

    # 3. One leader for each conflict: whoever cannot give way, then who raised its flag, or else
    #    the first to see, which is the one that asks.
    cornered = [party for party in conflict if party.cornered]
    claims = cornered or [party for party in conflict if party.leader] or [me]
    leader = min(claims, key=lambda party: (not party.leader, party.robot))
    if leader is not me:
        gives_way = leader.stuck and blocks(leader, me) and not me.cornered
        return Ruling("retreat" if gives_way else "wait", False, (leader.robot,))

    # 4. The leader goes on, round those that stand in its way, or waits until they have left.
    standing = [mate for mate in conflict if mate is not me and blocks(me, mate)] + parked
    if not standing:
        return Ruling("go", True, ())
    return Ruling("wait" if me.stuck else "detour", True, _numbers(standing))


def is_in_sector(
    at: Configuration, mate: Configuration, radius_m: float, half_opening_rad: float = SECTOR_RAD
) -> bool:
    """Whether a mate is in the sector that a robot looks into."""
    distance = at.distance(mate)
    if not 0.0 < distance <= radius_m:
        return False
    bearing = math.atan2(mate.y - at.y, mate.x - at.x)
    return abs(wrap_angle(bearing - at.heading)) <= half_opening_rad


def stands_in_the_way(
    path: FloatArray, mate: Configuration, near_m: float, within_m: float = math.inf
) -> bool:
    """Whether a path leads nearer to a mate than it may, and nearer than where it begins.

    So a robot that is close to a mate can leave it, and one that has passed another is no more
    in its way.

    Parameters
    ----------
    path : (k, 2) array
        The path, from where the robot is on.
    mate : Configuration
        Where the mate is.
    near_m : float
        How near the two reference points may come.
    within_m : float
        Only so much of the path counts.
    """
    here = np.array([[mate.x, mate.y]])
    legs = _legs(path, within_m)
    nearest = float(distance_to_segments(here, legs)[0])
    at_first = math.hypot(legs[0, 0] - mate.x, legs[0, 1] - mate.y)
    return nearest < near_m and nearest < at_first - NEARER_M


def place_aside(
    places: FloatArray, costs: FloatArray, leader_path: FloatArray, apart_m: float
) -> tuple[float, float] | None:
    """Choose where to let the leader pass: the nearest place off its path.

    Parameters
    ----------
    places : (n, 2) array
        Places that the robot can reach without passing the leader, such as centres of cells.
    costs : (n,) array
        How long its way to each is; inf where there is none.
    leader_path : (k, 2) array
        What is left of the leader's path, from where it is on.
    apart_m : float
        How far the place is from that path at least: both radii, and what shall stay free
        between the bodies.

    Returns
    -------
    (x, y) or None
        The place, of equally near ones the first; None where there is none.
    """
    places = np.ascontiguousarray(places, dtype=np.float64)
    clear = distance_to_segments(places, _legs(leader_path)) >= apart_m
    wanted = np.where(clear, costs, np.inf)
    if not np.isfinite(wanted).any():
        return None
    x, y = places[int(np.argmin(wanted))].tolist()
    return x, y


def _conflict(me: Party, active: list[Party], sees: Callable[[Party, Party], bool]) -> list[Party]:
    # Who waits for this robot and is waited for by it, itself included, also through others.
    def reached(forwards: bool) -> list[Party]:
        found = [me]
        for party in found:
            found += [
                mate
                for mate in active
                if mate not in found and (sees(party, mate) if forwards else sees(mate, party))
            ]
        return found

    waited_for = reached(forwards=True)
    return [party for party in reached(forwards=False) if party in waited_for]


def _legs(path: FloatArray, within_m: float = math.inf) -> FloatArray:
    # The legs of a path, or of as much of it as counts; a single place is a leg of no length.
    legs = np.hstack([path[:-1], path[1:]]) if len(path) > 1 else np.hstack([path, path])
    lengths = np.hypot(legs[:, 2] - legs[:, 0], legs[:, 3] - legs[:, 1])
    begins = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    legs, lengths, begins = legs[begins < within_m], lengths, begins[begins < within_m]
    left = within_m - begins[-1]
    if left < lengths[len(legs) - 1]:
        share = left / lengths[len(legs) - 1]
        legs[-1, 2:] = legs[-1, :2] + share * (legs[-1, 2:] - legs[-1, :2])
    return np.ascontiguousarray(legs)


def _numbers(parties: Sequence[Party]) -> tuple[int, ...]:
    return tuple(sorted(party.robot for party in parties))
