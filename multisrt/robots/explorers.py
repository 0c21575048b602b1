"""The explorers of the strategies of this package, by their names.

They are apart from `built_in`, which describes the strategies: listing strategies and their options
needs neither the algorithms nor the compiled kernels below them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from multisrt.geometry.regions.shapes import Shape
from multisrt.robots.explorer import Explorer, RobotSelf
from multisrt.robots.frontier.alvarez import rules_explorer
from multisrt.robots.frontier.explore import FrontierExplorer, Rule
from multisrt.robots.frontier.gain import choose_gain
from multisrt.robots.frontier.nearness import drive_by_option
from multisrt.robots.frontier.options import BiddingOptions
from multisrt.robots.frontier.robot import Watch
from multisrt.robots.frontier.routes import choose_routes
from multisrt.robots.frontier.self_bidding import (
    choose_by_self_bidding,
    send_last_stop_signal,
    send_stop_signals,
)
from multisrt.robots.frontier.utility import answer_requests, choose_utility
from multisrt.robots.frontier.wavefront_rules import choose_closest, choose_greedy, choose_minpos
from multisrt.robots.multi_srt.build_multi_srt import SrtExplorer
from multisrt.robots.multi_srt.options import MultiSrtOptions


def _srt(shape: Shape) -> Callable[[RobotSelf, MultiSrtOptions], Explorer]:
    return lambda me, options: SrtExplorer(me, shape, options)


def _bids(
    rule: Rule, watch: Watch | None = None, at_end: Watch | None = None
) -> Callable[[RobotSelf, BiddingOptions], Explorer]:
    return lambda me, options: FrontierExplorer(me, options, rule, drive_by_option, watch, at_end)


def _led(me: RobotSelf, options: BiddingOptions) -> FrontierExplorer:
    explorer = FrontierExplorer(me, options, choose_utility, drive_by_option)
    answer_requests(explorer.robot)
    return explorer


EXPLORERS: Final[Mapping[str, Callable[[RobotSelf, Any], Explorer]]] = {
    "srt-ball": _srt("ball"),
    "srt-star": _srt("star"),
    "srt-radial": _srt("radial"),
    "closest": _bids(choose_closest),
    "greedy": _bids(choose_greedy),
    "minpos": _bids(choose_minpos),
    "utility": _led,
    "self-bidding": _bids(choose_by_self_bidding, send_stop_signals, send_last_stop_signal),
    "rules": rules_explorer,
    "gain": _bids(choose_gain),
    "routes": _bids(choose_routes),
}
"""Builds the explorer of one robot, for each strategy of `built_in`."""
