"""Worlds by name: every generator and every bundled map.

Nothing is built, and no geometry is loaded, before a world is asked for.
"""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from multisrt.geometry.errors import InvalidInputError, did_you_mean

if TYPE_CHECKING:
    from multisrt.environments.environment import Environment

MAPS = Path(__file__).parent / "maps"
"""Folder of the bundled maps."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CatalogEntry:
    """What a list of worlds says of one of them.

    Parameters
    ----------
    name : str
        What `environment` takes.
    kind : "generator" or "map"
        Drawn from parameters and a seed, or read from a bundled file.
    summary : str
        One line.
    parameters : tuple of (name, default)
        What a generator takes besides its seed; empty for maps.
    width_m, height_m : float
        Extent of free space, for a generator with its defaults and seed 0.
    area_m2 : float
        Area of free space, likewise.
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
}
"""Name to module and function, and summary."""

_MAPS: dict[str, tuple[str, str]] = {
    "museum": ("museum.geojson", "galleries around a rotunda, with alcoves and columns"),
    "apartment": ("apartment.geojson", "large furnished apartment"),
    "workshop": ("workshop.yaml", "workshop with slanted walls and round columns (occupancy grid)"),
    "library": ("library.wkt", "library: rows of shelves, a reading room, study cells"),
    "clinic": ("clinic.geojson", "clinic of two wings at an angle, a waiting room where they meet"),
    "cave": ("cave.geojson", "cave with pillars, no straight wall in it"),
}
"""Name to file, and summary."""


def names() -> tuple[str, ...]:
    """Give the names of all worlds, generators first, without building any."""
    return (*_GENERATORS, *_MAPS)


def environment(name: str, *, seed: int | None = None, **parameters: float) -> "Environment":
    """Build the world of a name.

    Parameters
    ----------
    name : str
        One of `names`.
    seed : int, optional
        Seed of a generator, 0 unless given. Bundled maps take none.
    **parameters
        A generator's parameters; the entries of `catalog` list them.

    Raises
    ------
    InvalidInputError
        If no world has the name, or it does not take a parameter, or not that value.

    Examples
    --------
    >>> environment("open", size_m=12).area_m2
    144.0
    """
    if name in _MAPS:
        if seed is not None or parameters:
            given = [*([] if seed is None else ["seed"]), *parameters]
            raise InvalidInputError(
                f"the bundled map {name!r} is fixed: it takes neither seed nor parameters; "
                f"leave out {', '.join(given)}"
            )
        return _read(name)
    if name not in _GENERATORS:
        raise InvalidInputError(_unknown(name))
    accepted = _parameters(name)
    unknown = [parameter for parameter in parameters if parameter not in dict(accepted)]
    if unknown:
        listed = ", ".join(f"{parameter}={default:g}" for parameter, default in accepted)
        raise InvalidInputError(
            f"{name} has no parameter {unknown[0]!r}; it takes seed and, with these defaults, "
            f"{listed}"
        )
    return _generator(name)(**parameters, seed=0 if seed is None else seed)


@cache
def catalog() -> tuple[CatalogEntry, ...]:
    """Describe all worlds, in the order of `names`.

    Sizes are those of the worlds themselves, which are built for it once.
    """
    return tuple(_entry(name) for name in names())


def _entry(name: str) -> CatalogEntry:
    world = environment(name)
    x0, y0, x1, y1 = world.bounds
    generated = name in _GENERATORS
    return CatalogEntry(
        name=name,
        kind="generator" if generated else "map",
        summary=(_GENERATORS if generated else _MAPS)[name][1],
        parameters=_parameters(name) if generated else (),
        width_m=x1 - x0,
        height_m=y1 - y0,
        area_m2=world.area_m2,
    )


def _generator(name: str) -> Callable[..., "Environment"]:
    module, function = _GENERATORS[name][0].split(":")
    found: Callable[..., Environment] = getattr(
        import_module(f"multisrt.environments.generators.{module}"), function
    )
    return found


def _parameters(name: str) -> tuple[tuple[str, float], ...]:
    signature = inspect.signature(_generator(name))
    return tuple(
        (parameter.name, parameter.default)
        for parameter in signature.parameters.values()
        if parameter.name != "seed"
    )


def _read(name: str) -> "Environment":
    from multisrt.environments.formats import read_environment

    return read_environment(MAPS / _MAPS[name][0], name=name)


def _unknown(name: str) -> str:
    hint = did_you_mean(name, names())
    return f"no environment is called {name!r}{hint}; the names are {', '.join(names())}"
