"""Results of an experiment: one for each run, with their provenance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Literal

import msgspec

from multisrt.analysis.metrics import SUCCESS_COVERAGE, Metrics
from multisrt.experiments.crossing import Condition
from multisrt.experiments.provenance import Provenance
from multisrt.experiments.spec import ExperimentSpec
from multisrt.extras.notebook import table_html
from multisrt.geometry.errors import InvalidInputError
from multisrt.informed.reference import Reference

Status = Literal[
    "complete", "stalled", "out_of_time", "over_time", "over_memory", "crashed", "refused", "error"
]
"""How a run ended. The first three are outcomes of recordings. `over_time` and `over_memory`: it
exceeded the experiment's limits. `crashed`: its process died. `refused`: its spec is impossible.
`error`: an exception."""

ENDED = ("complete", "stalled", "out_of_time")
"""Statuses of runs that came to an end and were measured."""


class Result(msgspec.Struct, frozen=True, kw_only=True):
    """The result of one run.

    Attributes
    ----------
    key : str
        Digest of the run's spec; see `crossing.key_of`.
    condition : Condition
        The condition that the run repeats.
    repetition : int
        Number of the repetition, from 0.
    status : str
        How the run ended; see `Status`.
    reason : str
        Why it ended, as text.
    digest : str
        Digest of the recording; empty if the run did not come to an end.
    metrics : Metrics or None
        Metrics of the run; None if it did not come to an end.
    horizon_s : float or None
        Time to which the integrals of its metrics run (s); None: to the end of the run.
        `known_to_one_by_robot_m2s` is not continued beyond the end of the run.
    success_coverage : float
        Share of the explorable area that the run must cover to be a success.
    chance : bool
        Whether any random number was drawn in the run; if not, it is the same for every seed.
    same_as : int or None
        The repetition of which this one is a copy: they differ only by their seeds, on which
        nothing in the run depends.
    covered_at_s : tuple of (float or None)
        Simulated time (s) at which 0, 1, ..., 100 % of the explorable area were covered; None if
        it was never reached.
    delivered_at_s : tuple of (float or None)
        The same for the area known to the base station; empty without one.
    reference : Reference or None
        Times of the informed plan with the same team and starts; None without one.
    no_reference : str
        Why there is no reference; empty if there is one, or if it has not been computed yet.
    computing_s, wall_s : float
        Computing time and elapsed time of the run (s).
    memory_mb : float
        Peak memory of the process during the run (MB); on macOS, since its start.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.experiments.crossing import runs
    >>> from multisrt.experiments.mission import make_run
    >>> spec = ms.ExperimentSpec(name="x", environments=("open",), strategies=("srt-radial",))
    >>> result = make_run(runs(spec)[0], spec.limits)
    >>> result.condition.strategy, result.status, result.success
    ('srt-radial', 'complete', True)
    """

    key: str
    condition: Condition
    repetition: int
    status: Status
    reason: str
    digest: str = ""
    metrics: Metrics | None = None
    horizon_s: float | None = None
    success_coverage: float = SUCCESS_COVERAGE
    chance: bool = True
    same_as: int | None = None
    covered_at_s: tuple[float | None, ...] = ()
    delivered_at_s: tuple[float | None, ...] = ()
    reference: Reference | None = None
    no_reference: str = ""
    computing_s: float = 0.0
    wall_s: float = 0.0
    memory_mb: float = 0.0

    @property
    def success(self) -> bool:
        """Whether the run covered enough, however it ended, and nothing collided."""
        return is_success(self.metrics, self.success_coverage)

    @property
    def failed(self) -> bool:
        """Whether the run did not succeed."""
        return not self.success

    @property
    def over_informed(self) -> float | None:
        """Time to 99 % coverage over that of the informed plan; None if either never was."""
        m, plan = self.metrics, self.reference
        if m is None or plan is None or m.time_to_99_s is None or not plan.time_to_99_s:
            return None
        return m.time_to_99_s / plan.time_to_99_s

    @property
    def account(self) -> str:
        """One line on how the run ended and, if it failed, what it left uncovered and why.

        Examples
        --------
        >>> where = Condition(environment="open", strategy="srt-star", robots=1)
        >>> Result(key="k", condition=where, repetition=0, status="crashed", reason="died").account
        'died'
        """
        m = self.metrics
        if m is None or self.success:
            return self.reason
        if m.collisions > 0:
            return f"collided: {self.reason}"
        areas = {why: f"{area:.1f} m2" for why, area in m.given_up_m2.items()}
        by_reason = ", ".join(f"{area} {why}" for why, area in areas.items() if area != "0.0 m2")
        left = f"; left: {by_reason}" if by_reason else ""
        return f"covered {100 * m.coverage:.1f} %, seen {100 * m.seen:.1f} %{left}; {self.reason}"

    def to_horizon(self, horizon_s: float) -> Result:
        """Return the result with integrals that run to a horizon.

        Nothing changes after the end of a run: from there on the integrals grow by what is left
        uncovered, and by the area that only one robot knows; what was not delivered ages.

        Parameters
        ----------
        horizon_s : float
            Time to which the integrals run (s).

        Returns
        -------
        Result
            The result; itself if it was not measured.

        Raises
        ------
        InvalidInputError
            If the horizon or the one that the integrals have is before the end of the run, and
            they differ: then the run must be measured again.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1)
        >>> where = Condition(environment="open", strategy="srt-radial", robots=1)
        >>> result = Result(
        ...     key="k", condition=where, repetition=0, status=run.outcome, reason="",
        ...     metrics=run.metrics,
        ... )
        >>> later = result.to_horizon(run.metrics.makespan_s + 100.0).metrics
        >>> more_s = later.coverage_integral_s - run.metrics.coverage_integral_s
        >>> round(more_s / 100.0, 6) == round(1.0 - run.metrics.coverage, 6)
        True
        """
        m = self.metrics
        if m is None:
            return self
        end_s = m.makespan_s if self.horizon_s is None else self.horizon_s
        if not can_move_horizon(m.makespan_s, self.horizon_s, horizon_s):
            raise InvalidInputError(
                f"run {self.key}: its integrals run to {end_s:g} s and cannot be brought to "
                f"{horizon_s:g} s; measure it with that horizon"
            )
        more_s = horizon_s - end_s
        metrics = msgspec.structs.replace(
            m,
            coverage_integral_s=m.coverage_integral_s + more_s * (1.0 - m.coverage),
            known_to_one_m2s=m.known_to_one_m2s + more_s * m.known_to_one_m2,
            delivery_delay_s=_delayed(m, more_s),
        )
        return msgspec.structs.replace(self, metrics=metrics, horizon_s=horizon_s)


def _delayed(m: Metrics, more_s: float) -> float | None:
    # The mean delivery delay when a run's horizon is moved on, by what was never delivered.
    if m.delivery_delay_s is None or m.delivered_coverage is None:
        return None
    return m.delivery_delay_s + more_s * (1.0 - m.delivered_coverage / m.coverage)


def is_success(metrics: Metrics | None, threshold: float = SUCCESS_COVERAGE) -> bool:
    """Return whether a run is a success: it covered enough, and nothing collided.

    Parameters
    ----------
    metrics : Metrics or None
        Metrics of the run; None if it was not measured.
    threshold : float
        Share of the explorable area that must be covered.

    Returns
    -------
    bool
        Whether it is; how the run ended does not matter.

    Examples
    --------
    >>> import multisrt as ms
    >>> is_success(ms.explore("open", seed=1, max_time_s=10.0).metrics), is_success(None)
    (False, False)
    """
    return metrics is not None and metrics.collisions == 0 and metrics.reached(threshold)


def can_move_horizon(makespan_s: float, from_s: float | None, to_s: float) -> bool:
    """Return whether integrals can be brought to a horizon without measuring the run again.

    Parameters
    ----------
    makespan_s : float
        End of the run (s).
    from_s : float or None
        Time to which the integrals run (s); None: to the end of the run.
    to_s : float
        Time to which they shall run (s).

    Returns
    -------
    bool
        Whether they run to that time already, or both times are not before the end of the run.

    Examples
    --------
    >>> can_move_horizon(80.0, None, 100.0), can_move_horizon(80.0, 50.0, 100.0)
    (True, False)
    """
    if from_s is None:
        return makespan_s <= to_s
    return from_s == to_s or makespan_s <= min(from_s, to_s)


class Results:
    """The results of an experiment so far: a sized iterable of `Result`.

    Parameters
    ----------
    experiment : ExperimentSpec
        The experiment, whose threshold of success and horizon they get.
    results : iterable of Result
        The results, in the order of the experiment's runs.
    planned : int
        Number of runs of the experiment.
    provenance : Provenance
        Versions and machine that made the results.

    Attributes
    ----------
    unreferenced : dict of Condition to str
        Settings, with an empty strategy, that lack the time of an informed plan to 99 % for some
        of their runs, and why; empty if no plan was asked for. None of their results has a
        reference, so that all strategies of a setting are compared by the same repetitions.

    Examples
    --------
    >>> from multisrt.experiments.provenance import provenance
    >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("srt-star",))
    >>> where = Condition(environment="open", strategy="srt-star", robots=1)
    >>> one = Result(key="k", condition=where, repetition=0, status="stalled", reason="blocked")
    >>> results = Results(spec, [one], planned=20, provenance=provenance())
    >>> len(results), [result.reason for result in results if result.failed]
    (1, ['blocked'])
    """

    def __init__(
        self,
        experiment: ExperimentSpec,
        results: Iterable[Result],
        planned: int,
        provenance: Provenance,
    ) -> None:
        self.experiment = experiment
        given = tuple(results)
        self.unreferenced = _unreferenced(experiment, given)
        self.results = _comparable(experiment, given, self.unreferenced)
        self.planned = planned
        self.provenance = provenance

    def __len__(self) -> int:
        """Return the number of results."""
        return len(self.results)

    def __iter__(self) -> Iterator[Result]:
        """Iterate over the results, in the experiment's order."""
        return iter(self.results)

    def conditions(self) -> list[Condition]:
        """Return the conditions that have results.

        Returns
        -------
        list of Condition
            The conditions, in the experiment's order.

        Examples
        --------
        >>> from multisrt.experiments.provenance import provenance
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("srt-star",))
        >>> where = Condition(environment="open", strategy="srt-star", robots=1)
        >>> one = Result(key="k", condition=where, repetition=0, status="complete", reason="")
        >>> [str(each) for each in Results(spec, [one], 20, provenance()).conditions()]
        ['open, srt-star, 1 robot, scattered, unlimited, disc:0.25']
        """
        return list(dict.fromkeys(result.condition for result in self.results))

    def of(self, condition: Condition) -> list[Result]:
        """Return the results of a condition.

        Parameters
        ----------
        condition : Condition
            The condition.

        Returns
        -------
        list of Result
            Its results, sorted by repetition; empty if there are none.

        Examples
        --------
        >>> from multisrt.experiments.provenance import provenance
        >>> spec = ExperimentSpec(name="x", environments=("open",), strategies=("srt-star",))
        >>> where = Condition(environment="open", strategy="srt-star", robots=1)
        >>> one = Result(key="k", condition=where, repetition=0, status="complete", reason="")
        >>> [result.status for result in Results(spec, [one], 20, provenance()).of(where)]
        ['complete']
        """
        found = [result for result in self.results if result.condition == condition]
        return sorted(found, key=lambda result: result.repetition)

    def _repr_html_(self) -> str:
        rows = []
        for condition in self.conditions():
            own = self.of(condition)
            ends = Counter(result.status.replace("_", " ") for result in own)
            good = sum(result.success for result in own)
            ended = ", ".join(f"{count} {end}" for end, count in ends.items())
            rows.append((str(condition), f"{good} of {len(own)}", ended))
        title = f"{self.experiment.name}: {len(self)} of {self.planned} runs"
        return table_html(title, ("condition", "success", "ended"), rows)


def setting_of(condition: Condition) -> Condition:
    """Return a condition without its strategy: what all strategies have in common.

    Parameters
    ----------
    condition : Condition
        The condition.

    Returns
    -------
    Condition
        The same with an empty strategy.

    Examples
    --------
    >>> setting_of(Condition(environment="open", strategy="srt-star", robots=2)).strategy
    ''
    """
    return msgspec.structs.replace(condition, strategy="")


def referred(results: Iterable[Result], plans: Mapping[str, Reference | str]) -> tuple[Result, ...]:
    """Return results with their references.

    Parameters
    ----------
    results : iterable of Result
        The results.
    plans : mapping of str to Reference or str
        By the key of a run its reference, or why it has none; runs without a plan are left out.

    Returns
    -------
    tuple of Result
        The results.
    """
    found = []
    for result in results:
        plan = plans.get(result.key)
        if isinstance(plan, str):
            result = msgspec.structs.replace(result, no_reference=plan)
        elif plan is not None:
            result = msgspec.structs.replace(result, reference=plan)
        found.append(result)
    return tuple(found)


def _unreferenced(experiment: ExperimentSpec, results: tuple[Result, ...]) -> dict[Condition, str]:
    """Return the settings without multiples of the informed plan's times, and why."""
    if experiment.reference == "none" and not any(r.reference or r.no_reference for r in results):
        return {}
    lacking: dict[Condition, str] = {}
    for result in results:
        if result.metrics is not None and (why := _why_no_multiple(result)):
            lacking.setdefault(setting_of(result.condition), why)
    return lacking


def _why_no_multiple(result: Result) -> str:
    plan = result.reference
    if plan is None:
        return result.no_reference or "not planned yet"
    if plan.time_to_99_s is None:
        return f"the informed plan covers {100 * plan.coverage:.1f} %"
    return "" if plan.time_to_99_s > 0.0 else "99 % are seen from the starts"


def _comparable(
    experiment: ExperimentSpec,
    results: tuple[Result, ...],
    unreferenced: Mapping[Condition, str],
) -> tuple[Result, ...]:
    """Return results judged by one threshold, with one horizon and all plans in each setting."""
    horizons_s: dict[Condition, float] = {}
    for result in results:
        if experiment.horizon_s is None and result.metrics is not None:
            setting = setting_of(result.condition)
            end_s = result.metrics.makespan_s
            horizons_s[setting] = max(end_s, horizons_s.get(setting, end_s))
    threshold = experiment.success_coverage
    return tuple(
        msgspec.structs.replace(
            result.to_horizon(
                horizons_s.get(setting_of(result.condition), 0.0)
                if experiment.horizon_s is None
                else experiment.horizon_s
            ),
            success_coverage=threshold,
            reference=(None if setting_of(result.condition) in unreferenced else result.reference),
        )
        for result in results
    )
