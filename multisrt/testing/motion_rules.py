"""What is wrong with a trajectory that an explorer yields, by the kinematics of its robot."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic, Kinematics
from multisrt.planners.motion.trajectory import NO_TURN_RAD, Trajectory, Waypoint, leg_length
from multisrt.robots.defects import Flaw
from multisrt.simulation.motions import START_TOLERANCE, begins_at

LIMIT_TOLERANCE = 1e-6
"""Share by which a body may exceed its speed, its turn rate and its curvature, for rounding."""

ASIDE_TOLERANCE_M = 1e-6
"""Distance by which a body that drives along its heading may come off that line, for rounding."""


def trajectory_flaw(
    trajectory: Trajectory, at: Configuration, kinematics: Kinematics
) -> Flaw | None:
    """Return the first flaw of a trajectory.

    Parameters
    ----------
    trajectory : Trajectory
        Of finite numbers, whose times begin at 0 and never fall.
    at : Configuration
        Where the robot is.
    kinematics : Kinematics
        How it moves.

    Returns
    -------
    Flaw or None
        None if the robot can follow it.
    """
    return next(_flaws(trajectory, at, kinematics), None)


def pose(configuration: Configuration | tuple[float, ...]) -> str:
    """Return a configuration as text, to three digits."""
    return "({:.3f}, {:.3f}, {:.3f})".format(*configuration)


def _flaws(trajectory: Trajectory, at: Configuration, kinematics: Kinematics) -> Iterator[Flaw]:
    if not begins_at(trajectory, at):
        yield Flaw(
            f"its trajectory begins at {pose(trajectory.start)}, but the robot is at {pose(at)}",
            "begin where the last Moved says that the robot is, heading included",
        )
    for a, b in pairwise(trajectory.waypoints):
        yield from _limit_flaws(a, b, kinematics)
        yield from _direction_flaws(a, b, kinematics)


def _limit_flaws(a: Waypoint, b: Waypoint, kinematics: Kinematics) -> Iterator[Flaw]:
    # Speed and turn rate.
    leg = f"from {pose(a[1:])} to {pose(b[1:])}"
    length, turn, time_s = leg_length(a, b), abs(b.heading - a.heading), b.time_s - a.time_s
    max_m = kinematics.speed_m_s * time_s * (1.0 + LIMIT_TOLERANCE) + START_TOLERANCE
    if length > max_m:
        yield Flaw(
            f"it drives {length:.6g} m {leg} in {time_s:.6g} s",
            f"its kinematics allow {kinematics.speed_m_s:g} m/s: give its waypoints later "
            "times, or let multisrt.planners.motion.steering make its trajectories",
        )
    if isinstance(kinematics, Differential) and turn > (
        kinematics.turn_rate_rad_s * time_s * (1.0 + LIMIT_TOLERANCE) + START_TOLERANCE
    ):
        yield Flaw(
            f"it turns by {turn:.6g} rad {leg} in {time_s:.6g} s",
            f"its kinematics allow {kinematics.turn_rate_rad_s:g} rad/s: give its waypoints later "
            "times",
        )


def _direction_flaws(a: Waypoint, b: Waypoint, kinematics: Kinematics) -> Iterator[Flaw]:
    # What this kind of drive cannot do at any speed.
    leg = f"from {pose(a[1:])} to {pose(b[1:])}"
    length, turn = leg_length(a, b), abs(b.heading - a.heading)
    turns = turn > NO_TURN_RAD
    if isinstance(kinematics, Holonomic):
        if turns:
            yield Flaw(
                f"it turns {leg}",
                "a holonomic body keeps its heading: give all waypoints that of the start",
            )
        return
    middle = 0.5 * (a.heading + b.heading)
    dx, dy = b.x - a.x, b.y - a.y
    ahead = dx * math.cos(middle) + dy * math.sin(middle)
    aside = abs(dy * math.cos(middle) - dx * math.sin(middle))
    if aside > ASIDE_TOLERANCE_M:
        yield Flaw(
            f"it moves sideways, by {aside:.3g} m, {leg}",
            "its kinematics drive along the heading: turn first",
        )
    if isinstance(kinematics, Car):
        min_m = turn * kinematics.turning_radius_m * (1.0 - LIMIT_TOLERANCE)
        if turns and length < min_m - START_TOLERANCE:
            yield Flaw(
                f"its curve is too tight {leg}",
                f"the car's turning radius is {kinematics.turning_radius_m:g} m",
            )
        if ahead < -ASIDE_TOLERANCE_M and not kinematics.reverse:
            yield Flaw(f"it drives backwards {leg}", "this car drives forwards only")
