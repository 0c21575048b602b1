"""Results of an experiment: one for each run, with their provenance."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal

import msgspec

from multisrt.analysis.metrics import Metrics
from multisrt.experiments.crossing import Condition
from multisrt.experiments.provenance import Provenance
from multisrt.experiments.spec import ExperimentSpec

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
        Why it ended, in words.
    digest : str
        Digest of the recording; empty if the run did not come to an end.
    metrics : Metrics or None
        Metrics of the run; None if it did not come to an end.
    covered_at_s : tuple of (float or None)
        Simulated time (s) at which 0, 1, ..., 100 % of the explorable area were covered; None
        where that never happened.
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
    >>> result.condition.strategy, result.status, result.failed
    ('srt-radial', 'complete', False)
    """

    key: str
    condition: Condition
    repetition: int
    status: Status
    reason: str
    digest: str = ""
    metrics: Metrics | None = None
    covered_at_s: tuple[float | None, ...] = ()
    computing_s: float = 0.0
    wall_s: float = 0.0
    memory_mb: float = 0.0

    @property
    def failed(self) -> bool:
        """Whether the run needs a look: it is not complete, or has a collision."""
        return self.status != "complete" or (
            self.metrics is not None and self.metrics.collisions > 0
        )


class Results:
    """The results of an experiment so far: a sized iterable of `Result`.

    Parameters
    ----------
    experiment : ExperimentSpec
        The experiment.
    results : iterable of Result
        The results, in the order of the experiment's runs.
    planned : int
        Number of runs of the experiment.
    provenance : Provenance
        Versions and machine that made the results.

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
        self.results = tuple(results)
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
