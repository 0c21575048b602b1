"""Reading specs of runs and experiments from TOML and JSON files."""

from __future__ import annotations

import os
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
        If the file cannot be read or holds no spec of a run, or a file that the spec names is
        missing; the message names both.
    """
    from multisrt.spec import FileEnvironment, RunSpec

    spec = _read(path, RunSpec.from_toml, RunSpec.from_json)
    if isinstance(spec.environment, FileEnvironment):
        for field in ("path", "starts_from"):
            if (name := getattr(spec.environment, field)) is not None:
                _require_there(path, field, Path(name))
    return spec


def _require_there(spec: Path, field: str, file: Path) -> None:
    # Relative to the working folder, as when the spec was written; never to another one in silence.
    if os.path.lexists(file):
        return
    if file.is_absolute():
        raise InvalidInputError(
            f"{spec} names the file {file}, which does not exist; restore it, or correct {field!r} "
            "in the spec"
        )
    beside = spec.parent / file
    there = os.path.lexists(beside)
    places = f"but {beside} does" if there else f"and neither does {beside}"
    raise InvalidInputError(
        f"{spec} names the file {file}, relative to the working folder: {Path.cwd() / file} does "
        f"not exist, {places}; run the command in the folder to which the name is relative, or "
        f"correct {field!r} in the spec"
    )


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
