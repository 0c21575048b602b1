"""Reading specs of runs and experiments from TOML and JSON files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from multisrt.geometry.errors import InvalidInputError

if TYPE_CHECKING:
    from multisrt.experiments.spec import ExperimentSpec
    from multisrt.spec import RunSpec

Spec = TypeVar("Spec")


def read_run_spec(path: Path) -> RunSpec:
    """Read the spec of a run: JSON if the suffix is ``.json``, else TOML.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    RunSpec
        The spec.

    Raises
    ------
    InvalidInputError
        If the file cannot be read or holds no spec of a run; the message names the file.
    """
    from multisrt.spec import RunSpec

    return _read(path, RunSpec.from_toml, RunSpec.from_json)


def read_experiment(path: Path) -> ExperimentSpec:
    """Read an experiment: JSON if the suffix is ``.json``, else TOML.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    ExperimentSpec
        The experiment.

    Raises
    ------
    InvalidInputError
        If the file cannot be read or holds no experiment; the message names the file.
    """
    from multisrt.experiments.spec import ExperimentSpec

    if path.suffix == ".sqlite":
        raise InvalidInputError(
            f"{path} is a file of results; name the experiment instead, such as "
            f"{path.with_suffix('.toml')}"
        )
    return _read(path, ExperimentSpec.from_toml, ExperimentSpec.from_json)


def _read(path: Path, from_toml: Callable[[str], Spec], from_json: Callable[[str], Spec]) -> Spec:
    if path.is_dir():
        raise InvalidInputError(f"{path} is a folder; name the file in it (.toml)")
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a text file"
        raise InvalidInputError(f"{path}: {reason or error}") from None
    try:
        return from_json(text) if path.suffix == ".json" else from_toml(text)
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from None
