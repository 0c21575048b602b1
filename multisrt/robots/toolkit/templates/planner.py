"""A planner on safe regions: it chooses the next place. The rest is provided.

multisrt check mine.py
multisrt explore museum --strategy mine.py --robots 3
multisrt why runs/museum-mine-0 --all
"""

from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from multisrt.robots.toolkit import RegionExplorer, RegionOptions


class Options(RegionOptions, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Parameters, to be set with --option NAME=VALUE.

    Attributes
    ----------
    gain : float
        How many metres of path a metre of frontier is worth.
    apart_m : float
        Distance in metres within which places near other robots' goals count as theirs.
    """

    gain: float = 1.0
    apart_m: float = 4.0


class Mine(RegionExplorer):
    """Go to long frontiers on short paths, away from the goals of other robots."""

    options: Options

    def __init__(self, me: Any, options: Options) -> None:
        super().__init__(me, options)

    def choose(self) -> Any:
        """Return the next place to scan from, or None if there is none left."""
        # self.map contains nodes, the robot's own and those of others: places where scans were
        # taken, each with its local safe region and the frontier arcs on its border, beyond
        # which nothing is known.
        arcs = [arc for node in self.map.open_nodes() for arc in self.map.frontier_arcs(node)]
        if not arcs:
            return None
        # An arc is an array of segments x0, y0, x1, y1. Candidates: the middle of each arc and
        # both ends, which may be reachable if the middle is not.
        places = np.vstack([[arc[len(arc) // 2, :2], arc[0, :2], arc[-1, 2:]] for arc in arcs])
        frontier_m = np.repeat([np.hypot(*(arc[:, 2:] - arc[:, :2]).T).sum() for arc in arcs], 3)
        path_m = self.costs(places)  # inf: no path, or visited before
        score = path_m - self.options.gain * frontier_m
        goals = [other.goal for other in self.teammates() if other.goal is not None]
        if goals:
            near = cdist(places, goals).min(axis=1) < self.options.apart_m
            score = score + 100.0 * near
        best = int(score.argmin())
        # 'multisrt why' shows these values.
        self.explain(
            "least path less frontier", places, score=score, path_m=path_m, frontier_m=frontier_m
        )
        return places[best] if np.isfinite(score[best]) else None
