"""What of a run is written, by a word or else by the suffix of the file."""

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
"""All of a run, where robots were, what they knew, their trees, or the true world."""

SUFFIXES: Final[Mapping[What, Mapping[str, object]]] = {
    "run": FORMATS,
    "trajectories": TRAJECTORY_FORMATS,
    "map": MAP_SUFFIXES,
    "tree": TREE_FORMATS,
    "world": MAP_SUFFIXES,
}
"""Suffixes of files by what they hold. Without a word a suffix means the first that has it."""


def what_of(path: Path, what: What | None = None) -> What:
    """Return what of a run a file is to hold.

    Parameters
    ----------
    path : Path
        The file.
    what : str, optional
        A word, if one was given.

    Raises
    ------
    InvalidInputError
        If no such thing is written in the format that the suffix says.

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
    said = f"{suffix!r} is no format of exports" if suffix else "no suffix says the format"
    listed = "; ".join(f"{one}: {' '.join(SUFFIXES[one])}" for one in SUFFIXES if one != "world")
    raise InvalidInputError(f"{path}: {said}{did_you_mean(suffix, known)}; {listed}")


def options_of(path: Path, what: What) -> frozenset[str]:
    """Return the names of the options that such a file takes."""
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
