"""The strategies of this package: names, options, and which runs they can make.

What explores is in `explorers`, which is imported with the first explorer that is built.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import msgspec

from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.frontier.options import (
    BiddingOptions,
    GainOptions,
    RoutesOptions,
    RulesOptions,
    SelfBiddingOptions,
    UtilityOptions,
)
from multisrt.robots.multi_srt.options import BallOptions, MultiSrtOptions
from multisrt.robots.strategy import Strategy

if TYPE_CHECKING:
    from multisrt.robots.explorer import Explorer, RobotSelf
    from multisrt.spec import RunSpec


def _strategy(
    name: str,
    summary: str,
    options: type[msgspec.Struct],
    fits: Callable[[RunSpec], None] | None = None,
) -> Strategy:
    def explorer(me: RobotSelf, options: Any) -> Explorer:
        from multisrt.robots.explorers import EXPLORERS

        return EXPLORERS[name](me, options)

    return Strategy(name=name, summary=summary, options=options, explorer=explorer, fits=fits)


def _bids(
    name: str,
    summary: str,
    options: type[BiddingOptions],
    fits: Callable[[RunSpec], None] | None = None,
) -> Strategy:
    def require_fit(spec: RunSpec) -> None:
        if spec.options.get("drive", options().drive) == "nearness-diagram":
            require_no_car(spec)
        if fits is not None:
            fits(spec)

    return _strategy(name, summary, options, require_fit)


def require_no_car(spec: RunSpec) -> None:
    """Refuse a run with a robot that is a car, which the nearness diagram cannot drive."""
    for number, robot in enumerate(spec.robots):
        if robot.drive.is_car:
            raise InvalidInputError(
                f"robot {number} is a car, which {spec.strategy} cannot drive by the nearness "
                "diagram; choose drive=path, or give it a holonomic or differential drive"
            )


def _require_reach(spec: RunSpec) -> None:
    # Robots that may become engaged have to hear one another before: R_c >= 3 R_p (Multi-SRT,
    # section 2).
    reach, ranges = spec.radio.range_m, [robot.range_finder.range_m for robot in spec.robots]
    least = 3.0 * max(ranges)
    if len(spec.robots) == 1 or reach is None or math.isclose(reach, least):
        return
    if reach < least:
        raise InvalidInputError(
            f"{spec.strategy} needs a radio range of at least three times the sensor range: "
            f"{least:g} m for a sensor range of {max(ranges):g} m, not {reach:g} m; "
            "give a longer radio range, or none for an unlimited one"
        )


def _require_talk(spec: RunSpec) -> None:
    # Assigning, bidding for others and swapping goals need their positions.
    if len(spec.robots) > 1 and spec.radio.range_m == 0.0:
        raise InvalidInputError(
            f"{spec.strategy} needs robots that hear one another, and the radio range is 0; "
            "give a longer radio range, or none for an unlimited one"
        )


_SRT = "Sensor-based Random Tree; safe regions are "

BUILT_IN = (
    _strategy("srt-ball", f"{_SRT}discs of the smallest reading", BallOptions, _require_reach),
    _strategy("srt-star", f"{_SRT}stars of equal cones", MultiSrtOptions, _require_reach),
    _strategy(
        "srt-radial", f"{_SRT}stars that keep every reading", MultiSrtOptions, _require_reach
    ),
    _bids("closest", "Each robot goes to its nearest frontier", BiddingOptions),
    _bids("greedy", "Frontiers are assigned to robots at increasing path length", BiddingOptions),
    _bids(
        "minpos",
        "Each robot goes to the frontier to which the fewest others are nearer",
        BiddingOptions,
    ),
    _bids(
        "utility",
        "A leader assigns frontiers by unknown area in view and path length",
        UtilityOptions,
        _require_talk,
    ),
    _bids(
        "self-bidding",
        "SBX-R: each robot bids for the whole team, and favours staying in touch",
        SelfBiddingOptions,
        _require_talk,
    ),
    _strategy(
        "rules",
        "Álvarez: scores of unexplored cells, right of way, and exchange of goals",
        RulesOptions,
        _require_talk,
    ),
    _bids("gain", "Large unknown areas at short paths, on a short tour of the rest", GainOptions),
    _bids(
        "routes",
        "Plans routes of the whole team over up to 24 frontiers, with the longest kept short",
        RoutesOptions,
    ),
)
"""All of them but `informed`, which sees the truth."""
