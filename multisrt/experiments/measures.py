"""Measures by which runs are compared: title, unit, and which way is better."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

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
        Computes the value from a run's metrics; None where the run has none.
    digits : int
        Digits after the point in tables.
    """

    name: str
    title: str
    unit: str
    lower_is_better: bool
    get: Callable[[Metrics], float | None]
    digits: int = 1

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
        value = self.get(result.metrics)
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
            One value for each run. Where lower is better, a run that is not complete is ``inf``,
            worse than all others: its times and distances are not those of an exploration. Where
            higher is better, it has the value it reached, or 0 if it was not measured.
        """
        return [self._value(result) for result in results]

    def _value(self, result: Result) -> float:
        value = self.of(result)
        if not self.lower_is_better:
            return 0.0 if value is None else value
        return math.inf if value is None or result.status != "complete" else value

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title} ({self.unit})" if self.unit else self.title


def _plain(
    name: str, title: str, unit: str, *, lower_is_better: bool = True, digits: int = 1
) -> Measure:
    return Measure(
        name=name,
        title=title,
        unit=unit,
        lower_is_better=lower_is_better,
        get=lambda metrics: getattr(metrics, name),
        digits=digits,
    )


def _ratio(above: float | None, below: float) -> float | None:
    return above / below if above is not None and below > 0.0 else None


MEASURES = (
    _plain("known_complete_s", "Time until a robot knows the map complete", "s"),
    _plain("makespan_s", "Time until all are home", "s"),
    _plain("total_distance_m", "Distance of all robots", "m"),
    Measure(
        name="distance_per_robot_m",
        title="Distance per robot",
        unit="m",
        lower_is_better=True,
        get=lambda m: m.total_distance_m / len(m.distance_by_robot_m),
    ),
    Measure(
        name="longest_distance_m",
        title="Distance of the robot that went farthest",
        unit="m",
        lower_is_better=True,
        get=lambda m: max(m.distance_by_robot_m),
    ),
    Measure(
        name="imbalance",
        title="Imbalance of distances: their spread over their mean",
        unit="",
        lower_is_better=True,
        get=lambda m: _ratio(m.distance_spread_m, m.total_distance_m / len(m.distance_by_robot_m)),
        digits=2,
    ),
    _plain("waiting_time_s", "Waiting time of all robots", "s"),
    _plain("coverage", "Coverage", "", lower_is_better=False, digits=4),
    _plain("coverage_integral_s", "Integral of what is not yet covered", "s"),
    _plain("time_to_90_s", "Time to 90 % coverage", "s"),
    _plain("time_to_95_s", "Time to 95 % coverage", "s"),
    _plain("time_to_99_s", "Time to 99 % coverage", "s"),
    _plain("overlap_share", "Share seen by several robots", "", digits=3),
    _plain("lost_area_m2", "Area lost with robots that died", "m2"),
    _plain("isolated_total_s", "Time in which a robot was isolated", "s"),
    _plain("isolated_longest_s", "Longest isolation of a robot", "s"),
    _plain("split_s", "Time in which the team was split", "s"),
    _plain("beyond_range_m", "Largest distance beyond the radio's range", "m"),
    _plain("known_to_one_m2s", "Area known to one robot only, over time", "m2 s", digits=0),
    _plain("messages", "Messages", "", digits=0),
    _plain("bytes_sent", "Bytes sent", "B", digits=0),
    _plain("nodes", "Nodes", "", digits=0),
    _plain("deadlocks", "Rounds in which a master could let nobody go", "", digits=2),
    _plain("protective_stops", "Protective stops", "", digits=1),
    Measure(
        name="over_bound",
        title="Exploration time over its lower bound",
        unit="",
        lower_is_better=True,
        get=lambda m: _ratio(m.known_complete_s, m.lower_bound_s),
        digits=2,
    ),
)
"""All measures; the first is the main one."""


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
    'Time until all are home (s)'
    """
    known = {measure.name: measure for measure in MEASURES}
    if name not in known:
        raise InvalidInputError(
            f"there is no measure {name!r}{did_you_mean(name, known)}; "
            f"there are: {', '.join(known)}"
        )
    return known[name]
