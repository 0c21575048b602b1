"""Runs of an experiment repeated from their specs: pictures of median runs, and failures."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from multisrt.experiments.crossing import Condition, runs
from multisrt.experiments.measures import MEASURES, measure_named
from multisrt.experiments.results import Result, Results
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.reporting.custom_strategies import imported
from multisrt.reporting.layout import slug
from multisrt.reporting.study import Study
from multisrt.robots.registry import is_built_in
from multisrt.spec import RunSpec

MAX_TREES = 12
"""Upper bound of the pictures in a gallery."""

MAX_FAILURES = 30
"""Upper bound of the kinds of failures that are shown with a spec to repeat them."""

OTHER_RUN = (
    "this version of the program or of the strategy makes another run of the same spec than the "
    "one that was measured"
)
"""Why a run that was simulated again is not drawn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tree:
    """The picture of a run.

    Attributes
    ----------
    name : str
        Stem of its file name.
    result : Result
        The run.
    setting : Condition
        The setting of the run; its strategy is empty.
    svg : str
        The drawing.
    small : str
        A small drawing, for the page.
    replay : str
        The page that replays the run; empty if there is none.
    """

    name: str
    result: Result
    setting: Condition
    svg: str
    small: str
    replay: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """Runs of one strategy that were unsuccessful in the same way.

    Attributes
    ----------
    strategy : str
        Label of the strategy.
    status : str
        Status of the runs, or "collision".
    reason : str
        What the first run left and why: its `Result.account`.
    results : tuple of Result
        The runs.
    spec : RunSpec or None
        Spec of the first run; None if it cannot be built.
    problem : str
        Why there is no spec; empty if there is one, or if it was not asked for.
    imported : str
        What must be imported to repeat the run; empty for a built-in strategy.
    """

    strategy: str
    status: str
    reason: str
    results: tuple[Result, ...]
    spec: RunSpec | None
    problem: str = ""
    imported: str = ""

    @property
    def spec_name(self) -> str:
        """Name of the file with the spec of the first run."""
        return f"{self.results[0].key}.toml"


@dataclass(frozen=True, slots=True, kw_only=True)
class Gallery:
    """Pictures of median runs.

    Attributes
    ----------
    trees : tuple of Tree
        The pictures, setting by setting.
    notes : tuple of str
        Which runs could not be drawn, and why: a sentence each.
    """

    trees: tuple[Tree, ...] = ()
    notes: tuple[str, ...] = ()


class Specs:
    """Specs of an experiment's runs, built on first use.

    Parameters
    ----------
    results : Results
        Results of the experiment.
    folder : path, optional
        Folder that relative paths of environments start from.

    """

    def __init__(self, results: Results, folder: Path | None = None) -> None:
        self._results = results
        self._folder = folder
        self._specs: dict[str, RunSpec] | None = None
        self._impossible: dict[Condition, str] = {}
        self._problem = "the experiment no longer has this run"

    def of(self, result: Result) -> RunSpec | None:
        """Return the spec of a run; None if the experiment lacks the run or cannot be built."""
        if self._specs is None:
            self._specs = {}
            experiment, impossible = self._results.experiment, self._impossible
            try:
                planned = runs(experiment, self._folder, impossible=impossible)
            except InvalidInputError as error:
                planned, self._problem = [], str(error)
            self._specs = {run.key: run.spec for run in planned}
            if not planned and impossible:
                self._problem = next(iter(impossible.values()))
        return self._specs.get(result.key)

    def problem(self, result: Result) -> str:
        """Return why a run has no spec, as of a strategy that is not known here."""
        return self._impossible.get(result.condition, self._problem)


def gallery(
    study: Study,
    specs: Specs,
    progress: Callable[[str], None] | None = None,
    *,
    replays: bool = True,
) -> Gallery:
    """Simulate median runs again and draw them.

    Parameters
    ----------
    study : Study
        The results.
    specs : Specs
        Specs of their runs.
    progress : callable, optional
        Called with a line on what is being drawn.
    replays : bool, optional
        Whether pages that replay the runs are made, too.

    Returns
    -------
    Gallery
        At most `MAX_TREES` pictures.
    """
    from multisrt.simulation.simulate import simulate
    from multisrt.simulation.worlds import build_environment

    trees, notes = [], []
    for setting in gallery_settings(study):
        for strategy in study.here(setting)[:MAX_TREES]:
            what = f"{study.name(setting)}, {strategy}"
            result = median_run(study.distinct(setting, strategy))
            if result is None:
                notes.append(f"{what}: no run has ended.")
                continue
            spec = specs.of(result)
            if spec is None:
                notes.append(f"{what}: {specs.problem(result)}.")
                continue
            if progress is not None:
                progress(f"drawing {what}")
            try:
                recording = simulate(spec, build_environment(spec.environment))
            except InvalidInputError as error:
                notes.append(f"{what}: {error}.")
                continue
            except Exception as error:
                if is_built_in(spec.strategy):
                    raise
                notes.append(f"{what}: the strategy raised {type(error).__name__}: {error}.")
                continue
            if recording.footer.digest != result.digest:
                notes.append(f"{what}: {OTHER_RUN}.")
                continue
            tree = _tree(recording, what, result, setting)
            if replays:
                tree, note = _with_replay(tree, recording)
                notes += [f"{what}: {note}."] if note else []
            trees.append(tree)
    return Gallery(trees=tuple(trees), notes=tuple(notes))


def _tree(recording: Recording, what: str, result: Result, setting: Condition) -> Tree:
    from multisrt.drawing import tree_svg
    from multisrt.drawing.small_svg import small_svg

    return Tree(
        name=f"{slug(what)}-{result.key[:8]}",
        result=result,
        setting=setting,
        svg=tree_svg(recording),
        small=small_svg(recording, what),
    )


def _with_replay(tree: Tree, recording: Recording) -> tuple[Tree, str]:
    # With its replay, or why there is none.
    from multisrt.replay import replay_html

    try:
        return replace(tree, replay=replay_html(recording)), ""
    except InvalidInputError as error:
        return tree, str(error)


def gallery_settings(study: Study) -> list[Condition]:
    """Return the settings of a gallery: every world with its largest team, then with smaller ones.

    They are as many as fit into a gallery with all strategies, in the order of the study.
    """
    most = max(1, MAX_TREES // max(1, len(study.strategies)))
    by_scene = [list(reversed(settings)) for settings in study.scenes().values()]
    longest = max(map(len, by_scene), default=0)
    in_turn = [own[turn] for turn in range(longest) for own in by_scene if turn < len(own)]
    chosen = in_turn[:most]
    return [setting for setting in study.settings if setting in chosen]


def median_run(results: list[Result]) -> Result | None:
    """Return the median run: by the main measure if any run is a success, else by coverage.

    Of an even number the lower of the two in the middle is taken; None if no run was measured.
    """
    for measure in (MEASURES[0], measure_named("coverage")):
        found = [
            (value, result.repetition, result)
            for result in results
            if measure.counts(result) and (value := measure.of(result)) is not None
        ]
        if found:
            return sorted(found, key=lambda entry: entry[:2])[(len(found) - 1) // 2][2]
    return None


def failures(study: Study, specs: Specs, out: Path = Path()) -> list[Failure]:
    """Group the distinct unsuccessful runs by strategy, status and area left uncovered.

    Numbers in the account of a run are ignored. The largest group comes first. Paths of files are
    relative to the folder `out`.
    """
    groups: dict[tuple[str, str, str], list[Result]] = defaultdict(list)
    for result in study.results:
        if result.failed and result.same_as is None:
            collided = result.metrics is not None and result.metrics.collisions > 0
            status = "collision" if collided else result.status
            pattern = re.sub(r"\d+(\.\d+)?", "#", result.account)
            groups[result.condition.strategy, status, pattern].append(result)
    found = []
    for number, ((label, ended, _), results) in enumerate(groups.items()):
        shown = number < MAX_FAILURES
        spec = specs.of(results[0]) if shown else None
        found.append(
            Failure(
                strategy=label,
                status=ended,
                reason=results[0].account,
                results=tuple(results),
                spec=spec,
                problem=specs.problem(results[0]) if shown and spec is None else "",
                imported="" if spec is None else imported(spec.strategy, out),
            )
        )
    return sorted(found, key=lambda failure: -len(failure.results))
