"""Parameters of Multi-SRT."""

from __future__ import annotations

import math
from typing import Literal

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.srt import SrtOptions


class MultiSrtOptions(SrtOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of a Multi-SRT explorer: those of `SrtOptions`, and of the team.

    Attributes
    ----------
    guard_m : float
        A robot stops before another's body comes nearer than this; paths that come nearer to
        one another conflict.
    support : bool
        Whether a robot that is done with its own tree supports others (with an unlimited radio).
    support_m : float or None
        A tree may need support if its open frontier is at least this long for each robot that
        is active in it (paper: F bar); None: the range of the range finder.
    select : {"closest_root", "most_recent"}
        Which of these trees is supported: the one whose root is the shortest way off, or the
        one that was extended last.
    take_over_after_s : float
        With a limited radio, a robot that is done with its own tree takes over the frontier of
        a robot that it has not heard of for so long.
    ask_period_s : float
        A robot that waits for another asks it again after this time; latency comes on top.
    silence_timeout_s : float or None
        A robot that does not answer for so long is taken as lost; None: as long as it takes
        until so many answers in a row would hardly be lost by the radio alone.
    sense : {"targets", "moving"}
        Whether the range finder looks round at targets only, as in the paper, or also on the way
        to new places.
    sense_period_s : float
        How often it does so on the way.
    pause_s : float
        Robots that could not be let go try again after up to this time, each its own.
    """

    guard_m: float = 0.1
    support: bool = True
    support_m: float | None = None
    select: Literal["closest_root", "most_recent"] = "closest_root"
    take_over_after_s: float = 120.0
    ask_period_s: float = 0.5
    silence_timeout_s: float | None = None
    sense: Literal["targets", "moving"] = "targets"
    sense_period_s: float = 2.0
    pause_s: float = 2.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("guard_m", "take_over_after_s", "ask_period_s", "sense_period_s", "pause_s"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be positive")
        for name in ("support_m", "silence_timeout_s"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < math.inf:
                raise InvalidInputError(f"{name} is {value}; it must be positive")
