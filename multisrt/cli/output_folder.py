"""A folder that gets all of a run's files, or none."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from multisrt.geometry.errors import InvalidInputError

UNFINISHED = "unfinished"
"""Name of the folder, inside the one asked for, in which files lie until all are written."""


@contextmanager
def output_folder(folder: Path) -> Iterator[Path]:
    """Give a folder to write to, whose files move to the folder asked for at the end.

    If anything fails before, they are removed, and so are the folders that were made.

    Raises
    ------
    InvalidInputError
        If the folder cannot be made or written to; the message says why.
    """
    made: list[Path] = []
    try:
        try:
            missing = [path for path in (folder, *folder.parents) if not path.exists()]
            if not missing and not folder.is_dir():
                raise InvalidInputError(f"{folder} is a file; --out names a folder")
            for path in reversed(missing):
                path.mkdir()
                made.insert(0, path)
            unfinished = folder / UNFINISHED
            shutil.rmtree(unfinished, ignore_errors=True)
            unfinished.mkdir()
            made.insert(0, unfinished)
        except OSError as error:
            raise InvalidInputError(
                f"cannot make the folder {folder}: {error.strerror or error}"
            ) from None
        yield unfinished
        for path in sorted(unfinished.iterdir()):
            path.replace(folder / path.name)
        unfinished.rmdir()
    except BaseException:
        if made and made[0].name == UNFINISHED:
            shutil.rmtree(made.pop(0), ignore_errors=True)
        for path in made:
            if any(path.iterdir()):
                break
            path.rmdir()
        raise
