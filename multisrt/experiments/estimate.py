"""How long an experiment will take, from a few of its runs.

What a run computes is taken for a product: of one factor for its environment, its strategy and
each other label, and of a power of the team's size. A few runs, the cheap ones first, give the
factors by least squares on logarithms; what a label did not show in a run counts as 1, and the
power as 1 until two sizes were seen.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from multisrt.experiments.crossing import Condition, PlannedRun
from multisrt.experiments.description import ExperimentSpec, Limits
from multisrt.experiments.results import ENDED, Result
from multisrt.geometry.numerics.arrays import FloatArray

MOST_PROBES = 16

LABELS = ("environment", "strategy", "starts", "radio", "body", "faults")

HOLD = 0.05
"""How strongly the fit holds to the factors that it assumes: enough where nothing was seen."""

LEAST_SPREAD = 0.2
"""Repetitions of a condition differ by so much (as a logarithm), if the probes do not say more."""

UNKNOWN_SPREAD = 0.7
"""Spread that is assumed where there are too few probes to tell: a factor of two."""

Make = Callable[[PlannedRun, Limits], Result]


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """What an experiment will take.

    Attributes
    ----------
    computing_s, low_s, high_s : float
        Seconds of one core for all runs, and between what bounds.
    by_condition_s : dict
        Of one run of each condition.
    probes : tuple of Result
        The runs that were made for it.
    cut_off : int
        How many of them took longer than a probe may, so that they tell a lower bound only.
    took_s : float
        How long it took to find out.
    """

    computing_s: float
    low_s: float
    high_s: float
    by_condition_s: dict[Condition, float]
    probes: tuple[Result, ...]
    cut_off: int
    took_s: float


def estimate(
    spec: ExperimentSpec,
    planned: Sequence[PlannedRun],
    make: Make,
    *,
    budget_s: float = 30.0,
    watch: Callable[[PlannedRun], None] | None = None,
) -> Estimate | None:
    """Estimate what an experiment takes, by making a few of its runs.

    Which runs are made depends on what they take.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.
    planned : sequence of PlannedRun
        Its runs.
    make : callable
        Makes a run within limits.
    budget_s : float
        About how long this may take.
    watch : callable, optional
        Is told of each run before it is made.

    Returns
    -------
    Estimate or None
        None if none of the runs that were tried came to an end.
    """
    begin = time.perf_counter()
    first = {run.condition: run for run in reversed(planned)}
    everything = list(dict.fromkeys(run.condition for run in planned))
    limits = msgspec.structs.replace(
        spec.limits, computing_s=min(spec.limits.computing_s, budget_s / 2.0)
    )
    probes: list[Result] = []
    warm: dict[str, None] = {}
    model = _Model(everything)
    while len(probes) < min(MOST_PROBES, len(everything)):
        left_s = budget_s - (time.perf_counter() - begin)
        run = _next(everything, probes, model, left_s)
        if run is None:
            break
        if watch is not None:
            watch(first[run])
        result = make(first[run], limits)
        if run.strategy not in warm and result.status in ENDED:
            # The first run of a strategy loads what it needs, which every worker does once.
            warm[run.strategy] = None
            if result.wall_s < 0.1 * budget_s:
                result = make(first[run], limits)
        probes.append(result)
        model.fit([probe for probe in probes if probe.status in (*ENDED, "over_time")])
    if not model.probes:
        return None
    each = dict(zip(everything, model.predicted(everything), strict=True))
    total = spec.repetitions * sum(each.values())
    # Conditions whose probe was cut off take at least what it took.
    factor = math.exp(model.spread())
    cut_off = sum(probe.status == "over_time" for probe in probes)
    return Estimate(
        computing_s=total,
        low_s=total / factor,
        high_s=total * factor,
        by_condition_s=each,
        probes=tuple(probes),
        cut_off=cut_off,
        took_s=time.perf_counter() - begin,
    )


def _next(
    everything: Sequence[Condition], probes: Sequence[Result], model: _Model, left_s: float
) -> Condition | None:
    # What shows most that was not seen yet; of those, the cheapest.
    tried = [probe.condition for probe in probes]
    seen = {(name, getattr(one, name)) for one in tried for name in LABELS}
    sizes = {(one.strategy, one.robots) for one in tried}
    best: tuple[float, ...] | None = None
    chosen = None
    for number, one in enumerate(everything):
        if one in tried:
            continue
        new = sum((name, getattr(one, name)) not in seen for name in LABELS)
        new_size = (one.strategy, one.robots) not in sizes
        expected_s = model.predicted([one])[0] if model.probes else 0.0
        if probes and expected_s > left_s / 2.0:
            continue
        # After all labels, sizes of teams, the larger ones first: they cost most.
        rank = (-new, one.robots) if new else (0, -int(new_size), -one.robots)
        candidate = (*map(float, rank), *([0.0] * (3 - len(rank))), float(number))
        if best is None or candidate < best:
            best, chosen = candidate, one
    return chosen if left_s > 0.0 or not probes else None


class _Model:
    """Logarithms of computing times as a sum: of labels, and of the team's size to a power."""

    def __init__(self, everything: Sequence[Condition]) -> None:
        pairs = ((name, getattr(one, name)) for one in everything for name in LABELS)
        self._features = list(dict.fromkeys(pairs))
        self.probes: list[Result] = []
        self._weights = self._assumed = np.array([0.0, 1.0, *[0.0] * len(self._features)])

    def fit(self, probes: Sequence[Result]) -> None:
        """Take what runs took."""
        self.probes = list(probes)
        if self.probes:
            self._weights = self._fitted(self.probes)

    def predicted(self, wanted: Sequence[Condition]) -> list[float]:
        """Give what a run of each condition takes (s)."""
        return [float(value) for value in np.exp(self._matrix(wanted) @ self._weights)]

    def spread(self) -> float:
        """How far a probe is from what the others say of it, as a logarithm."""
        if len(self.probes) < 3:
            return UNKNOWN_SPREAD
        errors = []
        for number, probe in enumerate(self.probes):
            others = self._fitted([*self.probes[:number], *self.probes[number + 1 :]])
            says = float((self._matrix([probe.condition]) @ others)[0])
            errors.append(_log(probe) - says)
        return max(LEAST_SPREAD, min(math.sqrt(float(np.mean(np.square(errors)))), 1.5))

    def _fitted(self, probes: Sequence[Result]) -> FloatArray:
        # Ridge regression towards what is assumed; the level itself is free.
        x = self._matrix([probe.condition for probe in probes])
        y = np.array([_log(probe) for probe in probes]) - x @ self._assumed
        hold = np.diag([1e-9, *[HOLD] * (x.shape[1] - 1)])
        solved: FloatArray = np.linalg.solve(x.T @ x + hold, x.T @ y)
        return self._assumed + solved

    def _matrix(self, wanted: Sequence[Condition]) -> FloatArray:
        return np.array(
            [
                [
                    1.0,
                    math.log(one.robots),
                    *(float(getattr(one, name) == label) for name, label in self._features),
                ]
                for one in wanted
            ]
        )


def _log(probe: Result) -> float:
    return math.log(max(probe.computing_s, 1e-3))
