"""What may be wrong with the messages of a reader, and with what it has read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import shapely

from multisrt.environments.environment import MAX_COORDINATE_M, Environment

MAX_MESSAGE: Final = 1000
"""Upper bound of the length of an error message, in characters."""


def flaw_of_message(message: str, must_name: Sequence[str]) -> str:
    """Return what is wrong with an error message; empty if it is one line that names a file.

    Parameters
    ----------
    message : str
        The message.
    must_name : sequence of str
        What it must contain, such as the folder of the file.
    """
    if not message.isprintable():
        return "not one line of printable text"
    if lacking := [part for part in must_name if part not in message]:
        return f"does not name {lacking[0]}"
    if "Traceback" in message or " object at 0x" in message:
        return "text of a program"
    return "too long" if len(message) > MAX_MESSAGE else ""


def flaw_of_world(world: Environment) -> str:
    """Return what is wrong with a world; empty if it can be explored."""
    points = shapely.get_coordinates(world.free)
    if world.free.is_empty or not len(points):
        return "free space is empty"
    if not np.isfinite(points).all() or np.abs(points).max() > MAX_COORDINATE_M * (1 + 1e-9):
        return "a coordinate is not finite or too large"
    if not world.free.is_valid:
        return f"free space is not valid: {shapely.is_valid_reason(world.free)}"
    if not all(world.contains(x, y) for x, y in world.starts):
        return "a suggested start is not in free space"
    # A name is kept as it is given; what writes it makes it printable.
    if not f"{world.origin}{world.cleaning}".isprintable():
        return f"origin or cleaning is not printable: {world.origin!r}, {str(world.cleaning)!r}"
    return ""


def flaw_of_shown(text: str) -> str:
    """Return what is wrong with lines that a command prints; empty if a terminal shows them."""
    wrong = next((line for line in text.split("\n") if not line.isprintable()), None)
    return "" if wrong is None else f"prints what is not printable: {wrong[:200]!r}"
