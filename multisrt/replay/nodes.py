"""Nodes, regions and scans of a replay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from multisrt.analysis.scans import scanned_regions
from multisrt.events import BaseLearned, Learned, NodeAdded, NodeName, Pose, Sensed
from multisrt.explain.terms import stage_name
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.recording import Recording
from multisrt.replay.outlines import simplified
from multisrt.replay.packing import (
    UNIT_M,
    UNIT_S,
    Packed,
    Table,
    differences,
    lists,
    points,
    whole,
)


class Names(NamedTuple):
    """The nodes of a recording and their numbers in the data of a page."""

    nodes: Sequence[NodeAdded]
    numbers: Mapping[NodeName, int]

    @classmethod
    def of(cls, recording: Recording) -> Names:
        """Return the nodes of a recording in the order in which they were added."""
        nodes = recording.of(NodeAdded)
        return cls(nodes, {(n.robot, n.serial): i for i, n in enumerate(nodes)})


def packed_nodes(recording: Recording, names: Names, tolerance_m: float) -> Packed:
    """Pack the nodes, with their regions and trees.

    Parameters
    ----------
    recording : Recording
        The run.
    names : Names
        Its nodes.
    tolerance_m : float
        How far outlines of regions may move, in metres.

    Returns
    -------
    dict
        Columns with one entry for each node.
    """
    nodes = names.nodes
    stages = Table()
    parents = [-1 if n.parent is None else names.numbers.get(n.parent, -1) for n in nodes]
    tags = [np.frombuffer(node.tags.encode(), np.uint8).astype(np.int64) - 48 for node in nodes]
    outlines, kinds = simplified([recording.region(node) for node in nodes], tags, tolerance_m)
    places = np.array([node.configuration[:2] for node in nodes]).reshape(-1, 2)
    return {
        "t": whole([node.time_s for node in nodes], UNIT_S),
        "robot": [node.robot for node in nodes],
        "serial": differences(node.serial for node in nodes),
        "parent": differences(parents),
        "stage": [stages.index(node.stage) for node in nodes],
        "stages": stages.values,
        "stage_names": [stage_name(str(stage)) for stage in stages.values],
        "x": whole(places[:, 0], UNIT_M),
        "y": whole(places[:, 1], UNIT_M),
        "region": points(outlines),
        "tags": "".join(map(_digits, kinds)),
    }


def packed_scans(recording: Recording, names: Names, tolerance_m: float) -> Packed | None:
    """Pack what scans showed; None if the recording has no scans.

    A scan that showed the region of a node refers to it.
    """
    scans = recording.of(Sensed)
    if not scans:
        return None
    shown = scanned_regions(recording, recording.environment())
    at = {(node.robot, node.configuration): number for number, node in enumerate(names.nodes)}
    same = [_same(recording, names, at, scan, own) for scan, own in zip(scans, shown, strict=True)]
    others = [own for own, node in zip(shown, same, strict=True) if node < 0]
    return {
        "t": whole([scan.time_s for scan in scans], UNIT_S),
        "robot": [scan.robot for scan in scans],
        "node": differences(same),
        "region": points(simplified(others, None, tolerance_m)[0]),
    }


def packed_learned(recording: Recording, names: Names) -> Packed:
    """Pack which nodes of others robots learned of, and when."""
    learned = recording.of(Learned)
    numbers = names.numbers
    return {
        "t": whole([event.time_s for event in learned], UNIT_S),
        "robot": [event.robot for event in learned],
        "nodes": lists(
            sorted(numbers[name] for name in event.nodes if name in numbers) for event in learned
        ),
    }


def packed_delivered(recording: Recording, names: Names) -> Packed | None:
    """Pack which nodes the base station learned of, and when; None if there is none."""
    if recording.spec.base is None:
        return None
    learned, numbers = recording.of(BaseLearned), names.numbers
    return {
        "t": whole([event.time_s for event in learned], UNIT_S),
        "nodes": lists(
            sorted(numbers[name] for name in event.nodes if name in numbers) for event in learned
        ),
    }


def _same(
    recording: Recording,
    names: Names,
    at: Mapping[tuple[int, Pose], int],
    scan: Sensed,
    shown: FloatArray,
) -> int:
    number = at.get((scan.robot, scan.configuration), -1)
    if number < 0:
        return -1
    region = recording.region(names.nodes[number])
    return number if region.shape == shown.shape and np.allclose(region, shown, atol=1e-6) else -1


def _digits(tags: IntArray) -> str:
    return (tags + 48).astype(np.uint8).tobytes().decode()
