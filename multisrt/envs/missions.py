"""Which mission comes next: the spec that all share, and the world and the seed that are drawn."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.random import Generator

from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.run import RunKeywords, run_fields
from multisrt.simulation.worlds import build_environment, environment_spec, inline
from multisrt.spec import CatalogEnvironment, RunSpec
from multisrt.spec.environments import EnvironmentSpec

MAX_BUILT = 64
"""Maximum number of built worlds that are kept; the oldest is dropped first."""

KEYWORDS = tuple(name for name in RunKeywords.__annotations__ if name != "strategy")
"""The keywords of `multisrt.explore` that describe a team and its mission."""

World = Environment | EnvironmentSpec | str | Path
"""A world, its spec, its name in the catalogue, or a map file."""

Worlds = World | RunSpec | Sequence[World]
"""One world or several; or the spec of a run."""


class Missions:
    """The missions of an environment for learning.

    Parameters
    ----------
    worlds : Environment, str, Path, RunSpec or a sequence of worlds
        The world, or those that are drawn from; or the spec of a run, whose strategy is replaced.
    strategy : str
        Name of the strategy in the specs of the missions.
    world_seeds : sequence of int or None
        The seeds that generated worlds are given, of which one is drawn for each mission. None:
        worlds are as they are named.
    keywords : mapping
        Keywords of `multisrt.explore` that describe the team and the run.

    Attributes
    ----------
    team : int
        Number of robots.
    seed : int or None
        The seed that was given, in the spec or as a keyword; None if there was none.
    template : RunSpec
        That spec.

    Raises
    ------
    InvalidInputError
        If these contradict each other or describe no mission.
    """

    def __init__(
        self,
        worlds: Worlds,
        strategy: str,
        world_seeds: Sequence[int] | None,
        keywords: Mapping[str, Any],
    ) -> None:
        given = {name: value for name, value in keywords.items() if value is not None}
        if "strategy" in given:
            raise InvalidInputError(
                "where robots go is decided by actions: leave out strategy, "
                f"which is {given['strategy']!r}"
            )
        for name in given:
            if name not in KEYWORDS:
                raise InvalidInputError(
                    f"an environment for learning takes no {name!r}"
                    f"{did_you_mean(name, KEYWORDS)}; missions are described by: "
                    f"{', '.join(KEYWORDS)}"
                )
        if isinstance(worlds, RunSpec):
            if given:
                raise InvalidInputError(
                    f"a RunSpec describes the run: with it, leave out {', '.join(given)}"
                )
            named: tuple[World, ...] = (worlds.environment,)
        else:
            one = isinstance(worlds, World)
            if not (one or isinstance(worlds, Iterable)):
                raise InvalidInputError(
                    f"a world is its name, a map file or a spec, not {worlds!r}"
                )
            named = (worlds,) if one else tuple(worlds)  # type: ignore[arg-type, assignment]
            if not named:
                raise InvalidInputError("a mission needs a world, and the sequence has none")
        self._worlds = tuple(map(_spec_of, named))
        template = (
            worlds
            if isinstance(worlds, RunSpec)
            else RunSpec(environment=self._worlds[0], **run_fields(given))
        )
        self.template = msgspec.structs.replace(template, strategy=strategy)
        self._world_seeds = None if world_seeds is None else _checked(world_seeds, self._worlds)
        self.team = len(template.robots)
        has_seed = isinstance(worlds, RunSpec) or "seed" in given
        self.seed = template.seed if has_seed else None
        self._built: dict[tuple[int, int | None], Environment] = {
            (number, None): world
            for number, world in enumerate(named)
            if isinstance(world, Environment)
        }

    @property
    def described(self) -> str:
        """The worlds and the team, in a few words."""
        first = self._worlds[0]
        named = [getattr(first, name, None) for name in ("name", "path")]
        world = next((str(name) for name in named if name), "a world")
        more = len(self._worlds) - 1
        worlds = f"{world!r} and {more} more" if more else repr(world)
        seed = "" if self.seed is None else f", seed={self.seed}"
        return f"{worlds}, robots={self.team}{seed}"

    def draw(self, seed: int, chance: Generator) -> tuple[RunSpec, Environment]:
        """Return the spec of a mission and its world.

        Parameters
        ----------
        seed : int
            Seed of the mission.
        chance : Generator
            Draws the world, if there are several.
        """
        number = int(chance.integers(len(self._worlds))) if len(self._worlds) > 1 else 0
        world_seed, world = None, self._worlds[number]
        if self._world_seeds is not None:
            world_seed = self._world_seeds[int(chance.integers(len(self._world_seeds)))]
            world = msgspec.structs.replace(world, seed=world_seed)
        key = number, world_seed
        if key not in self._built:
            self._built[key] = build_environment(world)
            if len(self._built) > MAX_BUILT:
                self._built.pop(next(iter(self._built)))
        spec = msgspec.structs.replace(self.template, environment=world, seed=seed)
        return spec, self._built[key]


def seed_of(given: object, what: str = "seed") -> int:
    """Return a seed as a builtin number.

    Parameters
    ----------
    given : object
        The seed.
    what : str
        What it is called, for the message.

    Raises
    ------
    InvalidInputError
        If it is no whole number from 0.
    """
    if not isinstance(given, int | np.integer) or given < 0:
        raise InvalidInputError(f"{what} is a whole number from 0, not {given!r}")
    return int(given)


def _spec_of(world: World) -> EnvironmentSpec:
    if not isinstance(world, World):
        raise InvalidInputError(f"a world is its name, a map file or a spec, not {world!r}")
    if isinstance(world, EnvironmentSpec):
        return world
    if isinstance(world, Environment):
        return inline(world)
    return environment_spec(str(world))


def _checked(world_seeds: Sequence[int], worlds: Sequence[EnvironmentSpec]) -> tuple[int, ...]:
    if not isinstance(world_seeds, Iterable):
        raise InvalidInputError(f"world_seeds is a sequence of seeds, not {world_seeds!r}")
    seeds = tuple(seed_of(seed, "a seed of world_seeds") for seed in world_seeds)
    if not seeds:
        raise InvalidInputError("world_seeds has no seed; give at least one, or leave it out")
    for world in worlds:
        # Refuses bundled maps and files, which are as they are.
        if not isinstance(world, CatalogEnvironment):
            raise InvalidInputError(
                f"world_seeds are for generators of the catalogue, and {world} is none"
            )
        build_environment(msgspec.structs.replace(world, seed=seeds[0]))
    return seeds
