"""The team as the search sees it: where each robot can go, what it sees, what its legs take."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.informed.roadmap import Roadmap, line_angle
from multisrt.informed.views import Bits, Cells, Sensor
from multisrt.planners.assignment.min_max_routes import Costs
from multisrt.planners.motion.kinematics import Differential, Holonomic

SENSE_SPACING_M = 0.4
"""Maximum distance between scans on the way, in metres."""

MAX_LEGS = 10_000
"""Legs of which it is kept what is seen on them."""

MAX_SLOTS = 1_024
"""Nodes between which legs are kept in a table."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Member:
    """One robot.

    Attributes
    ----------
    start : Configuration
        Where it starts.
    kinematics : Holonomic or Differential
        How it moves.
    roadmap : Roadmap
        Its paths.
    node : int
        Its start on the roadmap.
    sensor : Sensor
        What it sees.
    """

    start: Configuration
    kinematics: Holonomic | Differential
    roadmap: Roadmap
    node: int
    sensor: Sensor

    @property
    def turn_s(self) -> float:
        """Time of a turn by one radian, in seconds."""
        drive = self.kinematics
        return 1.0 / drive.turn_rate_rad_s if isinstance(drive, Differential) else 0.0


def samples(corners: FloatArray) -> FloatArray:
    """Return where scans are taken along a path, after its first corner: ``(k, 2)`` in metres.

    They are at most `SENSE_SPACING_M` apart, and one is at each corner.
    """
    found = [corners[:0]]
    for a, b in pairwise(corners):
        parts = max(1, math.ceil(float(np.hypot(*(b - a))) / SENSE_SPACING_M - 1e-9))
        share = np.arange(1, parts + 1)[:, None] / parts
        found.append(a + share * (b - a))
    return np.concatenate(found)


class Team:
    """A team, and the places that it may visit.

    Parameters
    ----------
    members : sequence of Member
        The robots.
    cells : Cells
        What there is to see.
    home : bool
        Whether routes lead back to their start.

    Attributes
    ----------
    places : (p, 2) array
        All places, in metres.
    views : (p, words) array
        The cells that are seen from each place, by the shortest range finder that can get there.
    """

    def __init__(self, members: Sequence[Member], cells: Cells, home: bool) -> None:
        self.members = tuple(members)
        self.cells = cells
        self.home = home
        self.roadmaps = list(dict.fromkeys(member.roadmap for member in members))
        self.sensors = list(dict.fromkeys(member.sensor for member in members))
        kinds = [(m.roadmap, m.kinematics.speed_m_s, m.turn_s) for m in members]
        self._kinds = list(dict.fromkeys(kinds))
        self._kind_of = np.array([self._kinds.index(kind) for kind in kinds], np.int64)
        self._tables = {roadmap: _Table(roadmap) for roadmap in self.roadmaps}
        self._seen_on: dict[tuple[int, int, int, int], Bits] = {}
        self._place_nodes()
        self._see()

    def node(self, robot: int, place: int) -> int:
        """Return the node of a place (-1: its start) on a robot's roadmap; -1 for none."""
        member = self.members[robot]
        if place < 0:
            return member.node
        return int(self._nodes[self.roadmaps.index(member.roadmap), place])

    def distances(self, robot: int, place: int, others: IntArray) -> FloatArray:
        """Return the distances of other places from one (-1: its start) for a robot, in metres.

        They are measured along its roadmap, so a little too long; inf where there is no path.
        """
        member = self.members[robot]
        row, _ = member.roadmap.row(self.node(robot, place))
        nodes = self._nodes[self.roadmaps.index(member.roadmap), others]
        return np.where(nodes >= 0, row[nodes].astype(np.float64), np.inf)

    def seen_on_leg(self, robot: int, a: int, b: int) -> Bits:
        """Return the cells that a robot sees behind a place (-1: its start) up to another."""
        member = self.members[robot]
        i, j = self.node(robot, a), self.node(robot, b)
        key = (self.sensors.index(member.sensor), self.roadmaps.index(member.roadmap), i, j)
        if key not in self._seen_on:
            if len(self._seen_on) >= MAX_LEGS:
                self._seen_on.clear()
            tight = member.roadmap.tight(i, j)
            assert tight is not None
            seen = self.cells.none()
            for x, y in samples(tight.corners).tolist():
                seen |= self.cells.within(member.sensor.region(x, y))
            self._seen_on[key] = seen
        return self._seen_on[key]

    def costs(self, places: Sequence[int]) -> Costs:
        """Return the costs of legs between some places and all starts, as in `min_max_routes`."""
        m, n = len(places), len(self.members)
        times = np.full((len(self._kinds), m + n, m + n), np.inf)
        angles = np.zeros_like(times)
        for k, (roadmap, speed, turn_s) in enumerate(self._kinds):
            map_nodes = self._nodes[self.roadmaps.index(roadmap), np.asarray(places, np.int64)]
            starts = [mem.node if mem.roadmap is roadmap else -1 for mem in self.members]
            nodes = np.concatenate((map_nodes, np.array(starts, np.int64)))
            lengths, turning, angles[k] = self._tables[roadmap].of(nodes)
            times[k] = lengths / speed + turn_s * turning
        return Costs(
            time_s=times,
            angle=angles,
            turn_s=np.array([turn_s for _, _, turn_s in self._kinds]),
            kind=self._kind_of,
            heading=np.array([member.start.heading % math.pi for member in self.members]),
            home=self.home,
        )

    def _place_nodes(self) -> None:
        # Places of several roadmaps with the same coordinates are one.
        number: dict[tuple[float, float], int] = {}
        nodes: list[dict[int, int]] = []
        for roadmap in self.roadmaps:
            found: dict[int, int] = {}
            reached = np.zeros(len(roadmap.places), np.bool_)
            for member in self.members:
                if member.roadmap is roadmap:
                    reached |= np.isfinite(roadmap.row(member.node)[0])
            for node in np.flatnonzero(reached).tolist():
                x, y = roadmap.places[node].round(6).tolist()
                found[number.setdefault((x, y), len(number))] = node
            nodes.append(found)
        self.places = np.array(list(number), np.float64).reshape(-1, 2)
        self._nodes = np.full((len(nodes), len(number)), -1, np.int64)
        for k, found in enumerate(nodes):
            self._nodes[k, list(found)] = list(found.values())

    def _see(self) -> None:
        ranges = {}
        for member in sorted(self.members, key=lambda m: -m.sensor.range_m):
            ranges[self.roadmaps.index(member.roadmap)] = member.sensor
        self.views = np.zeros((len(self.places), self.cells.words), np.uint64)
        for place, (x, y) in enumerate(self.places.tolist()):
            sensors = [ranges[k] for k in np.flatnonzero(self._nodes[:, place] >= 0).tolist()]
            least = min(sensors, key=lambda sensor: sensor.range_m)
            self.views[place] = self.cells.within(least.region(x, y))


class _Table:
    """Lengths, turning and angles of the legs between the nodes asked for so far."""

    def __init__(self, roadmap: Roadmap) -> None:
        self._roadmap = roadmap
        self._slots: dict[int, int] = {}
        self._legs = np.full((3, 64, 64), np.nan)

    def of(self, nodes: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return lengths (inf: no path), turning, and angles of the line at the first node."""
        new = sum(node not in self._slots for node in nodes.tolist())
        if new and len(self._slots) + new > MAX_SLOTS:
            self._slots.clear()
            self._legs[:] = np.nan
        slots = np.array([self._slot(int(node)) for node in nodes], np.int64)
        asked = self._legs[0][np.ix_(slots, slots)]
        for i, j in np.argwhere(np.isnan(asked)).tolist():
            if i < j:
                self._fill(int(nodes[i]), int(nodes[j]))
        legs = self._legs[:, slots[:, None], slots[None, :]]
        return legs[0], legs[1], legs[2]

    def _slot(self, node: int) -> int:
        if node not in self._slots:
            slot = self._slots[node] = len(self._slots)
            size = self._legs.shape[1]
            if slot >= size:
                larger = np.full((3, 2 * size, 2 * size), np.nan)
                larger[:, :size, :size] = self._legs
                self._legs = larger
            self._legs[:, slot, slot] = 0.0
        return self._slots[node]

    def _fill(self, a: int, b: int) -> None:
        i, j = self._slots[a], self._slots[b]
        tight = self._roadmap.tight(a, b) if min(a, b) >= 0 else None
        if i == j:
            return
        if tight is None:
            self._legs[:, i, j] = self._legs[:, j, i] = (np.inf, 0.0, 0.0)
            return
        corners = tight.corners
        self._legs[:, i, j] = tight.length_m, tight.turning_rad, line_angle(corners[0], corners[1])
        self._legs[:, j, i] = (
            tight.length_m,
            tight.turning_rad,
            line_angle(corners[-1], corners[-2]),
        )
