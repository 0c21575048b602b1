"""A suite: generated worlds with their digests, built when they are accessed."""

from __future__ import annotations

import hashlib
import operator
from collections.abc import Iterator
from typing import TYPE_CHECKING

import msgspec

from multisrt.environments.catalog import environment
from multisrt.geometry.errors import InvalidInputError

if TYPE_CHECKING:
    from multisrt.environments.environment import Environment


class Entry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a world of a suite is made.

    Attributes
    ----------
    generator : str
        Name of a generator in the catalog.
    seed : int
        Its seed.
    parameters : dict
        Its parameters, except for defaults.
    digest : str
        What `digest_of` returns for the world.
    """

    generator: str
    seed: int
    parameters: dict[str, int | float] = {}
    digest: str


class Suite(msgspec.Struct, frozen=True, kw_only=True):
    """Worlds that are held out for comparisons: no example, test or default uses them.

    A suite is a sequence: ``suite[7]`` is the world ``NAME/07``. Iteration builds one world at a
    time.

    Attributes
    ----------
    name : str
        Name, such as "indoor-30".
    version : int
        Version number; a change of any world changes it.
    about : str
        Description in one line.
    entries : tuple of Entry
        How the worlds are made.

    Examples
    --------
    >>> from multisrt import suites
    >>> mazes = suites.load("mazes-30")
    >>> mazes.version, len(mazes), mazes.world_names[-1]
    (1, 30, 'mazes-30/29')
    >>> mazes[29].name
    'mazes-30/29'
    """

    name: str
    version: int
    about: str
    entries: tuple[Entry, ...]

    @property
    def world_names(self) -> tuple[str, ...]:
        """Names of the worlds, without building them."""
        return tuple(f"{self.name}/{number:02}" for number in range(len(self.entries)))

    def require_world(self, name: str) -> int:
        """Return the number of a world.

        Parameters
        ----------
        name : str
            Its name, such as "indoor-30/07".

        Raises
        ------
        InvalidInputError
            If there is no such world.

        Examples
        --------
        >>> from multisrt import suites
        >>> suites.load("indoor-30").require_world("indoor-30/07")
        7
        """
        if name not in self.world_names:
            raise InvalidInputError(
                f"the suite {self.name} has no world {name!r}; its worlds are "
                f"{self.world_names[0]} to {self.world_names[-1]}"
            )
        return self.world_names.index(name)

    def __len__(self) -> int:
        return len(self.entries)

    def __getitem__(self, number: int) -> Environment:
        """Build a world.

        Parameters
        ----------
        number : int
            From 0; negative numbers count from the end.

        Returns
        -------
        Environment
            The world, under its name in the suite.

        Raises
        ------
        IndexError
            If there is no such world.
        InvalidInputError
            If this installation builds a world with another digest than that of the suite.
        """
        from multisrt.environments.environment import Environment

        number = range(len(self.entries))[operator.index(number)]
        entry, name = self.entries[number], self.world_names[number]
        built = environment(entry.generator, seed=entry.seed, **entry.parameters)
        if (found := digest_of(built)) != entry.digest:
            raise InvalidInputError(
                f"{name} is not the world of version {self.version} of the suite: "
                f"{built.origin} has the digest {found[:12]} here, and {entry.digest[:12]} in the "
                "suite; results would not be comparable with those of others. Install the package "
                "versions of constraints.txt of this release"
            )
        return Environment(name, built.free, starts=built.starts, origin=built.origin)

    def __iter__(self) -> Iterator[Environment]:
        return (self[number] for number in range(len(self)))


def digest_of(world: Environment) -> str:
    """Return the SHA-256 of a world's free space and suggested starts, in hexadecimal digits.

    Examples
    --------
    >>> hall = environment("open", size_m=12)
    >>> digest_of(hall) == digest_of(environment("open", size_m=12, seed=5)), len(digest_of(hall))
    (True, 64)
    """
    return hashlib.sha256(f"{world.digest} {world.starts}".encode()).hexdigest()
