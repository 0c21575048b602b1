"""Which part of what a team can explore it saw, and which it covered, in the course of a run.

*Seen* is what any scan showed. *Covered* is what robots took into their knowledge: the regions of
the nodes that they noted, as far as their scans there had shown them. A robot that notes no node
is measured by its scans.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from multisrt.analysis.evidence import Evidence
from multisrt.analysis.explorable import EXPLORABLE, explorable, viewers
from multisrt.analysis.metrics import ROUNDING, SUCCESS_COVERAGE
from multisrt.analysis.owners import label_count, owner_tables
from multisrt.analysis.scans import shown_from
from multisrt.environments.environment import Environment
from multisrt.events import (
    BLOCKED,
    ArcClosed,
    ArcReopened,
    Died,
    MapComplete,
    NodeAdded,
    Sensed,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.strip_map import OUTSIDE, StripMap
from multisrt.geometry.grids.strips import runs_of
from multisrt.geometry.numerics.kernel import FloatArray, IntArray
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.recording import Recording
from multisrt.spec import RunSpec

SEEN: Final = 2
"""The label of what was seen and is not covered."""

COVERED: Final = 3
"""The label of what is covered."""

SEE, COVER = range(2)
"""The tables by which a scan changes labels, and a node or a scan of a robot without nodes."""

TABLES: Final = np.array([[OUTSIDE, SEEN, SEEN, COVERED], [OUTSIDE, COVERED, COVERED, COVERED]])

KNOWN_SHARE: Final = 0.99
"""Share of what a team covers in the end that a robot knows when it knows its map complete."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Coverage:
    """How much of what a team can explore it saw and covered, in the course of a run.

    Attributes
    ----------
    explorable_m2 : float
        Area that the team can explore, in square metres.
    times_s : (n,) array
        When a scan was taken or a node was noted, ascending.
    seen_m2, covered_m2 : (n,) array
        Area seen and covered from then on; they never fall.
    overlap_m2 : float
        Area that at least two robots saw.
    plane : StripMap
        What was seen and covered in the end, with the labels of this module.
    """

    explorable_m2: float
    times_s: FloatArray
    seen_m2: FloatArray
    covered_m2: FloatArray
    overlap_m2: float
    plane: StripMap

    @property
    def seen(self) -> float:
        """The share seen in the end, from 0 to 1."""
        return self._share(self.seen_m2)

    @property
    def share(self) -> float:
        """The share covered in the end, from 0 to 1."""
        return self._share(self.covered_m2)

    def _share(self, areas_m2: FloatArray) -> float:
        return min(1.0, float(areas_m2[-1]) / self.explorable_m2) if len(areas_m2) else 0.0

    def covered_by_m2(self, time_s: float) -> float:
        """Return the area covered by a time (s), in square metres."""
        last = int(np.searchsorted(self.times_s, time_s, side="right"))
        return float(self.covered_m2[last - 1]) if last else 0.0

    def time_to(self, share: float) -> float | None:
        """Return when a share of the explorable area was covered (s); None if it never was."""
        return time_to(share, self.times_s, self.covered_m2, self.explorable_m2)

    def times_by_percent(self) -> tuple[float | None, ...]:
        """Return when each percent was covered, from 0 to 100 (s); None if it never was."""
        return (0.0, *(self.time_to(percent / 100) for percent in range(1, 101)))

    def integral_of_rest(self, end_s: float) -> float:
        """Return the time integral of the share not yet covered, from 0 to a time (s)."""
        return integral_of_rest(self.times_s, self.covered_m2, self.explorable_m2, end_s)


def time_to(
    share: float, times_s: FloatArray, areas_m2: FloatArray, explorable_m2: float
) -> float | None:
    """Return when an area that never falls reached a share of the explorable one (s), or None."""
    needed_m2 = (share - ROUNDING) * explorable_m2
    first = int(np.searchsorted(areas_m2, needed_m2))
    return float(times_s[first]) if first < len(times_s) else None


def integral_of_rest(
    times_s: FloatArray, areas_m2: FloatArray, explorable_m2: float, end_s: float
) -> float:
    """Return the time integral, from 0 to a time (s), of the share that an area leaves."""
    steps = np.clip(np.concatenate([[0.0], times_s, [end_s]]), 0.0, end_s)
    steps[-1] = end_s
    rest = 1.0 - np.concatenate([[0.0], areas_m2]) / explorable_m2
    return math.fsum((np.maximum(0.0, rest) * np.diff(steps)).tolist())


def coverage(proof: Evidence) -> Coverage:
    """Measure what a team saw and covered in the course of a run.

    Parameters
    ----------
    proof : Evidence
        What the run is judged by.

    Returns
    -------
    Coverage
        Covered lies in seen, and seen in what is explorable.
    """
    robots = len(proof.recording.spec.robots)
    times: list[float] = []
    regions: list[int] = []
    # What happened (SEE or COVER), and who saw (-1: no robot).
    what: list[int] = []
    who: list[int] = []
    scans = 0
    for event in proof.recording.events:
        match event:
            case Sensed():
                regions.append(scans)
                what.append(SEE if event.robot in proof.with_nodes else COVER)
                who.append(event.robot)
                scans += 1
            case NodeAdded():
                region = proof.nodes[event.robot, event.serial]
                if regions and regions[-1] == region and times[-1] == event.time_s:
                    # The scan became a node at once.
                    what[-1] = COVER
                    continue
                regions.append(region)
                what.append(COVER)
                who.append(-1)
            case _:
                continue
        times.append(event.time_s)
    states, owners = TABLES.shape[1], label_count(robots) - 1
    plane = proof.explorable.plane.mapped([OUTSIDE, EXPLORABLE * owners], states * owners)
    which = [happened * (robots + 2) + robot + 1 for happened, robot in zip(what, who, strict=True)]
    by_state = proof.regions.relabel(
        plane,
        _tables(robots),
        regions,
        which,
        measured=lambda areas_m2: areas_m2.reshape(-1, states, owners).sum(axis=2),
    )
    in_the_end = plane.areas_m2.reshape(states, owners)
    return Coverage(
        explorable_m2=proof.explorable.area_m2,
        times_s=np.array(times, np.float64),
        seen_m2=np.maximum(0.0, by_state[:, SEEN]) + by_state[:, COVERED],
        covered_m2=by_state[:, COVERED],
        overlap_m2=float(in_the_end[EXPLORABLE:, -1].sum()),
        plane=plane.mapped(np.repeat(np.arange(states), owners), states),
    )


def _tables(robots: int) -> IntArray:
    # A label says both what is covered and who saw it: state * owners + owner. One table for each
    # thing that happens, and in it for no robot and for each robot that sees.
    sees = owner_tables(robots)[:, EXPLORABLE:] - EXPLORABLE
    owners = sees.shape[1]
    sees = np.vstack([np.arange(owners), sees])
    tables = TABLES[:, None, :, None] * owners + sees[None, :, None, :]
    tables[:, :, OUTSIDE] = OUTSIDE
    flat: IntArray = tables.reshape(len(TABLES) * len(sees), -1)
    return flat


def known_complete_s(proof: Evidence, covered: Coverage) -> float | None:
    """Return when the first robot knew the map complete, in seconds; None if none did.

    That a robot says so is not enough. Its last word counts, and only if no arc that it gave up as
    blocked by a robot was then still to be taken up again, and if it knew `KNOWN_SHARE` of what the
    team covered in the end, and enough for a success (`SUCCESS_COVERAGE`). So a robot that ends
    early, or learns of more afterwards, did not know the map complete.
    """
    needed_m2 = max(
        KNOWN_SHARE * float(covered.plane.areas_m2[COVERED]),
        SUCCESS_COVERAGE * covered.explorable_m2,
    )
    for claim in _last_claims(proof.recording):
        # No robot knows more than all of them together.
        if covered.covered_by_m2(claim.time_s) >= needed_m2 * (1.0 - ROUNDING):
            known = proof.known_to(claim.robot, claim.time_s)
            everything = proof.known_to_any(claim.time_s)
            area_m2 = (
                covered.covered_by_m2(claim.time_s)
                if known == everything
                else known_area_m2(proof, covered, sorted(known))
            )
            if area_m2 >= needed_m2 * (1.0 - ROUNDING):
                return claim.time_s
    return None


def _last_claims(recording: Recording) -> list[MapComplete]:
    # The last claim of each robot that was made with no arc blocked, in the order of time.
    blocked: dict[int, set[object]] = defaultdict(set)
    last: dict[int, MapComplete] = {}
    for event in recording.events:
        match event:
            case ArcClosed() if event.reason == BLOCKED:
                blocked[event.robot].add((event.node, event.arc))
            case ArcReopened():
                blocked[event.robot].discard((event.node, event.arc))
            case MapComplete():
                last.pop(event.robot, None)
                if not blocked[event.robot]:
                    last[event.robot] = event
    return sorted(last.values(), key=lambda claim: claim.time_s)


def known_area_m2(proof: Evidence, covered: Coverage, regions: Iterable[int]) -> float:
    """Return the area of some regions together, as far as scans showed them, in square metres."""
    plane = seen_plane(covered, 3)
    proof.regions.relabel(plane, [[OUTSIDE, 2, 2]], list(regions))
    return float(plane.areas_m2[2])


def seen_plane(covered: Coverage, labels: int) -> StripMap:
    """Return a plane on which what was seen in the end has the label `EXPLORABLE`."""
    table = [OUTSIDE, OUTSIDE, EXPLORABLE, EXPLORABLE]
    return covered.plane.mapped(table, labels)


def lost_areas_m2(proof: Evidence, covered: Coverage) -> tuple[float, tuple[float, ...]]:
    """Return the area lost with robots that died, in square metres.

    Returns
    -------
    lost_m2 : float
        Area that robots saw which died, and that no survivor saw or knows at the end, nor the base
        station, if there is one.
    by_robot_m2 : tuple of float
        The part of it that each robot saw; 0 for survivors. Area that two of the dead saw counts
        for both.
    """
    robots = range(len(proof.recording.spec.robots))
    dead = {event.robot for event in proof.recording.of(Died)}
    if not dead:
        return 0.0, (0.0,) * len(robots)
    kept, lost = 2, 3
    plane = seen_plane(covered, 4)
    survivors = [robot for robot in robots if robot not in dead]
    known: dict[int, None] = {}  # each region once
    for robot in survivors:
        known.update(dict.fromkeys(proof.scans_of(robot)))
        known.update(dict.fromkeys(sorted(proof.known_to(robot, math.inf))))
    known.update(dict.fromkeys(region for _, region in proof.delivered))
    proof.regions.relabel(plane, [[OUTSIDE, kept, kept, kept]], list(known))
    table = [[OUTSIDE, lost, kept, lost]]
    by_robot = [0.0] * len(robots)
    for robot in dead:
        alone = plane.copy()
        proof.regions.relabel(alone, table, proof.scans_of(robot))
        by_robot[robot] = float(alone.areas_m2[lost])
    for robot in sorted(dead):
        proof.regions.relabel(plane, table, proof.scans_of(robot))
    return float(plane.areas_m2[lost]), tuple(by_robot)


class SeenMeter:
    """How much of what a team can explore it has seen so far, during the run.

    Parameters
    ----------
    spec : RunSpec
        The run.
    environment : Environment
        Its world.
    starts : tuple of Configuration
        Where its robots start.
    """

    def __init__(
        self, spec: RunSpec, environment: Environment, starts: tuple[Configuration, ...]
    ) -> None:
        what = explorable(environment, viewers(spec, starts))
        self._robots = spec.robots
        team_range_m = max(robot.range_finder.range_m for robot in spec.robots)
        self._index = EdgeIndex(environment.edges, team_range_m / 3.0)
        self._explorable_m2 = what.area_m2
        self._plane = what.plane.mapped([OUTSIDE, EXPLORABLE], 3)

    @property
    def share(self) -> float:
        """The share seen so far, from 0 to 1."""
        return min(1.0, float(self._plane.areas_m2[SEEN]) / self._explorable_m2)

    def add(self, scan: Sensed) -> FloatArray:
        """Take in a scan, and return the corners of what it showed, ``(n, 2)``."""
        shown = shown_from(self._index, self._robots[scan.robot], [scan.configuration])
        self._plane.relabel(runs_of(self._plane.cut, shown), [[OUTSIDE, SEEN, SEEN]])
        return shown[0]
