"""Pictures of the page on figures: one of every kind, by the functions of its commands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial

import multisrt as ms
from multisrt.drawing import tree_svg
from multisrt.drawing.figures import figure_bytes
from multisrt.recording import Recording


@cache
def team(name: str) -> Recording:
    """Return the run of a command of the page."""
    given = {"robots": 3, "starts": "clustered", "seed": 1}
    radio = None if name == "srt-radial" else ms.RadioSpec(range_m=6.0)
    return ms.explore("apartment", strategy=name, radio=radio, **given).recording


@cache
def seeds() -> tuple[Recording, ...]:
    """Return three runs each of two strategies."""
    return tuple(
        ms.explore("apartment", strategy=strategy, robots=3, seed=seed).recording
        for strategy in ("srt-radial", "minpos")
        for seed in (1, 2, 3)
    )


def drawn(kind: str, *names: str) -> str:
    """Draw a figure of some runs, or of all seeds."""
    runs: Sequence[Recording] = [team(name) for name in names] or seeds()
    return figure_bytes(kind, runs).decode()


def without_layers() -> str:
    """Draw a tree without some layers."""
    return tree_svg(team("srt-radial"), without=["outlines", "support", "areas"])


FIGURES: dict[str, Callable[[], str]] = {
    "map": partial(drawn, "map", "srt-radial"),
    "maps": partial(drawn, "maps", "self-bidding"),
    "trajectories": partial(drawn, "trajectories", "self-bidding", "closest"),
    "coverage": partial(drawn, "coverage"),
    "activity": partial(drawn, "activity", "srt-radial"),
    "visits": partial(drawn, "visits", "self-bidding"),
    "isolation": partial(drawn, "isolation", "self-bidding", "closest"),
    "decisions": partial(drawn, "decisions", "srt-radial", "self-bidding"),
    "without-layers": without_layers,
}
