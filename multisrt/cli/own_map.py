"""The options of commands that take a world, or a map of the user's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any

import click

from multisrt.cli import candidates
from multisrt.cli.output_options import Decorator


@dataclass(frozen=True, slots=True)
class OwnMap:
    """A map file, and for an image its resolution in metres per pixel and a team file with starts.

    As a string, the options that name it, without the folders of the files.
    """

    path: Path
    resolution_m: float | None
    starts_from: str | None = None

    def __str__(self) -> str:
        image = "" if self.resolution_m is None else f" --resolution {self.resolution_m:g}"
        team = "" if self.starts_from is None else f" --starts-from {Path(self.starts_from).name}"
        return f"--map {self.path.name}{image}{team}"


def resolution_option(when: str = "") -> Decorator:
    """Return the option --resolution of a command that takes an image as a map.

    Parameters
    ----------
    when : str
        What precedes its help, such as ``"With --map: "``.

    Returns
    -------
    callable
        The decorator of the command, which takes a keyword `resolution` of type float or None.
    """
    first = "metres" if when else "Metres"
    return click.option(
        "--resolution",
        type=click.FloatRange(min=0.0, min_open=True),
        metavar="METRES",
        help=f"{when}{first} per pixel of an image without its own.",
    )


def starts_from_option(when: str = "") -> Decorator:
    """Return the option --starts-from of a command that takes an image as a map.

    Parameters
    ----------
    when : str
        What precedes its help, such as ``"With --map: "``.

    Returns
    -------
    callable
        The decorator of the command, which takes a keyword `starts_from` of type str or None.
    """
    first = "suggested starts" if when else "Suggested starts"
    return click.option(
        "--starts-from",
        type=click.Path(),
        metavar="FILE",
        help=f"{when}{first} of an image: an MRESim team file.",
    )


def world_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options --set, --resolution, --threshold and --starts-from to a command with ENV.

    Parameters
    ----------
    command : callable
        The command; `multisrt.cli.run_options.world_of_options` takes what it is given.

    Returns
    -------
    callable
        The command with its options.
    """
    options = (
        click.option(
            "--set",
            "parameters",
            multiple=True,
            metavar="NAME=VALUE",
            shell_complete=candidates.parameters,
            help="Parameter of a generator, or its seed, as 'multisrt environments show ENV' lists "
            "them; repeatable.",
        ),
        resolution_option(),
        click.option(
            "--threshold",
            type=float,
            help="Lightness from 0 to 1 above which a pixel is free.",
        ),
        starts_from_option(),
    )
    for option in reversed(options):
        command = option(command)
    return command


def map_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options --map, --resolution and --starts-from to a command.

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
        *args: Any,
        map_file: Path | None,
        resolution: float | None,
        starts_from: str | None,
        **others: Any,
    ) -> None:
        for option, value in (("--resolution", resolution), ("--starts-from", starts_from)):
            if map_file is None and value is not None:
                raise click.UsageError(f"{option} is for an image that --map names")
        own_map = None if map_file is None else OwnMap(map_file, resolution, starts_from)
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
        resolution_option("With --map: "),
        starts_from_option("With --map: "),
    )
    decorated: Callable[..., None] = with_map
    for option in reversed(options):
        decorated = option(decorated)
    return decorated
