"""Recordings that commands are given: files, folders of runs, and files beside recordings."""

from __future__ import annotations

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
        The file; whether it is a recording is found when it is read.

    Raises
    ------
    InvalidInputError
        If there is none in the folder, or more than one, or the path is of another file of a run.
    """
    from multisrt.finished_run import RECORDING_NAME, RUN_FILES
    from multisrt.geometry.errors import InvalidInputError

    if path.is_dir():
        if (path / RECORDING_NAME).is_file():
            return path / RECORDING_NAME
        found = sorted(below.parent for below in path.glob(f"*/{RECORDING_NAME}"))
        if len(found) == 1:
            return found[0] / RECORDING_NAME
        if found:
            raise InvalidInputError(
                f"{path} holds {len(found)} runs: name one of {', '.join(map(str, found))}"
            )
        raise InvalidInputError(f"{path} holds no run: there is no {RECORDING_NAME} in it")
    if path.name in RUN_FILES and path.name != RECORDING_NAME:
        beside = path.with_name(RECORDING_NAME)
        if beside.is_file():
            raise InvalidInputError(
                f"{path} is not a recording; the recording of the run is {beside}"
            )
    return path
