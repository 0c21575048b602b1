"""The competition's sizes, budgets and published first places."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

TEAMS: Final = (1, 2, 3, 4, 5)
"""Numbers of robots of the two tracks: one alone, and teams."""

SIZES: Final = {
    "env1": "small",
    "env2": "small",
    "env3": "medium",
    "env4": "medium",
    "env5": "medium",
    "env6": "large",
    "env7": "large",
}
"""Size of each released map."""

BUDGETS: Final = {"small": (1000, 500), "medium": (1500, 1000), "large": (2000, 1500)}
"""Steps of a robot alone and of a team."""

FIRST: Final = {
    "alone": {"small": 73.89, "medium": 61.23, "large": 49.81},
    "team": {"small": 64.89, "medium": 68.18, "large": 56.72},
}
"""First places of the preliminary round in per cent, by track and size."""

MAX_DECISION_S: Final = 0.5
"""Mean time that a decision may take, for a robot and step."""


def track(robots: int) -> str:
    """Return the track of a number of robots: ``"alone"`` or ``"team"``."""
    return "alone" if robots == 1 else "team"


def budget(name: str, robots: int) -> int:
    """Return the number of steps on a map.

    Examples
    --------
    >>> budget("env3", 1), budget("env3", 4)
    (1500, 1000)
    """
    return BUDGETS[SIZES[name]][track(robots) == "team"]


def first_place(robots: int, maps: Iterable[str]) -> float:
    """Return the published first place as a mean over maps, in per cent.

    Parameters
    ----------
    robots : int
        Number of robots, which gives the track.
    maps : iterable of str
        The maps, at least one.

    Examples
    --------
    >>> round(first_place(2, SIZES), 2)
    63.97
    """
    return float(np.mean([FIRST[track(robots)][SIZES[name]] for name in maps]))
