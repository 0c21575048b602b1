"""The informed plans of an experiment, by which the times of its runs are judged.

A plan is a run of `informed`, made as any other: by workers, within the limits of the experiment.
Runs with the same world, team and starts share one. What it took is stored with each of them, and
kept in the user's cache for other experiments.
"""

from __future__ import annotations

import msgspec

from multisrt.environments.environment import Environment
from multisrt.experiments.crossing import PlannedRun, key_of
from multisrt.experiments.job import Job
from multisrt.experiments.mission import world_of
from multisrt.experiments.results import Result
from multisrt.experiments.store import Store
from multisrt.geometry.errors import InvalidInputError
from multisrt.informed.reference import (
    informed_run,
    keep_reference,
    kept_reference,
    reference_of,
)
from multisrt.robots.registry import strategy
from multisrt.spec import RunSpec


class MissingPlans:
    """The plans that the stored runs of an experiment lack.

    Those that the cache has, and the reasons for which there can be none, are stored at once.

    Parameters
    ----------
    store : Store
        The store of the experiment, open for writing.

    Attributes
    ----------
    jobs : list of Job
        The plans that must be made, in the order of the experiment.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._runs: dict[str, list[str]] = {}
        self._asked: dict[str, tuple[RunSpec, Environment]] = {}
        self.jobs: list[Job] = []
        missing = store.plans.missing()
        alike: dict[bytes, list[PlannedRun]] = {}
        for run in store.runs():
            if run.key in missing:
                alike.setdefault(place_of(run.spec), []).append(run)
        for runs in alike.values():
            self._ask(runs)

    def _ask(self, runs: list[PlannedRun]) -> None:
        first = runs[0]
        keys = [run.key for run in runs]
        try:
            strategy("informed").require_fit(first.spec)
            world = world_of(first.spec.environment)
            asked = informed_run(first.spec, world)
        except InvalidInputError as error:
            self._store.plans.add(keys, str(error))
            return
        kept = kept_reference(asked, world)
        if kept is not None:
            self._store.plans.add(keys, kept)
            return
        key = key_of(asked)
        if key not in self._runs:
            condition = msgspec.structs.replace(first.condition, strategy=asked.strategy)
            self._asked[key] = asked, world
            self.jobs.append(
                Job(
                    key=key,
                    condition=condition,
                    repetition=first.repetition,
                    spec=asked,
                    limits=self._store.experiment.limits,
                )
            )
        self._runs.setdefault(key, []).extend(keys)

    def add(self, made: Result) -> None:
        """Store a plan with the runs that are judged by it.

        Parameters
        ----------
        made : Result
            The result of one of the jobs.

        Raises
        ------
        InvalidInputError
            If it cannot be written.
        """
        keys = self._runs[made.key]
        if made.metrics is None:
            self._store.plans.add(keys, f"no informed plan: {made.reason}")
            return
        reference = reference_of(made.metrics)
        keep_reference(*self._asked[made.key], reference)
        self._store.plans.add(keys, reference)


def place_of(spec: RunSpec) -> bytes:
    """Return what the informed plan of a run may depend on.

    Parameters
    ----------
    spec : RunSpec
        The run.

    Returns
    -------
    bytes
        Equal for runs with the same world, team, starts and faults; the seed draws starts.
    """
    return msgspec.json.encode((spec.environment, spec.robots, spec.starts, spec.seed, spec.faults))
