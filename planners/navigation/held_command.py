"""Motions of commands that are held for a time, and how long they may be held."""

from __future__ import annotations

import math

import numpy as np

from multisrt.geometry.bodies.clearance import disc_clearance
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.geometry.numerics.distances import inside
from multisrt.planners.motion.kinematics import Differential, Holonomic, Kinematics
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.planners.navigation.nearness_diagram import Command


def motion(
    chosen: Command, kinematics: Kinematics, at: Configuration, duration_s: float
) -> Trajectory:
    """Return the motion of a command that is held for a time.

    Parameters
    ----------
    chosen : Command
        The command. For a holonomic drive it was made with ``any_direction=True``.
    kinematics : Differential or Holonomic
        A differential drive follows a circular arc; a holonomic one moves straight along the
        command's heading and keeps its own.
    at : Configuration
        Where the motion begins.
    duration_s : float
        How long the command is held, in seconds.

    Returns
    -------
    Trajectory

    Raises
    ------
    InvalidInputError
        If the body is a car, the time is not positive, or a drive would turn by more than half a
        circle on the way.

    Examples
    --------
    >>> ahead = Command(0.5, 0.0, 0.0, "goal", 0.0, np.nan, np.nan)
    >>> motion(ahead, Differential(), Configuration(0.0, 0.0, 0.0), 2.0).end
    Configuration(x=1.0, y=0.0, heading=0.0)
    """
    if not 0.0 < duration_s < math.inf:
        raise InvalidInputError(f"a command is held for a positive time, not {duration_s:g} s")
    length = chosen.speed_m_s * duration_s
    if isinstance(kinematics, Differential):
        turn = chosen.turn_rate_rad_s * duration_s
        half = 0.5 * turn
        chord = length if half == 0.0 else length * math.sin(half) / half
        direction, heading = at.heading + half, at.heading + turn
    elif isinstance(kinematics, Holonomic):
        chord, direction, heading = length, at.heading + chosen.heading_rad, at.heading
    else:
        raise InvalidInputError(
            "a car cannot turn in place, as the nearness diagram asks for; "
            "use a holonomic or differential drive, or plan its path instead"
        )
    x, y = at.x + chord * math.cos(direction), at.y + chord * math.sin(direction)
    return Trajectory((Waypoint(0.0, *at), Waypoint(duration_s, x, y, heading)))


def safe_time(
    chosen: Command,
    clearance_m: float,
    radius_m: float,
    *,
    margin_m: float = 0.0,
    is_disc: bool = True,
) -> float:
    """Return how long a command may be held without any part of the body leaving known space.

    A body that drives no farther than its distance to everything touches nothing. A command slows
    down by the same distance, so that the result is at least ``avoid_m / v_max_m_s`` where
    `clearance_m` is that of the readings and the command was made for the radius with the margin.

    Parameters
    ----------
    chosen : Command
        The command.
    clearance_m : float
        Distance of the reference point from the nearest obstacle in metres, see `known_clearance`.
    radius_m : float
        Distance of the body's farthest corner from its reference point in metres.
    margin_m : float
        Distance to keep from obstacles in metres.
    is_disc : bool
        Whether the body is a disc about its reference point, which touches nothing new as it turns
        in place. The corners of another one come nearer to what is beside it.

    Returns
    -------
    float
        Seconds; 0 if the body may not move, ``inf`` if it only turns in place.

    Examples
    --------
    >>> ahead = Command(0.5, 0.0, 0.0, "goal", 0.0, np.nan, np.nan)
    >>> safe_time(ahead, clearance_m=1.25, radius_m=0.25)
    2.0
    """
    if chosen.speed_m_s == 0.0:
        return math.inf if is_disc or clearance_m >= radius_m else 0.0
    return max(0.0, clearance_m - radius_m - margin_m) / chosen.speed_m_s


def known_clearance(
    boundary: FloatArray, at: Configuration, discs: FloatArray | None = None
) -> float:
    """Return the distance from a place to the border of known free space or the nearest body.

    Parameters
    ----------
    boundary : (n, 2) array
        Boundary of the known region; all of it counts, also where the region is open.
    at : Configuration
        The place, in the frame of the region.
    discs : (m, 3) array, optional
        x, y and radius of other bodies, in the same frame.

    Returns
    -------
    float
        Metres; 0 outside the region and inside a disc.

    Examples
    --------
    >>> room = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> known_clearance(room, Configuration(1.0, 2.0, 0.0))
    1.0
    """
    if not inside(boundary, at.x, at.y):
        return 0.0
    nearest = disc_clearance(boundary, at.x, at.y)
    if discs is not None and len(discs):
        apart = np.hypot(discs[:, 0] - at.x, discs[:, 1] - at.y) - discs[:, 2]
        nearest = min(nearest, float(apart.min()))
    return max(0.0, nearest)
