"""The content of a run that a file holds, by name or else by the suffix of the file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final, Literal

from multisrt.exporting.export import FORMATS
from multisrt.exporting.trajectories import TRAJECTORY_FORMATS
from multisrt.exporting.trees import TREE_FORMATS
from multisrt.exporting.worlds import MAP_SUFFIXES, map_writer
from multisrt.exporting.written import require_suffix
from multisrt.geometry.errors import InvalidInputError, did_you_mean

What = Literal["run", "trajectories", "map", "tree", "world"]
"""The whole run, poses of robots, what robots knew, their trees, or the true world."""

SUFFIXES: Final[Mapping[What, Mapping[str, object]]] = {
    "run": FORMATS,
    "trajectories": TRAJECTORY_FORMATS,
    "map": MAP_SUFFIXES,
    "tree": TREE_FORMATS,
    "world": MAP_SUFFIXES,
}
"""Suffixes of files by their content. Without a name, a suffix means the first that has it."""


def what_of(path: Path, what: What | None = None) -> What:
    """Return the content of a run that a file is to hold.

    Parameters
    ----------
    path : Path
        The file.
    what : str, optional
        Name of the content, if one was given.

    Raises
    ------
    InvalidInputError
        If no content, or not this one, is written in the format of the suffix.

    Examples
    --------
    >>> what_of(Path("a.csv")), what_of(Path("a.geojson")), what_of(Path("a.geojson"), "tree")
    ('trajectories', 'map', 'tree')
    """
    if what is not None:
        require_suffix(path, SUFFIXES[what], _PLURALS[what])
        return what
    suffix = path.suffix.lower()
    for one, suffixes in SUFFIXES.items():
        if suffix in suffixes:
            return one
    known = {suffix: None for suffixes in SUFFIXES.values() for suffix in suffixes}
    said = f"{suffix!r} is no format of exports" if suffix else "no suffix determines the format"
    listed = "; ".join(f"{one}: {' '.join(SUFFIXES[one])}" for one in SUFFIXES if one != "world")
    raise InvalidInputError(f"{path}: {said}{did_you_mean(suffix, known)}; {listed}")


def options_of(path: Path, what: What) -> frozenset[str]:
    """Return the names of the options that apply to a file with some content."""
    if what in ("map", "world"):
        own = set(map_writer(path).options)
        if "height_m" in own:
            own.add("without")
        return frozenset(own | ({"robot", "time_s"} if what == "map" else set()))
    names = {
        "run": ("rate_hz", "map_interval_s", "cell_m", "without"),
        "trajectories": ("robot", "rate_hz"),
        "tree": ("robot", "time_s"),
    }
    return frozenset(names[what])


_PLURALS: Final[Mapping[What, str]] = {
    "run": "runs",
    "trajectories": "trajectories",
    "map": "maps",
    "tree": "trees",
    "world": "worlds",
}
