"""Writing a world as a map file, in a format chosen by the suffix of the file."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from multisrt.environments.environment import Environment
from multisrt.exporting.polygon_text import geojson_bytes, wkt_bytes
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.recording import atomic_write


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldFormat:
    """A format in which worlds are written.

    Attributes
    ----------
    name : str
        Its name in messages and tables.
    suffixes : tuple of str
        Suffixes of its files in lower case, with the point.
    encoded : callable
        Returns the content of the file of a world.
    """

    name: str
    suffixes: tuple[str, ...]
    encoded: Callable[[Environment], bytes]


WORLD_FORMATS: Final = (
    WorldFormat(name="GeoJSON", suffixes=(".geojson", ".json"), encoded=geojson_bytes),
    WorldFormat(name="well-known text", suffixes=(".wkt",), encoded=wkt_bytes),
)
"""The formats in which worlds are written."""


def save_environment(
    environment: Environment, path: str | Path, *, overwrite: bool = False
) -> None:
    """Write a world as a map file.

    Parameters
    ----------
    environment : Environment
        The world.
    path : str or Path
        The file, whose suffix says the format: ``.geojson`` or ``.json`` for GeoJSON with the
        suggested starts, ``.wkt`` for well-known text, which has free space only. It is written
        completely or not at all. What is read from it has the same coordinates.
    overwrite : bool, optional
        Whether a file that exists is replaced.

    Raises
    ------
    InvalidInputError
        If the suffix is another one, the file exists and is not to be replaced, or it cannot be
        written.

    Examples
    --------
    >>> import multisrt as ms
    >>> save_environment(ms.environment("office"), "office.geojson")
    >>> ms.read_environment("office.geojson") == ms.environment("office")
    True
    """
    path = Path(path)
    encoded = world_format(path).encoded(environment)
    if not overwrite and os.path.lexists(path):
        raise InvalidInputError(f"{path} exists already; name another file, or allow to replace it")
    with atomic_write(path) as file:
        file.write(encoded)


def world_format(path: Path) -> WorldFormat:
    """Return the format that the suffix of a path says.

    Raises
    ------
    InvalidInputError
        If worlds are not written in such a format.
    """
    suffix = path.suffix.lower()
    for known in WORLD_FORMATS:
        if suffix in known.suffixes:
            return known
    suffixes = [suffix for known in WORLD_FORMATS for suffix in known.suffixes]
    said = f"{suffix!r} is no format of worlds" if suffix else "no suffix says the format"
    writable = "; ".join(f"{' '.join(known.suffixes)}: {known.name}" for known in WORLD_FORMATS)
    raise InvalidInputError(f"{path}: {said}{did_you_mean(suffix, suffixes)}; {writable}")
