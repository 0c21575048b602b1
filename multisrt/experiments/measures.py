"""Measures by which runs are compared: title, unit, and whether more or less is better."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from operator import attrgetter

from multisrt.analysis.metrics import Metrics
from multisrt.experiments.results import Result
from multisrt.geometry.errors import InvalidInputError, did_you_mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """A number by which runs are compared.

    Attributes
    ----------
    name : str
        Name in files and options.
    title : str
        Title in tables and figures.
    unit : str
        Unit; empty for a number without one.
    lower_is_better : bool
        Whether lower values are better.
    get : callable
        Computes the value of a run that was measured; None where it has none.
    digits : int
        Digits after the point in tables.
    needs_success : bool
        Whether the value of an unsuccessful run is that of a failure, where lower is better.
    """

    name: str
    title: str
    unit: str
    lower_is_better: bool
    get: Callable[[Result], float | None]
    digits: int = 1
    needs_success: bool = True

    def of(self, result: Result) -> float | None:
        """Return the value of a run.

        Parameters
        ----------
        result : Result
            The run.

        Returns
        -------
        float or None
            The value; None if the run was not measured or has no such value.
        """
        if result.metrics is None:
            return None
        value = self.get(result)
        return None if value is None else float(value)

    def values(self, results: Iterable[Result]) -> list[float]:
        """Return the values of runs, for statistics by ranks.

        Parameters
        ----------
        results : iterable of Result
            The runs.

        Returns
        -------
        list of float
            One value for each run. Where lower is better, an unsuccessful run is ``inf``,
            worse than all others: its times and distances are not those of an exploration. Where
            higher is better or the measure needs no success, it has the value it reached, or the
            worst one if it was not measured.
        """
        return [self._value(result) for result in results]

    def counts(self, result: Result) -> bool:
        """Return whether a run has a value that is compared with those of others.

        Parameters
        ----------
        result : Result
            The run.

        Returns
        -------
        bool
            Whether it has a value and, where lower is better and that is needed, is a success.
        """
        needs_success = self.lower_is_better and self.needs_success
        return self.of(result) is not None and (not needs_success or result.success)

    def _value(self, result: Result) -> float:
        value = self.of(result)
        if value is None or not self.counts(result):
            return math.inf if self.lower_is_better else 0.0
        return value

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title} ({self.unit})" if self.unit else self.title


def _measure(
    name: str,
    title: str,
    unit: str,
    get: Callable[[Metrics], float | None] | None = None,
    *,
    lower_is_better: bool = True,
    digits: int = 1,
    needs_success: bool = True,
) -> Measure:
    """Return a measure of the metrics of a run, by default the one of its name."""
    read: Callable[[Metrics], float | None] = get or attrgetter(name)
    return Measure(
        name=name,
        title=title,
        unit=unit,
        lower_is_better=lower_is_better,
        get=lambda result: None if result.metrics is None else read(result.metrics),
        digits=digits,
        needs_success=needs_success,
    )


def _ratio(above: float | None, below: float) -> float | None:
    return above / below if above is not None and below > 0.0 else None


MEASURES = (
    _measure("time_to_95_s", "Time to 95 % coverage", "s"),
    _measure("known_complete_s", "Time until one robot's map is complete", "s"),
    _measure("makespan_s", "Time until all are done", "s"),
    _measure("total_distance_m", "Distance of all robots", "m"),
    _measure(
        "distance_per_robot_m",
        "Distance per robot",
        "m",
        lambda m: m.total_distance_m / len(m.distance_by_robot_m),
    ),
    _measure(
        "longest_distance_m",
        "Distance of the robot that went farthest",
        "m",
        lambda m: max(m.distance_by_robot_m),
    ),
    _measure(
        "imbalance",
        "Imbalance of distances: their spread over their mean",
        "",
        lambda m: _ratio(m.distance_spread_m, m.total_distance_m / len(m.distance_by_robot_m)),
        digits=2,
    ),
    _measure("waiting_time_s", "Waiting time of all robots", "s"),
    Measure(
        name="success",
        title="Success",
        unit="",
        lower_is_better=False,
        get=lambda result: float(result.success),
        digits=2,
    ),
    _measure("coverage", "Coverage", "", lower_is_better=False, digits=4),
    _measure("seen", "Share seen by scans", "", lower_is_better=False, digits=4),
    _measure(
        "given_up_m2",
        "Explorable area left uncovered",
        "m2",
        lambda m: math.fsum(m.given_up_m2.values()),
    ),
    _measure("coverage_integral_s", "Integral of the uncovered area", "s"),
    _measure("time_to_90_s", "Time to 90 % coverage", "s"),
    _measure("time_to_99_s", "Time to 99 % coverage", "s"),
    _measure(
        "delivered_coverage", "Coverage known to the base", "", lower_is_better=False, digits=4
    ),
    _measure("delivered_90_s", "Time to 90 % delivered to the base", "s"),
    _measure("delivered_95_s", "Time to 95 % delivered to the base", "s"),
    _measure("delivered_99_s", "Time to 99 % delivered to the base", "s"),
    # Of an exploration that ends early, too: what was never delivered counts until the horizon.
    _measure(
        "delivery_delay_s",
        "Mean delivery delay to the base",
        "s",
        needs_success=False,
    ),
    _measure("carrying_s", "Mean time for which a robot had undelivered data", "s"),
    _measure("overlap_share", "Share seen by several robots", "", digits=3),
    _measure("lost_area_m2", "Area lost with robots that died", "m2"),
    _measure("isolated_total_s", "Time in which a robot was isolated", "s"),
    _measure("isolated_longest_s", "Longest isolation of a robot", "s"),
    _measure("split_s", "Time in which the team was split", "s"),
    _measure("beyond_range_m", "Largest distance beyond the radio's range", "m"),
    _measure("known_to_one_m2s", "Area known to one robot only, over time", "m2 s", digits=0),
    _measure("messages", "Messages", "", digits=0),
    _measure("bytes_sent", "Bytes sent", "B", digits=0),
    _measure("nodes", "Nodes", "", digits=0),
    _measure("decisions", "Decisions where to go", "", digits=0),
    _measure("deadlocks", "Rounds in which a master could let no robot move", "", digits=2),
    _measure("protective_stops", "Protective stops", "", digits=1),
    Measure(
        name="over_informed",
        title="Time to 99 % coverage over that of the informed plan",
        unit="",
        lower_is_better=True,
        get=lambda result: result.over_informed,
        digits=2,
    ),
    _measure(
        "over_bound",
        "Makespan over its lower bound",
        "",
        lambda m: _ratio(m.makespan_s, m.lower_bound_s),
        digits=2,
    ),
)
"""All measures; the first is the main one: it needs no word of a robot, only what was covered."""


INTEGRALS = ("coverage_integral_s", "known_to_one_m2s")
"""Names of the measures that are integrals over time, to the horizon of the runs."""

TO_HORIZON = (*INTEGRALS, "delivery_delay_s")
"""Names of all measures that depend on the horizon of the runs."""


def measure_named(name: str) -> Measure:
    """Return the measure of a name.

    Parameters
    ----------
    name : str
        The name.

    Returns
    -------
    Measure
        The measure.

    Raises
    ------
    InvalidInputError
        If there is none of that name; the message lists them.

    Examples
    --------
    >>> measure_named("makespan_s").heading
    'Time until all are done (s)'
    """
    known = {measure.name: measure for measure in MEASURES}
    if name not in known:
        raise InvalidInputError(
            f"there is no measure {name!r}{did_you_mean(name, known)}; "
            f"there are: {', '.join(known)}"
        )
    return known[name]
