"""A folder that receives all files of a run or none."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from multisrt.geometry.errors import InvalidInputError

PARTIAL_NAME = "unfinished"
"""Name of the folder, inside the target, that holds the files until all are written."""


@contextmanager
def output_folder(folder: Path) -> Iterator[Path]:
    """Open a folder for writing, whose files move to their target at the end.

    On any error the files are removed, and so are the folders that were created.

    Parameters
    ----------
    folder : Path
        The target; it is created if necessary.

    Yields
    ------
    Path
        The folder to write to.

    Raises
    ------
    InvalidInputError
        If the target cannot be created or written to.
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
            unfinished = folder / PARTIAL_NAME
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
        if made and made[0].name == PARTIAL_NAME:
            shutil.rmtree(made.pop(0), ignore_errors=True)
        for path in made:
            if any(path.iterdir()):
                break
            path.rmdir()
        raise
