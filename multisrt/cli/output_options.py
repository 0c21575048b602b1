"""Options of output, which commands share: --out, --store, --force, --height and --quiet.

A file made of recordings (a replay, an animation, a figure, an export) is written to the folder of
the first recording unless ``--out`` names another place.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from multisrt.cli import candidates

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]

REPLAY_NAME = "replay.html"
ANIMATION_NAME = "animation.svg"
EXPORT_NAME = "run.mcap"
FIGURE_NAME = "{kind}.pdf"


def out_file(what: str, default: str, *, several: bool = False) -> Decorator:
    """Return the option --out of a command that writes a file made of recordings.

    Parameters
    ----------
    what : str
        What the file holds, with its formats.
    default : str
        Name of the file if none is given; see `multisrt.cli.recordings.file_beside`.
    several : bool, optional
        Whether the command takes several recordings.

    Returns
    -------
    callable
        The decorator of the command.
    """
    where = "in the folder of the " + ("first RECORDING" if several else "recording")
    return click.option(
        "--out",
        type=click.Path(path_type=Path),
        metavar="FILE",
        help=f"File for {what}.  [default: {default} {where}]",
    )


def out_folder(what: str, default: str) -> Decorator:
    """Return the option --out of a command that writes a folder.

    Parameters
    ----------
    what : str
        What the folder holds.
    default : str
        The folder if none is given, in words.

    Returns
    -------
    callable
        The decorator of the command.
    """
    return click.option(
        "--out",
        type=click.Path(path_type=Path),
        metavar="DIR",
        shell_complete=candidates.folders,
        help=f"Folder for {what}.  [default: {default}]",
    )


def store_option(what: str = "the results") -> Decorator:
    """Return the option --store of a command that is given the file of an experiment.

    Parameters
    ----------
    what : str, optional
        What the file holds.

    Returns
    -------
    callable
        The decorator of the command.
    """
    return click.option(
        "--store",
        type=click.Path(path_type=Path),
        metavar="RESULTS",
        help=f"File for {what}.  [default: FILE with suffix .sqlite]",
    )


def force_option(what: str = "FILE") -> Decorator:
    """Return the option --force of a command, which replaces what is there.

    Parameters
    ----------
    what : str, optional
        What is replaced.

    Returns
    -------
    callable
        The decorator of the command.
    """
    return click.option("--force", is_flag=True, help=f"Replace {what} if it exists.")


def height_option() -> Decorator:
    """Return the option --height of a command that writes solids.

    Returns
    -------
    callable
        The decorator of the command, which takes a keyword `height_m` of type float or None.
    """
    return click.option(
        "--height",
        "height_m",
        type=float,
        metavar="M",
        help="Height of walls in .stl and .glb (m).  [default: 1]",
    )


def quiet_option(what: str = "errors") -> Decorator:
    """Return the option --quiet of a command.

    Parameters
    ----------
    what : str, optional
        What is printed all the same.

    Returns
    -------
    callable
        The decorator of the command.
    """
    return click.option("--quiet", is_flag=True, help=f"Print {what} only.")
