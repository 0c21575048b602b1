"""Checks of the robot and the time for which a run is exported."""

from __future__ import annotations

from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording


def require_robot(recording: Recording, robot: int | None) -> None:
    """Raise an `InvalidInputError` if a run has no robot of that number; None is the team."""
    robots = len(recording.starts)
    if robot is not None and not 0 <= robot < robots:
        there = "robot 0 only" if robots == 1 else f"robots 0 to {robots - 1}"
        raise InvalidInputError(f"there is no robot {robot}: the run has {there}")


def require_time(recording: Recording, time_s: float | None) -> float:
    """Return a time of a run in seconds; None is its end.

    Raises
    ------
    InvalidInputError
        If the run does not last that long, or the time is negative.
    """
    end_s = recording.footer.time_s
    if time_s is None:
        return end_s
    # Written so that NaN is refused. The end is shown to users rounded to hundredths.
    if not 0.0 <= time_s <= end_s + 0.005:
        raise InvalidInputError(f"the run lasts from 0 to {end_s:.2f} s; there is no {time_s:g} s")
    return time_s
