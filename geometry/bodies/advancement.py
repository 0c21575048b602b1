"""When a motion first leads to contact: in closed form for discs, else step by step."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from multisrt.geometry.errors import InvalidInputError

RESOLUTION_M: Final = 1e-3
"""Default length of the shortest step along a motion, in metres."""

CONTACT_PRECISION_M: Final = 1e-6
"""Precision with which the place of a contact is found, as a length of motion in metres."""


def require_resolution(resolution_m: float) -> None:
    """Raise an `InvalidInputError` unless a resolution is positive and finite."""
    if not (math.isfinite(resolution_m) and resolution_m > 0.0):
        raise InvalidInputError(f"a resolution of {resolution_m:g} m; it is positive and finite")


def first_contact_fraction(
    gap: Callable[[float], float],
    is_free: Callable[[float], bool],
    length_m: float,
    resolution_m: float,
    begin: float = 0.0,
) -> float | None:
    """Find the first contact along a motion by conservative advancement.

    A step is as long as the gap allows, but not shorter than the resolution.

    Parameters
    ----------
    gap : callable
        Distance to what might be hit, in metres, after a fraction of the motion; 0 in contact.
    is_free : callable
        Whether that distance is positive.
    length_m : float
        Bound on how much the gap can shrink over the whole motion, in metres.
    resolution_m : float
        Length of the shortest step in metres.
    begin : float
        Fraction up to which there is no contact.

    Returns
    -------
    float or None
        Fraction of the motion that is still free but within `CONTACT_PRECISION_M` of contact;
        ``begin`` if there is contact then; None if there is none at all.

    Examples
    --------
    A point moves 4 m towards a wall at 3 m:

    >>> gap = lambda fraction: max(0.0, 3.0 - 4.0 * fraction)
    >>> fraction = first_contact_fraction(gap, lambda f: gap(f) > 0.0, 4.0, 1e-3)
    >>> round(fraction, 6)
    0.75
    """
    distance = gap(begin)
    if distance <= 0.0:
        return begin
    fraction = begin
    while fraction * length_m < length_m:
        before = fraction
        fraction = min(1.0, fraction + max(distance, resolution_m) / length_m)
        distance = gap(fraction)
        if distance <= 0.0:
            return _bisect(is_free, before, fraction, CONTACT_PRECISION_M / length_m)
    return None


def _bisect(
    is_free: Callable[[float], bool], free: float, contact: float, precision: float
) -> float:
    # Narrow down the last free fraction before a contact.
    while contact - free > precision:
        middle = 0.5 * (free + contact)
        if middle in (free, contact):
            break
        if is_free(middle):
            free = middle
        else:
            contact = middle
    return free


def disc_entry(
    position: tuple[float, float], step: tuple[float, float], radius_m: float
) -> float | None:
    """Return when a point that moves on a line enters a disc about the origin.

    Parameters
    ----------
    position : (x, y)
        Where the point begins, in metres.
    step : (dx, dy)
        Its displacement, in metres.
    radius_m : float
        Radius of the disc in metres.

    Returns
    -------
    float or None
        Fraction of the step; 0 if the point begins in the disc; None if it never enters.

    Examples
    --------
    >>> disc_entry((-3.0, 0.0), (4.0, 0.0), 1.0)
    0.5
    >>> disc_entry((-3.0, 2.0), (4.0, 0.0), 1.0) is None
    True
    """
    (x, y), (dx, dy) = position, step
    distance = math.hypot(x, y)
    if distance <= radius_m:
        return 0.0
    closing = -(x * dx + y * dy)
    speed, aside = math.hypot(dx, dy), abs(x * dy - y * dx)
    if closing <= 0.0 or aside > radius_m * speed:
        return None
    root = math.sqrt((radius_m * speed - aside) * (radius_m * speed + aside))
    fraction = (distance - radius_m) * (distance + radius_m) / (closing + root)
    return fraction if fraction <= 1.0 else None


def last_outside(
    position: tuple[float, float], step: tuple[float, float], radius_m: float
) -> float | None:
    """Return the fraction shortly before `disc_entry` at which the point is surely outside.

    It is earlier by half of `CONTACT_PRECISION_M`, or more for a line that nearly misses the
    disc. Parameters are those of `disc_entry`.
    """
    fraction = disc_entry(position, step, radius_m)
    if fraction is None or fraction == 0.0:
        return fraction
    (x, y), (dx, dy) = position, step
    back = 0.5 * CONTACT_PRECISION_M / math.hypot(dx, dy)
    while True:
        fraction = max(0.0, fraction - back)
        if math.hypot(x + fraction * dx, y + fraction * dy) > radius_m:
            return fraction
        back *= 2.0
