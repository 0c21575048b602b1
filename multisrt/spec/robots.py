"""One robot of a team: its body, its drive and its range finder."""

from __future__ import annotations

import math
from typing import Literal

import msgspec

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.beams import MIN_BEAMS, sure_reach
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic, Kinematics
from multisrt.spec.part import Part

MIN_RANGE_M, MAX_RANGE_M = 0.01, 1e6
"""Bounds of the range of a range finder, in metres."""

TURNING_RADIUS_M = 0.6
"""Default turning radius of a car, in metres."""

MAX_BEAMS = 100_000
"""Maximum number of beams of a laser; far more would exhaust the memory."""


class DriveSpec(Part, frozen=True, kw_only=True):
    """The drive of a robot: its kinematics and speeds.

    Attributes
    ----------
    kind : {"differential", "holonomic", "reeds-shepp", "dubins"}
        A differential drive turns in place and drives along its heading; a holonomic one drives
        in any direction and keeps its heading; a Reeds-Shepp car drives forwards and backwards, a
        Dubins car forwards only.
    speed_m_s : float
        The maximum speed in m/s.
    turn_rate_rad_s : float
        The maximum turn rate of a differential drive in rad/s.
    turning_radius_m : float
        The minimum turning radius of a car in metres; other drives have none.

    Raises
    ------
    InvalidInputError
        If a number is not positive and finite, or a turning radius is given for a drive other than
        a car.

    Examples
    --------
    >>> DriveSpec(kind="dubins", turning_radius_m=0.4).kinematics().reverse
    False
    """

    kind: Literal["differential", "holonomic", "reeds-shepp", "dubins"] = "differential"
    speed_m_s: float = 0.5
    turn_rate_rad_s: float = math.pi / 2
    turning_radius_m: float = TURNING_RADIUS_M

    def __post_init__(self) -> None:
        Differential(speed_m_s=self.speed_m_s, turn_rate_rad_s=self.turn_rate_rad_s)
        Car(speed_m_s=self.speed_m_s, turning_radius_m=self.turning_radius_m)
        if self.turning_radius_m != TURNING_RADIUS_M and not self.is_car:
            raise InvalidInputError(
                f"a {self.kind} drive has no turning radius: leave out turning_radius_m, or "
                "choose a car (reeds-shepp or dubins)"
            )

    @property
    def is_car(self) -> bool:
        """Whether it has a turning radius, and therefore cannot turn in place."""
        return self.kind in ("reeds-shepp", "dubins")

    def kinematics(self) -> Kinematics:
        """Return the kinematics described by this spec.

        Returns
        -------
        Holonomic, Differential or Car
            The kinematics, with the limits of this drive.

        Examples
        --------
        >>> DriveSpec(speed_m_s=1.0, turn_rate_rad_s=0.5).kinematics()
        Differential(speed_m_s=1.0, turn_rate_rad_s=0.5)
        """
        if self.kind == "holonomic":
            return Holonomic(speed_m_s=self.speed_m_s)
        if self.kind == "differential":
            return Differential(speed_m_s=self.speed_m_s, turn_rate_rad_s=self.turn_rate_rad_s)
        return Car(
            speed_m_s=self.speed_m_s,
            turning_radius_m=self.turning_radius_m,
            reverse=self.kind == "reeds-shepp",
        )


class RangeFinderSpec(Part, frozen=True, kw_only=True):
    """The range finder of a robot.

    Attributes
    ----------
    range_m : float
        Its range in metres (paper: R_p), from 0.01 to 1e6.
    beams : int or None
        Number of beams of a laser, from 5 to 100,000; None for the exact visibility polygon.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    Examples
    --------
    >>> RangeFinderSpec(range_m=3.0, beams=180).beams
    180
    """

    range_m: float = 4.0
    beams: int | None = None

    def __post_init__(self) -> None:
        if not MIN_RANGE_M <= self.range_m <= MAX_RANGE_M:
            raise InvalidInputError(
                "the range of a range finder is a positive number of metres, from "
                f"{MIN_RANGE_M:g} to {MAX_RANGE_M:g}, not {self.range_m:g}"
            )
        if self.beams is not None and not MIN_BEAMS <= self.beams <= MAX_BEAMS:
            raise InvalidInputError(
                f"a laser has {MIN_BEAMS} to {MAX_BEAMS} beams, not {self.beams}"
            )

    @property
    def free_reach_m(self) -> float:
        """Radius of the free space that it shows around itself far from obstacles, in metres.

        A laser shows less than its range, because obstacles may lie between its beams; with very
        few beams it shows none, and the value is 0 or less.
        """
        return self.range_m if self.beams is None else sure_reach(self.range_m, self.beams)


class RobotSpec(Part, frozen=True, kw_only=True):
    """One robot.

    Attributes
    ----------
    start : (x, y) or (x, y, heading) or None
        Its start, in metres and radians; None: it is placed by the run, see `RunSpec.starts`.
    footprint : str
        Its body, in the notation of `Footprint.parse`: ``disc:0.25``, ``box:0.5x0.3`` or
        ``polygon:x,y x,y x,y``.
    drive : DriveSpec
        Its drive.
    range_finder : RangeFinderSpec
        Its range finder.

    Raises
    ------
    InvalidInputError
        If the footprint is invalid, the start is not finite, or the range finder shows no more
        free space than the body occupies, in which case the robot could not move.

    Examples
    --------
    >>> RobotSpec(start=(1, 2), footprint="box:0.5x0.3").start
    (1.0, 2.0)
    """

    start: tuple[float, ...] | None = None
    footprint: str = "disc:0.25"
    drive: DriveSpec = DriveSpec()
    range_finder: RangeFinderSpec = RangeFinderSpec()

    def __post_init__(self) -> None:
        body_m = Footprint.parse(self.footprint).circumscribed_radius_m
        shown_m = self.range_finder.free_reach_m
        if shown_m <= body_m:
            beams = self.range_finder.beams
            sensor = "range finder" if beams is None else f"laser of {beams} beams"
            raise InvalidInputError(
                f"a {sensor} with a range of {self.range_finder.range_m:g} m shows free space only "
                f"{max(0.0, shown_m):.3g} m around, and the body {self.footprint} needs "
                f"{body_m:.3g} m: it would see no way to move; give it a longer range"
                + ("" if beams is None else " or more beams")
            )
        if self.start is None:
            return
        if len(self.start) not in (2, 3):
            raise InvalidInputError(f"a start is (x, y) or (x, y, heading), not {self.start!r}")
        numbers = tuple(map(float, self.start))
        if not all(map(math.isfinite, numbers)):
            raise InvalidInputError(f"a start is finite, not {numbers}")
        msgspec.structs.force_setattr(self, "start", numbers)
