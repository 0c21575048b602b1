"""Map sizes, numbers of steps and winning scores, as published by the competition."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

TEAMS: Final = (1, 2, 3, 4, 5)
"""Numbers of robots: one alone in the first track, teams in the second."""

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
"""Number of steps of a robot alone and of a team, by map size."""

WINNING_SCORES: Final = {
    "alone": {"small": 73.89, "medium": 61.23, "large": 49.81},
    "team": {"small": 64.89, "medium": 68.18, "large": 56.72},
}
"""Published scores of the first-placed team of the preliminary round, by track and map size.

They are in per cent.
"""

MAX_DECISION_S: Final = 0.5
"""Maximum mean time of a decision, per robot and step, in seconds."""


def track(robots: int) -> str:
    """Return the track for a number of robots: ``"alone"`` or ``"team"``."""
    return "alone" if robots == 1 else "team"


def budget(name: str, robots: int) -> int:
    """Return the number of steps of a run on a map.

    Examples
    --------
    >>> budget("env3", 1), budget("env3", 4)
    (1500, 1000)
    """
    return BUDGETS[SIZES[name]][track(robots) == "team"]


def winning_score(robots: int, maps: Iterable[str]) -> float:
    """Return the published score of the first-placed team, averaged over maps, in per cent.

    Parameters
    ----------
    robots : int
        Number of robots, which determines the track.
    maps : iterable of str
        Names of the maps, at least one.

    Examples
    --------
    >>> round(winning_score(2, SIZES), 2)
    63.97
    """
    return float(np.mean([WINNING_SCORES[track(robots)][SIZES[name]] for name in maps]))
