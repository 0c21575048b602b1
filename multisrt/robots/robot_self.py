"""What a robot knows of itself before it begins: its number, body, sensor and radio."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from numpy.random import Generator as RandomGenerator

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.kinematics import Kinematics


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioSelf:
    """The data sheet of a robot's radio.

    Attributes
    ----------
    range_m : float
        Range in the open, in metres; inf: unlimited.
    latency_s : float
        Maximum time that a message takes; one that has not come by then never comes.
    loss : float
        Share of messages that are lost, from 0 to 1.
    multi_hop : bool
        Whether robots in between relay messages.
    reaches_all : bool
        Whether every message reaches every robot: nothing limits the range, blocks the radio, or
        loses messages.
    walls_matter : bool
        Whether walls break links, or shorten them.
    """

    range_m: float = float("inf")
    latency_s: float = 0.0
    loss: float = 0.0
    multi_hop: bool = True
    reaches_all: bool = True
    walls_matter: bool = False


class RadioMember(Protocol):
    """What takes part in the radio traffic of a team: a robot, or the base station."""

    @property
    def robot(self) -> int:
        """Its number."""

    @property
    def team(self) -> int:
        """Number of robots in the team."""

    @property
    def base(self) -> tuple[float, float] | None:
        """Where the base station is; None if there is none."""

    @property
    def radio(self) -> RadioSelf:
        """What its radio can do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseSelf:
    """The data of a base station before it begins.

    Attributes
    ----------
    team : int
        Number of robots in the team. It is also the number of the base station, as robots count
        from 0.
    base : (x, y)
        Where it is, in metres.
    radio : RadioSelf
        What its radio can do.

    Examples
    --------
    >>> BaseSelf(team=3, base=(0.0, 0.0)).robot
    3
    """

    team: int
    base: tuple[float, float]
    radio: RadioSelf = RadioSelf()

    @property
    def robot(self) -> int:
        """Its number among all that take part in the radio traffic."""
        return self.team


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSelf:
    """The data of a robot before it begins.

    Attributes
    ----------
    robot : int
        Its number, from 0.
    start : Configuration
        Its configuration at the beginning.
    footprint : Footprint
        The outline of its body about the reference point.
    kinematics : Kinematics
        How it moves.
    range_m : float
        Sensing range in metres.
    rng : numpy.random.Generator
        Its own stream of random numbers: the only source of chance, so that runs are repeatable.
    team : int
        Number of robots in the team, this one included.
    radio : RadioSelf
        What its radio can do.
    base : (x, y) or None
        Where the base station is, in metres; None if there is none. In messages the number of the
        base station is `team`.
    time_s : float
        When it begins.
    limit_s : float
        When the run ends at the latest; inf: it has no limit.
    team_range_m : float or None
        Maximum sensing range in the team; None: its own.
    orders : object
        What the plan of a strategy that sees the truth wants it to do; None for all others.

    Examples
    --------
    >>> import numpy as np
    >>> from multisrt.planners.motion.kinematics import Differential
    >>> me = RobotSelf(
    ...     robot=0,
    ...     start=Configuration(1.0, 1.0),
    ...     footprint=Footprint.disc(0.25),
    ...     kinematics=Differential(),
    ...     range_m=4.0,
    ...     rng=np.random.default_rng(0),
    ... )
    >>> me.team, me.max_range_m
    (1, 4.0)
    """

    robot: int
    start: Configuration
    footprint: Footprint
    kinematics: Kinematics
    range_m: float
    rng: RandomGenerator
    team: int = 1
    radio: RadioSelf = RadioSelf()
    base: tuple[float, float] | None = None
    time_s: float = 0.0
    limit_s: float = float("inf")
    team_range_m: float | None = None
    orders: object = None

    @property
    def max_range_m(self) -> float:
        """Maximum sensing range in the team, in metres."""
        return self.range_m if self.team_range_m is None else self.team_range_m
