"""The options of a command that can use a map of the user's own instead of its worlds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any

import click


@dataclass(frozen=True, slots=True)
class OwnMap:
    """A map file, and the resolution of an image without its own in metres per pixel.

    As a string, the options that name it, without the folder of the file.
    """

    path: Path
    resolution_m: float | None

    def __str__(self) -> str:
        image = "" if self.resolution_m is None else f" --resolution {self.resolution_m:g}"
        return f"--map {self.path.name}{image}"


def map_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options --map and --resolution to a command.

    Parameters
    ----------
    command : callable
        The command, which takes a keyword `own_map` of type `OwnMap` or None instead of them.

    Returns
    -------
    callable
        The command with its options.
    """

    @wraps(command)
    def with_map(
        *args: Any, map_file: Path | None, resolution: float | None, **others: Any
    ) -> None:
        if map_file is None and resolution is not None:
            raise click.UsageError("--resolution is for an image that --map names")
        own_map = None if map_file is None else OwnMap(map_file, resolution)
        command(*args, own_map=own_map, **others)

    options = (
        click.option(
            "--map",
            "map_file",
            type=click.Path(path_type=Path, exists=True, dir_okay=False),
            metavar="FILE",
            help="A map of your own instead of the worlds of the experiment; with minpos, of its "
            "hospital.",
        ),
        click.option(
            "--resolution",
            type=click.FloatRange(min=0.0, min_open=True),
            metavar="METRES",
            help="With --map: metres per pixel of an image without its own.",
        ),
    )
    decorated: Callable[..., None] = with_map
    for option in reversed(options):
        decorated = option(decorated)
    return decorated
