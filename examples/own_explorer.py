"""A new explorer: it drives to the nearest frontier, and back along its tree.

`python examples/own_explorer.py` checks it, explores an environment and writes a picture.
"""

from pathlib import Path

import msgspec
import numpy as np
from scipy.spatial.distance import cdist

import multisrt as ms
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.steering import turn_and_drive
from multisrt.robots.exploration_map import ExplorationMap, Node, NodeId
from multisrt.robots.explorer import Done, Move, Note, Receive, Sense
from multisrt.testing import check_explorer


class Options(msgspec.Struct, frozen=True, kw_only=True):
    """Distances (m) that the body keeps from unseen space and from other robots."""

    margin_m: float = 0.02
    guard_m: float = 0.1


class NearestFrontier:
    """An explorer for disc-shaped bodies with a differential or holonomic drive."""

    def __init__(self, me, options):
        self.me, self.options, self.at = me, options, me.start
        self.body = PlanningBody(me.footprint, options.margin_m)
        self.map = ExplorationMap(reach_m=me.range_m, min_arc_m=me.footprint.width_m)

    def run(self):
        """Extend the tree towards the nearest frontier; without one, return to the parent."""
        here, is_free = None, True
        while is_free:
            scan = yield Sense()
            here = yield from self.add(scan, parent=here)
            while is_free and (target := self.nearest_frontier(here)) is None:
                if (here := self.map[here].parent) is None:
                    return (yield Done(complete=self.map.is_complete(), reason="back at its root"))
                is_free = yield from self.go(*self.map[here].configuration[:2])
            is_free = is_free and (yield from self.go(*target))
        yield Done(complete=False, reason="another robot stays in its way")

    def add(self, scan, parent):
        """Add a node to the tree and record it."""
        region, name = local_safe_region(scan, "radial"), NodeId(self.me.robot, len(self.map))
        node = Node(
            id=name, configuration=self.at, region=region, parent=parent, time_s=scan.time_s
        )
        self.map.add(node)
        yield Note(node.added("root" if parent is None else "approach"))
        return name

    def nearest_frontier(self, here):
        """Return the point nearest to a frontier at which there is no node yet, or None."""
        region, frontier = self.map[here].region.boundary, self.map.frontier(here)
        for place in towards(frontier, region, self.at, self.body, self.me.range_m):
            if not self.map.near(*place, self.body.outer_radius_m):
                return place
        return None

    def go(self, x, y):
        """Turn and drive; wait and retry while another robot is in the way."""
        for _ in range(20):
            way = turn_and_drive(self.me.kinematics, self.at, x, y)
            moved = yield Move(trajectory=way, guard_m=self.options.guard_m)
            self.at = moved.configuration
            if moved.blocked_by is None:
                return True
            yield Receive(timeout_s=self.me.rng.uniform(1.0, 5.0))
        return False


def towards(frontier, region, at, body, range_m):
    """Return points in a straight line from here, sorted by distance to a frontier."""
    angle = np.linspace(0.0, 2.0 * np.pi, 72)
    way = np.column_stack([np.cos(angle), np.sin(angle)])
    way *= body.disc_fan(region, at, angle, range_m)[:, None]
    places = np.vstack([at[:2] + way, at[:2] + 0.5 * way])
    middles = 0.5 * (frontier[:, :2] + frontier[:, 2:])
    gaps = cdist(places, middles)
    gaps[gaps > cdist([at[:2]], middles) - body.outer_radius_m] = np.inf
    nearest = gaps.min(axis=1, initial=np.inf)
    return [places[k].tolist() for k in np.argsort(nearest, kind="stable") if nearest[k] < np.inf]


NEAREST_FRONTIER = ms.Strategy(
    name="nearest-frontier",
    summary="Straight to the nearest frontier, and back along the tree",
    options=Options,
    explorer=NearestFrontier,
)


def main(environment="apartment", folder="out/examples"):
    """Check the explorer, explore an environment with it and draw its tree."""
    print(check_explorer(NEAREST_FRONTIER))
    ms.register(NEAREST_FRONTIER)
    run = ms.explore(environment, strategy="nearest-frontier", seed=1)
    picture = Path(folder) / "own_explorer.svg"
    picture.parent.mkdir(parents=True, exist_ok=True)
    run.save_svg(picture)
    print(run)
    print(f"The tree: {picture}")


if __name__ == "__main__":
    main()
