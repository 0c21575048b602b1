"""How a process that this one starts finds the modules that this one finds, and no others."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

PATH = "--path="
"""Begins an argument that is a folder of the import path."""


def python_command(program: str, arguments: Sequence[str]) -> list[str]:
    """Return the command that starts a program of this package in a separate process.

    No file of the working directory shadows a library there, as `queue.py` might.

    Parameters
    ----------
    program : str
        Name of its module, which takes what `extend_path` returns.
    arguments : sequence of str
        Its arguments.

    Returns
    -------
    list of str
        The command.
    """
    folders = [f"{PATH}{Path(folder).absolute()}" for folder in sys.path]
    return [sys.executable, "-P", "-m", program, *folders, *arguments]


def extend_path(arguments: Sequence[str]) -> list[str]:
    """Append folders that arguments name to the import path, and return the other arguments."""
    folders = [word.removeprefix(PATH) for word in arguments if word.startswith(PATH)]
    sys.path.extend(folder for folder in folders if folder not in sys.path)
    return [word for word in arguments if not word.startswith(PATH)]
