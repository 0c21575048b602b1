"""Output of commands: existing files are not replaced unless the user says so.

- A run without ``--out`` gets its own folder (`new_folder`); with ``--out`` an existing run is
  an error (`require_no_run`), and ``--force`` replaces its files and no others.
- A picture or a table replaces an existing file only with ``--force`` (`require_no_file`).
- New experiment files never replace a file; reports replace reports only; stores of results are
  continued. The functions that write these check that.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

from multisrt.geometry.errors import InvalidInputError

PARTIAL_NAME = "unfinished"
"""Name of the folder, inside the target, that holds the files until all are written."""

RECORDING_BEGINS = b'{"event":"header"'
"""Beginning of the first line of a recording."""


def new_folder(folder: Path) -> Path:
    """Return a folder that does not exist: the one named, or else that name with a number.

    Parameters
    ----------
    folder : Path
        What it is to be called.

    Returns
    -------
    Path
        ``runs/office``, or ``runs/office-2`` if that exists, and so on.
    """
    if not os.path.lexists(folder):
        return folder
    numbered = (folder.with_name(f"{folder.name}-{number}") for number in count(2))
    return next(path for path in numbered if not os.path.lexists(path))


def require_no_file(path: Path, *, force: bool) -> None:
    """Check that a file may be written.

    Parameters
    ----------
    path : Path
        The file.
    force : bool
        Whether the user asked to replace it.

    Raises
    ------
    InvalidInputError
        If something is there and was not to be replaced.
    """
    if not force and path.is_file():
        raise InvalidInputError(
            f"{path} exists already: name another file, or replace it with --force"
        )


def require_no_run(folder: Path, *, force: bool) -> None:
    """Check that the files of a run may be written to a folder.

    Parameters
    ----------
    folder : Path
        The folder, which need not exist.
    force : bool
        Whether the user asked to replace a run that is there.

    Raises
    ------
    InvalidInputError
        If there is a run that was not to be replaced, or a file of the name that is of no run.
    """
    from multisrt.finished_run import RECORDING_NAME, RUN_FILES

    try:
        there = [name for name in RUN_FILES if os.path.lexists(folder / name)]
        recorded = _is_recording(folder / RECORDING_NAME)
    except OSError as error:
        raise InvalidInputError(
            f"cannot write to the folder {folder}: {error.strerror or error}"
        ) from None
    if there and not recorded:
        raise InvalidInputError(
            f"{folder / there[0]} exists already and is not of a run: name another folder (--out)"
        )
    if there and not force:
        raise InvalidInputError(
            f"{folder} holds a run already: name another folder (--out), or replace the run with "
            "--force"
        )


def _is_recording(path: Path) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(RECORDING_BEGINS)) == RECORDING_BEGINS


@contextmanager
def run_folder(folder: Path, *, force: bool = False) -> Iterator[Path]:
    """Open a folder for the files of a run, which move to their target at the end.

    On any error the files are removed, and so are the folders that were created.

    Parameters
    ----------
    folder : Path
        The target; it is created if necessary.
    force : bool, optional
        Whether a run that is there is replaced.

    Yields
    ------
    Path
        The folder to write to.

    Raises
    ------
    InvalidInputError
        If the target cannot be created or written to, or holds a run that is not to be replaced.
    """
    made: list[Path] = []
    try:
        try:
            missing = [path for path in (folder, *folder.parents) if not path.exists()]
            if not missing and not folder.is_dir():
                raise InvalidInputError(f"{folder} is a file; --out names a folder")
            require_no_run(folder, force=force)
            for path in reversed(missing):
                path.mkdir()
                made.insert(0, path)
            unfinished = folder / PARTIAL_NAME
            _remove_partial(unfinished, force)
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


def _remove_partial(unfinished: Path, force: bool) -> None:
    # Left behind by a process that was killed, or in use by one that still runs.
    from multisrt.finished_run import RUN_FILES

    if not os.path.lexists(unfinished):
        return
    ours = {*RUN_FILES, *(f"{name}.part" for name in RUN_FILES)}
    if not unfinished.is_dir() or any(path.name not in ours for path in unfinished.iterdir()):
        raise InvalidInputError(
            f"{unfinished} exists already and is not of a run: name another folder (--out)"
        )
    if not force:
        raise InvalidInputError(
            f"{unfinished} is of a run that was killed or is still going on: name another folder "
            "(--out), or replace it with --force"
        )
    shutil.rmtree(unfinished)
