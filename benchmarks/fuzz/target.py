"""A reader under test: its seeds, dictionary, options and call.

A folder of seeds has the files of one format; the files that they name (an image, an included
file) are in its folder ``companions``, which is copied beside every input.
"""

from __future__ import annotations

import shutil
import tempfile
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.fuzz.flaws import flaw_of_world
from benchmarks.fuzz.mutations import Mutation, mutated, of_text, pick
from multisrt.environments.formats import read_environment
from multisrt.geometry.errors import InvalidInputError

FOLDER: Final = Path(__file__).resolve().parents[2] / "tests" / "fuzz"
"""Folder of the seeds and of the kept inputs."""

Options = dict[str, Any]
Read = Callable[..., Any]
"""Takes the path and the options, and returns what the file holds."""

Flaw = Callable[[Any], str]
"""Takes what was read, and returns what is wrong with it; empty if nothing is."""

Finish = Callable[[bytes, np.random.Generator], bytes]


@dataclass(frozen=True, slots=True)
class Input:
    """A file for a reader: its content, the suffix of its name, and the options of the reader."""

    content: bytes
    suffix: str
    options: Options


def _as_it_is(content: bytes, rng: np.random.Generator) -> bytes:
    return content


def _as_it_is_kept(path: Path) -> tuple[str, bytes]:
    return path.suffix, path.read_bytes()


@dataclass(frozen=True, kw_only=True)
class Target:
    """A reader, and how its inputs are made.

    Attributes
    ----------
    name : str
        The format, and the name of the folders of its seeds and of its kept inputs.
    options : tuple of dict
        Sets of options of the reader: each input uses one of them, kept inputs are read with all.
    mutate : Mutation
        Mutation of its files.
    words : tuple of bytes
        The dictionary of the format.
    read : callable
        Takes the path and the options.
    flaw : callable
        Takes what was read, and returns what is wrong with it.
    must_name : tuple of str
        Parts of every message; by default the folder of the file.
    finish : callable
        Last step in making an input, such as the repair of a digest.
    made : callable
        Takes the path of a seed or of a kept input, and returns suffix and content of the file.
    """

    name: str
    options: tuple[Options, ...] = ({},)
    mutate: Mutation = of_text
    words: tuple[bytes, ...] = ()
    read: Read = read_environment
    flaw: Flaw = flaw_of_world
    must_name: tuple[str, ...] = ()
    finish: Finish = _as_it_is
    made: Callable[[Path], tuple[str, bytes]] = _as_it_is_kept

    @cached_property
    def seeds(self) -> list[tuple[str, bytes]]:
        """Suffix and content of the seeds, in the order of their names."""
        return [self.made(path) for path in files_in(FOLDER / "seeds" / self.name)]

    def input(self, seed: int, number: int) -> Input:
        """Return an input by its number: first the unchanged seeds, then mutations of them.

        Parameters
        ----------
        seed : int
            Seed of the campaign.
        number : int
            Number of the input, from 0.
        """
        rng = np.random.default_rng((seed, zlib.crc32(self.name.encode()), number))
        options = pick(rng, self.options)
        if number < len(self.seeds):
            suffix, content = self.seeds[number]
            return Input(content, suffix, options)
        suffix, content = pick(rng, self.seeds)
        contents = [other for _, other in self.seeds]
        changed = mutated(content, rng, contents, self.words, self.mutate)
        return Input(self.finish(changed, rng), suffix, options)

    def warm_up(self) -> None:
        """Read the seeds once, so that later inputs include no compilation and imports."""
        with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
            self.prepare(Path(name))
            for (suffix, content), options in product(self.seeds, self.options):
                path = Path(name) / f"input{suffix}"
                path.write_bytes(content)
                with suppress(InvalidInputError):
                    self.read(path, **options)

    def prepare(self, folder: Path) -> None:
        """Copy the companions of the inputs into an empty folder."""
        for path in files_in(FOLDER / "seeds" / self.name / "companions"):
            shutil.copy(path, folder)


def files_in(folder: Path) -> list[Path]:
    """Return the files of a folder, sorted by name; none if there is no folder."""
    if not folder.is_dir():
        return []
    return sorted(path for path in folder.iterdir() if path.is_file())
