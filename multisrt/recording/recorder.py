"""Recording a run in progress."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import IO

import msgspec

from multisrt.events import AnyEvent, GoalChosen, Learned, NodeName
from multisrt.events.event import Point
from multisrt.recording.lines import ENCODER, Footer, Header, RunOutcome
from multisrt.recording.recording import Recording


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
    _places: dict[Point, Point] = field(init=False, default_factory=dict)
    _names: dict[tuple[NodeName, ...], tuple[NodeName, ...]] = field(
        init=False, default_factory=dict
    )

    def __post_init__(self) -> None:
        self._write(ENCODER.encode(self.header))
        for part in (self.header.spec, self.header.free, self.header.starts):
            self._digest.update(ENCODER.encode(part) + b"\n")

    def record(self, event: AnyEvent) -> None:
        """Record an event."""
        line = ENCODER.encode(event)
        self._digest.update(line + b"\n")
        self.events.append(self._compact(event))
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
        self._write(ENCODER.encode(footer))
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
            digest.update(ENCODER.encode(event) + b"\n")
        footer = Footer(
            time_s=time_s,
            outcome="out_of_time",
            reason=reason,
            chance=chance,
            digest=digest.hexdigest(),
        )
        return Recording(header=self.header, events=tuple(events), footer=footer)

    def _compact(self, event: AnyEvent) -> AnyEvent:
        # A recording of a large team holds millions of places and of names of nodes, but few
        # different ones: equal places, and equal tuples of names, are stored once.
        try:
            match event:
                case GoalChosen():
                    places, own = self._places, event.frontiers
                    frontiers = tuple([places.setdefault(place, place) for place in own])
                    return msgspec.structs.replace(event, frontiers=frontiers)
                case Learned():
                    nodes = self._names.setdefault(event.nodes, event.nodes)
                    return msgspec.structs.replace(event, nodes=nodes)
        except TypeError:
            # Explorers of others may note lists in place of tuples.
            pass
        return event

    def _write(self, line: bytes) -> None:
        if self.file is not None:
            self.file.write(line + b"\n")
