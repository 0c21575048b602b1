"""The area that only one robot of a team knew, and that would have been lost with it.

Area known to a base station is not lost with any robot.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from multisrt.analysis.coverage import Coverage, coverage, seen_plane
from multisrt.analysis.evidence import Evidence, evidence
from multisrt.analysis.explorable import explorable, viewers
from multisrt.analysis.owners import label_count, of_one, owner_tables
from multisrt.environments.environment import Environment
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownToOne:
    """Area that only one robot knew, and that would have been lost with it.

    Attributes
    ----------
    integral_m2s : tuple of float
        For each robot the time integral of the area that it alone knew (m2 s).
    final_m2 : tuple of float
        For each robot the area that it alone knew at the end.
    """

    integral_m2s: tuple[float, ...]
    final_m2: tuple[float, ...]


def area_known_to_one(recording: Recording, environment: Environment | None = None) -> KnownToOne:
    """Compute the area that only one robot knew, and its integral over time.

    A robot knows the regions of its own nodes and of those that it learned of, as far as they were
    seen and are explorable; a robot that records no nodes knows its own scans. A dead robot knows
    nothing. Area that the base station also knows does not count. The area changes only at events,
    so the integral over time is exact.

    Parameters
    ----------
    recording : Recording
        The run.
    environment : Environment, optional
        The world, if it has been built already; by default it is built from the recording.

    Returns
    -------
    KnownToOne
        For each robot, until the end of the run.

    Raises
    ------
    InvalidInputError
        If the recording has no valid world, or nodes but no scans.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, area_known_to_one, simulate
    >>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
    >>> known = area_known_to_one(recording)
    >>> len(known.final_m2), known.final_m2[0] > 10.0
    (1, True)
    """
    environment = environment or recording.environment()
    what = explorable(environment, viewers(recording.spec, recording.starts))
    proof = evidence(recording, environment, what)
    return known_to_one(proof, coverage(proof), recording.footer.time_s)


def known_to_one(proof: Evidence, covered: Coverage, until_s: float) -> KnownToOne:
    """Integrate the area that only one robot knew from 0 to a given time in seconds.

    The final areas are those at the end of the run.
    """
    robots = len(proof.recording.spec.robots)
    # The base station knows what it learned like one more robot, under the number after the last.
    has_base = proof.recording.spec.base is not None
    ledger = _Ledger(proof, covered, robots + has_base)
    integral_m2s: FloatArray | None = None
    for time_s, robot, region in _news(proof, robots):
        if time_s > until_s and integral_m2s is None:
            ledger.settle(until_s)
            integral_m2s = ledger.integral_m2s.copy()
        if region is None:
            ledger.forget(robot, time_s)
        else:
            ledger.learn(robot, region, time_s)
    if integral_m2s is None:
        ledger.settle(until_s)
        integral_m2s = ledger.integral_m2s.copy()
    ledger.settle(max(until_s, proof.recording.footer.time_s))
    return KnownToOne(
        integral_m2s=tuple(integral_m2s.tolist()[:robots]),
        final_m2=tuple(ledger.alone_m2.tolist()[:robots]),
    )


def _news(proof: Evidence, base: int) -> list[tuple[float, int, int | None]]:
    """Return who came to know which region, in the order of time."""
    news: list[tuple[float, int, int | None]] = [*proof.knowledge]
    if proof.delivered:
        news += [(time_s, base, region) for time_s, region in proof.delivered]
        news.sort(key=lambda one: one[0])
    return news


class _Ledger:
    """What every robot knows, and how much of it no other one does, in the course of time."""

    def __init__(self, proof: Evidence, covered: Coverage, robots: int) -> None:
        self._proof, self._covered, self._robots = proof, covered, robots
        self._tables = owner_tables(robots)
        self._plane = seen_plane(covered, label_count(robots))
        self._known_by: dict[int, set[int]] = defaultdict(set)
        # What has been learned since the plane was last up to date: times, regions, tables.
        self._news: list[tuple[float, int, int]] = []
        self._latest: dict[int, int] = {}
        self._settled_s = 0.0
        self.alone_m2: FloatArray = np.zeros(robots)
        self.integral_m2s: FloatArray = np.zeros(robots)

    def learn(self, robot: int, region: int, time_s: float) -> None:
        """Add a region to the knowledge of a robot."""
        known_by = self._known_by[region]
        if not known_by:
            self._latest[region] = len(self._news)
            self._news.append((time_s, region, robot))
        elif len(known_by) == 1 and robot not in known_by:
            to_several = (time_s, region, self._robots)
            latest = self._latest.get(region, len(self._news))
            if latest < len(self._news) and self._news[latest][0] == time_s:
                # Shared as soon as it was known.
                self._news[latest] = to_several
            else:
                self._news.append(to_several)
        known_by.add(robot)

    def forget(self, robot: int, time_s: float) -> None:
        """Remove all knowledge of a robot."""
        self.settle(time_s)
        self._plane = seen_plane(self._covered, label_count(self._robots))
        self.alone_m2 = np.zeros(self._robots)
        for region, known_by in self._known_by.items():
            known_by.discard(robot)
            if known_by:
                table = self._robots if len(known_by) > 1 else min(known_by)
                self._news.append((time_s, region, table))
        self.settle(time_s)

    def settle(self, until_s: float) -> None:
        """Bring the areas up to date, and their integrals up to a time."""
        times, regions, tables = zip(*self._news, strict=True) if self._news else ((), (), ())
        history = self._proof.regions.relabel(self._plane, self._tables, regions, tables)
        alone = np.vstack([self.alone_m2, np.maximum(0.0, of_one(history))])
        spans = np.diff([self._settled_s, *times, until_s])
        self.integral_m2s += (spans[:, None] * alone).sum(axis=0)
        self.alone_m2 = alone[-1]
        self._settled_s = until_s
        self._news.clear()
        self._latest.clear()
