"""Parameters of frontier bidding."""

from __future__ import annotations

import math
from typing import Literal

import msgspec

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.safe_region import Shape


class FrontierOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What all strategies that bid for frontiers have in common.

    Attributes
    ----------
    cell_m : float
        Width of the raster's cells; never above the body's width.
    margin_m : float
        How far the body stays away from what is not surely free.
    shape : {"ball", "star", "radial"}
        Shape of the regions that are painted into the raster.
    cones : int
        How many equal cones a star has.
    sense : {"moving", "targets"}
        Whether the range finder looks round while the robot drives, or at its goals only.
    sense_period_s : float
        How often it does so while driving.
    least_frontier_m : float or None
        A group of frontier cells that is shorter is dropped; None: the body's width.
    replan : {"news", "target"}
        Whether a goal is chosen anew whenever the map has changed, or only when the last one is
        reached or nothing is left to be seen there.
    replan_period_s : float
        With `news`: at most once in this time.
    reached : {"cell", "sight"}
        Whether a goal is reached at its cell, or where it is in sight within half the range.
    paths : {"march", "eedt"}
        Whether paths to goals come from a fast march, or from the exact Euclidean distances that
        SBX-R uses.
    report_period_s : float
        How often a robot that drives tells where it is, if it has nothing else to tell.
    forget_after_s : float
        A robot that drives and was not heard of for so long is no longer reckoned with.
    guard_m : float
        A robot stops before another's body comes nearer than this.
    ask_period_s : float
        A robot that waits for another's answer asks again after this time; latency comes on top.
    pause_s : float
        Robots that stand in each other's way try again after up to this time, each its own.
    patience : int
        How often a robot asks another to give way before it looks for another way or goal.
    max_waits : int
        How often, with nothing new in its map, a robot waits for others to leave the ways to the
        last frontiers before it is done. Each wait takes about `pause_s`, so the default is a
        minute: longer than robots need to pass each other in a corridor.
    max_jams : int
        How often, at one place and with nothing new in its map, a robot and others may fail to
        let each other pass before it is done. Crowds in narrow places need many attempts.
    max_instant_goals : int
        How many goals in a row may end at the moment they were chosen before a robot pauses, so
        that robots that stop each other at once do not choose without end.
    detour_factor : float
        A detour round another robot may be longer than the path by this factor...
    detour_extra_m : float
        ... and this length in metres; otherwise asking it to give way takes less time.
    aside_m : float
        How far, in x and y, a robot looks for a place to give way.
    max_vain_motions : int
        Cars: how many motions to a goal that bring the car no nearer are tried until the map
        changes.
    """

    cell_m: float = 0.1
    margin_m: float = 0.02
    shape: Shape = "radial"
    cones: int = 16
    sense: Literal["moving", "targets"] = "moving"
    sense_period_s: float = 0.5
    least_frontier_m: float | None = None
    replan: Literal["news", "target"] = "news"
    replan_period_s: float = 1.0
    reached: Literal["cell", "sight"] = "cell"
    paths: Literal["march", "eedt"] = "march"
    report_period_s: float = 2.0
    forget_after_s: float = 15.0
    guard_m: float = 0.1
    ask_period_s: float = 0.5
    pause_s: float = 2.0
    patience: int = 4
    max_waits: int = 30
    max_jams: int = 100
    max_instant_goals: int = 5
    detour_factor: float = 1.5
    detour_extra_m: float = 3.0
    aside_m: float = 15.0
    max_vain_motions: int = 4

    def __post_init__(self) -> None:
        for name in (
            "cell_m",
            "sense_period_s",
            "replan_period_s",
            "report_period_s",
            "forget_after_s",
            "guard_m",
            "ask_period_s",
            "pause_s",
            "aside_m",
        ):
            self.require(name, 0.0 < getattr(self, name) < math.inf, "positive")
        for name in ("margin_m", "detour_extra_m"):
            self.require(name, 0.0 <= getattr(self, name) < math.inf, "0 or more")
        self.require("cones", self.cones >= 3, "at least 3")
        for name in ("patience", "max_waits", "max_jams", "max_instant_goals", "max_vain_motions"):
            self.require(name, getattr(self, name) >= 1, "at least 1")
        self.require("detour_factor", 1.0 <= self.detour_factor < math.inf, "at least 1")
        least = self.least_frontier_m
        self.require("least_frontier_m", least is None or 0.0 <= least < math.inf, "0 or more")

    def require(self, name: str, holds: bool, allowed: str) -> None:
        """Refuse a value that is not allowed.

        Raises
        ------
        InvalidInputError
            The message says what is.
        """
        if not holds:
            raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be {allowed}")


class BiddingOptions(FrontierOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `closest`, `greedy` and `minpos`: those of `FrontierOptions`, and of driving.

    Attributes
    ----------
    drive : {"path", "nearness-diagram"}
        Whether the robot follows its path, or drives by Smooth Nearness Diagram along it, which
        slows down near obstacles.
    control_period_s : float
        How long a command of the nearness diagram is held.
    lookahead_m : float
        How far ahead on its path the nearness diagram is led.
    """

    drive: Literal["path", "nearness-diagram"] = "path"
    control_period_s: float = 0.25
    lookahead_m: float = 1.5

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("control_period_s", "lookahead_m"):
            self.require(name, 0.0 < getattr(self, name) < math.inf, "positive")


class UtilityOptions(BiddingOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `utility`: those of `BiddingOptions`, and of the rule.

    Attributes
    ----------
    replan : {"target", "news"}
        As above; in the paper goals are given anew whenever a robot needs one.
    beta : float
        Weight of the distance against the utility (Burgard et al.: beta).
    """

    replan: Literal["news", "target"] = "target"
    beta: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require("beta", 0.0 <= self.beta < math.inf, "0 or more")


class SelfBiddingOptions(BiddingOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `self-bidding` (SBX-R): those of `BiddingOptions`, and of the rule.

    Attributes
    ----------
    replan : {"target", "news"}
        As above; in the paper a robot decides at its target, or on a stop signal.
    reached : {"cell", "sight"}
        As above.
    paths : {"march", "eedt"}
        As above.
    phi_factor : float
        The first radius of cohesion, in ranges of the radio (paper: j).
    phi_step : float
        By how much the factor grows while the robot has no finite bid.
    drive : {"nearness-diagram", "path"}
        As above.
    """

    replan: Literal["news", "target"] = "target"
    reached: Literal["cell", "sight"] = "sight"
    paths: Literal["march", "eedt"] = "eedt"
    phi_factor: float = 0.9
    phi_step: float = 0.5
    drive: Literal["path", "nearness-diagram"] = "nearness-diagram"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("phi_factor", "phi_step"):
            self.require(name, 0.0 < getattr(self, name) < math.inf, "positive")


class RulesOptions(FrontierOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `rules` (Álvarez): those of `FrontierOptions`, and of the rules.

    Attributes
    ----------
    replan : {"target", "news"}
        As above; in the thesis a robot keeps its goal until that cell is explored.
    search_cell_m : float
        Width of the cells that are goals; never below `cell_m`.
    enough_share : float
        The search for goals widens until so large a share of all cells is found unexplored.
    distance_weight, turn_weight, others_weight : float
        What a cell's distance, the turn towards it and its distance from the others' goals
        weigh in its score (thesis: 45, 25 and 30).
    conflict_radius_m : float
        How far ahead a robot looks for others that it has to wait for; 0: it does not.
    exchange : bool
        Whether robots swap goals.
    random_goal_after : int
        After so many goals in a row to which it could not drive, a robot goes to a random place.
    """

    replan: Literal["news", "target"] = "target"
    search_cell_m: float = 0.5
    enough_share: float = 0.05
    distance_weight: float = 45.0
    turn_weight: float = 25.0
    others_weight: float = 30.0
    conflict_radius_m: float = 1.5
    exchange: bool = True
    random_goal_after: int = 3

    def __post_init__(self) -> None:
        super().__post_init__()
        width = self.search_cell_m
        self.require("search_cell_m", self.cell_m <= width < math.inf, "at least cell_m")
        self.require("enough_share", 0.0 < self.enough_share <= 1.0, "above 0 and at most 1")
        for name in ("distance_weight", "turn_weight", "others_weight", "conflict_radius_m"):
            self.require(name, 0.0 <= getattr(self, name) < math.inf, "0 or more")
        self.require("random_goal_after", self.random_goal_after >= 1, "at least 1")
