"""Output of commands: existing files are not replaced unless the user says so.

- A run without ``--out`` gets its own folder (`new_folder`); with ``--out`` an existing run is
  an error (`require_no_run`), and ``--force`` replaces its files. The replay, the animation and
  the export of the run that is replaced are removed (`remove_made_of_run`), and no others.
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

from multisrt.cli.output_options import ANIMATION_NAME, EXPORT_NAME, REPLAY_NAME
from multisrt.geometry.errors import InvalidInputError

PARTIAL_NAME = "unfinished"
"""Name of the folder, inside the target, that holds the files until all are written."""

RECORDING_BEGINS = b'{"event":"header"'
"""Beginning of the first line of a recording."""


MADE_OF_RUNS = {
    REPLAY_NAME: (b"script-src &#39;sha256-", b": replay</title>"),
    ANIMATION_NAME: (b"<svg ", b"<desc>A run of multisrt "),
    EXPORT_NAME: (b"\x89MCAP0", b"multisrt "),
}
"""Files that other commands make of a run, by their usual names, with what they begin with."""

BEGINNING = 4096
"""Number of bytes in which the marks of a file are looked for."""


def stem_of(environment: str) -> str:
    """Return an environment's name as a part of the names of files and folders.

    Parameters
    ----------
    environment : str
        Name in the catalogue or of a world of a suite, or a map file.

    Examples
    --------
    >>> stem_of("office"), stem_of("maps/floor.yaml"), stem_of("indoor-30/07")
    ('office', 'floor', 'indoor-30-07')
    """
    from multisrt.environments import suites

    return environment.replace("/", "-") if suites.is_world(environment) else Path(environment).stem


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


def require_place(path: Path, *, force: bool) -> None:
    """Check that a file may be written to a folder that is there.

    Parameters
    ----------
    path : Path
        The file.
    force : bool
        Whether the user asked to replace it.

    Raises
    ------
    InvalidInputError
        If its folder does not exist, the path is that of a folder, or something is there and was
        not to be replaced.
    """
    if path.is_dir():
        raise InvalidInputError(f"cannot write {path}: it is a folder; name a file")
    if not path.parent.is_dir():
        raise InvalidInputError(f"cannot write {path}: there is no folder {path.parent}")
    require_no_file(path, force=force)


def require_svg(path: Path) -> None:
    """Check that a file for a picture has the suffix of SVG.

    Raises
    ------
    InvalidInputError
        If it has another suffix, or none.

    Examples
    --------
    >>> require_svg(Path("office.svg"))
    """
    # That a folder cannot be written is told by the writer.
    if path.suffix.lower() != ".svg" and not path.is_dir():
        raise InvalidInputError(
            f"{path}: this picture is written as SVG; name the file {path.with_suffix('.svg')}"
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
        raise _not_of_a_run(folder / there[0])
    if there and not force:
        raise InvalidInputError(
            f"{folder} holds a run already: name another folder (--out), or replace the run with "
            "--force"
        )


def _not_of_a_run(path: Path) -> InvalidInputError:
    return InvalidInputError(
        f"{path} exists already and does not belong to a run: name another folder (--out)"
    )


def _is_recording(path: Path) -> bool:
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(RECORDING_BEGINS)) == RECORDING_BEGINS


def remove_made_of_run(folder: Path, keep: Path | None = None) -> None:
    """Remove what other commands made of the run in a folder, since it shows another run now.

    Parameters
    ----------
    folder : Path
        The folder. Files of other names stay, as do files of these names that are not of this
        program.
    keep : Path, optional
        A file that stays, because it is of the new run.
    """
    for name, marks in MADE_OF_RUNS.items():
        path = folder / name
        if path == keep or path.is_symlink() or not path.is_file():
            continue
        with path.open("rb") as file:
            beginning = file.read(BEGINNING)
        if all(mark in beginning for mark in marks):
            path.unlink()


@contextmanager
def run_folder(folder: Path, *, force: bool = False, keep: Path | None = None) -> Iterator[Path]:
    """Open a folder for the files of a run, which move to their target at the end.

    On any error the files are removed, and so are the folders that were created.

    Parameters
    ----------
    folder : Path
        The target; it is created if necessary.
    force : bool, optional
        Whether a run that is there is replaced, with what other commands made of it.
    keep : Path, optional
        A file made of the new run, which is not removed.

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
                f"cannot create the folder {folder}: {error.strerror or error}"
            ) from None
        yield unfinished
        if force:
            remove_made_of_run(folder, keep)
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
        raise _not_of_a_run(unfinished)
    if not force:
        raise InvalidInputError(
            f"{unfinished} belongs to a run that was killed or is still in progress: name another "
            "folder (--out), or replace it with --force"
        )
    shutil.rmtree(unfinished)
