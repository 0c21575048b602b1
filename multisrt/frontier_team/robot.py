"""One robot that bids for frontiers: what it knows, where it is, and what it can reach."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import cast

import numpy as np

from multisrt.entries import Entries, Entry, Node, NodeId
from multisrt.events import MapComplete
from multisrt.explorer import Action, Look, Note, Outcome, RobotSelf, Sense, Sighting
from multisrt.frontier_team.options import FrontierOptions
from multisrt.frontier_team.team import Team
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.distance_field import DistanceField
from multisrt.geometry.distances import inside
from multisrt.geometry.grid_path import shortest_path
from multisrt.geometry.kernel import FloatArray, IntArray
from multisrt.geometry.occupancy import FrontierGroup, Occupancy
from multisrt.geometry.safe_region import LocalSafeRegion, local_safe_region
from multisrt.geometry.scan import Scan
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.trajectory import Trajectory

Steps = Generator[Action, Outcome, None]

NEAR_BY_CELLS = 8
"""A robot that stands where its raster has no passable cell begins at one so near."""

MOST_FIELDS = 64
"""Distance fields that a robot keeps, so as not to begin them anew."""


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """Where a robot goes.

    Attributes
    ----------
    x, y : float
        The place, a cell's centre.
    path : (n, 2) array
        The way there from where the robot was when it chose.
    cost_m : float
        Length of that way.
    """

    x: float
    y: float
    path: FloatArray
    cost_m: float

    @property
    def place(self) -> tuple[float, float]:
        """The place as a pair."""
        return self.x, self.y


class FrontierRobot:
    """What the rules of frontier bidding work on: one robot's knowledge and place.

    Parameters
    ----------
    me : RobotSelf
        What the robot knows of itself.
    options : FrontierOptions
        The parameters.

    Attributes
    ----------
    raster : Occupancy
        What it knows of the world, of its own and from others.
    at : Configuration
        Where it stands, or stood before the motion that goes on.
    region : LocalSafeRegion
        What it saw last, from where it stood then.
    goal : Goal or None
        Where it goes.
    team : Team
        What it knows of the others.
    bodies : dict of int to Sighting
        Robots that stand in its way and do not leave.
    """

    def __init__(self, me: RobotSelf, options: FrontierOptions) -> None:
        self.me = me
        self.options = options
        self.body = PlanningBody(me.footprint, options.margin_m)
        self.radius_m = self.body.ample_radius_m
        self.raster = Occupancy(options.cell_m, self.radius_m)
        self.entries = Entries()
        self.at = me.start
        self.time_s = me.time_s
        self.here: NodeId | None = None
        self.region: LocalSafeRegion | None = None
        self.goal: Goal | None = None
        self.motion: Trajectory | None = None
        self.set_out_s = 0.0
        self.bodies: dict[int, Sighting] = {}
        self.unchanged_since_s = me.time_s
        self.told_complete = False
        self._serial = 0
        self._given_up: dict[tuple[float, float], None] = {}
        self._fields: dict[tuple[float, float], tuple[int, DistanceField]] = {}
        self.team = Team(self)

    # Knowledge ---------------------------------------------------------------------------

    def perceive(self) -> Steps:
        """Look round; what is new becomes a node, and is told."""
        scan = cast(Scan, (yield Sense()))
        self.time_s = scan.time_s
        region = local_safe_region(scan, self.options.shape, cones=self.options.cones)
        self.region = region
        if self.raster.add(region) == 0 and self.here is not None:
            return
        node = Node(
            id=NodeId(self.me.robot, self._serial),
            configuration=scan.configuration,
            region=region,
            parent=self.here,
            time_s=self.time_s,
        )
        self._serial += 1
        self.entries.add_node(node)
        self.here = node.id
        yield Note(node.added("root" if node.parent is None else "scan"))
        if not self.team.is_alone:
            yield from self.team.report()

    def merge(self, entries: tuple[Entry, ...]) -> tuple[NodeId, ...]:
        """Take in what others saw; give what was new."""
        new = [entry for entry in entries if isinstance(entry, Node)]
        new = [node for node in new if self.entries.add_node(node)]
        for node in new:
            self.raster.add(node.region)
        return tuple(node.id for node in new)

    def groups(self) -> list[FrontierGroup]:
        """Give the groups of frontier cells that are worth going to."""
        least = self.options.least_frontier_m
        return self.raster.frontier_groups(self.me.footprint.width_m if least is None else least)

    def targets(self) -> FloatArray:
        """Give the places to go to, one for each group, ``(m, 2)``; groups without one have none."""
        return np.array(
            [place for group in self.groups() if (place := self._target(group)) is not None]
        ).reshape(-1, 2)

    def _target(self, group: FrontierGroup) -> tuple[float, float] | None:
        if group.target is None:
            return None
        place = self.raster.centre_of(*group.target)
        if place not in self._given_up:
            return place
        # From there nothing more can be seen of it: perhaps from another of its cells.
        centres = self.raster.centres_of(group.cells)
        passable = self.raster.passable[tuple(self.raster.indices_of(group.cells).T)]
        left = [
            (x, y)
            for x, y in centres[passable].tolist()
            if all(
                math.dist((x, y), given_up) > 0.5 * self.me.footprint.width_m
                for given_up in self._given_up
            )
        ]
        middle = centres.mean(axis=0)
        return min(left, key=lambda p: (math.dist(p, middle), p[1], p[0]), default=None)

    def give_up(self, place: tuple[float, float]) -> None:
        """Choose no place as a goal any more: nothing new is seen from it, or no way leads there."""
        self._given_up[place] = None

    def is_frontier(self, x: float, y: float) -> bool:
        """Whether there is still something to be seen around a place."""
        return self.raster.has_frontier_near(x, y, 0.5 * self.me.footprint.width_m)

    def tell_when_complete(self) -> Steps:
        """Put on record that no frontier is left in the map, once."""
        if not self.told_complete:
            self.told_complete = True
            yield Note(MapComplete(time_s=self.time_s, robot=self.me.robot))

    # Ways ---------------------------------------------------------------------------------

    def cell_near(self, x: float, y: float) -> tuple[int, int] | None:
        """Give the passable cell nearest to a place, if there is one near by."""
        return self.raster.passable_cell_near(x, y, NEAR_BY_CELLS * self.options.cell_m)

    def field(self, x: float, y: float) -> DistanceField | None:
        """Give the distances from a place over what is known to be passable.

        Fields are kept, and repaired where the map has changed since.
        """
        cell = self.cell_near(x, y)
        if cell is None:
            return None
        raster = self.raster
        source = raster.centre_of(*cell)
        known = self._fields.pop(source, None)
        if known is not None and known[1].passable is raster.passable:
            revision, field = known
            window = raster.changed_since(revision)
            if window is not None:
                field.repair(window)
        else:
            field = DistanceField(raster.passable, cell, raster.cell_m)
        self._fields[source] = raster.revision, field
        if len(self._fields) > MOST_FIELDS:
            self._fields.pop(next(iter(self._fields)))
        return field

    def cells_of(self, places: FloatArray) -> IntArray:
        """Give the raster's cells of places, ``(k, 2)`` rows and columns."""
        return np.array([self.raster.cell_of(x, y) for x, y in places.tolist()]).reshape(-1, 2)

    def goal_at(self, field: DistanceField, x: float, y: float) -> Goal:
        """Give a place as a goal, with the way there."""
        raster = self.raster
        cell = raster.cell_of(x, y)
        path = shortest_path(field, cell, raster.x0, raster.y0)
        whole = np.vstack([[self.at[:2]], path])
        return Goal(x, y, whole, length_of(whole))

    # Other bodies --------------------------------------------------------------------------

    def look(self) -> Generator[Action, Outcome, tuple[Sighting, ...]]:
        """Notice who stands around; forget those who are not where they were seen."""
        seen = cast(tuple[Sighting, ...], (yield Look()))
        places = {sighting.robot: sighting for sighting in seen}
        for number, sighting in list(self.bodies.items()):
            x, y, _ = sighting.configuration
            if number in places:
                if places[number].configuration.distance(sighting.configuration) > 0.05:
                    del self.bodies[number]
            elif self.region is not None and inside(self.region.boundary, x, y):
                del self.bodies[number]
        return seen

    def discs(self, sightings: list[Sighting]) -> FloatArray:
        """Give the cells' centres that bodies keep this one from, as discs, ``(k, 3)``."""
        own = self.body.outer_radius_m + self.options.guard_m
        return np.array(
            [
                (
                    s.configuration.x,
                    s.configuration.y,
                    own + s.footprint.circumscribed_radius_m + self.options.margin_m,
                )
                for s in sightings
            ]
        ).reshape(-1, 3)

    def now_at(self) -> Configuration:
        """Where the robot is at this moment, also while it drives."""
        if self.motion is None:
            return self.at
        return self.motion.at(self.time_s - self.set_out_s)


def length_of(path: FloatArray) -> float:
    """Give the length of a polyline ``(n, 2)``."""
    steps = np.diff(path, axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
