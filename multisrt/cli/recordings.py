"""Recordings that commands are given: files, folders of runs, and files beside recordings."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def recording_in(path: Path) -> Path:
    """Return the recording that a path means.

    Parameters
    ----------
    path : Path
        A recording, or the folder of a run, or the folder of one run among others.

    Returns
    -------
    Path
        The file, which is there; whether it is a recording is found when it is read.

    Raises
    ------
    InvalidInputError
        If there is nothing, or in the folder none or more than one, or the path is of another file
        of a run.
    """
    from multisrt.geometry.errors import InvalidInputError

    found = _found(path)
    if len(found) > 1:
        folders = ", ".join(str(file.parent) for file in found)
        raise InvalidInputError(f"{path} holds {len(found)} runs: name one of {folders}")
    return found[0]


def recordings_in(paths: Iterable[Path]) -> list[Path]:
    """Return the recordings that some paths mean.

    Parameters
    ----------
    paths : iterable of Path
        Recordings, folders of runs, and folders of several runs, which mean all of them in order
        of name.

    Returns
    -------
    list of Path
        The files, which are there; whether they are recordings is found when they are read.

    Raises
    ------
    InvalidInputError
        If there is nothing, or none in a folder, or a path is of another file of a run.
    """
    return [file for path in paths for file in _found(path)]


def file_beside(path: Path, name: str) -> Path:
    """Return a file of a name in a folder of runs, or beside a recording.

    Examples
    --------
    >>> file_beside(Path("runs/a/recording.jsonl"), "replay.html").as_posix()
    'runs/a/replay.html'
    """
    return path / name if path.is_dir() else path.with_name(name)


def _found(path: Path) -> list[Path]:
    from multisrt.finished_run import RECORDING_NAME, RUN_FILES
    from multisrt.geometry.errors import InvalidInputError

    if path.is_dir():
        if (path / RECORDING_NAME).is_file():
            return [path / RECORDING_NAME]
        if found := sorted(path.glob(f"*/{RECORDING_NAME}")):
            return found
        raise InvalidInputError(f"{path} holds no run: there is no {RECORDING_NAME} in it")
    if path.name in RUN_FILES and path.name != RECORDING_NAME:
        beside = path.with_name(RECORDING_NAME)
        if beside.is_file():
            raise InvalidInputError(
                f"{path} is not a recording; the recording of the run is {beside}"
            )
    if not path.exists():
        raise InvalidInputError(
            f"{path} does not exist: name the folder of a run, or the {RECORDING_NAME} in it"
        )
    return [path]
