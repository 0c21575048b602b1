"""Results of planned runs that were not made."""

from typing import Any

from multisrt.analysis.metrics import Metrics
from multisrt.experiments.crossing import PlannedRun
from multisrt.experiments.job import Job
from multisrt.experiments.results import Result, Status


def result_of(
    run: PlannedRun | Job, status: Status = "complete", reason: str = "no reason", **fields: Any
) -> Result:
    """Return a result of a run, without metrics unless they are given."""
    return Result(
        key=run.key,
        condition=run.condition,
        repetition=run.repetition,
        status=status,
        reason=reason,
        **fields,
    )


def metrics_of(result: Result) -> Metrics:
    """Return the metrics of a run that was measured."""
    assert result.metrics is not None
    return result.metrics
