"""Parameters of Multi-SRT."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Literal

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.srt_options import SrtOptions

_POSITIVE = (
    "guard_m",
    "take_over_after_s",
    "ask_period_s",
    "sense_period_s",
    "pause_s",
    "left_out_s",
    "check_period_s",
    "settle_s",
    "home_after_s",
)
_POSITIVE_IF_GIVEN = ("support_m", "silence_timeout_s", "no_place_after")
_AT_LEAST_ONE = (
    "max_waits",
    "max_new_targets",
    "crowded_after",
    "jammed_after",
    "boxed_in_after",
    "gives_up_after",
    "max_reopenings",
    "max_rounds",
)


class MultiSrtOptions(SrtOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of a Multi-SRT explorer: those of `SrtOptions`, and of the team.

    Attributes
    ----------
    home : {"never", "in-time", "worth"}
        When a robot drives over its roadmap, from node to node, to where the base station hears it.
        "never": never. "in-time": when nothing is left to explore, or early enough to deliver its
        data before the time limit. "worth": then, and when the trip is worthwhile (`home_ratio`).
        Other values than "never" need a base station.
    guard_m : float
        Distance in metres to another body at which the protective stop ends a motion; paths that
        come nearer to one another conflict.
    support : bool
        Whether a robot that is done with its own tree supports others, or with a limited radio
        takes over from them.
    support_m : float or None
        A tree may need support if its open frontier is at least this long, in metres, for each
        robot that is active in it (paper: F bar); None: the sensing range.
    select : {"closest_root", "most_recent"}
        Which of these trees is supported: the one whose root has the shortest path, or the
        one that was extended last.
    entry : {"root", "nearest_open"}
        Where a robot begins to extend a tree that it supports: at its root, as in the paper, or at
        the nearest of its nodes with a frontier.
    support_in_contact : bool
        With a limited radio, whether a robot also supports the trees of robots that it has heard
        from in the last `check_period_s`, as with an unlimited one.
    no_place_after : int or None
        Only without the third stage of the planner (``complete=False``): number of times that
        robots of the same body and drive have found no place at a node, after which none of them
        goes there to support its tree; they tell one another. None: each tries for itself.
    take_over_after_s : float
        With a limited radio, time after which a robot that is done with its own tree takes over
        the frontier of a robot that it has not heard from.
    ask_period_s : float
        Time after which a robot that waits for another asks it again; latency comes on top.
    silence_timeout_s : float or None
        A robot that does not answer for this long is presumed lost; None: as long as it takes
        until the radio is very unlikely to have lost that many answers in a row.
    sense : {"targets", "moving"}
        Whether scans are taken at targets only, as in the paper, or also on the way to new
        places.
    sense_period_s : float
        Time between two scans on the way.
    pause_s : float
        Scale of the random pauses of a robot that could not go, before it tries again. Each robot
        draws its own, so that the same robots do not try the same again: a quarter of this to all
        of it where the robot makes no motion in a step, was stopped before it had moved, or was
        stopped as a car that cannot reverse; half of this to all of it, times one plus the number
        of setbacks (at most `jammed_after`), where it stands aside.
    max_new_targets : int
        Number of other targets that a master draws for a robot whose path conflicts, until one
        conflicts with no other robot; each of them takes up to `max_draws` candidates.
    max_waits : int
        Steps in a row that a robot waits before it chooses its target again. The default lets
        three other robots go first.
    crowded_after : int
        Setbacks without progress after which a robot stands aside when it is stopped, and takes
        a place near the end of a transfer as its end; see `multisrt.robots.multi_srt.progress`.
        Two robots may stop one another a few times before the path of one of them is free.
    jammed_after : int
        Setbacks without progress after which a robot plans around robots that stand idle: they
        have not cleared its way however often a master ordered them to.
    boxed_in_after : int
        Number of times in a row that a robot may find no path at all; after one more it gives up
        its task. The pauses between them give a body that blocks the path time to leave.
    gives_up_after : int
        Setbacks without progress after which a robot gives up its task. Robots that block each
        other, all of them on their way somewhere, would wait forever.
    max_reopenings : int
        Number of times that the arcs of one node, which bodies barred, are taken up again when a
        body is gone. Robots that give way to each other by turns would otherwise never end.
    max_rounds : int
        Rounds of questions within one step after which a robot continues without those that do not
        agree on the group. Robots that hear one another, but not the same others, may never.
    left_out_s : float
        Time for which it then leaves these out of its groups.
    check_period_s : float
        Time after which a robot that waits for the end of the exploration asks robots that it
        has not heard from whether they are still there; again every `ask_period_s` until they
        answer, or are presumed lost.
    settle_s : float
        Time for which a robot that waits, and has heard news, waits for more of it.
    home_after_s : float
        Time after which a robot that has nothing left to do, and gave way, goes back to the root
        of its own tree, if the path there over the roadmap is longer than its sensing range.
    """

    home: Literal["never", "in-time", "worth"] = "never"
    guard_m: float = 0.1
    support: bool = True
    support_m: float | None = None
    select: Literal["closest_root", "most_recent"] = "closest_root"
    entry: Literal["root", "nearest_open"] = "root"
    support_in_contact: bool = False
    no_place_after: int | None = None
    take_over_after_s: float = 120.0
    ask_period_s: float = 0.5
    silence_timeout_s: float | None = None
    sense: Literal["targets", "moving"] = "targets"
    sense_period_s: float = 2.0
    pause_s: float = 2.0
    max_new_targets: int = 10
    max_waits: int = 3
    crowded_after: int = 3
    jammed_after: int = 12
    boxed_in_after: int = 12
    gives_up_after: int = 60
    max_reopenings: int = 10
    max_rounds: int = 40
    left_out_s: float = 30.0
    check_period_s: float = 30.0
    settle_s: float = 1.0
    home_after_s: float = 5.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in (*_POSITIVE, *_POSITIVE_IF_GIVEN):
            value = getattr(self, name)
            if value is None and name in _POSITIVE_IF_GIVEN:
                continue
            if not 0.0 < value < math.inf:
                raise InvalidInputError(f"{name} is {value}; it must be positive")
        if self.complete and self.no_place_after is not None:
            raise InvalidInputError(
                f"no_place_after is {self.no_place_after}, but complete is true: with the third "
                "stage of the planner robots do not tell where they found no place; set complete "
                "to false, or leave out no_place_after"
            )
        for name in _AT_LEAST_ONE:
            if getattr(self, name) < 1:
                raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be at least 1")
        for low, high in pairwise(("crowded_after", "jammed_after", "gives_up_after")):
            if getattr(self, high) < getattr(self, low):
                raise InvalidInputError(
                    f"{high} is {getattr(self, high)}; it must be at least {low}, which is "
                    f"{getattr(self, low)}"
                )


class BallOptions(MultiSrtOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of a Multi-SRT explorer whose safe regions are balls.

    A ball is no larger than the distance from the nearest obstacle, and allows steps that are as
    small. In a corridor of three body widths they are shorter than the `d_min_m` of other regions,
    which would refuse all of them.

    Attributes
    ----------
    d_min_m : float or None
        As above; here None for half of the body's width.

    Examples
    --------
    >>> MultiSrtOptions().distance_from_nodes_m(0.5), BallOptions().distance_from_nodes_m(0.5)
    (0.5, 0.25)
    """

    def distance_from_nodes_m(self, width_m: float) -> float:
        """Return `d_min_m`, or its default for a body of this width in metres."""
        return 0.5 * width_m if self.d_min_m is None else self.d_min_m
