"""Pictures of the gallery: every world, and a run of every strategy."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import multisrt as ms
from multisrt.drawing import environment_svg, tree_svg

STRATEGIES = [
    "srt-ball",
    "srt-star",
    "srt-radial",
    "closest",
    "greedy",
    "minpos",
    "utility",
    "self-bidding",
    "rules",
    "gain",
    "routes",
]


def world(name: str) -> str:
    """Draw a world."""
    return environment_svg(ms.environment(name))


def strategy(name: str) -> str:
    """Draw a run of three robots in the apartment."""
    run = ms.explore("apartment", strategy=name, robots=3, starts="clustered", seed=1)
    return tree_svg(run.recording)


FIGURES: dict[str, Callable[[], str]] = {
    **{f"world-{entry.name}": partial(world, entry.name) for entry in ms.catalog()},
    **{f"strategy-{name}": partial(strategy, name) for name in STRATEGIES},
}
