"""The lines of a recording: its header, its footer, and the digest of what lies between."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable
from functools import cache
from importlib.metadata import version
from typing import Literal

import msgspec
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent
from multisrt.geometry.configuration import Configuration
from multisrt.spec import RunSpec

FORMAT = "multisrt-recording"
VERSION = 6
READABLE = (3, 4, 5, VERSION)
"""Versions that are read: 5 has all that 6 has but base stations, 4 lacks the ends of steering by
the nearness diagram as well, and 3 the decisions of user-defined explorers."""

WITHOUT_BASE = 5
"""The version of a recording without a base station, which older programs read as well."""

RunOutcome = Literal["complete", "stalled", "out_of_time"]

Ring = tuple[tuple[float, float], ...]


class Header(msgspec.Struct, frozen=True, kw_only=True, tag_field="event", tag="header"):
    """The first line of a recording.

    Attributes
    ----------
    format, format_version
        The format of the file, and its version.
    versions : dict of str to str
        Versions of the packages that computed the run, and the architecture of the machine.
    spec : RunSpec
        Everything that the run depends on.
    world : str
        Name of the world.
    free : tuple of polygons
        Free space. A polygon is a tuple of rings, the outline first, then the holes; a ring is a
        tuple of corners (x, y) in metres, the first and the last of which are equal.
    starts : tuple of (x, y, heading)
        Where the robots started.
    """

    format: str = FORMAT
    format_version: int = VERSION
    versions: dict[str, str]
    spec: RunSpec
    world: str
    free: tuple[tuple[Ring, ...], ...]
    starts: tuple[tuple[float, float, float], ...]


class Footer(msgspec.Struct, frozen=True, kw_only=True, tag_field="event", tag="run_ended"):
    """The last line of a recording.

    Attributes
    ----------
    time_s : float
        When the run ended, in seconds.
    outcome : {"complete", "stalled", "out_of_time"}
        How it ended.
    reason : str
        Why, in words.
    chance : bool
        Whether any random number was drawn in the run. A run without chance is the same for every
        seed.
    digest : str
        SHA-256 of the spec, the world and the events, as 64 hexadecimal digits.
    """

    time_s: float
    outcome: RunOutcome
    reason: str
    chance: bool = True
    digest: str


ENCODER = msgspec.json.Encoder()


def digest_of(header: Header, events: Iterable[AnyEvent]) -> str:
    """Return the digest of a run: of its spec, its world and its events."""
    digest = hashlib.sha256()
    for part in (header.spec, header.free, header.starts, *events):
        digest.update(ENCODER.encode(part) + b"\n")
    return digest.hexdigest()


def header_of(spec: RunSpec, environment: Environment, starts: tuple[Configuration, ...]) -> Header:
    """Return the header of a run."""
    free = tuple(
        tuple(
            tuple(map(tuple, shapely.get_coordinates(ring).tolist()))
            for ring in (part.exterior, *part.interiors)
        )
        for part in environment.free.geoms
    )
    return Header(
        format_version=WITHOUT_BASE if spec.base is None else VERSION,
        versions=_versions(),
        spec=spec.canonical(),
        world=environment.name,
        free=free,
        starts=tuple((*start,) for start in starts),
    )


@cache
def _versions() -> dict[str, str]:
    packages = ("multisrt", "numba", "numpy", "scipy", "shapely", "python-fcl", "simpy")
    versions = {package: version(package) for package in packages}
    versions["geos"] = shapely.geos_version_string
    versions["python"] = platform.python_version()
    versions["architecture"] = platform.machine()
    return versions
