"""The looks of strategies in figures: colours, markers and dashes that differ also in grey."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from multisrt.drawing.colours import ROBOT_COLOURS, tint

MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X", "p")
DASHES: Final[tuple[Any, ...]] = (
    "-",
    (0, (5, 1.6)),
    (0, (1.2, 1.2)),
    (0, (5, 1.4, 1.2, 1.4)),
    (0, (9, 2)),
    (0, (2.6, 2.6)),
    (0, (9, 1.4, 1.2, 1.4, 1.2, 1.4)),
    (0, (6, 1.5, 2, 1.5)),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """Colours, marker and dashes of one strategy."""

    colour: str
    light: str
    marker: str
    dashes: Any


def look_of(number: int) -> Look:
    """Return the look of a strategy by its index among all strategies."""
    colour = ROBOT_COLOURS[number % len(ROBOT_COLOURS)]
    turn = number + number // len(ROBOT_COLOURS)
    return Look(
        colour=colour,
        light=tint(colour, 0.35),
        marker=MARKERS[turn % len(MARKERS)],
        dashes=DASHES[turn % len(DASHES)],
    )
