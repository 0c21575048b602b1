"""What a run is judged by: the scans that robots took, and the regions that they noted as known.

*Seen* is what a scan showed, whatever the robot did with it. What a robot *knows* are the regions
of the nodes that it made, as far as its scans at their places had shown them, and of those that it
learned of from a robot that knew them and whose messages reached it. A robot that notes no node
knows its own scans. A base station learns as a robot does.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from multisrt.analysis.explorable import Explorable
from multisrt.analysis.scans import scanned_regions
from multisrt.analysis.shown_regions import NOTHING, WHOLE, ShownRegions
from multisrt.environments.environment import Environment
from multisrt.events import (
    BaseLearned,
    Died,
    Learned,
    NodeAdded,
    NodeName,
    Pose,
    Sensed,
    Sent,
)
from multisrt.recording import Recording

SAME_PLACE_M = 1e-6
"""Places closer together than this, in metres, are the same."""

Learning = tuple[float, int, int | None]
"""A robot came to know a region: time (s), robot, number of the region; instead of a region None
if the robot died, and knows nothing any more."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Evidence:
    """The regions of a run on the strips of what there is to explore.

    Attributes
    ----------
    recording : Recording
        The run.
    explorable : Explorable
        What its team can explore.
    regions : ShownRegions
        The regions: first those that the scans showed, then those of nodes that are others.
    nodes : dict of (robot, serial) to int
        The number of the region of each node.
    with_nodes : frozenset of int
        The robots that noted nodes.
    knowledge : tuple of Learning
        What robots came to know, in the order of the recording.
    delivered : tuple of (time_s, region)
        When the base station came to know which region, in the order of the recording.
    unshown_m2 : float
        Area of regions of nodes that no scan of their robots had shown at their places; it does
        not count.
    """

    recording: Recording
    explorable: Explorable
    regions: ShownRegions
    nodes: dict[NodeName, int]
    with_nodes: frozenset[int]
    knowledge: tuple[Learning, ...]
    delivered: tuple[tuple[float, int], ...]
    unshown_m2: float

    def scans_of(self, robot: int) -> list[int]:
        """Return the numbers of the regions that the scans of a robot showed."""
        scans = self.recording.of(Sensed)
        return [number for number, scan in enumerate(scans) if scan.robot == robot]

    def known_to(self, robot: int, until_s: float) -> set[int]:
        """Return the numbers of the regions that a robot has come to know by a time (s)."""
        return {
            region
            for time_s, who, region in self.knowledge
            if who == robot and region is not None and time_s <= until_s
        }

    def known_to_any(self, until_s: float) -> set[int]:
        """Return the numbers of the regions that any robot has come to know by a time (s)."""
        return {
            region
            for time_s, _, region in self.knowledge
            if region is not None and time_s <= until_s
        }


def evidence(recording: Recording, environment: Environment, what: Explorable) -> Evidence:
    """Return what a run is judged by.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment
        The world in which it was made.
    what : Explorable
        What its team can explore there.

    Raises
    ------
    InvalidInputError
        As `scanned_regions`.
    """
    regions = scanned_regions(recording, environment)
    masks = [WHOLE] * len(regions)
    nodes: dict[NodeName, int] = {}
    knowledge: list[Learning] = []
    delivered: list[tuple[float, int]] = []
    base = len(recording.spec.robots)
    with_nodes = frozenset(node.robot for node in recording.of(NodeAdded))
    scans = _Scans()
    heard = _Heard()
    for event in recording.events:
        match event:
            case Sensed():
                number = scans.add(event)
                if event.robot not in with_nodes:
                    knowledge.append((event.time_s, event.robot, number))
            case NodeAdded():
                region, scan = recording.region(event), scans.at(event)
                # A radial region is what the scan showed, and need not be measured twice.
                if scan is not None and np.array_equal(regions[scan], region):
                    number = scan
                else:
                    number = len(regions)
                    regions.append(region)
                    masks.append(NOTHING if scan is None else scan)
                nodes[event.robot, event.serial] = number
                heard.know((event.robot, event.serial), event.robot, event.time_s)
                knowledge.append((event.time_s, event.robot, number))
            case Sent():
                heard.hear(event)
            case Learned():
                for name in event.nodes:
                    if heard.could_learn(name, event.robot):
                        heard.know(name, event.robot, event.time_s)
                        knowledge.append((event.time_s, event.robot, nodes[name]))
            case BaseLearned():
                for name in event.nodes:
                    if heard.could_learn(name, base):
                        heard.know(name, base, event.time_s)
                        delivered.append((event.time_s, nodes[name]))
            case Died():
                knowledge.append((event.time_s, event.robot, None))
    shown = ShownRegions(what.plane.cut, regions, masks)
    return Evidence(
        recording=recording,
        explorable=what,
        regions=shown,
        nodes=nodes,
        with_nodes=with_nodes,
        knowledge=tuple(knowledge),
        delivered=tuple(delivered),
        unshown_m2=shown.unshown_m2(),
    )


class _Scans:
    """The scans so far: which one a node is made from."""

    def __init__(self) -> None:
        self._count = 0
        self._by_robot: dict[int, list[tuple[Pose, int]]] = defaultdict(list)

    def add(self, scan: Sensed) -> int:
        """Take in a scan, and return its number."""
        self._by_robot[scan.robot].append((scan.configuration, self._count))
        self._count += 1
        return self._count - 1

    def at(self, node: NodeAdded) -> int | None:
        """Return the number of the last scan that a robot took at the place of its node."""
        x, y, _ = node.configuration
        for (at_x, at_y, _), number in reversed(self._by_robot[node.robot]):
            if math.hypot(at_x - x, at_y - y) <= SAME_PLACE_M:
                return number
        return None


class _Heard:
    """Which nodes robots and the base station know, and when they heard from one another."""

    def __init__(self) -> None:
        self._knew_s: dict[NodeName, dict[int, float]] = defaultdict(dict)
        self._heard_s: dict[int, dict[int, float]] = defaultdict(dict)

    def know(self, name: NodeName, robot: int, time_s: float) -> None:
        """Take in that a robot knows a node."""
        self._knew_s[name].setdefault(robot, time_s)

    def hear(self, sent: Sent) -> None:
        """Take in a message."""
        for robot in sent.reached:
            self._heard_s[robot][sent.robot] = sent.time_s

    def could_learn(self, name: NodeName, robot: int) -> bool:
        """Whether a robot that knew a node has sent something to another one since."""
        heard_s = self._heard_s[robot]
        return any(
            since_s <= heard_s.get(other, -math.inf)
            for other, since_s in self._knew_s.get(name, {}).items()
            if other != robot
        )
