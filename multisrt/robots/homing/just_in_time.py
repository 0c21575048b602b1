"""Home just in time: whether what a robot carries can still be delivered before the deadline.

A robot turns back as late as possible, but never too late. The travel time of a path of length `d`
is estimated by ``d / speed * (1 + margin)``, plus half a turn at its beginning. The *slack* is the
time left before the deadline, minus the estimated travel time home and the reserve. A robot that
drives away from home loses at most ``2 + margin`` seconds of slack per second: one because time
passes, the others because the path home gets longer. So the slack need not be computed at every
step.

Source: J. de Hoog, S. Cameron and A. Visser, Role-based autonomous multi-robot exploration,
COGNITIVE 2009, where an explorer turns back in time to meet its relay. Differs in: the deadline is
the time limit of the run, the path leads to where the base station hears the robot, and its travel
time has a stated margin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.home_options import HomeOptions
from multisrt.planners.motion.kinematics import Car, Differential
from multisrt.robots.homing.options import EXCHANGE_MESSAGES
from multisrt.robots.robot_self import RobotSelf


class LimitTooShortError(InvalidInputError):
    """The time limit of a run is too short for a robot to deliver data.

    Parameters
    ----------
    message : str
        What is wrong, and the remedy.
    needed_s : int
        Minimum limit for this robot, in seconds.
    """

    def __init__(self, message: str, needed_s: int) -> None:
        super().__init__(message)
        self.needed_s = needed_s


@dataclass(frozen=True, slots=True, kw_only=True)
class JustInTime:
    """Travel times and the deadline of one robot.

    Attributes
    ----------
    limit_s : float
        Time at which the run ends, in seconds; ``inf`` if it has no limit.
    speed_m_s : float
        Speed of the robot in metres per second.
    half_turn_s : float
        Time of half a turn in place, or for a car of half a circle of its minimum radius, in
        seconds.
    margin : float
        Share by which the travel time exceeds that at full speed.
    reserve_s : float
        Time in seconds to be left at home before the deadline.

    Examples
    --------
    >>> time = JustInTime(limit_s=100, speed_m_s=0.5, half_turn_s=2, margin=0.25, reserve_s=10)
    >>> time.travel_time_s(8.0)  # 16 s at full speed, a quarter of that, and half a turn
    22.0
    >>> time.slack_s(60.0, 8.0), time.slack_s(80.0, 8.0)
    (8.0, -12.0)
    """

    limit_s: float
    speed_m_s: float
    half_turn_s: float
    margin: float
    reserve_s: float

    @classmethod
    def of(cls, me: RobotSelf, options: HomeOptions) -> JustInTime:
        """Return the travel-time model of a robot.

        Raises
        ------
        LimitTooShortError
            If the limit is too short to come home from the start of the robot in a straight line.
        """
        drive = me.kinematics
        half_turn_s = 0.0
        if isinstance(drive, Differential):
            half_turn_s = math.pi / drive.turn_rate_rad_s
        elif isinstance(drive, Car):
            half_turn_s = math.pi * drive.turning_radius_m / drive.speed_m_s
        made = cls(
            limit_s=me.limit_s,
            speed_m_s=drive.speed_m_s,
            half_turn_s=half_turn_s,
            margin=options.home_margin,
            reserve_s=options.home_reserve_s + EXCHANGE_MESSAGES * me.radio.latency_s,
        )
        made._require_time(me)
        return made

    @property
    def max_slack_loss_rate(self) -> float:
        """Maximum slack lost per second of driving, in seconds."""
        return 2.0 + self.margin

    def travel_time_s(self, length_m: float, speed_m_s: float | None = None) -> float:
        """Return the estimated travel time of a path of this length in metres, in seconds.

        At the speed of the robot, or that of another one.
        """
        speed_m_s = self.speed_m_s if speed_m_s is None else speed_m_s
        return length_m / speed_m_s * (1.0 + self.margin) + self.half_turn_s

    def slack_s(self, now_s: float, home_m: float) -> float:
        """Return the time that is left after the path home and the reserve.

        Parameters
        ----------
        now_s : float
            Time at which the robot sets out, in seconds.
        home_m : float
            Length of the path home in metres.

        Returns
        -------
        float
            Seconds; negative if the time is too short.
        """
        return self.limit_s - now_s - self.travel_time_s(home_m) - self.reserve_s

    def _require_time(self, me: RobotSelf) -> None:
        assert me.base is not None
        away_m = math.dist(me.start[:2], me.base)
        shortest_m = max(0.0, away_m - me.radio.range_m)
        short_s = -self.slack_s(me.time_s, shortest_m)
        if short_s > 0.0:
            needed_s = math.ceil(self.limit_s + short_s)
            raise LimitTooShortError(
                f"the time limit of {self.limit_s:g} s is too short to deliver data: robot "
                f"{me.robot} begins at {me.time_s:g} s, {away_m:.3g} m from the base station, and "
                f"takes {self.travel_time_s(shortest_m):.3g} s to where it is heard and "
                f"{self.reserve_s:.3g} s in reserve; give a limit (max_time_s, --max-time) of at "
                f"least {needed_s} s, or less home_reserve_s",
                needed_s,
            )
