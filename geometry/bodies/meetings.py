"""Collision of two bodies with each other, at rest and in motion.

Two moving bodies are followed by conservative advancement, as one is among obstacles; see
`collision`. Two discs on straight lines meet in closed form.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from multisrt.geometry.bodies.advancement import (
    CONTACT_PRECISION_M,
    RESOLUTION_M,
    disc_entry,
    first_contact_fraction,
    last_outside,
    require_resolution,
)
from multisrt.geometry.bodies.collision_body import Body, gap, placed_pair, touch
from multisrt.geometry.bodies.footprint import checked_configuration
from multisrt.geometry.bodies.motion import Motion
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError


def bodies_collide(
    body_a: Body,
    configuration_a: Sequence[float],
    body_b: Body,
    configuration_b: Sequence[float],
) -> bool:
    """Whether two bodies overlap or touch.

    Parameters
    ----------
    body_a, body_b : Body
        The bodies; they may be the same object at two places.
    configuration_a, configuration_b : (x, y, heading)
        Where they are, in metres and radians.

    Raises
    ------
    InvalidInputError
        If a configuration is not three finite numbers.

    Examples
    --------
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> body = Body(Footprint.disc(0.5))
    >>> bodies_collide(body, (0.0, 0.0, 0.0), body, (1.0, 0.0, 0.0))
    True
    """
    return touch(
        *placed_pair(
            body_a,
            checked_configuration(configuration_a),
            body_b,
            checked_configuration(configuration_b),
        )
    )


def body_distance(
    body_a: Body,
    configuration_a: Sequence[float],
    body_b: Body,
    configuration_b: Sequence[float],
) -> float:
    """Return the distance between two bodies.

    Parameters
    ----------
    body_a, body_b : Body
        The bodies; they may be the same object at two places.
    configuration_a, configuration_b : (x, y, heading)
        Where they are, in metres and radians.

    Returns
    -------
    float
        Metres; 0 where they overlap or touch.

    Raises
    ------
    InvalidInputError
        If a configuration is not three finite numbers.

    Examples
    --------
    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> body = Body(Footprint.box(1.0, 0.5))
    >>> body_distance(body, (0.0, 0.0, 0.0), body, (3.0, 0.0, 0.0))
    2.0
    """
    return _apart(
        body_a,
        checked_configuration(configuration_a),
        body_b,
        checked_configuration(configuration_b),
    )


def first_meeting(
    body_a: Body,
    motion_a: Motion,
    body_b: Body,
    motion_b: Motion,
    *,
    gap_m: float = 0.0,
    resolution_m: float = RESOLUTION_M,
) -> float | None:
    """Find when two bodies that move over the same time first touch, or come within a gap.

    Exact for two discs on straight lines; otherwise by conservative advancement.

    Parameters
    ----------
    body_a, body_b : Body
        The bodies; they may be the same object.
    motion_a, motion_b : Motion
        How they move, at constant speeds over the same time; one that stands still has a motion
        of no length.
    gap_m : float
        Distance in metres that counts as contact, as does any below it; 0: they touch.
    resolution_m : float
        Length of the shortest step in metres; contacts up to half as deep may be missed.

    Returns
    -------
    float or None
        Fraction of the time, from 0 to 1, at which they are still farther apart than the gap
        but within a micrometre of motion of it; 0 if they start in contact; None if they never
        meet.

    Raises
    ------
    InvalidInputError
        If the gap is negative or not finite, or the resolution is not positive.

    Examples
    --------
    Two discs drive towards each other:

    >>> from multisrt.geometry.bodies.footprint import Footprint
    >>> body = Body(Footprint.disc(0.5))
    >>> there = Motion.between((0.0, 0.0, 0.0), (10.0, 0.0, 0.0))
    >>> back = Motion.between((10.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    >>> round(first_meeting(body, there, body, back), 6)
    0.45
    >>> round(first_meeting(body, there, body, back, gap_m=1.0), 6)
    0.4
    """
    if not 0.0 <= gap_m < math.inf:
        raise InvalidInputError(f"a gap of {gap_m:g} m; it is 0 or more, and finite")
    a, b = motion_a, motion_b
    if a.centre is None and b.centre is None:
        approach = math.hypot(a.step[0] - b.step[0], a.step[1] - b.step[1])
    else:
        approach = a.length + b.length
    turning = body_a.turning_radius_m * abs(a.turn) + body_b.turning_radius_m * abs(b.turn)

    def beyond_gap(fraction: float) -> float:
        return _apart(body_a, a.pose(fraction), body_b, b.pose(fraction)) - gap_m

    # Until the circles around the bodies come within the gap, the bodies do not.
    offset = b.start.x - a.start.x, b.start.y - a.start.y
    step = b.step[0] - a.step[0], b.step[1] - a.step[1]
    reach = body_a.footprint.circumscribed_radius_m + body_b.footprint.circumscribed_radius_m
    reach += gap_m
    if body_a.footprint.is_disc and body_b.footprint.is_disc and a.centre is b.centre is None:
        return last_outside(offset, step, reach)
    begin = disc_entry(offset, step, reach + a.bulge + b.bulge + CONTACT_PRECISION_M)
    if begin is None:
        return None
    require_resolution(resolution_m)
    return first_contact_fraction(
        beyond_gap,
        lambda fraction: beyond_gap(fraction) > 0.0,
        approach + turning,
        resolution_m,
        begin,
    )


def _apart(body_a: Body, pose_a: Configuration, body_b: Body, pose_b: Configuration) -> float:
    if body_a.footprint.is_disc and body_b.footprint.is_disc:
        between = math.hypot(pose_b[0] - pose_a[0], pose_b[1] - pose_a[1])
        return max(0.0, between - (body_a.footprint.radius_m + body_b.footprint.radius_m))
    return gap(*placed_pair(body_a, pose_a, body_b, pose_b))
