"""What came out of an experiment: a result for each run, and what made them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal

import msgspec

from multisrt.analysis.metrics import Metrics
from multisrt.experiments.crossing import Condition
from multisrt.experiments.description import ExperimentSpec
from multisrt.experiments.provenance import Provenance

Status = Literal[
    "complete", "stalled", "out_of_time", "over_time", "over_memory", "crashed", "refused", "error"
]
"""How a run ended: as its recording says, or without one. `over_time` and `over_memory`: beyond
the experiment's limits. `crashed`: its process died. `refused`: the spec cannot be run. `error`: a
defect."""

ENDED = ("complete", "stalled", "out_of_time")
"""Those that came to an end of their own and were measured."""


class Result(msgspec.Struct, frozen=True, kw_only=True):
    """One run.

    Attributes
    ----------
    key : str
        Digest of its spec.
    condition : Condition
        What it is a repetition of.
    repetition : int
        Which, from 0.
    status : str
        How it ended; see `Status`.
    reason : str
        Why, in words.
    digest : str
        That of its recording; empty if it did not come to an end.
    metrics : Metrics or None
        What was measured; None if it did not come to an end.
    covered_at_s : tuple of (float or None)
        When each percent of the explorable area was covered, from 0 to 100; None if it never was.
    computing_s, wall_s : float
        What it took, of computing time and by the clock.
    memory_mb : float
        The most that its process took while it was made; on macOS, that it took until then.
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
        """Whether it has to be looked at: not complete, or a collision."""
        return self.status != "complete" or (
            self.metrics is not None and self.metrics.collisions > 0
        )


class Results:
    """The results of an experiment, as far as they are there.

    Parameters
    ----------
    experiment : ExperimentSpec
        What was asked for.
    results : iterable of Result
        What came out, in the order of the experiment's runs.
    asked : int
        How many runs the experiment has.
    provenance : Provenance
        What made them.
    """

    def __init__(
        self,
        experiment: ExperimentSpec,
        results: Iterable[Result],
        asked: int,
        provenance: Provenance,
    ) -> None:
        self.experiment = experiment
        self.results = tuple(results)
        self.asked = asked
        self.provenance = provenance

    def __len__(self) -> int:
        """How many there are."""
        return len(self.results)

    def __iter__(self) -> Iterator[Result]:
        """Give them one by one."""
        return iter(self.results)

    def conditions(self) -> list[Condition]:
        """Give the conditions that have results, in their order."""
        return list(dict.fromkeys(result.condition for result in self.results))

    def of(self, condition: Condition) -> list[Result]:
        """Give the results of a condition, by repetition."""
        found = [result for result in self.results if result.condition == condition]
        return sorted(found, key=lambda result: result.repetition)
