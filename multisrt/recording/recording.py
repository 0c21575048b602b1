"""The recording of a run, in memory and in its file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, TypeVar

import msgspec
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent, Event, NodeAdded, NodeName
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import MAX_REASON, InvalidInputError, reason_of, shortened, shown
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording.files import atomic_write
from multisrt.recording.flaws import flaw_of, order_flaws
from multisrt.recording.lines import ENCODER, FORMAT, READABLE, Footer, Header, digest_of
from multisrt.spec import RunSpec

MAX_BYTES = 2_000_000_000
"""Size of the largest file that is read."""

EventT = TypeVar("EventT", bound=Event)


@dataclass(frozen=True, slots=True, weakref_slot=True, kw_only=True, eq=False)
class Recording:
    """All events of a run.

    Attributes
    ----------
    header : Header
        The spec, the world and the versions of packages.
    events : tuple of Event
        The events in the order in which they were recorded: motions at their end, all others when
        they happen.
    footer : Footer
        How the run ended.

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
        """The spec of the run."""
        return self.header.spec

    @property
    def starts(self) -> tuple[Configuration, ...]:
        """Starts of the robots."""
        return tuple(Configuration(*start) for start in self.header.starts)

    def environment(self) -> Environment:
        """Return the world that was explored.

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
            raise InvalidInputError(
                f"environment {shown(world)} of the recording: {reason_of(error)}"
            ) from None
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
                file.write(ENCODER.encode(line) + b"\n")

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
            If the file cannot be read, is not a recording, is of an interrupted run, or was
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
            raise InvalidInputError(f"{path}: {reason_of(error)}") from None

    @classmethod
    def _parse(cls, file: IO[bytes], path: Path) -> Recording:
        decoder = msgspec.json.Decoder(Header | AnyEvent | Footer)
        lines: list[Header | AnyEvent | Footer] = []
        for number, text in enumerate(file, 1):
            try:
                lines.append(decoder.decode(text))
            except (msgspec.MsgspecError, ValueError, RecursionError) as error:
                if number == 1 and not _claims_to_be_header(text):
                    raise _no_header(path) from None
                raise InvalidInputError(
                    f"{path}, line {number}: not a line of a recording: {reason_of(error)}"
                ) from None
            if number == 1:
                _require_header(lines[0], path)
        if not lines:
            raise _no_header(path)
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
            if flaw := flaw_of(event, header.spec, nodes):
                raise InvalidInputError(f"{path}, line {number}: {shortened(flaw, MAX_REASON)}")
        for number, flaw in order_flaws(events, footer.time_s):
            raise InvalidInputError(f"{path}, line {number + 2}: {flaw}")
        if (digest := digest_of(header, events)) != footer.digest:
            raise InvalidInputError(
                f"{path}: its last line says digest {shortened(footer.digest, 15)}, but its "
                f"contents have {digest[:12]}...: the file was changed after the run; run its spec "
                "again"
            )
        return cls(header=header, events=events, footer=footer)


def _claims_to_be_header(text: bytes) -> bool:
    try:
        line = msgspec.json.decode(text)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return False
    return isinstance(line, dict) and line.get("event") == "header"


def _no_header(path: Path) -> InvalidInputError:
    return InvalidInputError(
        f"{path} is not a recording: its first line is no header; name the folder of a run, or "
        "the recording.jsonl in it"
    )


def _require_header(line: Header | AnyEvent | Footer, path: Path) -> None:
    if not isinstance(line, Header) or line.format != FORMAT:
        raise _no_header(path)
    if line.format_version not in READABLE:
        raise InvalidInputError(
            f"{path}: format version {line.format_version}; this program reads "
            f"{', '.join(map(str, READABLE))}: repeat the run from its spec"
        )
