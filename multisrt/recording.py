"""Recordings: all that happened in a run, one JSON object a line, written while the run goes on.

The first line is a `Header`: the format and its version, the spec, the world, and the versions of
the packages. The events of `multisrt.events` follow in the order in which they were recorded. The
last line is a `Footer`: how the run ended, and the digest. A recording without a footer is of a
run that was cut off.

The digest is the SHA-256 of the spec, the world and every event line: equal specs give equal
digests, in any process and on any machine of the same architecture with the same packages.
"""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import IO, Any, Literal, TypeVar

import msgspec
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import (
    AnyEvent,
    Event,
    NodeAdded,
    NodeName,
)
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording_flaws import flaw_of, order_flaws
from multisrt.spec import RunSpec

FORMAT = "multisrt-recording"
VERSION = 4
READABLE = (3, VERSION)
"""Versions that are read: 3 has all that 4 has but the decisions of explorers of one's own."""
MAX_BYTES = 2_000_000_000
"""Size of the largest file that is read."""

RunOutcome = Literal["complete", "stalled", "out_of_time"]

EventT = TypeVar("EventT", bound=Event)

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


@dataclass(frozen=True, slots=True, weakref_slot=True, kw_only=True, eq=False)
class Recording:
    """All that happened in a run.

    Attributes
    ----------
    header : Header
        What was run.
    events : tuple of Event
        What happened, in the order in which it was recorded: a motion when it ended, all else
        when it happened.
    footer : Footer
        How it ended.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, Recording, RunSpec, simulate
    >>> from multisrt.events import NodeAdded
    >>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
    >>> recording.of(NodeAdded)[0].stage
    'root'
    >>> recording.save("recording.jsonl")
    >>> Recording.load("recording.jsonl").footer.digest == recording.footer.digest
    True
    """

    header: Header
    events: tuple[AnyEvent, ...]
    footer: Footer
    _by_kind: dict[type, list[Any]] = field(init=False, repr=False, default_factory=dict)
    _regions: dict[NodeName, FloatArray] = field(init=False, repr=False, default_factory=dict)

    def of(self, kind: type[EventT]) -> Sequence[EventT]:
        """Return the events of a class, in the order of the recording.

        Parameters
        ----------
        kind : type
            A class of `multisrt.events`, such as `Motion`.

        Returns
        -------
        sequence of Event
            The events; empty if there are none.
        """
        if not self._by_kind:
            for event in self.events:
                self._by_kind.setdefault(type(event), []).append(event)
        return self._by_kind.get(kind, [])

    def region(self, node: NodeAdded) -> FloatArray:
        """Return the corners of the region of a node.

        Parameters
        ----------
        node : NodeAdded
            An event of this recording.

        Returns
        -------
        (n, 2) array
            Metres, counter-clockwise, not closed; the same array at every call.
        """
        name = node.robot, node.serial
        if name not in self._regions:
            self._regions[name] = node.region()
        return self._regions[name]

    @property
    def spec(self) -> RunSpec:
        """Everything that the run depends on."""
        return self.header.spec

    @property
    def starts(self) -> tuple[Configuration, ...]:
        """Where the robots started."""
        return tuple(Configuration(*start) for start in self.header.starts)

    def environment(self) -> Environment:
        """Return the world that was explored, built anew.

        Returns
        -------
        Environment
            The world, without suggested starts.

        Raises
        ------
        InvalidInputError
            If the free space of the header is not valid.
        """
        world, free = self.header.world, self.header.free
        try:
            parts = [shapely.Polygon(rings[0], rings[1:]) for rings in free]
        except (IndexError, ValueError, shapely.errors.ShapelyError) as error:
            raise InvalidInputError(f"environment {world!r} of the recording: {error}") from None
        return Environment(world, shapely.MultiPolygon(parts))

    def save(self, path: str | Path) -> None:
        """Write the recording to a file, completely or not at all.

        Parameters
        ----------
        path : str or Path
            The file; it is replaced if it exists.

        Raises
        ------
        InvalidInputError
            If the file cannot be written.
        """
        with atomic_write(Path(path)) as file:
            for line in (self.header, *self.events, self.footer):
                file.write(_ENCODER.encode(line) + b"\n")

    @classmethod
    def load(cls, path: str | Path) -> Recording:
        """Read a recording.

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        Recording
            The recording.

        Raises
        ------
        InvalidInputError
            If the file cannot be read, is not a recording, is of a run that was cut off, or was
            changed after the run; the message names the line, or the digests that differ.
        """
        path = Path(path)
        try:
            if path.stat().st_size > MAX_BYTES:
                raise InvalidInputError(
                    f"{path}: larger than {MAX_BYTES} bytes, which no recording is"
                )
            with path.open("rb") as file:
                return cls._parse(file, path)
        except OSError as error:
            raise InvalidInputError(f"{path}: {error.strerror or error}") from None

    @classmethod
    def _parse(cls, file: IO[bytes], path: Path) -> Recording:
        decoder = msgspec.json.Decoder(Header | AnyEvent | Footer)
        lines: list[Header | AnyEvent | Footer] = []
        for number, text in enumerate(file, 1):
            try:
                lines.append(decoder.decode(text))
            except (msgspec.MsgspecError, ValueError, RecursionError) as error:
                raise InvalidInputError(
                    f"{path}, line {number}: not a line of a recording: {error}"
                ) from None
            if number == 1:
                _require_header(lines[0], path)
        if not lines:
            raise InvalidInputError(f"{path}: not a recording: its first line is no header")
        header = lines[0]
        assert isinstance(header, Header)
        if not isinstance(footer := lines[-1], Footer):
            raise InvalidInputError(f"{path}: the run was cut off: the last line is missing")
        events = tuple(e for e in lines[1:-1] if not isinstance(e, Header | Footer))
        if len(events) != len(lines) - 2:
            raise InvalidInputError(f"{path}: a header or an end stands among the events")
        if len(header.starts) != len(header.spec.robots):
            raise InvalidInputError(
                f"{path}, line 1: {len(header.starts)} starts for {len(header.spec.robots)} robots"
            )
        nodes = {(event.robot, event.serial) for event in events if isinstance(event, NodeAdded)}
        for number, event in enumerate(events, 2):
            if flaw := flaw_of(event, header.spec.robots, nodes):
                raise InvalidInputError(f"{path}, line {number}: {flaw}")
        for number, flaw in order_flaws(events, footer.time_s):
            raise InvalidInputError(f"{path}, line {number + 2}: {flaw}")
        if (digest := _digest(header, events)) != footer.digest:
            raise InvalidInputError(
                f"{path}: its last line says digest {footer.digest[:12]}..., but its contents have "
                f"{digest[:12]}...: the file was changed after the run; run its spec again"
            )
        return cls(header=header, events=events, footer=footer)


def _require_header(line: Header | AnyEvent | Footer, path: Path) -> None:
    if not isinstance(line, Header) or line.format != FORMAT:
        raise InvalidInputError(f"{path}: not a recording: its first line is no header")
    if line.format_version not in READABLE:
        raise InvalidInputError(
            f"{path}: format version {line.format_version}; this program reads "
            f"{' and '.join(map(str, READABLE))}: make the run again from its spec"
        )


_ENCODER = msgspec.json.Encoder()


def _digest(header: Header, events: Iterable[AnyEvent]) -> str:
    digest = hashlib.sha256()
    for part in (header.spec, header.free, header.starts, *events):
        digest.update(_ENCODER.encode(part) + b"\n")
    return digest.hexdigest()


@dataclass(slots=True)
class Recorder:
    """Records the events of a run as they happen, and writes them to a file if there is one.

    Parameters
    ----------
    header : Header
        What is run.
    file : binary file, optional
        Where to write.
    """

    header: Header
    file: IO[bytes] | None = None
    events: list[AnyEvent] = field(default_factory=list)
    _digest: hashlib._Hash = field(default_factory=hashlib.sha256)

    def __post_init__(self) -> None:
        self._write(_ENCODER.encode(self.header))
        for part in (self.header.spec, self.header.free, self.header.starts):
            self._digest.update(_ENCODER.encode(part) + b"\n")

    def record(self, event: AnyEvent) -> None:
        """Record an event."""
        line = _ENCODER.encode(event)
        self._digest.update(line + b"\n")
        self.events.append(event)
        self._write(line)

    def finish(
        self, time_s: float, outcome: RunOutcome, reason: str, *, chance: bool = True
    ) -> Recording:
        """Write the footer, and return the recording."""
        footer = Footer(
            time_s=time_s,
            outcome=outcome,
            reason=reason,
            chance=chance,
            digest=self._digest.hexdigest(),
        )
        self._write(_ENCODER.encode(footer))
        return Recording(header=self.header, events=tuple(self.events), footer=footer)

    def cut_off(
        self, time_s: float, reason: str, under_way: Iterable[AnyEvent], *, chance: bool
    ) -> Recording:
        """Return the recording of a run that is cut off at a time, and record on.

        Parameters
        ----------
        time_s : float
            The time now, in seconds.
        reason : str
            Why the run is cut off.
        under_way : iterable of Event
            What has begun and is not recorded yet.
        chance : bool
            Whether a random number was drawn.
        """
        events, digest = list(self.events), self._digest.copy()
        for event in under_way:
            events.append(event)
            digest.update(_ENCODER.encode(event) + b"\n")
        footer = Footer(
            time_s=time_s,
            outcome="out_of_time",
            reason=reason,
            chance=chance,
            digest=digest.hexdigest(),
        )
        return Recording(header=self.header, events=tuple(events), footer=footer)

    def _write(self, line: bytes) -> None:
        if self.file is not None:
            self.file.write(line + b"\n")


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


@contextmanager
def atomic_write(path: Path) -> Iterator[IO[bytes]]:
    """Open a file for writing that gets its name only when it has been written completely.

    Raises
    ------
    InvalidInputError
        If it cannot be written; no part of it is left behind.
    """
    if not path.name:
        raise InvalidInputError(f"cannot write {path}: it is a folder; name a file")
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            yield file
        os.replace(part, path)
    except BaseException as error:
        with suppress(OSError):
            part.unlink()
        if isinstance(error, OSError):
            raise InvalidInputError(f"cannot write {path}: {error.strerror or error}") from None
        raise
