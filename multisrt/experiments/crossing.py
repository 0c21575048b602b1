"""From an experiment's description to its runs: every condition, crossed, with every repetition."""

from __future__ import annotations

import hashlib
import itertools
import math
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, TypeVar

import msgspec
import numpy as np

from multisrt.environments.catalog import names
from multisrt.environments.environment import Environment
from multisrt.experiments.description import (
    Block,
    BodyChoice,
    EnvironmentChoice,
    ExperimentSpec,
    FaultsChoice,
    MemberChoice,
    Only,
    RadioChoice,
    StartsChoice,
    StrategyChoice,
    TeamChoice,
)
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.robots.registry import Strategy, strategy
from multisrt.simulation.starts import drawn_start
from multisrt.simulation.worlds import build_environment, environment_spec, inline
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    EnvironmentSpec,
    Fault,
    FileEnvironment,
    InlineEnvironment,
    LateStart,
    RadioSpec,
    RobotSpec,
    RunSpec,
    Silence,
)

MOST_RUNS = 1_000_000
"""An experiment of more is taken for a mistake."""

WORLDS_KEPT = 512

OWN_BODIES = "its own"
"""Label of the bodies of a team whose robots differ."""

Choice = TypeVar("Choice")


class Condition(msgspec.Struct, frozen=True, kw_only=True, order=True):
    """What a run is one repetition of, by the labels that tables use.

    Attributes
    ----------
    environment, strategy : str
        Labels.
    robots : int
        How many.
    team : str
        Label of a team whose robots differ; empty for others.
    starts, radio, body, faults : str
        Labels.
    """

    environment: str
    strategy: str
    robots: int
    team: str = ""
    starts: str = "scattered"
    radio: str = "unlimited"
    body: str = "disc:0.25"
    faults: str = "none"

    def __str__(self) -> str:
        """Say it in a line."""
        size = self.team or f"{self.robots} robot{'s' * (self.robots != 1)}"
        what = (self.environment, self.strategy, size, self.starts, self.radio, self.body)
        return ", ".join((*what, *((f"faults: {self.faults}",) * (self.faults != "none"))))


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedRun:
    """A run that an experiment asks for.

    Attributes
    ----------
    key : str
        Digest of the spec.
    condition : Condition
        What it is a repetition of.
    repetition : int
        Which, from 0.
    spec : RunSpec
        What it depends on.
    """

    key: str
    condition: Condition
    repetition: int
    spec: RunSpec


@dataclass(frozen=True, slots=True)
class _Axes:
    """One choice of each kind, with its label."""

    environment: EnvironmentChoice
    strategy: StrategyChoice
    team: int | TeamChoice
    starts: StartsChoice
    radio: RadioChoice
    body: BodyChoice
    faults: FaultsChoice


def conditions(spec: ExperimentSpec) -> list[Condition]:
    """Give every condition of an experiment, in the order in which it names them.

    Raises
    ------
    InvalidInputError
        If nothing is left after exclusions, or a label stands for two things.
    """
    return [condition for condition, _ in _conditions(spec)]


def runs(spec: ExperimentSpec, folder: Path | None = None) -> list[PlannedRun]:
    """Give every run of an experiment, repetition by repetition.

    So that an experiment that is cut short has something of each condition.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.
    folder : path, optional
        What paths of environments are relative to; by default the working directory.

    Raises
    ------
    InvalidInputError
        If a run cannot be: the message says which condition, and why.
    """
    for kept in (_world, _held, _drawn):
        kept.cache_clear()  # files may have changed since
    crossed = _conditions(spec)
    planned: dict[str, PlannedRun] = {}
    for repetition in range(spec.repetitions):
        for condition, axes in crossed:
            try:
                run = _run_spec(spec, axes, spec.first_seed + repetition, folder)
                key = key_of(run)
            except InvalidInputError as error:
                raise InvalidInputError(f"{spec.name}: [{condition}]: {error}") from None
            if key in planned:
                raise InvalidInputError(
                    f"{spec.name}: repetition {repetition} of [{condition}] and repetition "
                    f"{planned[key].repetition} of [{planned[key].condition}] are the same run; "
                    "leave one of them out"
                )
            planned[key] = PlannedRun(key=key, condition=condition, repetition=repetition, spec=run)
    return list(planned.values())


def key_of(spec: RunSpec) -> str:
    """Digest of a spec: equal for equal specs, however they were written.

    An environment from a file counts as what the file holds, wherever it is.
    """
    canonical = spec.canonical()
    if isinstance(canonical.environment, FileEnvironment):
        held = _held(msgspec.json.encode(canonical.environment))
        canonical = msgspec.structs.replace(canonical, environment=held)
    return _digest(msgspec.json.encode(canonical))


@lru_cache(maxsize=WORLDS_KEPT)
def _held(world: bytes) -> InlineEnvironment:
    return inline(_world(world))


def _digest(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()[:32]


# Crossing -----------------------------------------------------------------------------------


def _conditions(spec: ExperimentSpec) -> list[tuple[Condition, _Axes]]:
    asked = [
        (_condition(axes), axes)
        for block in spec.blocks or (Block(),)
        for axes in _crossed(spec, block)
    ]
    if not asked:
        raise InvalidInputError(
            f"{spec.name}: there are no runs; name 'environments' and 'strategies'"
        )
    _check_exclusions(spec, [condition for condition, _ in asked])
    crossed: dict[Condition, _Axes] = {}
    for condition, axes in asked:
        if any(_is_meant(condition, only) for only in spec.exclude):
            continue
        if _unlabelled(crossed.setdefault(condition, axes)) != _unlabelled(axes):
            raise InvalidInputError(
                f"{spec.name}: two different conditions are both called [{condition}]; give "
                "what differs labels of its own ('label')"
            )
    if not crossed:
        raise InvalidInputError(
            f"{spec.name}: no runs are left: 'exclude' takes all {len(asked)} conditions; "
            "exclude fewer"
        )
    return list(crossed.items())


def _unlabelled(axes: _Axes) -> tuple[object, ...]:
    # What a condition is, whatever it is called.
    parts = [getattr(axes, field.name) for field in fields(axes)]
    return tuple(
        part if isinstance(part, int) else msgspec.structs.replace(part, label="") for part in parts
    )


def _crossed(spec: ExperimentSpec, block: Block) -> Iterator[_Axes]:
    def of(name: str) -> Sequence[object]:
        own: Sequence[object] | None = getattr(block, name)
        return getattr(spec, name) if own is None else own

    environments = [
        one
        for given in of("environments")
        for one in _by_seed(
            EnvironmentChoice(name=given)
            if isinstance(given, str)
            else _as(EnvironmentChoice, given)
        )
    ]
    strategies = [
        StrategyChoice(name=g) if isinstance(g, str) else _as(StrategyChoice, g)
        for g in of("strategies")
    ]
    starts = [
        StartsChoice(how=_how(g)) if isinstance(g, str) else _as(StartsChoice, g)
        for g in of("starts")
    ]
    radios = [RadioChoice() if isinstance(g, str) else _as(RadioChoice, g) for g in of("radios")]
    bodies = [
        BodyChoice(footprint=g) if isinstance(g, str) else _as(BodyChoice, g) for g in of("bodies")
    ]
    faults = [
        FaultsChoice(label="none") if isinstance(g, str) else _as(FaultsChoice, g)
        for g in of("faults")
    ]
    teams = [g if isinstance(g, int) else _as(TeamChoice, g) for g in of("robots")]
    kinds: list[list[Any]] = [environments, strategies, [*teams], starts, radios, bodies, faults]
    if math.prod(map(len, kinds)) * spec.repetitions > MOST_RUNS:
        counts = " x ".join(str(len(kind)) for kind in kinds)
        raise InvalidInputError(
            f"{spec.name}: {counts} conditions of {spec.repetitions} repetitions are more than "
            f"{MOST_RUNS} runs; take fewer"
        )
    for axes in itertools.product(*kinds):
        made = _Axes(*axes)
        if isinstance(made.team, TeamChoice):
            # It has bodies of its own.
            if made.body != bodies[0]:
                continue
            made = replace(made, body=BodyChoice(label=OWN_BODIES))
        yield made


def _as(kind: type[Choice], given: object) -> Choice:
    assert isinstance(given, kind)
    return given


def _how(text: str) -> Literal["scattered", "clustered"]:
    return "clustered" if text == "clustered" else "scattered"


def _by_seed(choice: EnvironmentChoice) -> Iterator[EnvironmentChoice]:
    # One environment for each of the seeds that a choice gives.
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
            f"{choice.seeds!r}"
        )
    first, last = int(span[1]), int(span[2])
    if last - first >= MOST_RUNS:
        raise InvalidInputError(
            f"environment {choice.name!r}: {last - first + 1} seeds are more than {MOST_RUNS} "
            "runs; take fewer"
        )
    return range(first, last + 1)


def _condition(axes: _Axes) -> Condition:
    team = axes.team
    return Condition(
        environment=_environment_label(axes.environment),
        strategy=axes.strategy.label or axes.strategy.name,
        robots=team if isinstance(team, int) else len(team.members),
        team="" if isinstance(team, int) else team.label,
        starts=_starts_label(axes.starts),
        radio=_radio_label(axes.radio),
        body=axes.body.label or axes.body.footprint,
        faults=axes.faults.label,
    )


def _environment_label(choice: EnvironmentChoice) -> str:
    if choice.label is not None:
        return choice.label
    return Path(choice.name).stem if choice.wkt is None and _is_file(choice) else choice.name


def _starts_label(choice: StartsChoice) -> str:
    if choice.label is not None:
        return choice.label
    if choice.places:
        return "given"
    return choice.how + (", drawn" if choice.first == "drawn" else "")


def _radio_label(choice: RadioChoice) -> str:
    if choice.label is not None:
        return choice.label
    return "unlimited" if choice.range_m is None else f"{choice.range_m:g} m"


# Exclusions ---------------------------------------------------------------------------------


def _is_meant(condition: Condition, only: Only) -> bool:
    for name in only.__struct_fields__:
        given = getattr(only, name)
        wanted = given if isinstance(given, tuple) else (given,)
        own = (
            (condition.robots, condition.team) if name == "robots" else (getattr(condition, name),)
        )
        if wanted and not any(value in wanted for value in own if value != ""):
            return False
    return True


def _check_exclusions(spec: ExperimentSpec, everything: list[Condition]) -> None:
    # An exclusion that meets nothing is a slip of the pen.
    for number, only in enumerate(spec.exclude, start=1):
        if only == Only():
            raise InvalidInputError(
                f"{spec.name}: exclusion {number} says nothing; leave it out, or name labels"
            )
        if not any(_is_meant(condition, only) for condition in everything):
            raise InvalidInputError(
                f"{spec.name}: exclusion {number} meets no condition{_stranger(only, everything)}; "
                f"labels are those of tables, as in [{everything[0]}]"
            )


def _stranger(only: Only, everything: list[Condition]) -> str:
    # The first label that no condition has.
    for name in only.__struct_fields__:
        given = getattr(only, name)
        known: dict[object, None] = {}
        for condition in everything:
            known[getattr(condition, name)] = None
            if name == "robots" and condition.team:
                known[condition.team] = None
        for label in given if isinstance(given, tuple) else (given,):
            if label not in known:
                return f": there is no {name} {label!r}{did_you_mean(label, known)}"
    return ""


# A run --------------------------------------------------------------------------------------


def _run_spec(spec: ExperimentSpec, axes: _Axes, seed: int, folder: Path | None) -> RunSpec:
    world = _environment(axes.environment, seed, folder)
    robots = _team(spec, axes)
    how = axes.starts
    if how.places or how.first == "drawn":
        for number, robot in enumerate(robots):
            if robot.start is not None and (how.places or number == 0):
                raise InvalidInputError(
                    f"starts {_starts_label(how)!r} and the team both say where robot {number} "
                    "starts; leave one of them out"
                )
    if how.places:
        if how.first == "drawn":
            raise InvalidInputError("starts are given ('places') or 'drawn', not both")
        if len(how.places) < len(robots):
            raise InvalidInputError(
                f"{len(how.places)} starts are given for a team of {len(robots)}; give more, or "
                "exclude this condition"
            )
        robots = tuple(
            msgspec.structs.replace(robot, start=place)
            for robot, place in zip(robots, how.places, strict=False)
        )
    elif how.first == "drawn":
        first = _drawn(msgspec.json.encode(world), robots[0].footprint, seed)
        robots = (msgspec.structs.replace(robots[0], start=first), *robots[1:])
    chosen = strategy(axes.strategy.name)
    _check_options(chosen, msgspec.json.encode(axes.strategy.options))
    run = RunSpec(
        environment=world,
        strategy=chosen.name,
        options=axes.strategy.options,
        robots=robots,
        starts=how.how,
        radio=RadioSpec(
            **{name: getattr(axes.radio, name) for name in RadioSpec.__struct_fields__}
        ),
        faults=_faults(axes.faults, len(robots), seed),
        stop=spec.stop,
        seed=seed,
    )
    chosen.require_fit(run)
    return run


@lru_cache(maxsize=256)
def _check_options(chosen: Strategy, options: bytes) -> None:
    chosen.parse_options(msgspec.json.decode(options))


def _environment(choice: EnvironmentChoice, seed: int, folder: Path | None) -> EnvironmentSpec:
    if choice.wkt is not None:
        _require_only_text(choice)
        written = InlineEnvironment(name=choice.name, wkt=choice.wkt, starts=choice.starts)
        _world(msgspec.json.encode(written))
        return written
    if choice.starts:
        raise InvalidInputError(
            f"environment {choice.name!r}: 'starts' are for a world given as 'wkt'; to say where "
            "teams start, give the experiment's 'starts' places"
        )
    path = choice.name if folder is None else str(folder / choice.name)
    found = environment_spec(
        path if _is_file(choice, folder) else choice.name,
        resolution_m=choice.resolution_m,
        threshold=choice.threshold,
    )
    if isinstance(found, CatalogEnvironment):
        own = seed if choice.seed == "repetition" else choice.seed
        # Parameters that are wrong are wrong for every seed.
        checked = None if own is None else 0
        plain = msgspec.structs.replace(found, parameters=choice.parameters, seed=checked)
        _world(msgspec.json.encode(plain))
        return msgspec.structs.replace(plain, seed=own)
    if choice.parameters or choice.seed is not None:
        raise InvalidInputError(
            f"environment {choice.name!r} is a file: parameters and seeds are for generators"
        )
    # Written out, so that a run and its recording are the same wherever the file is.
    return _held(msgspec.json.encode(found))


def _require_only_text(choice: EnvironmentChoice) -> None:
    plain = EnvironmentChoice(
        name=choice.name, label=choice.label, wkt=choice.wkt, starts=choice.starts
    )
    if choice != plain:
        raise InvalidInputError(
            f"environment {choice.name!r} is given as 'wkt': parameters and seeds are for "
            "generators, a resolution and a threshold for images"
        )


def _is_file(choice: EnvironmentChoice, folder: Path | None = None) -> bool:
    # A name of the catalogue means that; ./office is a file of that name.
    name = choice.name
    if name in names():
        return False
    separators = (os.sep, *(() if os.altsep is None else (os.altsep,)))
    if Path(name).suffix or any(separator in name for separator in separators):
        return True
    return folder is not None and (folder / name).exists()


def _team(spec: ExperimentSpec, axes: _Axes) -> tuple[RobotSpec, ...]:
    if isinstance(axes.team, TeamChoice):
        return tuple(_robot(spec, member, member.start) for member in axes.team.members)
    return (_robot(spec, axes.body),) * axes.team


def _robot(
    spec: ExperimentSpec, body: BodyChoice | MemberChoice, start: tuple[float, ...] | None = None
) -> RobotSpec:
    return RobotSpec(
        start=start,
        footprint=body.footprint,
        drive=spec.drive if body.drive is None else body.drive,
        range_finder=spec.range_finder if body.range_finder is None else body.range_finder,
    )


@lru_cache(maxsize=1024)
def _drawn(world: bytes, footprint: str, seed: int) -> tuple[float, float, float]:
    # To the millimetre, so that it can be told in a few digits.
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_DRAWN_STARTS,)))
    at = drawn_start(_world(world), Footprint.parse(footprint), rng)
    return round(at.x, 3), round(at.y, 3), round(at.heading, 3)


@lru_cache(maxsize=WORLDS_KEPT)
def _world(world: bytes) -> Environment:
    described: EnvironmentSpec = msgspec.json.decode(world, type=EnvironmentSpec)
    return build_environment(described)


_DRAWN_STARTS, _DRAWN_FAULTS = 10, 11
"""Streams of an experiment, apart from those of its runs."""


def _faults(choice: FaultsChoice, robots: int, seed: int) -> tuple[Fault, ...]:
    drawn = choice.deaths + choice.silences + choice.late_starts
    if not drawn:
        return choice.faults
    busy = {fault.robot for fault in choice.faults}
    free = [robot for robot in range(robots) if robot not in busy]
    if drawn >= len(free):
        raise InvalidInputError(
            f"faults {choice.label!r}: {drawn} robots with a fault of their own leave none "
            f"without in a team of {robots}; exclude this condition, or let fewer fail"
        )
    begin, end = choice.between_s
    if not 0.0 <= begin <= end < math.inf:
        raise InvalidInputError(
            f"faults {choice.label!r}: between_s is two times, the first not after the second, "
            f"not {list(choice.between_s)}"
        )
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_DRAWN_FAULTS,)))
    who = [free[k] for k in rng.permutation(len(free))[:drawn]]
    times = [round(float(t), 3) for t in rng.uniform(begin, end, drawn)]
    made: list[Fault] = []
    for number, (robot, time) in enumerate(zip(who, times, strict=True)):
        if number < choice.deaths:
            made.append(Death(robot=robot, time_s=time))
        elif number < choice.deaths + choice.silences:
            made.append(Silence(robot=robot, time_s=time, duration_s=choice.silence_s))
        else:
            made.append(LateStart(robot=robot, time_s=time))
    return (*choice.faults, *made)
