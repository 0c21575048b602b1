"""The folder of a failure: its spec, recording, replay and violation."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Final

import msgspec

from multisrt.campaign.violations import Violation
from multisrt.experiments.store_file import sane
from multisrt.geometry.errors import InvalidInputError, reason_of
from multisrt.recording import atomic_write, make_folder
from multisrt.spec import RunSpec
from multisrt.validation_errors import UNREADABLE

FAILURE_NAME: Final = "failure.toml"
SPEC_NAME: Final = "spec.toml"
DRAWN_NAME: Final = "drawn.toml"
RECORDING_NAME: Final = "recording.jsonl"
REPLAY_NAME: Final = "replay.html"

NAMES: Final = (FAILURE_NAME, SPEC_NAME, DRAWN_NAME, RECORDING_NAME, REPLAY_NAME)
"""Names of the files of a failure."""

NAME_A_FOLDER: Final = (
    "name the folder of a failure; 'multisrt campaign show STORE' prints those of a campaign"
)
"""What to do about a path that is none."""


class Failure(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A failure of a mission, as it stands in `FAILURE_NAME`.

    Attributes
    ----------
    says : str
        What broke, in one line.
    invariant : str
        Which invariant does not hold.
    seed, number : int
        Seed of the campaign, and number of the mission.
    robot : int or None
        The robot that it is about.
    time_s : float or None
        When, in seconds of the run.
    tries : int
        Number of runs by which the spec was shrunk; 0: it is as drawn.
    digest : str
        Digest of the recording; empty if there is none.
    """

    says: str
    invariant: str
    seed: int
    number: int
    robot: int | None = None
    time_s: float | None = None
    tries: int = 0
    digest: str = ""

    @property
    def violation(self) -> Violation:
        """What broke."""
        return Violation(
            invariant=self.invariant, says=self.says, robot=self.robot, time_s=self.time_s
        )


def folder_name(number: int, invariant: str) -> str:
    """Return the name of the folder of a failure.

    Examples
    --------
    >>> folder_name(123, "no-collision")
    '000123-no-collision'
    """
    return f"{number:06d}-{invariant}"


def free_folder(folder: Path, number: int, invariant: str) -> Path:
    """Return a folder for a failure that is not there yet: nothing is overwritten.

    Parameters
    ----------
    folder : Path
        The folder that it is to be in.
    number, invariant
        As for `folder_name`.

    Examples
    --------
    >>> free_folder(Path("none-failures"), 123, "no-collision").as_posix()
    'none-failures/000123-no-collision'
    """
    name = folder_name(number, invariant)
    names = itertools.chain([name], (f"{name}-{again}" for again in itertools.count(2)))
    return next(folder / name for name in names if not (folder / name).exists())


def write_failure(folder: Path, failure: Failure, spec: RunSpec, drawn: RunSpec) -> None:
    """Write what broke and the specs; the recording is written by what makes the run.

    Parameters
    ----------
    folder : Path
        The folder, which is made.
    failure : Failure
        What broke.
    spec, drawn : RunSpec
        The spec that fails, and the one that was drawn.

    Raises
    ------
    InvalidInputError
        If a file cannot be written.
    """
    made = msgspec.toml.encode(failure).decode()
    files = {FAILURE_NAME: made, SPEC_NAME: spec.canonical().to_toml(), DRAWN_NAME: drawn.to_toml()}
    make_folder(folder)
    for name, text in files.items():
        with atomic_write(folder / name) as file:
            file.write(text.encode())


def read_failure(folder: Path) -> tuple[Failure, RunSpec]:
    """Read a failure.

    Parameters
    ----------
    folder : Path
        The folder, or a file in it.

    Returns
    -------
    (Failure, RunSpec)
        What broke, and the spec that fails.

    Raises
    ------
    InvalidInputError
        If it is no folder of a failure; the message says which file is missing or wrong.
    """
    folder = folder_of(folder)
    text, spec = (_read(folder, name) for name in (FAILURE_NAME, SPEC_NAME))
    try:
        failure = msgspec.convert(sane(msgspec.toml.decode(text)), Failure)
    except UNREADABLE as error:
        raise InvalidInputError(f"{folder / FAILURE_NAME}: {reason_of(error)}") from None
    try:
        return failure, RunSpec.from_toml(spec)
    except InvalidInputError as error:
        raise InvalidInputError(f"{folder / SPEC_NAME}: {error}") from None


def folder_of(path: Path) -> Path:
    """Return the folder of a failure that is given by itself or by a file in it.

    Raises
    ------
    InvalidInputError
        If there is nothing of that name, or a file that no failure has.
    """
    if path.is_dir():
        return path
    if not path.exists():
        raise InvalidInputError(f"there is no {path}: {NAME_A_FOLDER}")
    if path.name not in NAMES:
        raise InvalidInputError(f"{path} is a file, but not one of a failure: {NAME_A_FOLDER}")
    return path.parent


def _read(folder: Path, name: str) -> str:
    try:
        return (folder / name).read_text(encoding="utf-8")
    except FileNotFoundError:
        failures = sorted(folder.glob(f"*/{FAILURE_NAME}"))
        hint = f"name one in it, such as {failures[0].parent}" if failures else NAME_A_FOLDER
        raise InvalidInputError(
            f"{folder} is not the folder of a failure, as it has no {name}: {hint}"
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInputError(f"{folder / name}: {reason_of(error)}") from None
