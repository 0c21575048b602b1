"""Parameters of the strategies that go to frontiers."""

from __future__ import annotations

import math
from typing import Literal

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.shapes import Shape
from multisrt.robots.frontier.pursuit_options import PursuitOptions


class FrontierOptions(PursuitOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters that all strategies of the family share: those of `PursuitOptions`, and these.

    Attributes
    ----------
    cell_m : float
        Width of the raster's cells in metres; at most the body's width.
    margin_m : float
        Distance in metres that the body keeps from what is not known to be free.
    shape : {"ball", "star", "radial"}
        Shape of the local safe regions that are painted into the raster.
    cones : int
        Number of equal cones of a star.
    sense : {"moving", "targets"}
        Whether the robot takes scans for its map while it drives, or only at its goals and where
        it would give one up because no path to it is free.
    sense_period_s : float
        Time between two scans that are added to the map while driving, in seconds.
    min_frontier_m : float or None
        Groups of frontier cells that are shorter than this, as many times `cell_m` as they have
        cells, are dropped; None: the body's width.
    replan : {"news", "target", "arrival"}
        When a goal is chosen again: whenever the map has changed; when the last one is reached or
        nothing is left to be seen there; or only when it is reached, or another robot sends a stop
        signal (SBX-R). With "arrival" a robot drives on to a goal that is no frontier any more. In
        all cases it also chooses again where its path turns out not to be free, after it gave way
        or waited for others, and where it was done and hears something new.
    replan_period_s : float
        Minimum time between two choices because of news, in seconds.
    reached : {"cell", "sight"}
        Whether a goal is reached at its cell, or where it is in sight within half the range.
    paths : {"march", "eedt"}
        Whether the paths that the robot drives come from a fast march, or from the exact
        Euclidean distance transform that SBX-R uses. The lengths by which goals are chosen are
        those of the fast march in either case.
    saves_turns : bool
        Whether a differential drive turns on the way where there is room for the curve, and takes a
        leg of its path backwards where it turns less for that: a range finder that sees all around
        shows the same either way. With bodies in the way it turns in place.
    report_period_s : float
        Time after which a robot that drives reports its position, if it has reported nothing
        else, in seconds.
    lost_after_s : float
        A robot that has not been heard from for this long is presumed lost, in seconds. Until
        then it is taken into account with its last known position and goal. A robot that is met
        and does not answer is presumed lost at once. One that is heard again takes part again.
    relay_for_s : float
        Where the radio relays no messages, robots pass on the reports of others, if these have
        been heard from for at most this long, in seconds.
    answers : {"own", "known"}
        Whether a robot that is asked where it goes answers for itself alone, or also passes on what
        it knows of all others that it takes into account (SBX-R, Algorithm 3).
    body_stays_s : float
        For about this long (half of it to one and a half times), in seconds, the body of a robot
        that answers but does not leave counts as an obstacle. That of a robot presumed lost does
        until it is heard of or seen elsewhere; but before a robot is boxed in by one that it saw
        longer ago than this, it goes to look once whether that has left.
    guard_m : float
        Distance between two bodies, in metres, at which the protective stop ends a motion.
    ask_period_s : float
        Time after which a question without an answer is repeated, in seconds; the latency of the
        radio is added.
    pause_s : float
        Scale of the random times after which robots that block each other try again, in seconds:
        up to this where a robot that was asked to leave has answered, where the asked robot finds
        no place to go to, and after `max_instant_goals`; half of this to one and a half times
        this after a robot gave way, and where one waits for others to leave the paths to the last
        frontiers.
    patience : int
        How often a robot asks another to give way before it looks for another path or goal.
    max_waits : int
        How often, with nothing new in its map, a robot waits for others to leave the paths to the
        last frontiers before it is done. A wait takes about `pause_s`, so the default is about a
        minute: longer than two robots need to pass each other in a corridor.
    max_jams : int
        How often, at one place and with nothing new in its map, a robot and others may fail to
        let each other pass before it is done. Crowds in narrow places need many attempts.
    max_instant_goals : int
        How many goals in a row may end at the moment they were chosen before a robot pauses.
        Without pauses, robots that stop each other at once would choose forever.
    detour_factor : float
        A detour round another robot may be longer than the path by this factor...
    detour_extra_m : float
        ... and this length in metres. Beyond that, asking the other to give way is quicker.
    aside_m : float
        How far, along x and y, a robot looks for a place to give way, in metres.
    max_vain_motions : int
        Cars: how many motions to a goal that bring the car no nearer are tried until the map
        changes.
    """

    cell_m: float = 0.1
    margin_m: float = 0.02
    shape: Shape = "radial"
    cones: int = 16
    sense: Literal["moving", "targets"] = "moving"
    sense_period_s: float = 1.0
    min_frontier_m: float | None = None
    replan: Literal["news", "target", "arrival"] = "news"
    replan_period_s: float = 2.0
    reached: Literal["cell", "sight"] = "cell"
    paths: Literal["march", "eedt"] = "march"
    saves_turns: bool = False
    report_period_s: float = 2.0
    lost_after_s: float = 15.0
    relay_for_s: float = 15.0
    answers: Literal["own", "known"] = "own"
    body_stays_s: float = 15.0
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
        super().__post_init__()
        for name in (
            "cell_m",
            "sense_period_s",
            "replan_period_s",
            "report_period_s",
            "lost_after_s",
            "relay_for_s",
            "body_stays_s",
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
        least = self.min_frontier_m
        self.require("min_frontier_m", least is None or 0.0 <= least < math.inf, "0 or more")

    def require(self, name: str, holds: bool, allowed: str) -> None:
        """Raise an error unless a condition on a parameter holds.

        Parameters
        ----------
        name : str
            Name of the parameter.
        holds : bool
            The condition.
        allowed : str
            The values allowed, for the message.

        Raises
        ------
        InvalidInputError
            If the condition does not hold.
        """
        if not holds:
            raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be {allowed}")


class BiddingOptions(FrontierOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `closest`, `greedy` and `minpos`: those of `FrontierOptions`, and of driving.

    Attributes
    ----------
    drive : {"path", "nearness-diagram"}
        Whether the robot follows its path, or steers along it by Smooth Nearness Diagram, which
        slows down near obstacles. With ``sense="targets"`` it follows its path in either case.
    control_period_s : float
        How long a command of the nearness diagram is held, in seconds.
    lookahead_m : float
        How far ahead on the path the nearness diagram aims, in metres.
    """

    drive: Literal["path", "nearness-diagram"] = "path"
    control_period_s: float = 0.5
    lookahead_m: float = 1.5

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("control_period_s", "lookahead_m"):
            self.require(name, 0.0 < getattr(self, name) < math.inf, "positive")


class UtilityOptions(BiddingOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `utility`: those of `BiddingOptions`, and of the rule.

    Attributes
    ----------
    replan : {"target", "news", "arrival"}
        As above; in the paper a robot asks for a goal when it needs one.
    beta : float
        Weight of the path length against the utility (Burgard et al.: beta).
    overlap_ranges : float
        Distance from which frontiers take no utility from each other, in ranges of the range finder
        (Burgard et al.: 1). Areas seen from two places overlap up to 2.
    """

    replan: Literal["news", "target", "arrival"] = "target"
    beta: float = 1.0
    overlap_ranges: float = 2.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require("beta", 0.0 <= self.beta < math.inf, "0 or more")
        self.require("overlap_ranges", 0.0 < self.overlap_ranges < math.inf, "positive")


class PathCostOptions(BiddingOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of rules that count more than the length of a path: `gain` and `routes`.

    Attributes
    ----------
    saves_turns : bool
        As above.
    turn_m_per_rad : float
        Path length in metres that a radian of the first turn counts as.
    keep_m : float
        By how many metres the present goal of a robot counts as nearer, so that it does not turn
        to another one for a small advantage.
    """

    saves_turns: bool = True
    turn_m_per_rad: float = 0.3
    keep_m: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require("turn_m_per_rad", 0.0 <= self.turn_m_per_rad < math.inf, "0 or more")
        self.require("keep_m", 0.0 <= self.keep_m < math.inf, "0 or more")


class GainOptions(PathCostOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `gain`: those of `PathCostOptions`, and of the rule.

    Attributes
    ----------
    power : float
        Exponent of the path length in the value of a frontier.
    return_area_m2 : float
        Area in square metres that stands for the way back to a frontier that is left behind; it is
        added to the area beyond each. If every message reaches every robot, it is divided by the
        number of robots that the choice takes into account.
    overlap_ranges : float
        Distance from which a frontier that is taken no longer reduces the area of another, in
        ranges of the range finder. Areas seen from two places overlap up to 2.
    tour_weight : float
        Weight of the length of the tour over the frontiers that are left, against the way to the
        first of them. With 0 robots go to the frontier of the highest value that others leave
        them.
    room_m2 : float
        Maximum known area of a room in square metres, such as 30; with 0 there are no rooms. A
        robot in a room goes to the frontiers that it takes there before all others. A room is a
        part of its map that doorways of at most 1.4 m separate from the rest.
    routes_below_m2 : float
        Area in square metres: robots plan routes as in `routes` while no frontier that they can go
        to has as much unknown area in sight; with 0 they never do.
    """

    power: float = 4.0
    return_area_m2: float = 5.0
    overlap_ranges: float = 1.0
    tour_weight: float = 2.0
    room_m2: float = 0.0
    routes_below_m2: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("power", "overlap_ranges"):
            self.require(name, 0.0 < getattr(self, name) < math.inf, "positive")
        for name in ("return_area_m2", "tour_weight", "room_m2", "routes_below_m2"):
            self.require(name, 0.0 <= getattr(self, name) < math.inf, "0 or more")
        has_tours = self.tour_weight > 0.0
        self.require("room_m2", has_tours or not self.room_m2, "0 without tours (tour_weight)")


class RoutesOptions(PathCostOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `routes`: those of `PathCostOptions`, and of the rule.

    Attributes
    ----------
    search_m_per_m2 : float
        Path length in metres that a robot needs to explore a square metre beyond a frontier.
    keep_m : float
        As above.
    """

    keep_m: float = 2.0
    search_m_per_m2: float = 0.15

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require("search_m_per_m2", 0.0 <= self.search_m_per_m2 < math.inf, "0 or more")


class SelfBiddingOptions(BiddingOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `self-bidding` (SBX-R): those of `BiddingOptions`, and of the rule.

    Attributes
    ----------
    replan : {"arrival", "target", "news"}
        As above. The paper says both: by its Algorithm 1 a robot chooses again at its target or on
        a stop signal ("arrival"), by section III, state 2, when its target has been explored
        ("target").
    lost_after_s : float
        As above; in the paper a robot is left out only when it is broken. Silence does not tell
        whether a robot is broken or out of range, so the default is longer than robots usually
        stay apart: with 15 s those that part are no longer bound to each other.
    answers : {"known", "own"}
        As above.
    stop_signals : bool
        Whether robots send stop signals.
    reached : {"cell", "sight"}
        As above.
    paths : {"march", "eedt"}
        As above.
    phi_factor : float
        First radius of cohesion, in ranges of the radio (paper: j).
    phi_step : float
        Increase of the factor while the robot has no finite bid.
    drive : {"nearness-diagram", "path"}
        As above.
    """

    replan: Literal["news", "target", "arrival"] = "arrival"
    reached: Literal["cell", "sight"] = "sight"
    paths: Literal["march", "eedt"] = "eedt"
    lost_after_s: float = 600.0
    answers: Literal["own", "known"] = "known"
    stop_signals: bool = True
    phi_factor: float = 0.9
    phi_step: float = 0.5
    drive: Literal["path", "nearness-diagram"] = "nearness-diagram"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("phi_factor", "phi_step"):
            self.require(name, 0.0 < getattr(self, name) < math.inf, "positive")


class RulesOptions(FrontierOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of `rules` (Álvarez): those of `FrontierOptions`, and of the rules.

    The thesis has cells of 0.5 m, "almost the size of the robot", for the map as well as for goals
    (`cell_m` and `search_cell_m`), goals that are swapped as by `exchange_when` = "nearer", a
    Husky A200 at 0.1 m/s, and range finders of 4.5 m.

    Attributes
    ----------
    replan : {"target", "news"}
        As above; in the thesis a robot keeps its goal until that cell is explored.
    search_cell_m : float
        Width in metres of the cells that are goals; at least `cell_m`.
    enough_share : float
        Share of all cells that the search for goals must find unexplored before it ends.
    distance_weight, turn_weight, others_weight : float
        Weights of the distance to a cell, of the turn towards it, and of its distance from the
        goals of other robots (thesis: 45, 25 and 30).
    conflict_radius_m : float
        How far ahead, in metres, a robot looks for others to wait for; 0: it does not.
    exchange : bool
        Whether robots swap goals.
    exchange_when : {"shorter", "nearer"}
        When they do. "nearer": a robot takes the goal of another if the path to it is shorter than
        to its own goal, and shorter than the other robot's path to it, whatever the other robot
        gets in return (thesis: Algorithm 6). "shorter": the sum of the two paths must not grow
        by more than `cell_m` either.
    random_goal_after : int
        Number of goals in a row that a robot could not drive to after which it goes to a random
        place.
    max_failures : int
        How often no path leads to a goal before it is not tried again.
    """

    replan: Literal["news", "target"] = "target"
    search_cell_m: float = 0.5
    enough_share: float = 0.05
    distance_weight: float = 45.0
    turn_weight: float = 25.0
    others_weight: float = 30.0
    conflict_radius_m: float = 1.5
    exchange: bool = True
    exchange_when: Literal["shorter", "nearer"] = "shorter"
    random_goal_after: int = 3
    max_failures: int = 2

    def __post_init__(self) -> None:
        super().__post_init__()
        width = self.search_cell_m
        self.require("search_cell_m", self.cell_m <= width < math.inf, "at least cell_m")
        self.require("enough_share", 0.0 < self.enough_share <= 1.0, "above 0 and at most 1")
        for name in ("distance_weight", "turn_weight", "others_weight", "conflict_radius_m"):
            self.require(name, 0.0 <= getattr(self, name) < math.inf, "0 or more")
        for name in ("random_goal_after", "max_failures"):
            self.require(name, getattr(self, name) >= 1, "at least 1")
