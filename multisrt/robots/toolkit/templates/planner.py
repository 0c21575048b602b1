"""A planner on safe regions: the next place in the map. All else is done for it.

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
    """Go where much frontier is seen for a short path, and no other robot goes."""

    options: Options

    def __init__(self, me: Any, options: Options) -> None:
        super().__init__(me, options)

    def choose(self) -> Any:
        """Return the place to scan from next, or None if there is none left."""
        # self.map has nodes: places where scans were taken, each with its local safe region and
        # the arcs of its border beyond which nothing is known. The robot's own and those of
        # others are in it.
        arcs = [arc for node in self.map.open_nodes() for arc in self.map.frontier_arcs(node)]
        if not arcs:
            return None
        # An arc is a row of segments x0, y0, x1, y1. Candidates: the middle of each, and both
        # ends, which may be in reach where the middle is not.
        places = np.vstack([[arc[len(arc) // 2, :2], arc[0, :2], arc[-1, 2:]] for arc in arcs])
        frontier_m = np.repeat([np.hypot(*(arc[:, 2:] - arc[:, :2]).T).sum() for arc in arcs], 3)
        path_m = self.costs(places)  # inf: no path, or it has been there
        score = path_m - self.options.gain * frontier_m
        goals = [other.goal for other in self.teammates() if other.goal is not None]
        if goals:
            near = cdist(places, goals).min(axis=1) < self.options.apart_m
            score = score + 100.0 * near
        best = int(score.argmin())
        # 'multisrt why' shows this.
        self.explain(
            "least path less frontier", places, score=score, path_m=path_m, frontier_m=frontier_m
        )
        return places[best] if np.isfinite(score[best]) else None
