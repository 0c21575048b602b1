"""Worlds by name: every generator and every bundled map.

Importing this module builds no world and imports no geometry.
"""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from multisrt.environments.generators.difficulty import KNOB, RANGES, parameters_at
from multisrt.geometry.errors import InvalidInputError, did_you_mean, shown

if TYPE_CHECKING:
    from multisrt.environments.environment import Environment

MAPS = Path(__file__).parent / "maps"
"""Folder of the bundled maps."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CatalogEntry:
    """A world of the catalog.

    Attributes
    ----------
    name : str
        Name by which `environment` returns it.
    kind : {"generator", "map"}
        Whether the world is generated from parameters and a seed, or read from a bundled file.
    summary : str
        Description in one line.
    parameters : tuple of (str, float)
        Names and defaults of a generator's parameters besides the seed; empty for maps.
    width_m, height_m : float
        Extent of free space in metres, for a generator with its defaults and seed 0.
    area_m2 : float
        Area of free space in square metres, likewise.
    """

    name: str
    kind: Literal["generator", "map"]
    summary: str
    parameters: tuple[tuple[str, float], ...]
    width_m: float
    height_m: float
    area_m2: float


_GENERATORS: dict[str, tuple[str, str]] = {
    "garden": ("garden:garden", "formal garden: beds, hedges and trees, paths around all of them"),
    "clutter": ("clutter:clutter", "field cluttered with obstacles of many shapes"),
    "rooms": ("rooms:rooms", "grid of large rooms with doors between them"),
    "office": ("office:office", "office floor: corridors, rooms with doors, desks"),
    "maze": ("maze:maze", "maze, perfect or with loops"),
    "hospital": (
        "hospital:hospital",
        "hospital: entrance hall, long wings of wards, nurse stations",
    ),
    "open": ("open:open_hall", "empty hall, with a few columns if wanted"),
    "warehouse": ("warehouse:warehouse", "warehouse: shelves, aisles, a loading zone"),
    "city": ("city:city", "streets and squares, buildings of many shapes"),
    "forest": ("forest:forest", "forest of trunks of varied thickness"),
    "cavern": ("cavern:cavern", "cavern of chambers, pillars and narrow tunnels"),
    "dungeon": ("dungeon:dungeon", "rooms, winding corridors, loops and dead ends"),
}
"""Module, function and summary of every generator, by name."""

_MAPS: dict[str, tuple[str, str]] = {
    "museum": ("museum.geojson", "galleries around a rotunda, with alcoves and columns"),
    "apartment": ("apartment.geojson", "large furnished apartment"),
    "workshop": ("workshop.yaml", "workshop with slanted walls and round columns (occupancy grid)"),
    "library": ("library.wkt", "library: rows of shelves, a reading room, study cells"),
    "clinic": ("clinic.geojson", "clinic of two wings at an angle, a waiting room where they meet"),
    "cave": ("cave.geojson", "cave with pillars, no straight wall in it"),
}
"""File and summary of every bundled map, by name."""

_GENERATED_LIKE = {"cave": ", or take the generator 'cavern'"}
"""Hint at the generator for which a bundled map may be mistaken, by the name of the map."""


def names() -> tuple[str, ...]:
    """Return the names of all worlds, generators first."""
    return (*_GENERATORS, *_MAPS)


def summaries() -> dict[str, str]:
    """Return a description in one line of every world, by name.

    Examples
    --------
    >>> summaries()["cave"]
    'cave with pillars, no straight wall in it'
    """
    return {name: summary for name, (_, summary) in (_GENERATORS | _MAPS).items()}


def environment(name: str, /, *, seed: int | None = None, **parameters: float) -> "Environment":
    """Return a world of the catalog.

    Parameters
    ----------
    name : str
        Name of a generator or a bundled map, one of `names`.
    seed : int, optional
        Seed of a generator, 0 by default. Bundled maps take none.
    **parameters : float
        Parameters of the generator; the entries of `catalog` list them. All generators except
        "open" also take a `difficulty` from 0 to 1. For generators that do not list it, it sets
        some of the listed parameters; those that are given explicitly take precedence.

    Returns
    -------
    Environment
        The world. Equal arguments give equal worlds.

    Raises
    ------
    InvalidInputError
        If there is no world of that name, a parameter is unknown, or its value is out of range.

    Examples
    --------
    >>> environment("open", size_m=12).area_m2
    144.0
    >>> environment("museum").name
    'museum'
    >>> environment("maze", difficulty=0.5).origin
    'maze(size_m=24, cells=12, loops=0.3, seed=0)'
    """
    if name in _MAPS:
        if seed is not None or parameters:
            given = [*([] if seed is None else ["seed"]), *parameters]
            raise InvalidInputError(
                f"the bundled map {name!r} is fixed: it takes neither seed nor parameters; "
                f"leave out {', '.join(given)}{_GENERATED_LIKE.get(name, '')}"
            )
        return _read(name)
    if name not in _GENERATORS:
        raise InvalidInputError(_unknown(name))
    accepted = default_parameters(name)
    if KNOB in parameters and KNOB not in dict(accepted) and name in RANGES:
        others = {given: value for given, value in parameters.items() if given != KNOB}
        parameters = parameters_at(name, parameters[KNOB]) | others
    unknown = [parameter for parameter in parameters if parameter not in dict(accepted)]
    if unknown:
        listed = ", ".join(f"{parameter}={as_text(value)}" for parameter, value in accepted)
        raise InvalidInputError(
            f"{name} has no parameter {shown(unknown[0])}; it takes seed and, with these defaults, "
            f"{listed}"
        )
    return _generator(name)(**parameters, seed=0 if seed is None else seed)


def default_parameters(name: str) -> tuple[tuple[str, float], ...]:
    """Return the parameters of a world, without building it.

    Parameters
    ----------
    name : str
        One of `names`.

    Returns
    -------
    tuple of (str, float)
        Names and defaults of a generator's parameters besides the seed; empty for maps.

    Examples
    --------
    >>> default_parameters("dungeon")
    (('size_m', 40.0), ('difficulty', 0.5), ('passage_m', 1.4))
    """
    if name not in _GENERATORS:
        return ()
    signature = inspect.signature(_generator(name))
    return tuple(
        (parameter.name, parameter.default)
        for parameter in signature.parameters.values()
        if parameter.name != "seed"
    )


def generator_reference(name: str) -> str:
    """Return the module and function of a generator as ``MODULE:FUNCTION``; empty for other names.

    Examples
    --------
    >>> generator_reference("open"), generator_reference("museum")
    ('multisrt.environments.generators.open:open_hall', '')
    """
    if name not in _GENERATORS:
        return ""
    return f"multisrt.environments.generators.{_GENERATORS[name][0]}"


@cache
def catalog() -> tuple[CatalogEntry, ...]:
    """Return the descriptions of all worlds, in the order of `names`.

    The first call builds all worlds, to measure them.

    Returns
    -------
    tuple of CatalogEntry
        One entry per world.

    Examples
    --------
    >>> [entry.name for entry in catalog() if entry.kind == "map"][:3]
    ['museum', 'apartment', 'workshop']
    """
    return tuple(_entry(name) for name in names())


def as_text(value: float) -> str:
    """Return the value of a parameter as it is written in TOML and on the command line.

    Examples
    --------
    >>> as_text(34.0), as_text(True)
    ('34', 'true')
    """
    return str(value).lower() if isinstance(value, bool) else f"{value:g}"


def _entry(name: str) -> CatalogEntry:
    world = environment(name)
    x0, y0, x1, y1 = world.bounds
    generated = name in _GENERATORS
    return CatalogEntry(
        name=name,
        kind="generator" if generated else "map",
        summary=summaries()[name],
        parameters=default_parameters(name),
        width_m=x1 - x0,
        height_m=y1 - y0,
        area_m2=world.area_m2,
    )


def _generator(name: str) -> Callable[..., "Environment"]:
    module, function = generator_reference(name).split(":")
    found: Callable[..., Environment] = getattr(import_module(module), function)
    return found


def _read(name: str) -> "Environment":
    from multisrt.environments.formats import read_environment

    return read_environment(MAPS / _MAPS[name][0], name=name)


def _unknown(name: str) -> str:
    hint = did_you_mean(name, names())
    if "/" in name:
        hint += " (worlds of suites: multisrt.suites.world)"
    return f"no environment is called {shown(name)}{hint}; the names are {', '.join(names())}"
