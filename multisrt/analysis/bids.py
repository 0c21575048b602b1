"""How far robots with self-bidding (SBX-R) had to let go of their team to find a goal."""

from __future__ import annotations

from collections import Counter
from typing import Final, Literal, get_args

import numpy as np

from multisrt.events import GoalChosen
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.planners.assignment.costs import UNASSIGNED
from multisrt.planners.assignment.self_bidding import minimum_matching
from multisrt.recording import Recording

Bid = Literal["first radius", "larger radius", "virtual frontier"]
"""How a goal was found: with the first radius of cohesion, with a larger one, or, as the robot was
matched to a virtual frontier, as its nearest one, which no radius bounds."""

BIDS: Final[tuple[Bid, ...]] = get_args(Bid)


def bids_by_radius(recording: Recording) -> Counter[Bid]:
    """Count the goals that were chosen by self-bidding, by the radius of cohesion.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    Counter of str to int
        Empty for other strategies.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", strategy="self-bidding", seed=1)
    >>> [*bids_by_radius(run.recording)]
    ['first radius']
    """
    return Counter(_bid(chosen) for chosen in recording.of(GoalChosen) if _was_bid_for(chosen))


def _was_bid_for(chosen: GoalChosen) -> bool:
    """Whether a goal was chosen by self-bidding, with all entries of its tables on record."""
    shape = [len(chosen.frontiers)] * len(chosen.robots)
    return (
        chosen.rule == "self-bidding"
        and chosen.goal is not None
        and chosen.robot in chosen.robots
        and all([*map(len, table)] == shape for table in (chosen.bids, chosen.costs))
    )


def _bid(chosen: GoalChosen) -> Bid:
    # The matching is not on record; it follows from the tables that are.
    matching = minimum_matching(_table(chosen.bids), _table(chosen.costs))
    if matching[chosen.robots.index(chosen.robot)] == UNASSIGNED:
        return "virtual frontier"
    return "first radius" if len(chosen.phi_m) <= 1 else "larger radius"


def _table(rows: tuple[tuple[float | None, ...], ...]) -> FloatArray:
    """Return the table of which `finite_or_none` of the robots made rows."""
    return np.array([[np.inf if x is None else x for x in row] for row in rows], np.float64)
