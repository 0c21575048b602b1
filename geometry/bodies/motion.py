"""Motions of a body at constant speed and turn rate: on a line or on a circular arc."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from multisrt.geometry.bodies.footprint import checked_configuration
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError

STRAIGHT_RAD: Final = 1e-8
"""Below this turn an arc is treated as straight: its centre is too far away to compute with."""

HEADING_TOLERANCE_RAD: Final = 1e-6
"""Maximum difference between the heading that a turn leads to and the one that is given."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """A motion at constant speed and turn rate; build one with `Motion.between`.

    Attributes
    ----------
    start : Configuration
        First configuration.
    step : (dx, dy)
        Displacement of the reference point from start to end in metres.
    turn : float
        Signed angle from the first heading to the last in radians, counter-clockwise positive.
    centre : (x, y) or None
        Centre of the arc in metres; None for a straight line.
    length : float
        Length of the reference point's path in metres.
    """

    start: Configuration
    step: tuple[float, float]
    turn: float
    centre: tuple[float, float] | None
    length: float

    @classmethod
    def between(
        cls,
        start: Sequence[float],
        end: Sequence[float],
        turn: float | None = None,
        *,
        arc: bool = False,
    ) -> Motion:
        """Return the motion from one configuration to another.

        Parameters
        ----------
        start, end : (x, y, heading)
            First and last configuration in metres and radians.
        turn : float, optional
            Signed angle from the first heading to the last, which may be more than one turn; by
            default the shorter way.
        arc : bool
            Whether the reference point moves on the circular arc on which the motion looks the
            same from the body at all times (constant twist: a car with its wheels held still, or
            a differential drive at constant speeds), or on a straight line. The heading turns
            evenly in both.

        Raises
        ------
        InvalidInputError
            If a number is not finite, the turn does not lead to the last heading, or no arc
            joins the configurations.

        Examples
        --------
        A quarter of a circle of radius 1 m to the left:

        >>> import math
        >>> motion = Motion.between((0.0, 0.0, 0.0), (1.0, 1.0, math.pi / 2), arc=True)
        >>> round(motion.length, 6) == round(math.pi / 2, 6)
        True
        >>> x, y, heading = motion.pose(0.5)
        >>> round(x, 3), round(y, 3), round(heading, 3)
        (0.707, 0.293, 0.785)
        """
        first, last = checked_configuration(start), checked_configuration(end)
        turn = _checked_turn(first, last, turn)
        dx, dy = last[0] - first[0], last[1] - first[1]
        chord = math.hypot(dx, dy)
        if not arc or chord == 0.0 or abs(turn) < STRAIGHT_RAD:
            return cls(start=first, step=(dx, dy), turn=turn, centre=None, length=chord)
        half = math.sin(turn / 2.0)
        if abs(half) < 0.25 * STRAIGHT_RAD:
            raise InvalidInputError(
                f"no arc leads from ({first[0]:g}, {first[1]:g}) to ({last[0]:g}, {last[1]:g}) "
                f"with a turn of {turn:g} rad: whole turns on a circle end where they begin"
            )
        # The centre lies on the chord's bisector, to the left for a turn to the left.
        away = 0.5 * math.cos(turn / 2.0) / half
        centre = (first[0] + dx / 2.0 - dy * away, first[1] + dy / 2.0 + dx * away)
        length = abs(turn * chord / (2.0 * half))
        return cls(start=first, step=(dx, dy), turn=turn, centre=centre, length=length)

    @property
    def end(self) -> Configuration:
        """Last configuration, to rounding."""
        return self.pose(1.0)

    @property
    def bulge(self) -> float:
        """Bound on the distance in metres, at any moment, from the straight motion to its end."""
        return 0.0 if self.centre is None else self.length * abs(self.turn) / 8.0

    def pose(self, fraction: float) -> Configuration:
        """Return the configuration after a fraction of the motion, from 0 to 1."""
        x, y, heading = self.start
        turned = fraction * self.turn
        if self.centre is None:
            dx, dy = self.step
            return Configuration(x + fraction * dx, y + fraction * dy, heading + turned)
        cx, cy = self.centre
        c, s = math.cos(turned), math.sin(turned)
        ox, oy = x - cx, y - cy
        return Configuration(cx + c * ox - s * oy, cy + s * ox + c * oy, heading + turned)


def _checked_turn(first: Configuration, last: Configuration, turn: float | None) -> float:
    if turn is None:
        return math.remainder(last.heading - first.heading, 2.0 * math.pi)
    if not math.isfinite(turn):
        raise InvalidInputError(f"a turn of {turn:g} is not finite; give radians")
    error = math.remainder(first.heading + turn - last.heading, 2.0 * math.pi)
    if abs(error) > HEADING_TOLERANCE_RAD:
        raise InvalidInputError(
            f"a turn of {turn:g} rad does not lead from heading {first.heading:g} to "
            f"{last.heading:g}; give the signed angle between them, or leave it out for the "
            "shorter way"
        )
    return float(turn)
