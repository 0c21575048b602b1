"""Runs of an experiment made again from their specs: pictures of median runs, and failures."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from multisrt.experiments.crossing import Condition, runs
from multisrt.experiments.measures import measure_named
from multisrt.experiments.results import Result, Results
from multisrt.geometry.errors import InvalidInputError
from multisrt.reporting.layout import slug
from multisrt.reporting.study import Study
from multisrt.spec import RunSpec

MOST_TREES = 12
"""Trees in a gallery."""

MOST_FAILURES = 30
"""Kinds of failures that are told one by one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tree:
    """The picture of a run.

    Attributes
    ----------
    name : str
        What files call it.
    result : Result
        The run.
    setting : Condition
        Where; its strategy is empty.
    svg : str
        The drawing.
    same : bool
        Whether the run made again is the run that was measured, to the byte.
    """

    name: str
    result: Result
    setting: Condition
    svg: str
    same: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """Runs that failed in the same way.

    Attributes
    ----------
    strategy, status, reason : str
        Whose, how, and why: the first one's words.
    results : tuple of Result
        All of them.
    spec : RunSpec or None
        That of the first; None if it cannot be built.
    """

    strategy: str
    status: str
    reason: str
    results: tuple[Result, ...]
    spec: RunSpec | None

    @property
    def spec_name(self) -> str:
        """Name of the file of the spec that repeats the first one."""
        return f"{self.results[0].key}.toml"


class Specs:
    """The specs of an experiment's runs by their keys, built when they are first asked for.

    Parameters
    ----------
    results : Results
        Of the experiment.
    folder : path, optional
        What paths of its environments are relative to.

    Attributes
    ----------
    problem : str
        Why they cannot be built; empty where they can, or nobody has asked.
    """

    def __init__(self, results: Results, folder: Path | None = None) -> None:
        self._results = results
        self._folder = folder
        self._specs: dict[str, RunSpec] | None = None
        self.problem = ""

    def of(self, result: Result) -> RunSpec | None:
        """Give the spec of a run; None if the experiment has no such run, or cannot be built."""
        if self._specs is None:
            self._specs = {}
            try:
                planned = runs(self._results.experiment, self._folder)
                self._specs = {run.key: run.spec for run in planned}
            except InvalidInputError as error:
                self.problem = str(error)
        return self._specs.get(result.key)


def gallery(
    study: Study, specs: Specs, progress: Callable[[str], None] | None = None
) -> tuple[list[Tree], list[str]]:
    """Draw the trees of median runs, by simulating them again.

    Parameters
    ----------
    study : Study
        The results.
    specs : Specs
        Of their runs.
    progress : callable, optional
        Is told what is being made.

    Returns
    -------
    trees : list of Tree
        As many as a gallery has, setting by setting.
    notes : list of str
        What could not be drawn, and why.
    """
    from multisrt.drawing import tree_svg
    from multisrt.simulation.simulate import simulate
    from multisrt.simulation.worlds import build_environment

    trees, notes = [], []
    for setting in gallery_settings(study):
        for strategy in study.here(setting)[:MOST_TREES]:
            what = f"{study.name(setting)}, {strategy}"
            result = median_run(study.of(setting, strategy))
            if result is None:
                notes.append(f"{what}: no run came to an end.")
                continue
            spec = specs.of(result)
            if spec is None:
                why = specs.problem or "the experiment has no such run any more"
                notes.append(f"{what}: {why}.")
                continue
            if progress is not None:
                progress(f"drawing {what}")
            try:
                recording = simulate(spec, build_environment(spec.environment))
            except InvalidInputError as error:
                notes.append(f"{what}: {error}.")
                continue
            trees.append(
                Tree(
                    name=f"{slug(what)}-{result.key[:8]}",
                    result=result,
                    setting=setting,
                    svg=tree_svg(recording),
                    same=recording.footer.digest == result.digest,
                )
            )
    return trees, notes


def gallery_settings(study: Study) -> list[Condition]:
    """Choose settings for a gallery: every world first with its largest team, then smaller ones."""
    most = max(1, MOST_TREES // max(1, len(study.strategies)))
    by_scene = [list(reversed(settings)) for settings in study.scenes().values()]
    longest = max(map(len, by_scene), default=0)
    in_turn = [own[turn] for turn in range(longest) for own in by_scene if turn < len(own)]
    chosen = in_turn[:most]
    return [setting for setting in study.settings if setting in chosen]


def median_run(results: list[Result]) -> Result | None:
    """Give the run in the middle: by its time if any was complete, else by its coverage."""
    time, coverage = measure_named("exploration_time_s"), measure_named("coverage")
    for measure, wanted in ((time, ("complete",)), (coverage, ("stalled", "out_of_time"))):
        found = [
            (value, result.repetition, result)
            for result in results
            if result.status in wanted and (value := measure.of(result)) is not None
        ]
        if found:
            return sorted(found, key=lambda entry: entry[:2])[(len(found) - 1) // 2][2]
    return None


def failures(study: Study, specs: Specs) -> list[Failure]:
    """Group the runs that failed by strategy, status and reason, whatever the numbers in it."""
    groups: dict[tuple[str, str, str], list[Result]] = defaultdict(list)
    for result in study.results:
        if result.failed:
            status = result.status if result.status != "complete" else "collision"
            pattern = re.sub(r"\d+(\.\d+)?", "#", result.reason)
            groups[result.condition.strategy, status, pattern].append(result)
    found = [
        Failure(
            strategy=strategy,
            status=status,
            reason=results[0].reason,
            results=tuple(results),
            spec=specs.of(results[0]) if number < MOST_FAILURES else None,
        )
        for number, ((strategy, status, _), results) in enumerate(groups.items())
    ]
    return sorted(found, key=lambda failure: -len(failure.results))
