"""The spec of a run: one choice of each kind and the seed of a repetition, put together.

The first start and the faults that an experiment draws come from streams of its own, which depend
on the repetition's seed alone: they are the same for all strategies.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import msgspec
import numpy as np

from multisrt.environments import suites
from multisrt.environments.catalog import names
from multisrt.environments.environment import Environment
from multisrt.experiments.spec import (
    BodyChoice,
    EnvironmentChoice,
    ExperimentSpec,
    FaultsChoice,
    MemberChoice,
    RadioChoice,
    StartsChoice,
    StrategyChoice,
    TeamChoice,
)
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.registry import strategy
from multisrt.robots.strategy import Strategy
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
    SuiteEnvironment,
)
from multisrt.validation_errors import explained

MAX_WORLDS_KEPT = 512
"""Environments that are kept built while an experiment's runs are planned."""

DRAWN_STARTS, DRAWN_FAULTS = 10, 11
"""Streams of an experiment's draws, distinct from those of its runs (`random_streams.STREAMS`)."""


@dataclass(frozen=True, slots=True)
class Choices:
    """One choice of each kind, from which the runs of a condition are made."""

    environment: EnvironmentChoice
    strategy: StrategyChoice
    team: int | TeamChoice
    starts: StartsChoice
    radio: RadioChoice
    body: BodyChoice
    faults: FaultsChoice


def run_spec(
    spec: ExperimentSpec, choices: Choices, seed: int, folder: Path | None = None
) -> RunSpec:
    """Return the spec of one run of an experiment.

    Parameters
    ----------
    spec : ExperimentSpec
        The experiment.
    choices : Choices
        What is run.
    seed : int
        Seed of the repetition.
    folder : Path, optional
        Folder that relative paths of environments refer to; by default the working directory.

    Returns
    -------
    RunSpec
        The spec. An environment from a file is written out in it, so that the run and its
        recording are the same wherever the file is.

    Raises
    ------
    InvalidInputError
        If such a run is impossible.
    """
    world = _environment(choices.environment, seed, folder)
    chosen = strategy(choices.strategy.name)
    if chosen.sees_truth:
        raise InvalidInputError(
            f"{chosen.name} knows the map: it does not compete with strategies that explore; "
            'remove it, and ask for it as the reference: reference = "informed"'
        )
    _check_options(chosen, msgspec.json.encode(choices.strategy.options))
    robots = _placed(choices.starts, _team(spec, choices), world, seed)
    run = RunSpec(
        environment=world,
        strategy=chosen.name,
        options=choices.strategy.options,
        robots=robots,
        starts=choices.starts.how,
        radio=RadioSpec(
            **{name: getattr(choices.radio, name) for name in RadioSpec.__struct_fields__}
        ),
        base=spec.base,
        faults=_faults(choices.faults, len(robots), seed),
        stop=spec.stop,
        seed=seed,
    )
    chosen.require_fit(run)
    return run


def forget_worlds() -> None:
    """Forget the environments that were built: files may have changed since."""
    for kept in (_world, _written_out, _drawn):
        kept.cache_clear()


def written_out(environment: FileEnvironment) -> InlineEnvironment:
    """Return an environment from a file as an inline one.

    Parameters
    ----------
    environment : FileEnvironment
        The file.

    Returns
    -------
    InlineEnvironment
        The environment that the file holds.

    Raises
    ------
    InvalidInputError
        If the file cannot be read or holds no environment.
    """
    return _written_out(msgspec.json.encode(environment))


def is_file(choice: EnvironmentChoice, folder: Path | None = None) -> bool:
    """Whether an environment is a file, not a name of the catalogue or of a suite.

    Parameters
    ----------
    choice : EnvironmentChoice
        The choice. A name of the catalogue means that environment; ``./office`` is a file of the
        same name.
    folder : Path, optional
        Folder in which a name without suffix is looked for.

    Returns
    -------
    bool
        Whether the name is a path.
    """
    name = choice.name
    if name in names() or name in suites.names() or suites.is_world(name):
        return False
    separators = (os.sep, *(() if os.altsep is None else (os.altsep,)))
    if Path(name).suffix or any(separator in name for separator in separators):
        return True
    return folder is not None and os.path.exists(folder / name)  # False of names too long


def starts_label(choice: StartsChoice) -> str:
    """Return the label of a choice of starts, made from its fields if it has none."""
    if choice.label is not None:
        return choice.label
    if choice.places:
        return "given"
    return choice.how + (", drawn" if choice.first == "drawn" else "")


@lru_cache(maxsize=256)
def _check_options(chosen: Strategy, options: bytes) -> None:
    chosen.parse_options(msgspec.json.decode(options))


# Environments --------------------------------------------------------------------------------


def _environment(choice: EnvironmentChoice, seed: int, folder: Path | None) -> EnvironmentSpec:
    if choice.wkt is not None:
        _require_only_text(choice)
        written = InlineEnvironment(name=choice.name, wkt=choice.wkt, starts=choice.starts)
        _world(msgspec.json.encode(written))
        return written
    if choice.starts:
        raise InvalidInputError(
            f"environment {choice.name!r}: 'starts' are for an environment given as 'wkt'; to say "
            "where teams start, give the experiment's 'starts' places"
        )
    path, team = choice.name, choice.starts_from
    if folder is not None:
        path, team = str(folder / path), None if team is None else str(folder / team)
    found = environment_spec(
        path if is_file(choice, folder) else choice.name,
        resolution_m=choice.resolution_m,
        threshold=choice.threshold,
        starts_from=team,
    )
    if isinstance(found, CatalogEnvironment):
        own = seed if choice.seed == "repetition" else choice.seed
        # Parameters are checked with one seed: wrong ones are wrong with every seed.
        checked = None if own is None else 0
        plain = msgspec.structs.replace(found, parameters=choice.parameters, seed=checked)
        _world(msgspec.json.encode(plain))
        return msgspec.structs.replace(plain, seed=own)
    if choice.parameters or choice.seed is not None:
        kind = "a file" if isinstance(found, FileEnvironment) else "of a suite"
        raise InvalidInputError(
            f"environment {choice.name!r} is {kind}: parameters and seeds are for generators"
        )
    if isinstance(found, SuiteEnvironment):
        _world(msgspec.json.encode(found))
        return found
    return written_out(found)


def _require_only_text(choice: EnvironmentChoice) -> None:
    plain = EnvironmentChoice(
        name=choice.name, label=choice.label, wkt=choice.wkt, starts=choice.starts
    )
    if choice != plain:
        raise InvalidInputError(
            f"environment {choice.name!r} is given as 'wkt': parameters and seeds are for "
            "generators, a resolution, a threshold and a team file for images"
        )


@lru_cache(maxsize=MAX_WORLDS_KEPT)
def _world(environment: bytes) -> Environment:
    try:
        described: EnvironmentSpec = msgspec.json.decode(environment, type=EnvironmentSpec)
    except msgspec.ValidationError as error:  # JSON has no infinite numbers
        place = explained(error, EnvironmentSpec).partition(":")[0]
        raise InvalidInputError(f"{place} of the environment is no finite number") from None
    return build_environment(described)


@lru_cache(maxsize=MAX_WORLDS_KEPT)
def _written_out(environment: bytes) -> InlineEnvironment:
    return inline(_world(environment))


# Teams and starts ----------------------------------------------------------------------------


def _team(spec: ExperimentSpec, choices: Choices) -> tuple[RobotSpec, ...]:
    if isinstance(choices.team, TeamChoice):
        return tuple(_robot(spec, member, member.start) for member in choices.team.members)
    return (_robot(spec, choices.body),) * choices.team


def _robot(
    spec: ExperimentSpec, body: BodyChoice | MemberChoice, start: tuple[float, ...] | None = None
) -> RobotSpec:
    return RobotSpec(
        start=start,
        footprint=body.footprint,
        drive=spec.drive if body.drive is None else body.drive,
        range_finder=spec.range_finder if body.range_finder is None else body.range_finder,
    )


def _placed(
    starts: StartsChoice, robots: tuple[RobotSpec, ...], world: EnvironmentSpec, seed: int
) -> tuple[RobotSpec, ...]:
    """Return the robots with the starts that the experiment gives or draws."""
    drawn = starts.first == "drawn"
    if starts.places and drawn:
        raise InvalidInputError("starts are given ('places') or 'drawn', not both")
    if starts.how == "base" and (starts.places or drawn):
        raise InvalidInputError(
            "starts of how = 'base' have neither 'places' nor first = 'drawn': leave them out"
        )
    for number, robot in enumerate(robots):
        if robot.start is not None and (starts.places or (drawn and number == 0)):
            raise InvalidInputError(
                f"starts {starts_label(starts)!r} and the team both say where robot {number} "
                "starts; leave one of them out"
            )
    if starts.places:
        if len(starts.places) < len(robots):
            raise InvalidInputError(
                f"{len(starts.places)} starts are given for a team of {len(robots)}; give more, "
                "or exclude this condition"
            )
        return tuple(
            msgspec.structs.replace(robot, start=place)
            for robot, place in zip(robots, starts.places, strict=False)
        )
    if drawn:
        first = _drawn(msgspec.json.encode(world), robots[0].footprint, seed)
        return (msgspec.structs.replace(robots[0], start=first), *robots[1:])
    return robots


@lru_cache(maxsize=1024)
def _drawn(world: bytes, footprint: str, seed: int) -> tuple[float, float, float]:
    # Rounded to a millimetre, so that it is written in a few digits.
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(DRAWN_STARTS,)))
    at = drawn_start(_world(world), Footprint.parse(footprint), rng)
    return round(at.x, 3), round(at.y, 3), round(at.heading, 3)


# Faults --------------------------------------------------------------------------------------


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
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(DRAWN_FAULTS,)))
    chosen = [free[k] for k in rng.permutation(len(free))[:drawn]]
    times = [round(float(t), 3) for t in rng.uniform(begin, end, drawn)]
    made: list[Fault] = []
    for number, (robot, time) in enumerate(zip(chosen, times, strict=True)):
        if number < choice.deaths:
            made.append(Death(robot=robot, time_s=time))
        elif number < choice.deaths + choice.silences:
            made.append(Silence(robot=robot, time_s=time, duration_s=choice.silence_s))
        else:
            made.append(LateStart(robot=robot, time_s=time))
    return (*choice.faults, *made)
