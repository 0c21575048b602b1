"""The protective stop: how near a motion may come to another body, and how to plan for it."""

from __future__ import annotations

LEAST_SHARE = 0.25
"""Whoever stands nearer than this share of the guard to another body is stopped at once."""

NO_NEARER = 0.999
"""Where it is stopped then, as a share of its distance: what is left keeps a stop from coming
before the motion begins, as it would for who leaves."""

BEYOND_GUARD = 1.2
"""Paths keep this share of the guard distance between them, so that none is stopped by it."""


def stop_within(distance_m: float, guard_m: float) -> float:
    """Give at what distance a body stops a motion that was nearer than the guard as it began.

    At half of the distance that it had then, but not within `LEAST_SHARE` of the guard.
    """
    return max(0.5 * distance_m, min(NO_NEARER * distance_m, LEAST_SHARE * guard_m))


def least_gap(now_m: float, guard_m: float) -> float:
    """Give how near to one another ways may be planned of two bodies that are so far apart now.

    So that no protective stop ends them: farther than the guard, where they are; for bodies that
    are nearer already, half way from there to where they would be stopped.
    """
    beyond = BEYOND_GUARD * guard_m
    if now_m >= beyond:
        return beyond
    if now_m > guard_m:
        return guard_m
    return 0.5 * (now_m + stop_within(now_m, guard_m))
