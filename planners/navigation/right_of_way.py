"""Right of way: which of several robots that meet continues.

Source: J. A. Álvarez Jáuregui, "Algoritmo descentralizado para la exploración multi-robot de
escenarios 2D" (2018), section 3.2.7 and Algorithm 5. A robot looks into a sector about its
heading; another robot in it makes it wait, unless that robot is inactive. Face to face, the first
to see the other becomes the leader and continues, the others wait, and the leader's flag falls when
its sector is clear. Differs in what the rules leave open:

- *Face to face* are robots that wait for each other, also three in a ring. Each such group has one
  leader (`leader_of`).
- A robot that stands on the path is seen also outside the sector (`stands_in_the_way`).
- A robot that is asked to leave the leader's path goes to a place aside (`place_aside`); one that
  finds no such place leads instead (`Claim`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.distances import distance_to_segments
from multisrt.planners.navigation.sector import SECTOR_RAD, is_in_sector

NEARER_M: Final = 1e-6
"""A path approaches a robot only if it comes nearer than its beginning by more than this."""


class Claim(NamedTuple):
    """What decides which robot of a conflict leads.

    Attributes
    ----------
    robot : int
        Number of the robot.
    leader : bool
        Whether it has raised its flag.
    cornered : bool
        Whether it has found no place off the leader's path.
    """

    robot: int
    leader: bool = False
    cornered: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Party:
    """A robot that meets others, as all of them know it.

    Attributes
    ----------
    robot : int
        Its number.
    configuration : Configuration
        Where it is; its heading is the direction in which it goes or wants to go.
    path : (k, 2) array
        The rest of its path in metres, from its position on; a single point if it has none.
    radius_m : float
        Radius of its body in metres.
    leader : bool
        Whether it has raised its flag.
    inactive : bool
        Whether it has finished or is presumed lost, so that no robot waits for it.
    """

    robot: int
    configuration: Configuration
    path: FloatArray
    radius_m: float
    leader: bool = False
    inactive: bool = False

    @property
    def claim(self) -> Claim:
        """Its claim to lead."""
        return Claim(self.robot, self.leader)


class Ruling(NamedTuple):
    """Whether a robot waits, and whether it leads.

    Attributes
    ----------
    leader : bool
        Whether its flag is raised from now on.
    waits_for : tuple of int
        Numbers of the robots that it waits for, ascending; without any, it continues.
    """

    leader: bool
    waits_for: tuple[int, ...] = ()


def right_of_way(
    me: Party,
    others: Sequence[Party],
    conflict_radius_m: float,
    *,
    margin_m: float = 0.0,
    sector_rad: float = SECTOR_RAD,
) -> Ruling:
    """Decide whether a robot continues.

    Parameters
    ----------
    me : Party
        The robot that decides. If no flag is raised in its conflict, it is the first to see.
    others : sequence of Party
        The robots that it knows of, in any order.
    conflict_radius_m : float
        Radius of the sector, and length of the path ahead, in which robots matter, in metres.
    margin_m : float
        Distance to keep between two bodies in metres.
    sector_rad : float
        Half of the sector's opening angle in radians.

    Returns
    -------
    Ruling

    Raises
    ------
    InvalidInputError
        If two robots have the same number.

    Examples
    --------
    Two robots in neighbouring lanes, face to face: the first to decide leads.

    >>> lanes = np.array([[0.0, 0.0], [8.0, 0.0]]), np.array([[2.9, 0.7], [-6.0, 0.7]])
    >>> east = Party(robot=1, configuration=Configuration(0.0, 0.0, 0.0), path=lanes[0],
    ...              radius_m=0.25)
    >>> west = Party(robot=2, configuration=Configuration(2.9, 0.7, np.pi), path=lanes[1],
    ...              radius_m=0.25, leader=True)
    >>> right_of_way(east, [west], 3.0)
    Ruling(leader=False, waits_for=(2,))
    >>> right_of_way(west, [east], 3.0)
    Ruling(leader=True, waits_for=())
    """
    meeting = _Meeting(me, others, conflict_radius_m, margin_m, sector_rad)
    seen = meeting.seen()
    if not seen:
        return Ruling(leader=False)
    conflict = meeting.conflict()
    # Robots that do not wait for this one will continue their own.
    passing = [teammate.robot for teammate in seen if teammate not in conflict]
    if passing:
        return Ruling(me.leader and len(conflict) > 1, tuple(passing))
    number = leader_of(party.claim for party in conflict)
    if number is None or number == me.robot:
        return Ruling(leader=True)
    return Ruling(leader=False, waits_for=(number,))


def leader_of(claims: Iterable[Claim]) -> int | None:
    """Return which robot of a conflict leads.

    A robot that has found no place off the leader's path leads before one that has raised its
    flag. Of several such robots one with its flag raised leads, then the one of the lowest number.

    Parameters
    ----------
    claims : iterable of Claim
        The claims of all robots in the conflict.

    Returns
    -------
    int or None
        Number of the leader; None if no robot is cornered or has raised its flag. The first to see
        the others then becomes the leader.

    Examples
    --------
    >>> leader_of([Claim(3, leader=True), Claim(5, leader=True), Claim(1)])
    3
    >>> leader_of([Claim(3, leader=True), Claim(5, cornered=True)])
    5
    >>> leader_of([Claim(3), Claim(5)]) is None
    True
    """
    conflict = list(claims)
    claimants = [c for c in conflict if c.cornered] or [c for c in conflict if c.leader]
    leader = min(claimants, key=lambda claim: (not claim.leader, claim.robot), default=None)
    return None if leader is None else leader.robot


def stands_in_the_way(
    path: FloatArray, teammate: Configuration, near_m: float, within_m: float = math.inf
) -> bool:
    """Whether a path approaches another robot more closely than allowed.

    A path that only leads away from the robot does not approach it, even if it begins too near. So
    a robot can leave another that it stands close to, and is not held up by one it has passed.

    Parameters
    ----------
    path : (k, 2) array
        The path in metres, from the robot's position on.
    teammate : Configuration
        Configuration of the other robot.
    near_m : float
        Minimum distance between the two reference points in metres.
    within_m : float
        Length of the path that counts, in metres.

    Returns
    -------
    bool

    Examples
    --------
    >>> path = np.array([[0.0, 0.0], [5.0, 0.0]])
    >>> stands_in_the_way(path, Configuration(3.0, 0.4, 0.0), 0.6)
    True
    >>> stands_in_the_way(path, Configuration(-0.1, 0.4, 0.0), 0.6)
    False
    """
    here = np.array([[teammate.x, teammate.y]])
    legs = _legs(path, within_m)
    nearest = float(distance_to_segments(here, legs)[0])
    at_first = math.hypot(legs[0, 0] - teammate.x, legs[0, 1] - teammate.y)
    return nearest < near_m and nearest < at_first - NEARER_M


def place_aside(
    places: FloatArray, costs: FloatArray, leader_path: FloatArray, apart_m: float
) -> tuple[float, float] | None:
    """Return the place from which to let the leader pass: the nearest off its path.

    Parameters
    ----------
    places : (n, 2) array
        Places in metres that the robot can reach without passing the leader, such as the centres
        of cells.
    costs : (n,) array
        Path length to each in metres; ``inf`` where there is no path.
    leader_path : (k, 2) array
        The rest of the leader's path, from its position on.
    apart_m : float
        Minimum distance of the place from that path in metres: both radii and the margin.

    Returns
    -------
    (x, y) or None
        The place, the first of equally near ones; None if there is none.

    Examples
    --------
    >>> places = np.array([[3.0, 0.5], [4.0, 0.6], [5.0, 2.0]])
    >>> path = np.array([[0.0, 0.0], [8.0, 0.0]])
    >>> place_aside(places, np.array([0.5, 3.0, 1.5]), path, 0.6)
    (5.0, 2.0)
    """
    places = np.ascontiguousarray(places, dtype=np.float64)
    clear = distance_to_segments(places, _legs(leader_path)) >= apart_m
    wanted = np.where(clear, costs, np.inf)
    if not np.isfinite(wanted).any():
        return None
    x, y = places[int(np.argmin(wanted))].tolist()
    return x, y


class _Meeting:
    """Which robots see, block and wait for each other around one robot."""

    def __init__(
        self,
        me: Party,
        others: Sequence[Party],
        conflict_radius_m: float,
        margin_m: float,
        sector_rad: float,
    ) -> None:
        self._me = me
        team = sorted((me, *others), key=lambda party: party.robot)
        self._active = [party for party in team if not party.inactive]
        self._radius_m, self._margin_m, self._sector_rad = conflict_radius_m, margin_m, sector_rad
        numbers = [party.robot for party in team]
        if len(set(numbers)) < len(numbers):
            raise InvalidInputError(f"robots have numbers of their own, not {numbers}")

    def blocks(self, party: Party, teammate: Party) -> bool:
        """Whether `teammate` stands on the path of `party`."""
        near_m = party.radius_m + teammate.radius_m + self._margin_m
        return stands_in_the_way(party.path, teammate.configuration, near_m, self._radius_m)

    def sees(self, party: Party, teammate: Party) -> bool:
        """Whether `party` waits for `teammate`: it is in the sector or on the path."""
        at, there = party.configuration, teammate.configuration
        return party is not teammate and (
            is_in_sector(at, there, self._radius_m, self._sector_rad)
            or self.blocks(party, teammate)
        )

    def seen(self) -> list[Party]:
        """Return the active robots that this one sees."""
        return [teammate for teammate in self._active if self.sees(self._me, teammate)]

    def conflict(self) -> list[Party]:
        """Return the robots that this one waits for and that wait for it, also through others."""
        waited_for = self._reached(self.sees)
        waiting = self._reached(lambda party, teammate: self.sees(teammate, party))
        return [party for party in waiting if party in waited_for]

    def _reached(self, leads_to: Callable[[Party, Party], bool]) -> list[Party]:
        found = [self._me]
        for party in found:
            found += [
                other for other in self._active if other not in found and leads_to(party, other)
            ]
        return found


def _legs(path: FloatArray, within_m: float = math.inf) -> FloatArray:
    """Return the legs of a path up to a length; a single point is a leg of length 0."""
    legs = np.hstack([path[:-1], path[1:]]) if len(path) > 1 else np.hstack([path, path])
    lengths = np.hypot(legs[:, 2] - legs[:, 0], legs[:, 3] - legs[:, 1])
    begins = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    legs, lengths, begins = (
        legs[begins < within_m],
        lengths[begins < within_m],
        begins[begins < within_m],
    )
    remaining = within_m - begins[-1]
    if remaining < lengths[len(legs) - 1]:
        share = remaining / lengths[len(legs) - 1]
        legs[-1, 2:] = legs[-1, :2] + share * (legs[-1, 2:] - legs[-1, :2])
    return np.ascontiguousarray(legs)
