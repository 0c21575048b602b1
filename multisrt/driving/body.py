"""The callables that command a body, and what they receive and return."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import msgspec

from multisrt.geometry.regions.scan import Scan
from multisrt.robots.explorer import Move, Moved, Sighting, TimedOut


class Arrived(msgspec.Struct, frozen=True, kw_only=True):
    """Messages that have arrived by radio.

    Attributes
    ----------
    data : tuple of bytes
        At least one message, each as it was passed to `send`, in the order of arrival.
    time_s : float
        When the last of them arrived, in seconds.
    """

    data: tuple[bytes, ...]
    time_s: float


Told = Moved | Arrived | TimedOut | None
"""What `receive` returns."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """The callables that command a robot: its sensor, its drive and its radio.

    All places are in one frame, in metres and radians, and all times in seconds of one clock,
    which never runs backwards.

    Attributes
    ----------
    sense : callable
        Takes nothing; returns a scan. `scan_of_ranges` and `scan_of_polygon` make one.
    move : callable
        Takes a `Move`: the trajectory to follow and the guard distance. Either it returns a `Moved`
        when the motion has ended (its place, its time and the body that blocked it), or it starts
        the motion and returns None; `receive` then reports its end.
    send : callable or None
        Takes a message as bytes and the number of the receiving robot, or None for all. None: the
        robot has no radio.
    receive : callable or None
        Takes a time of the clock, which may be infinite. It returns `Arrived` when messages have
        arrived, `Moved` when a motion has ended, `TimedOut` at that time, or None if none of these
        has happened yet, in which case it is called again. It may wait. None: no message ever
        arrives.
    look : callable or None
        Takes nothing; returns a `Sighting` of each visible robot. None: there are no other robots,
        or they cannot be detected.
    stop : callable or None
        Takes nothing; ends the present motion and returns `Moved`. Needed if `move` returns None
        and the explorer stops motions.
    """

    sense: Callable[[], Scan]
    move: Callable[[Move], Moved | None]
    send: Callable[[bytes, int | None], object] | None = None
    receive: Callable[[float], Told] | None = None
    look: Callable[[], Iterable[Sighting]] | None = None
    stop: Callable[[], Moved] | None = None
