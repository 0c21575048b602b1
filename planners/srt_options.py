"""Parameters of Sensor-based Random Trees."""

from __future__ import annotations

import math
from typing import Literal

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.shapes import CONTACT_TOLERANCE_M, MIN_CONES
from multisrt.planners.home_options import HomeOptions
from multisrt.planners.motion.margin import MIN_MARGIN_M


class SrtOptions(HomeOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters of an SRT explorer, with the paper's names where it has any.

    Those of `HomeOptions` come first.

    Attributes
    ----------
    choice : {"random", "gain"}
        How the next place is chosen: drawn at random towards the local frontier, as in the paper,
        with the stages that follow; or a place that sees the frontier arc of the highest value,
        the area that it would show over a power of the way there. Then `alpha`, `max_draws`,
        `frontier_bias` and `approach` have no effect on a robot's own plans, and `complete` is
        needed.
    power : float
        With ``choice="gain"``: power of the way in the value of an arc.
    return_area_m2 : float
        With ``choice="gain"``: area in square metres that stands for the way back to an arc that is
        left behind; it is added to the area beyond each.
    turn_m_per_rad : float
        With ``choice="gain"``: way in metres that a radian of the first turn counts as.
    stop_share : float
        With ``choice="gain"``: on the last straight piece of its way the robot stops where this
        share of the largest unknown area that any place on it shows is in sight; 1 to go all the
        way.
    alpha : float
        Distance of a candidate as a share of the distance to the region's boundary (paper: alpha).
    max_draws : int
        Maximum number of candidates drawn at a node (paper: I_max).
    d_min_m : float or None
        Minimum distance of a candidate from every node in metres; None for the body's width.
    frontier_bias : bool
        Draw towards the local frontier (Multi-SRT). Otherwise directions are uniform, and
        candidates lie in no other region (single-robot SRT).
    gaps_count : bool
        Whether radial pieces of the boundary behind corners are frontier.
    approach : bool
        Use the second stage.
    complete : bool
        Use the third stage.
    backtrack : {"parent", "nearest_open"}
        Where to go from a node with nothing to do: step by step to the parent, as in the paper,
        or over the roadmap to the nearest node with a frontier.
    cones : int
        Number of cones of a star.
    contact_tolerance_m : float
        Maximum distance in metres between the arc of a star or ball and a reading behind it at
        which the arc is an obstacle.
    margin_m : float
        Distance of the body from the border of known space in metres, where there is room for it.
    completion_spacing : float
        In the third stage, minimum distance from all nodes as a share of `d_min_m`.
    max_views : int
        In the third stage, maximum number of views of arcs in one spot of width `d_min_m`. They
        are counted anew when they have shown as much near it as a square of that width.

    Raises
    ------
    InvalidInputError
        If a value is outside its range.
    """

    choice: Literal["random", "gain"] = "random"
    power: float = 4.0
    return_area_m2: float = 5.0
    turn_m_per_rad: float = 0.3
    stop_share: float = 0.2
    alpha: float = 0.8
    max_draws: int = 10
    d_min_m: float | None = None
    frontier_bias: bool = True
    gaps_count: bool = True
    approach: bool = True
    complete: bool = True
    backtrack: Literal["parent", "nearest_open"] = "parent"
    cones: int = 16
    contact_tolerance_m: float = CONTACT_TOLERANCE_M
    margin_m: float = 0.02
    completion_spacing: float = 0.5
    max_views: int = 3

    def distance_from_nodes_m(self, width_m: float) -> float:
        """Return `d_min_m`, or its default for a body of this width in metres."""
        return width_m if self.d_min_m is None else self.d_min_m

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.choice == "gain" and not self.complete:
            raise InvalidInputError(
                "choice is gain, but complete is false: arcs are looked at from the places of the "
                "third stage; set complete to true, or choice to random"
            )
        for name, ok, allowed in (
            ("power", 0.0 < self.power < math.inf, "positive"),
            ("return_area_m2", 0.0 <= self.return_area_m2 < math.inf, "0 or more"),
            ("turn_m_per_rad", 0.0 <= self.turn_m_per_rad < math.inf, "0 or more"),
            ("stop_share", 0.0 < self.stop_share <= 1.0, "above 0 and at most 1"),
            ("alpha", 0.0 < self.alpha <= 1.0, "above 0 and at most 1"),
            ("max_draws", self.max_draws >= 1, "at least 1"),
            ("d_min_m", self.d_min_m is None or 0.0 < self.d_min_m < math.inf, "positive"),
            ("cones", self.cones >= MIN_CONES, f"at least {MIN_CONES}"),
            ("contact_tolerance_m", 0.0 <= self.contact_tolerance_m < math.inf, "0 or more"),
            (
                "margin_m",
                5.0 * MIN_MARGIN_M <= self.margin_m < math.inf,
                f"at least {5.0 * MIN_MARGIN_M:g}",
            ),
            ("max_views", self.max_views >= 1, "at least 1"),
            ("completion_spacing", 0.0 < self.completion_spacing < math.inf, "positive"),
        ):
            if not ok:
                raise InvalidInputError(f"{name} is {getattr(self, name)}; it must be {allowed}")
