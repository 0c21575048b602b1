"""How long an experiment will take, estimated from a few of its runs.

The computing time of a run is modelled as a product: one factor for its environment, its strategy
and each other label, and a power of the team size. Trial runs, cheap ones first, give the factors
by least squares of logarithms. The factor of a label that no trial run has is 1, and the exponent
is 1 until two team sizes were tried.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from multisrt.experiments.crossing import Condition, PlannedRun
from multisrt.experiments.distinct import twin_key
from multisrt.experiments.results import ENDED, Result
from multisrt.experiments.spec import ExperimentSpec, Limits
from multisrt.geometry.numerics.arrays import FloatArray

MAX_PROBES = 16
"""Trial runs of one estimate."""

LABELS = ("environment", "strategy", "starts", "radio", "body", "faults")

RIDGE = 0.05
"""Weight of the assumed factors in the fit: enough to decide where no trial run does."""

MIN_SPREAD = 0.2
"""Standard deviation of log computing times of repetitions, if trial runs do not show more."""

UNKNOWN_SPREAD = 0.7
"""Standard deviation that is assumed for fewer than three trial runs: a factor of two."""

MAX_SPREAD = 1.5
"""Maximum standard deviation that is reported: a factor of 4.5."""

Make = Callable[[PlannedRun, Limits], Result]


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """Estimated computing time of an experiment.

    Attributes
    ----------
    computing_s, low_s, high_s : float
        Computing time of all runs that are executed (s of one core), and its bounds: one standard
        deviation.
    by_condition_s : dict of Condition to float
        Computing time of one run of each condition (s).
    probes : tuple of Result
        The trial runs.
    cut_off : int
        Number of trial runs that were given up as too long, and so are lower bounds only.
    took_s : float
        Elapsed time of the estimate (s).
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
    """Estimate the computing time of an experiment by making a few of its runs.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.
    planned : sequence of PlannedRun
        Its runs.
    make : callable
        Executes a run within limits.
    budget_s : float
        Time for trial runs (s), which is kept approximately.
    watch : callable, optional
        Called with each trial run before it is made.

    Returns
    -------
    Estimate or None
        The estimate; None if no trial run came to an end.
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
    while len(probes) < min(MAX_PROBES, len(everything)):
        left_s = budget_s - (time.perf_counter() - begin)
        run = _next(everything, probes, model, left_s)
        if run is None:
            break
        if watch is not None:
            watch(first[run])
        result = make(first[run], limits)
        if run.strategy not in warm and result.status in ENDED:
            # The first run of a strategy includes loading its code; a short one is repeated.
            warm[run.strategy] = None
            if result.wall_s < 0.1 * budget_s:
                result = make(first[run], limits)
        probes.append(result)
        model.fit([probe for probe in probes if probe.status in (*ENDED, "over_time")])
    if not model.probes:
        return None
    each = dict(zip(everything, model.predicted(everything), strict=True))
    total = sum(many * each[one] for one, many in _counts(planned, probes).items())
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


def _counts(planned: Sequence[PlannedRun], probes: Sequence[Result]) -> dict[Condition, int]:
    """Return how many runs of each condition are made; twins of a run without chance are not."""
    counts = Counter(run.condition for run in planned)
    for probe in probes:
        if not probe.chance:
            own = {twin_key(run) for run in planned if run.condition == probe.condition}
            counts[probe.condition] = len(own)
    return counts


def _next(
    everything: Sequence[Condition], probes: Sequence[Result], model: _Model, left_s: float
) -> Condition | None:
    """Return the condition that shows most labels not tried yet; of several, the cheapest."""
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
        # Once all labels are tried: other team sizes, large ones first, as they cost most.
        rank = (-new, one.robots) if new else (0, -int(new_size), -one.robots)
        candidate = (*map(float, rank), *([0.0] * (3 - len(rank))), float(number))
        if best is None or candidate < best:
            best, chosen = candidate, one
    return chosen if left_s > 0.0 or not probes else None


class _Model:
    """The logarithm of computing time as a sum over labels, and a multiple of log team size."""

    def __init__(self, everything: Sequence[Condition]) -> None:
        pairs = ((name, getattr(one, name)) for one in everything for name in LABELS)
        self._features = list(dict.fromkeys(pairs))
        self.probes: list[Result] = []
        self._weights = self._assumed = np.array([0.0, 1.0, *[0.0] * len(self._features)])

    def fit(self, probes: Sequence[Result]) -> None:
        """Fit the model to trial runs."""
        self.probes = list(probes)
        if self.probes:
            self._weights = self._fitted(self.probes)

    def predicted(self, wanted: Sequence[Condition]) -> list[float]:
        """Return the computing time of one run of each condition (s)."""
        return [float(value) for value in np.exp(self._matrix(wanted) @ self._weights)]

    def spread(self) -> float:
        """Return the leave-one-out error of log computing times, within its bounds."""
        if len(self.probes) < 3:
            return UNKNOWN_SPREAD
        errors = []
        for number, probe in enumerate(self.probes):
            others = self._fitted([*self.probes[:number], *self.probes[number + 1 :]])
            expected = float((self._matrix([probe.condition]) @ others)[0])
            errors.append(_log(probe) - expected)
        return max(MIN_SPREAD, min(math.sqrt(float(np.mean(np.square(errors)))), MAX_SPREAD))

    def _fitted(self, probes: Sequence[Result]) -> FloatArray:
        """Return the weights by ridge regression towards the assumed ones; the level is free."""
        x = self._matrix([probe.condition for probe in probes])
        y = np.array([_log(probe) for probe in probes]) - x @ self._assumed
        hold = np.diag([1e-9, *[RIDGE] * (x.shape[1] - 1)])
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
