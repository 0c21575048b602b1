"""The contract of an explorer: a plain object that is told what happens and says what to do.

`Explorer.run` is a generator. It yields actions and is sent back their outcomes. It does no
input or output, reads no clock but the one it is told, and cannot reach the world: it knows its
scans and its own configuration, and that is all. The same explorer can be driven by the
simulation, by a test by hand, or by a real robot.

=============  ==========================================  =====================
action         what is done                                what is sent back
=============  ==========================================  =====================
`Sense`        the range finder looks round                `Scan`
`Move`         the body follows a trajectory               `Moved`
`Note`         an event is put on record                   None
`Done`         nothing more; the robot stays where it is   (nothing: the last)
=============  ==========================================  =====================
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import Protocol

from numpy.random import Generator as RandomGenerator

from multisrt.events import AnyEvent
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.footprint import Footprint
from multisrt.geometry.scan import Scan
from multisrt.planners.motion.kinematics import Kinematics
from multisrt.planners.motion.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class Sense:
    """Look round from where the robot stands."""


@dataclass(frozen=True, slots=True)
class Move:
    """Follow a trajectory, which begins where the robot is."""

    trajectory: Trajectory


@dataclass(frozen=True, slots=True)
class Note:
    """Put an event on record. It changes nothing and takes no time."""

    event: AnyEvent


@dataclass(frozen=True, slots=True)
class Done:
    """The robot has finished.

    Attributes
    ----------
    complete : bool
        Whether all that it knew how to explore is explored.
    reason : str
        Why it ended, in words.
    frontier : tuple of (x0, y0, x1, y1)
        What frontier it leaves open.
    """

    complete: bool
    reason: str
    frontier: tuple[tuple[float, float, float, float], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Moved:
    """Where and when a motion ended."""

    configuration: Configuration
    time_s: float


Action = Sense | Move | Note | Done
Outcome = Scan | Moved | None


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSelf:
    """What a robot knows of itself before it begins.

    Attributes
    ----------
    robot : int
        Its number, from 0.
    start : Configuration
        Where it stands.
    footprint : Footprint
        Its body.
    kinematics : Kinematics
        How it moves.
    range_m : float
        How far its range finder reaches.
    rng : numpy.random.Generator
        Its own stream of random numbers.
    """

    robot: int
    start: Configuration
    footprint: Footprint
    kinematics: Kinematics
    range_m: float
    rng: RandomGenerator


class Explorer(Protocol):
    """What decides for one robot."""

    def run(self) -> Generator[Action, Outcome, None]:
        """Yield actions and be sent their outcomes; the last action is `Done`."""
        ...
