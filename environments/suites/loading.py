"""Suites by name, from the files in this folder."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from multisrt.environments.suites.suite import Entry, Suite
from multisrt.geometry.errors import InvalidInputError, did_you_mean

if TYPE_CHECKING:
    from multisrt.environments.environment import Environment

FILES = Path(__file__).parent
"""Folder of the suites."""


class _File(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Content of the file of a suite."""

    version: int
    about: str
    worlds: tuple[Entry, ...]


@cache
def names() -> tuple[str, ...]:
    """Return the names of all suites.

    Examples
    --------
    >>> names()
    ('indoor-30', 'mazes-30', 'outdoor-30')
    """
    return tuple(sorted(path.stem for path in FILES.glob("*.toml")))


@cache
def load(name: str) -> Suite:
    """Return a suite; its worlds are built when they are accessed.

    Parameters
    ----------
    name : str
        One of `names`.

    Returns
    -------
    Suite
        The suite.

    Raises
    ------
    InvalidInputError
        If there is no suite of that name.

    Examples
    --------
    >>> load("outdoor-30").world_names[:2]
    ('outdoor-30/00', 'outdoor-30/01')
    """
    if name not in names():
        raise InvalidInputError(
            f"no suite is called {name!r}{did_you_mean(name, names())}; "
            f"the names are {', '.join(names())}"
        )
    text = (FILES / f"{name}.toml").read_text(encoding="utf-8")
    file = msgspec.toml.decode(text, type=_File)
    return Suite(name=name, version=file.version, about=file.about, entries=file.worlds)


def is_world(name: str) -> bool:
    """Return whether a name is that of a suite and a number, which need not exist.

    Examples
    --------
    >>> is_world("indoor-30/07"), is_world("indoor-30"), is_world("maps/07")
    (True, False, False)
    """
    return name.partition("/")[0] in names() and "/" in name


def world(name: str, *, version: int | None = None) -> Environment:
    """Build a world of a suite by its name.

    Parameters
    ----------
    name : str
        Such as "indoor-30/07".
    version : int, optional
        Version of the suite that is required; by default that of this release.

    Returns
    -------
    Environment
        The world.

    Raises
    ------
    InvalidInputError
        If there is no such world, the suite has another version, or this installation builds a
        world with another digest than that of the suite.

    Examples
    --------
    >>> world("mazes-30/00", version=1).name
    'mazes-30/00'
    """
    suite = load(name.partition("/")[0])
    if version is not None and version != suite.version:
        raise InvalidInputError(
            f"the suite {suite.name} has version {suite.version} in this release, and version "
            f"{version} is required; install the release that has it"
        )
    return suite[suite.require_world(name)]
