"""From an experiment to its conditions, and from these to its runs.

Choices of all kinds are crossed in each block of the experiment. The conditions that are not
excluded are identified by their labels, and each is repeated with every seed.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from multisrt.environments import suites
from multisrt.experiments.run_specs import (
    Choices,
    forget_worlds,
    is_file,
    run_spec,
    starts_label,
    written_out,
)
from multisrt.experiments.spec import (
    Block,
    BodyChoice,
    EnvironmentChoice,
    ExperimentSpec,
    FaultsChoice,
    Only,
    RadioChoice,
    StartsChoice,
    StrategyChoice,
    TeamChoice,
)
from multisrt.geometry.errors import MAX_REASON, InvalidInputError, did_you_mean, shortened, shown
from multisrt.spec import FileEnvironment, RobotSpec, RunSpec

MAX_RUNS = 1_000_000
"""Upper bound of the runs of an experiment; more are assumed to be a mistake."""

OWN_BODIES = "its own"
"""Label of the bodies of a team whose robots differ."""

Choice = TypeVar("Choice")


class Condition(msgspec.Struct, frozen=True, kw_only=True, order=True):
    """A condition of an experiment, by the labels of its choices.

    Attributes
    ----------
    environment, strategy : str
        Labels.
    robots : int
        Number of robots.
    team : str
        Label of a team whose robots differ; empty for a team of equal robots.
    starts, radio, body, faults : str
        Labels.

    Examples
    --------
    >>> print(Condition(environment="office", strategy="srt-star", robots=2))
    office, srt-star, 2 robots, scattered, unlimited, disc:0.25
    """

    environment: str
    strategy: str
    robots: int
    team: str = ""
    starts: str = "scattered"
    radio: str = "unlimited"
    body: str = RobotSpec().footprint
    faults: str = "none"

    def __str__(self) -> str:
        """Return the labels, separated by commas."""
        size = self.team or f"{self.robots} robot{'s' * (self.robots != 1)}"
        what = (self.environment, self.strategy, size, self.starts, self.radio, self.body)
        return ", ".join((*what, *((f"faults: {self.faults}",) * (self.faults != "none"))))


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedRun:
    """One run of an experiment.

    Attributes
    ----------
    key : str
        Digest of the spec; see `key_of`.
    condition : Condition
        The condition that it repeats.
    repetition : int
        Number of the repetition, from 0.
    spec : RunSpec
        The spec of the run.
    """

    key: str
    condition: Condition
    repetition: int
    spec: RunSpec


def conditions(spec: ExperimentSpec) -> list[Condition]:
    """Return the conditions of an experiment, in the order of its choices.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.

    Returns
    -------
    list of Condition
        The conditions that are not excluded.

    Raises
    ------
    InvalidInputError
        If all conditions are excluded, or two different ones have the same labels.

    Examples
    --------
    >>> from multisrt.experiments.spec import ExperimentSpec
    >>> spec = ExperimentSpec(
    ...     name="x", environments=("open", "maze"), strategies=("srt-star",), robots=(1, 2)
    ... )
    >>> [(one.environment, one.robots) for one in conditions(spec)]
    [('open', 1), ('open', 2), ('maze', 1), ('maze', 2)]
    """
    return [condition for condition, _ in _conditions(spec)]


def runs(
    spec: ExperimentSpec,
    folder: Path | None = None,
    *,
    impossible: dict[Condition, str] | None = None,
) -> list[PlannedRun]:
    """Return the runs of an experiment.

    Repetition 0 of all conditions comes first, then repetition 1 and so on: an experiment that is
    cut short has results of each condition.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.
    folder : Path, optional
        Folder that relative paths of environments refer to; by default the working directory.
    impossible : dict, optional
        Gets why runs of a condition are impossible, which are left out then; by default they
        are an error.

    Returns
    -------
    list of PlannedRun
        The runs, each with a key of its own.

    Raises
    ------
    InvalidInputError
        If a run is impossible; the message names the condition.

    Examples
    --------
    >>> from multisrt.experiments.spec import ExperimentSpec
    >>> spec = ExperimentSpec(
    ...     name="x", environments=("open",), strategies=("srt-star", "minpos"), repetitions=2
    ... )
    >>> [(run.condition.strategy, run.spec.seed) for run in runs(spec)]
    [('srt-star', 0), ('minpos', 0), ('srt-star', 1), ('minpos', 1)]
    """
    forget_worlds()
    crossed = _conditions(spec)
    planned: dict[str, PlannedRun] = {}
    for repetition in range(spec.repetitions):
        for condition, choices in crossed:
            try:
                run = run_spec(spec, choices, spec.first_seed + repetition, folder)
                key = key_of(run)
            except InvalidInputError as error:
                if impossible is None:
                    raise InvalidInputError(f"{spec.name}: {_cited(condition)}: {error}") from None
                impossible[condition] = str(error)
                continue
            if key in planned:
                other = planned[key].condition
                raise InvalidInputError(
                    f"{spec.name}: repetition {repetition} of {_cited(condition)} and repetition "
                    f"{planned[key].repetition} of {_cited(other)} are the same run; "
                    "leave one of them out"
                )
            planned[key] = PlannedRun(key=key, condition=condition, repetition=repetition, spec=run)
    return list(planned.values())


def key_of(spec: RunSpec) -> str:
    """Return the digest of a spec, by which results are stored.

    Parameters
    ----------
    spec : RunSpec
        The spec of a run.

    Returns
    -------
    str
        32 hexadecimal digits, equal for equal specs however they were written. An environment
        from a file counts by the file's content, not its path.

    Raises
    ------
    InvalidInputError
        If the environment is a file that cannot be read.
    """
    canonical = spec.canonical()
    if isinstance(canonical.environment, FileEnvironment):
        inline = written_out(canonical.environment)
        canonical = msgspec.structs.replace(canonical, environment=inline)
    return hashlib.sha256(msgspec.json.encode(canonical)).hexdigest()[:32]


# Crossing ------------------------------------------------------------------------------------


def _conditions(spec: ExperimentSpec) -> list[tuple[Condition, Choices]]:
    crossings = [
        choices for block in spec.blocks or (Block(),) for choices in _crossed(spec, block)
    ]
    told_apart = _with_other_options(crossings)
    asked = [(_condition(choices, told_apart), choices) for choices in crossings]
    if not asked:
        raise InvalidInputError(
            f"{spec.name}: there are no runs; name 'environments' and 'strategies'"
        )
    _check_exclusions(spec, [condition for condition, _ in asked])
    crossed: dict[Condition, Choices] = {}
    for condition, choices in asked:
        if any(_matches(condition, only) for only in spec.exclude):
            continue
        if _unlabelled(crossed.setdefault(condition, choices)) != _unlabelled(choices):
            raise InvalidInputError(
                f"{spec.name}: two different conditions are both called {_cited(condition)}; give "
                "them labels of their own ('label')"
            )
    if not crossed:
        raise InvalidInputError(
            f"{spec.name}: no runs are left: 'exclude' matches all {len(asked)} conditions; "
            "exclude fewer"
        )
    return list(crossed.items())


def _with_other_options(crossings: Sequence[Choices]) -> set[str]:
    """Return the names of strategies that are chosen without a label, but with several options."""
    options: dict[str, list[Mapping[str, object]]] = {}
    for choice in (choices.strategy for choices in crossings):
        known = options.setdefault(choice.name, [])
        if choice.label is None and choice.options not in known:
            known.append(choice.options)
    return {name for name, known in options.items() if len(known) > 1}


def _unlabelled(choices: Choices) -> tuple[object, ...]:
    """Return the choices without their labels, to compare what they stand for."""
    parts = [getattr(choices, field.name) for field in fields(choices)]
    return tuple(
        part if isinstance(part, int) else msgspec.structs.replace(part, label="") for part in parts
    )


def _crossed(spec: ExperimentSpec, block: Block) -> Iterator[Choices]:
    def of(name: str) -> Sequence[object]:
        own: Sequence[object] | None = getattr(block, name)
        return getattr(spec, name) if own is None else own

    environments = [
        seeded
        for choice in _choices(of("environments"), EnvironmentChoice, "name")
        for one in _by_world(choice)
        for seeded in _by_seed(one)
    ]
    strategies = _choices(of("strategies"), StrategyChoice, "name")
    starts = _choices(of("starts"), StartsChoice, "how")
    radios = [RadioChoice() if isinstance(g, str) else _as(RadioChoice, g) for g in of("radios")]
    bodies = _choices(of("bodies"), BodyChoice, "footprint")
    faults = _choices(of("faults"), FaultsChoice, "label")
    teams = [g if isinstance(g, int) else _as(TeamChoice, g) for g in of("robots")]
    kinds: list[list[Any]] = [environments, strategies, [*teams], starts, radios, bodies, faults]
    if math.prod(map(len, kinds)) * spec.repetitions > MAX_RUNS:
        counts = " x ".join(str(len(kind)) for kind in kinds)
        raise InvalidInputError(
            f"{spec.name}: {counts} conditions of {spec.repetitions} repetitions are more than "
            f"{MAX_RUNS} runs; take fewer"
        )
    for choices in itertools.product(*kinds):
        made = Choices(*choices)
        if isinstance(made.team, TeamChoice):
            # The bodies of the experiment do not apply: the team is crossed with one only.
            if made.body != bodies[0]:
                continue
            made = replace(made, body=BodyChoice(label=OWN_BODIES))
        yield made


def _choices(given: Sequence[object], kind: type[Choice], field: str) -> list[Choice]:
    """Return choices of a kind; a text is a choice with this one field."""
    return [kind(**{field: one}) if isinstance(one, str) else _as(kind, one) for one in given]


def _as(kind: type[Choice], given: object) -> Choice:
    assert isinstance(given, kind)
    return given


def _by_world(choice: EnvironmentChoice) -> Iterator[EnvironmentChoice]:
    """Yield a choice for each of the worlds of a suite that an environment names."""
    if choice.wkt is not None or choice.name not in suites.names():
        yield choice
        return
    label = choice.label or choice.name
    for name in suites.load(choice.name).world_names:
        own = None if label == choice.name else name.replace(choice.name, label, 1)
        yield msgspec.structs.replace(choice, name=name, label=own)


def _by_seed(choice: EnvironmentChoice) -> Iterator[EnvironmentChoice]:
    """Yield a choice for each of the seeds that an environment is given with."""
    if not choice.seeds:
        yield choice
        return
    if choice.seed is not None:
        raise InvalidInputError(f"environment {choice.name!r}: give 'seed' or 'seeds', not both")
    for seed in _seeds(choice):
        label = f"{_environment_label(choice)} {seed}"
        yield msgspec.structs.replace(choice, label=label, seed=seed, seeds=())


def _seeds(choice: EnvironmentChoice) -> Sequence[int]:
    if not isinstance(choice.seeds, str):
        return choice.seeds
    span = re.fullmatch(r"\s*(\d{1,9})\s*-\s*(\d{1,9})\s*", choice.seeds)
    if span is None or int(span[1]) > int(span[2]):
        raise InvalidInputError(
            f'environment {choice.name!r}: seeds are numbers, or a range like "0-9", not '
            f"{shown(choice.seeds)}"
        )
    first, last = int(span[1]), int(span[2])
    if last - first >= MAX_RUNS:
        raise InvalidInputError(
            f"environment {choice.name!r}: {last - first + 1} seeds are more than {MAX_RUNS} "
            "runs; take fewer"
        )
    return range(first, last + 1)


def _condition(choices: Choices, told_apart: Container[str]) -> Condition:
    team, strategy = choices.team, choices.strategy
    return Condition(
        environment=_environment_label(choices.environment),
        strategy=strategy.told_apart if strategy.name in told_apart else strategy.shown,
        robots=team if isinstance(team, int) else len(team.members),
        team="" if isinstance(team, int) else team.label,
        starts=starts_label(choices.starts),
        radio=_radio_label(choices.radio),
        body=choices.body.label or choices.body.footprint,
        faults=choices.faults.label,
    )


def _environment_label(choice: EnvironmentChoice) -> str:
    if choice.label is not None:
        return choice.label
    return Path(choice.name).stem if choice.wkt is None and is_file(choice) else choice.name


def _radio_label(choice: RadioChoice) -> str:
    if choice.label is not None:
        return choice.label
    return "unlimited" if choice.range_m is None else f"{choice.range_m:g} m"


# Exclusions ----------------------------------------------------------------------------------


def _matches(condition: Condition, only: Only) -> bool:
    for name in only.__struct_fields__:
        given = getattr(only, name)
        wanted = given if isinstance(given, tuple) else (given,)
        own = (
            (condition.robots, condition.team) if name == "robots" else (getattr(condition, name),)
        )
        if wanted and not any(value in wanted for value in own if value != ""):
            return False
    return True


def _cited(condition: Condition) -> str:
    return f"[{shortened(str(condition), MAX_REASON)}]"


def _check_exclusions(spec: ExperimentSpec, everything: list[Condition]) -> None:
    """Raise InvalidInputError for an exclusion that no condition matches: it is a mistake."""
    for number, only in enumerate(spec.exclude, start=1):
        if only == Only():
            raise InvalidInputError(
                f"{spec.name}: exclusion {number} is empty; leave it out, or name labels"
            )
        if not any(_matches(condition, only) for condition in everything):
            hint = _unknown_label(only, everything)
            raise InvalidInputError(
                f"{spec.name}: exclusion {number} matches no condition{hint}; labels are those of "
                f"tables, as in {_cited(everything[0])}"
            )


def _unknown_label(only: Only, everything: list[Condition]) -> str:
    """Return a hint at the first label that no condition has."""
    for name in only.__struct_fields__:
        given = getattr(only, name)
        known: dict[object, None] = {}
        for condition in everything:
            known[getattr(condition, name)] = None
            if name == "robots" and condition.team:
                known[condition.team] = None
        for label in given if isinstance(given, tuple) else (given,):
            if label not in known:
                return f": there is no {name} {shown(label)}{did_you_mean(label, known)}"
    return ""
