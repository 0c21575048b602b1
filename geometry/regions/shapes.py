"""The shapes of local safe regions, and their limits."""

from __future__ import annotations

from typing import Final, Literal

Shape = Literal["ball", "star", "radial"]

CONTACT_TOLERANCE_M: Final = 0.05
"""Maximum distance in metres between the arc of a star or ball and an obstacle at which it ends."""

MIN_CONES: Final = 3
"""Minimum number of cones of a star."""
