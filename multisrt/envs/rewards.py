"""What a robot is rewarded for: a function of what a step brought."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import msgspec

from multisrt.geometry.errors import InvalidInputError


class Gain(msgspec.Struct, frozen=True, kw_only=True):
    """The gain of one robot in one step of an environment, computed from the true world.

    Attributes
    ----------
    robot : int
        Number of the robot.
    team_m2 : float
        Area that was seen for the first time, by any robot, in square metres.
    own_m2 : float
        The share of it that this robot saw first.
    time_s : float
        How long the step took, in the time of the run.
    distance_m : float
        How far the robot drove; a motion counts in the step in which it ends.
    """

    robot: int
    team_m2: float
    own_m2: float
    time_s: float
    distance_m: float


Reward = Callable[[Gain], float]
"""Takes the gain of a robot in a step, and returns its reward."""


class AreaReward(msgspec.Struct, frozen=True, kw_only=True):
    """The area that is newly seen, less what time and distance cost.

    Attributes
    ----------
    area : {"team", "own"}
        Whether every robot is rewarded for what the team sees, or for its own share of that.
    time_cost_per_s : float
        Cost of a second.
    distance_cost_per_m : float
        Cost of a metre that the robot drives.

    Raises
    ------
    InvalidInputError
        If the area is another word, or a cost is not finite.

    Examples
    --------
    >>> gain = Gain(robot=0, team_m2=8.0, own_m2=3.0, time_s=4.0, distance_m=2.0)
    >>> AreaReward()(gain), AreaReward(area="own", time_cost_per_s=0.5)(gain)
    (8.0, 1.0)
    """

    area: Literal["team", "own"] = "team"
    time_cost_per_s: float = 0.0
    distance_cost_per_m: float = 0.0

    def __post_init__(self) -> None:
        if self.area not in ("team", "own"):
            raise InvalidInputError(f"area is team or own, not {self.area!r}")
        for name in ("time_cost_per_s", "distance_cost_per_m"):
            if not math.isfinite(getattr(self, name)):
                raise InvalidInputError(f"{name} is a number, not {getattr(self, name)}")

    def __call__(self, gain: Gain) -> float:
        """Return the reward of a robot."""
        area_m2 = gain.team_m2 if self.area == "team" else gain.own_m2
        return (
            area_m2
            - self.time_cost_per_s * gain.time_s
            - self.distance_cost_per_m * gain.distance_m
        )
