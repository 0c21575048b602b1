"""Writing a file whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from multisrt.geometry.errors import InvalidInputError


@contextmanager
def atomic_write(path: Path) -> Iterator[IO[bytes]]:
    """Open a file for writing that gets its name only when it has been written completely.

    Raises
    ------
    InvalidInputError
        If it cannot be written; no part of it is left behind.
    """
    if not path.name:
        raise InvalidInputError(f"cannot write {path}: it is a folder; name a file")
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            yield file
        os.replace(part, path)
    except BaseException as error:
        with suppress(OSError):
            part.unlink()
        if isinstance(error, OSError):
            raise InvalidInputError(f"cannot write {path}: {error.strerror or error}") from None
        raise


def make_folder(folder: Path, remedy: str = "choose another one") -> None:
    """Make a folder and those above it, unless they are there.

    Parameters
    ----------
    folder : Path
        The folder.
    remedy : str
        What to do if it cannot be made.

    Raises
    ------
    InvalidInputError
        If it cannot be made, as a file of that name is there.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInputError(
            f"cannot create the folder {folder}: {error.strerror or error}; {remedy}"
        ) from None
