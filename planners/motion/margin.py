"""The margin that a body keeps from what is not known to be free."""

from __future__ import annotations

MIN_MARGIN_M = 5e-4
"""Minimum margin in metres, as contact counts as a collision."""
