"""The protective stop: when a motion is ended before another body, and how to plan around that.

A motion ends where another body in sight comes nearer than the guard distance. A body that is
nearer already as the motion begins may stay near, but not come much nearer (`stop_within`).
Planned paths keep a little more distance than that (`planned_gap`), so that no motion that was
planned with the other body in mind is ended by its protective stop.
"""

from __future__ import annotations

from multisrt.planners.motion.sweep import Sweep

MIN_SHARE = 0.25
"""Share of the guard distance below which a body may not come nearer at all."""

LEAVING_SHARE = 0.999
"""Share of the initial distance at which such a body is stopped: less than 1, so that rounding
does not stop a body that moves away."""

BEYOND_GUARD = 1.2
"""Distance that planned paths keep from other bodies, as a share of the guard distance."""


def stop_within(distance_m: float, guard_m: float) -> float:
    """Return the distance at which a body stops a motion that began within the guard distance.

    Half of the distance at the beginning, but at least `MIN_SHARE` of the guard distance; and
    never more than the distance at the beginning.

    Parameters
    ----------
    distance_m : float
        Distance between the two bodies as the motion begins, in metres; less than `guard_m`.
    guard_m : float
        Guard distance in metres.

    Examples
    --------
    >>> stop_within(0.08, guard_m=0.1)
    0.04
    >>> stop_within(0.03, guard_m=0.1)
    0.025
    """
    return max(0.5 * distance_m, min(LEAVING_SHARE * distance_m, MIN_SHARE * guard_m))


def max_gap(guard_m: float) -> float:
    """Return the largest value of `planned_gap`, whatever the distance between two bodies."""
    return BEYOND_GUARD * guard_m


def planned_gap(now_m: float, guard_m: float) -> float:
    """Return the distance that the planned paths of two bodies have to keep.

    It lies beyond the distance at which the protective stop would end a motion: the guard
    distance and a margin where the bodies are farther apart than that, the guard distance where
    they are within the margin; and for bodies that are nearer already, halfway between their
    present distance and that of their stop.

    Parameters
    ----------
    now_m : float
        Distance between the two bodies now, in metres.
    guard_m : float
        Guard distance in metres.

    Examples
    --------
    >>> planned_gap(1.0, guard_m=0.1)
    0.12
    >>> planned_gap(0.11, guard_m=0.1)
    0.1
    >>> planned_gap(0.08, guard_m=0.1)
    0.06
    """
    beyond = max_gap(guard_m)
    if now_m >= beyond:
        return beyond
    if now_m > guard_m:
        return guard_m
    return 0.5 * (now_m + stop_within(now_m, guard_m))


def conflict(sweep_a: Sweep, body_a: Sweep, sweep_b: Sweep, body_b: Sweep, guard_m: float) -> bool:
    """Return whether two sweeps come nearer to one another than `planned_gap` allows.

    Parameters
    ----------
    sweep_a, sweep_b : Sweep
        What each body sweeps; for a body that stays, what it covers where it stands.
    body_a, body_b : Sweep
        What each body covers now.
    guard_m : float
        Guard distance in metres.
    """
    apart_m = sweep_a.distance_to(sweep_b)
    if apart_m >= max_gap(guard_m):
        return False
    return apart_m < planned_gap(body_a.distance_to(body_b), guard_m)
