"""Errands: where a robot goes for other purposes than to explore, and how long it stays there."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from multisrt.events import Purpose
from multisrt.robots.frontier.goal import Goal

ErrandKind = Literal["home", "meet", "pursue", "link", "wait"]
"""Deliver data to the base station, meet the partner of the pair, pursue a teammate that is out of
touch, stand as a relay, or wait for relays."""

WHAT: Final = {
    "home": "goes home",
    "meet": "goes to meet its partner",
    "pursue": "pursues a teammate",
    "link": "serves the chain",
    "wait": "waits",
}
"""What a robot does on each kind of errand, in the words of recordings."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Errand:
    """Something for which a robot drives to a place, and waits there.

    Attributes
    ----------
    kind : {"home", "meet", "pursue", "link", "wait"}
        Purpose.
    why : str
        Reason in words, for the record.
    goal : Goal or None
        Place and the path there; None while bodies bar all paths.
    is_over : callable
        Returns whether there is nothing left to go there or to wait for.
    until_s : float
        Time in seconds until which the robot waits there. If it comes later than `patience_s`
        before, it waits for `patience_s` from its arrival.
    patience_s : float
        Minimum time for which it waits there, in seconds.
    heard_s : callable
        Returns when the robot that it waits for was last heard; it waits for `patience_s` from then
        on.
    is_barred : bool
        Whether no path is free to where it should be, so that it stays where it is and looks
        whether bodies have left.
    """

    kind: ErrandKind
    why: str
    goal: Goal | None
    is_over: Callable[[], bool]
    until_s: float = -math.inf
    patience_s: float = 0.0
    heard_s: Callable[[], float] = lambda: -math.inf
    is_barred: bool = False

    @property
    def what(self) -> str:
        """What the robot does, in words."""
        return WHAT[self.kind]

    @property
    def purpose(self) -> Purpose:
        """Purpose of the motions, for the record."""
        return "support" if self.kind == "pursue" else "home"

    def is_late(self, now_s: float) -> bool:
        """Return whether a robot that is not yet there is too late to come."""
        return math.isfinite(self.until_s) and now_s >= self.until_s + self.patience_s

    def waits_until_s(self, arrived_s: float) -> float:
        """Return the time until which a robot waits that arrived at a time.

        Examples
        --------
        >>> wait = Errand(
        ...     kind="meet", why="", goal=None, is_over=bool, until_s=100.0, patience_s=30.0
        ... )
        >>> wait.waits_until_s(20.0), wait.waits_until_s(90.0)
        (100.0, 120.0)
        """
        return max(self.until_s, max(arrived_s, self.heard_s()) + self.patience_s)
