"""The maps of a clone as worlds of this package."""

from __future__ import annotations

from pathlib import Path

from multisrt.competition.clone import Clone
from multisrt.environments.environment import Environment


def competition_environment(folder: str | Path, name: str) -> Environment:
    """Return a map of the competition as a world.

    Parameters
    ----------
    folder : path-like
        A clone of the competition's repository.
    name : str
        The map: ``"env1"`` to ``"env7"``.

    Returns
    -------
    Environment
        The free cells inside of the building, 10 cm each, in metres with the lower left corner of
        the map at the origin.

    Raises
    ------
    InvalidInputError
        If the folder is not a clone, or has no such map.

    Examples
    --------
    >>> competition_environment("elsewhere", "env3")
    Traceback (most recent call last):
        ...
    multisrt.geometry.errors.InvalidInputError: elsewhere is not a clone of the competition: ...
    """
    return Clone(Path(folder), any_version=True).environment(name)
