"""What the runs of Álvarez's experiment come to on a map: successes, and means by team size."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multisrt.experiments.measures import Measure
from multisrt.experiments.results import Result
from multisrt.presets.alvarez_experiment import COVERED, DISTANCE, HOME, TIME, TO_95
from multisrt.presets.alvarez_maps import SCENARIOS, Scenario
from multisrt.presets.cells import Cells


def success(result: Result) -> bool:
    """Return whether a run covered at least `COVERED`, and ended with a map known complete."""
    return (
        result.success
        and result.metrics is not None
        and result.metrics.known_complete_s is not None
        and result.metrics.reached(COVERED)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Results on a map.

    Attributes
    ----------
    label : str
        Label of the map.
    scenario : Scenario or None
        The scenario of the thesis that it stands for; None for a map that was given.
    runs, successes : int
        Numbers of runs and of successful runs.
    time, home, to_95, distance : dict from int to float
        Means over the successful runs by team size: exploration time (s), time until all are done
        (s), time to 95 % coverage (s), path length of a robot (m).
    """

    label: str
    scenario: Scenario | None
    runs: int
    successes: int
    time: dict[int, float]
    home: dict[int, float]
    to_95: dict[int, float]
    distance: dict[int, float]


def outcomes(cells: Cells) -> list[Outcome]:
    """Return the results on every map of the experiment, in its order."""
    by_label = {scenario.label: scenario for scenario in SCENARIOS}
    on_map: defaultdict[str, list[Result]] = defaultdict(list)
    for at in cells.conditions():
        on_map[at.environment] += cells.of(at)
    return [outcome_of(label, by_label.get(label), here) for label, here in on_map.items()]


def outcome_of(label: str, scenario: Scenario | None, here: Sequence[Result]) -> Outcome:
    """Return what runs on one map come to."""
    return Outcome(
        label=label,
        scenario=scenario,
        runs=len(here),
        successes=sum(map(success, here)),
        time=_means(here, TIME),
        home=_means(here, HOME),
        to_95=_means(here, TO_95),
        distance=_means(here, DISTANCE),
    )


def _means(results: Sequence[Result], measure: Measure) -> dict[int, float]:
    by_team: defaultdict[int, list[float]] = defaultdict(list)
    for result in results:
        value = measure.of(result)
        if success(result) and value is not None:
            by_team[result.condition.robots].append(value)
    return {robots: float(np.mean(by_team[robots])) for robots in sorted(by_team)}
