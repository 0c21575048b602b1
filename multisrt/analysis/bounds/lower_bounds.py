"""The lower bounds of the time that a team needs to see a share of what it can explore."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import shapely

from multisrt.analysis.bounds.reach import Places, reach_s
from multisrt.analysis.bounds.team import Member
from multisrt.analysis.bounds.witnesses import witness_s
from multisrt.environments.environment import Environment
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import RunSpec

AREA_ERROR: Final = 1e-4
"""Error of measured areas as a share of the explorable area; a team whose measured share is 1 may
have left this much unseen."""


class Task(Protocol):
    """What a team is to see, as `multisrt.analysis.explorable.Explorable` is."""

    @property
    def area_m2(self) -> float:
        """The area of all that is to be seen, in square metres."""

    @property
    def reachable(self) -> Places:
        """The places that bodies can reach, in metres; part of what is to be seen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LowerBounds:
    """Times in seconds before which no team can have seen a share of what it can explore.

    Attributes
    ----------
    reach_s : float
        From what is far away; see `multisrt.analysis.bounds.reach`.
    area_s : float
        From how much there is; see `lower_bounds`.
    witness_s : float or None
        From places no two of which are seen at once; see `multisrt.analysis.bounds.witnesses`.
        None if it was not asked for.
    """

    reach_s: float
    area_s: float
    witness_s: float | None

    @property
    def largest_s(self) -> float:
        """The largest of them, which bounds as each of them does."""
        return max(self.reach_s, self.area_s, self.witness_s or 0.0)


def lower_bounds(
    spec: RunSpec,
    environment: Environment,
    what: Task,
    starts: Sequence[Configuration],
    share: float = 1.0,
    *,
    witnesses: bool = False,
) -> LowerBounds:
    """Return times before which no team can have seen a share of what it can explore.

    **Statement.** Let the robots of a team start anywhere within their components of free space
    as given, move through places where their bodies have room at no more than their speeds, and
    see of the world what their range finders show from there, at any time. If at a time t the
    union of what they have seen is at least the share of the explorable area, less `AREA_ERROR`
    of it, then t is at least each of the bounds. It holds for robots that know the map, and so
    for every strategy; for robots that start late, stand still or die; for each time at which a
    share is covered, as what is covered has been seen; and for the makespan of a run that has
    covered the share in the end. It says nothing of a robot that claims to be done before.

    Parameters
    ----------
    spec : RunSpec
        The team.
    environment : Environment
        The world.
    what : Explorable
        What the team can explore; only its area and the places that bodies can reach count.
    starts : sequence of Configuration
        Where its robots start.
    share : float, default 1.0
        The share of the explorable area, from 0 to 1.
    witnesses : bool, default False
        Whether to compute the bound from witnesses. It takes about a second for a world that
        has not been asked for before, and a tenth of one for other starts or shares.

    Returns
    -------
    LowerBounds
        Each falls with the share.

    Raises
    ------
    InvalidInputError
        If the share is not from 0 to 1.

    Notes
    -----
    **Area.** While a robot moves from x to x', at a distance d, its disc of range R takes in at
    most 2 R d more area: the disc around x' without that around x is no larger. So all that it
    has seen after a path of length l is in a set whose area is at most that of its first disc and
    2 R l more. What is seen at all is in free space; so the robots together have seen no more
    than the free part of the union of their first discs, and the sum of 2 R v t. A laser shows
    nothing beyond its range either.

    Examples
    --------
    A robot with a range of 4 m in the middle of a hall of 20 x 20 m, at half a metre a second:

    >>> import shapely
    >>> from multisrt.analysis.explorable import explorable, viewers
    >>> from multisrt.simulation.worlds import inline
    >>> from multisrt.spec import RobotSpec
    >>> hall = Environment("hall", shapely.box(0, 0, 20, 20))
    >>> spec = RunSpec(environment=inline(hall), robots=(RobotSpec(start=(10, 10)),))
    >>> starts = (Configuration(10.0, 10.0),)
    >>> what = explorable(hall, viewers(spec, starts))
    >>> bounds = lower_bounds(spec, hall, what, starts)
    >>> round(bounds.area_s, 1), round((400 - 16 * math.pi) / (8 * 0.5), 1)
    (87.4, 87.4)
    >>> 0.9 < bounds.reach_s / ((math.hypot(10, 10) - 4) / 0.5) < 1.0
    True
    """
    if not 0.0 <= share <= 1.0:
        raise InvalidInputError(f"a share of the explorable area is from 0 to 1, not {share}")
    team = tuple(Member.of(robot, start) for robot, start in zip(spec.robots, starts, strict=True))
    unseen_m2 = (1.0 - share + AREA_ERROR) * what.area_m2
    return LowerBounds(
        reach_s=reach_s(environment, what.reachable, team, unseen_m2),
        area_s=_area_s(environment, team, what.area_m2 - unseen_m2),
        witness_s=witness_s(environment, what.reachable, team, unseen_m2) if witnesses else None,
    )


def _area_s(environment: Environment, team: Sequence[Member], seen_m2: float) -> float:
    # Polygons around the discs, so as to hold them.
    segments = 64
    around = 1.0 / math.cos(0.25 * math.pi / segments)
    discs = shapely.union_all(
        [
            shapely.Point(*member.start).buffer(around * member.range_m, quad_segs=segments)
            for member in team
        ]
    )
    at_once = float(shapely.area(shapely.intersection(discs, environment.free)))
    per_second = math.fsum(2.0 * member.range_m * member.speed_m_s for member in team)
    return max(0.0, seen_m2 - at_once) / per_second
