"""What a run is judged by: the scans that robots took, and the regions that they noted as known.

*Seen* is what a scan showed, whatever the robot did with it. What a robot *knows* are the regions
of the nodes that it made and of those that it learned of; a robot that notes no node knows its
own scans.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multisrt.analysis.explorable import Explorable
from multisrt.analysis.scans import scanned_regions
from multisrt.environments.environment import Environment
from multisrt.events import Died, Learned, NodeAdded, NodeName, Sensed
from multisrt.geometry.grids.strip_map import Runs, runs_of
from multisrt.recording import Recording

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
    runs : Runs
        The regions on strips: first those that the scans showed, then those of nodes that are
        others.
    nodes : dict of (robot, serial) to int
        The number of the region of each node.
    with_nodes : frozenset of int
        The robots that noted nodes.
    knowledge : tuple of Learning
        What robots came to know, in the order of the recording.
    """

    recording: Recording
    explorable: Explorable
    runs: Runs
    nodes: dict[NodeName, int]
    with_nodes: frozenset[int]
    knowledge: tuple[Learning, ...]

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
    nodes: dict[NodeName, int] = {}
    knowledge: list[Learning] = []
    with_nodes = frozenset(node.robot for node in recording.of(NodeAdded))
    scans = 0
    last_scan: dict[int, int] = {}
    for event in recording.events:
        match event:
            case Sensed():
                last_scan[event.robot] = scans
                if event.robot not in with_nodes:
                    knowledge.append((event.time_s, event.robot, scans))
                scans += 1
            case NodeAdded():
                region = recording.region(event)
                # A radial region is what the scan showed, and need not be measured twice.
                number = last_scan.get(event.robot)
                if number is None or not np.array_equal(regions[number], region):
                    number = len(regions)
                    regions.append(region)
                nodes[event.robot, event.serial] = number
                knowledge.append((event.time_s, event.robot, number))
            case Learned():
                knowledge += [(event.time_s, event.robot, nodes[name]) for name in event.nodes]
            case Died():
                knowledge.append((event.time_s, event.robot, None))
    return Evidence(
        recording=recording,
        explorable=what,
        runs=runs_of(what.plane.cut, regions),
        nodes=nodes,
        with_nodes=with_nodes,
        knowledge=tuple(knowledge),
    )
