"""What a base station knows in the course of a run, and what robots hold that it does not know.

*Delivered* is what the base station learned: the regions of the nodes that came to it in messages
(`multisrt.events.BaseLearned`), as far as scans had shown them. Always delivered lies in covered:
a node that no robot noted, or that its sender could not know, does not count.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from multisrt.analysis.coverage import Coverage, integral_of_rest, seen_plane, time_to
from multisrt.analysis.evidence import Evidence
from multisrt.geometry.grids.strip_map import OUTSIDE
from multisrt.geometry.numerics.kernel import FloatArray

DELIVERED = 2
"""The label of what is delivered."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Delivery:
    """How much of what a team can explore the base station knew, in the course of a run.

    Attributes
    ----------
    explorable_m2 : float
        Area that the team can explore, in square metres.
    times_s : (n,) array
        When the base station learned of a node, ascending.
    delivered_m2 : (n,) array
        Area delivered from then on; it never falls, and is no more than was covered, to rounding.
    carrying_s : tuple of float
        For each robot, for how long it knew something that the base station did not know.
    """

    explorable_m2: float
    times_s: FloatArray
    delivered_m2: FloatArray
    carrying_s: tuple[float, ...]

    @property
    def share(self) -> float:
        """The share delivered in the end, from 0 to 1."""
        areas_m2 = self.delivered_m2
        return min(1.0, float(areas_m2[-1]) / self.explorable_m2) if len(areas_m2) else 0.0

    def time_to(self, share: float) -> float | None:
        """Return when a share of the explorable area was delivered (s); None if it never was."""
        return time_to(share, self.times_s, self.delivered_m2, self.explorable_m2)

    def times_by_percent(self) -> tuple[float | None, ...]:
        """Return when each percent was delivered, from 0 to 100 (s); None if it never was."""
        return (0.0, *(self.time_to(percent / 100) for percent in range(1, 101)))

    def mean_delay_s(self, covered: Coverage, end_s: float) -> float | None:
        """Return the mean time between the covering and the delivery of an area, in seconds.

        Parameters
        ----------
        covered : Coverage
            What the same run covered.
        end_s : float
            Horizon (s): area that is not delivered by then counts up to it.

        Returns
        -------
        float or None
            The mean over the area that was covered by then; None if nothing was. It is the
            integral over time of the area covered and not yet delivered, by the area covered.
        """
        covered_m2 = covered.covered_by_m2(end_s)
        if covered_m2 <= 0.0:
            return None
        late_s = integral_of_rest(self.times_s, self.delivered_m2, self.explorable_m2, end_s)
        waited_m2s = self.explorable_m2 * (late_s - covered.integral_of_rest(end_s))
        return max(0.0, waited_m2s / covered_m2)


def delivery(proof: Evidence, covered: Coverage) -> Delivery | None:
    """Measure what the base station knew in the course of a run.

    Parameters
    ----------
    proof : Evidence
        What the run is judged by.
    covered : Coverage
        What it covered.

    Returns
    -------
    Delivery or None
        None if the run has no base station.
    """
    if proof.recording.spec.base is None:
        return None
    plane = seen_plane(covered, 3)
    regions = [region for _, region in proof.delivered]
    history = proof.regions.relabel(plane, [[OUTSIDE, DELIVERED, DELIVERED]], regions)
    times_s = np.array([time_s for time_s, _ in proof.delivered], np.float64)
    # No more than was covered, to rounding.
    most_m2 = np.array([covered.covered_by_m2(time_s) for time_s in times_s.tolist()])
    areas_m2 = np.maximum.accumulate(np.minimum(history[:, DELIVERED], most_m2))
    return Delivery(
        explorable_m2=covered.explorable_m2,
        times_s=times_s,
        delivered_m2=areas_m2,
        carrying_s=_carrying_s(proof),
    )


def _carrying_s(proof: Evidence) -> tuple[float, ...]:
    end_s = proof.recording.footer.time_s
    robots = len(proof.recording.spec.robots)
    delivered: set[int] = set()
    carried: list[set[int]] = [set() for _ in range(robots)]
    since_s: list[float | None] = [None] * robots
    total_s = [0.0] * robots
    for time_s, robot, region in _news(proof):
        if robot is None:
            assert region is not None
            delivered.add(region)
            changed = [one for one in range(robots) if region in carried[one]]
            for one in changed:
                carried[one].discard(region)
        else:
            changed = [robot]
            if region is None:
                carried[robot].clear()
            elif region not in delivered:
                carried[robot].add(region)
        for one in changed:
            begun_s = since_s[one]
            if carried[one] and begun_s is None:
                since_s[one] = time_s
            elif not carried[one] and begun_s is not None:
                total_s[one] += time_s - begun_s
                since_s[one] = None
    return tuple(
        total + (0.0 if begun_s is None else end_s - begun_s)
        for total, begun_s in zip(total_s, since_s, strict=True)
    )


def _news(proof: Evidence) -> Iterator[tuple[float, int | None, int | None]]:
    # Who came to know which region (None: no robot, but the base station), in the order of time.
    # What happens at one moment takes no time, in whatever order.
    news: list[tuple[float, int | None, int | None]] = [*proof.knowledge]
    news += [(time_s, None, region) for time_s, region in proof.delivered]
    yield from sorted(news, key=lambda one: one[0])


def mean_s(times_s: tuple[float, ...]) -> float:
    """Return the mean of times of robots, in seconds."""
    return math.fsum(times_s) / len(times_s)
