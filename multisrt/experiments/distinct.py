"""Repetitions that are one run: made once, stored for each.

Where nothing depends on the seed (one map, fixed starts and faults, a strategy that draws no random
number), all repetitions are the same run. Specs that differ by their seed alone are twins; a run
that ended without a random number being drawn is that of all its twins, because the seed enters a
run by its random numbers only.
"""

from __future__ import annotations

import msgspec

from multisrt.experiments.crossing import PlannedRun, key_of
from multisrt.experiments.results import Result
from multisrt.experiments.store import Store


class Twins:
    """The twins among the runs of an experiment.

    Of twins none of which has come to an end, one is made at a time. The first that ends decides
    whether the others are copies of it, so that what is made does not depend on the number of
    workers. One that failed without a result decides nothing: whatever took its process down may
    have been of the machine, or of its seed.

    Parameters
    ----------
    store : Store
        The store of the experiment.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._twins = {run.key: twin_key(run) for run in store.runs()}

    def copies(self) -> list[Result]:
        """Return the results of missing runs whose twin was made without chance.

        Returns
        -------
        list of Result
            Copies of the twins' results, in the experiment's order.
        """
        made = {self._twins[result.key]: result for result in self._store.of_no_chance()}
        return [
            copied(made[twins], run)
            for run in self._store.missing()
            if (twins := self._twins[run.key]) in made
        ]

    def next_batch(self) -> list[PlannedRun]:
        """Return the missing runs that can be made now.

        Returns
        -------
        list of PlannedRun
            The runs in the experiment's order: of twins none of which has come to an end, the
            first one that is missing. Once the batch is stored there is another, until no run is
            missing.
        """
        decided = {self._twins[key] for key in self._store.ended()}
        waiting: set[str] = set()
        batch = []
        for run in self._store.missing():
            twins = self._twins[run.key]
            if twins not in waiting:
                batch.append(run)
            if twins not in decided:
                waiting.add(twins)
        return batch


def twin_key(run: PlannedRun) -> str:
    """Return the digest of a run's spec without its seed.

    Parameters
    ----------
    run : PlannedRun
        The run.

    Returns
    -------
    str
        32 hexadecimal digits; equal for twins. The seed of a generated world, drawn starts and
        drawn faults are parts of the spec.
    """
    return key_of(msgspec.structs.replace(run.spec, seed=0))


def copied(result: Result, run: PlannedRun) -> Result:
    """Return the result of a run that is the same as one that was made.

    Parameters
    ----------
    result : Result
        The result of the run that was made.
    run : PlannedRun
        Its twin.

    Returns
    -------
    Result
        The result, which took no computing time.
    """
    return msgspec.structs.replace(
        result,
        key=run.key,
        condition=run.condition,
        repetition=run.repetition,
        same_as=result.repetition,
        computing_s=0.0,
        wall_s=0.0,
    )
