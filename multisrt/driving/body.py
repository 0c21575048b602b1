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
        At least one message, each as `send` was given it, in the order in which they arrived.
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
        Takes a `Move`: the trajectory to follow and the guard distance. Either it returns when
        the motion has ended, with where, when, and before which body (`Moved`); or it begins the
        motion and returns None, and `receive` tells its end.
    send : callable or None
        Takes a message as bytes and the number of the robot that it is for, or None for all.
        None: the robot has no radio.
    receive : callable or None
        Takes a time of the clock, which may be infinite. It returns `Arrived` when messages have
        come, `Moved` when a motion has ended, `TimedOut` when that time has come, or None if
        none of these has happened yet: then it is called again. It may wait. None: nothing ever
        comes.
    look : callable or None
        Takes nothing; returns a `Sighting` of each other robot that is seen. None: there are no
        others, or they are not seen.
    stop : callable or None
        Takes nothing; ends the present motion and returns `Moved`. It is needed if `move`
        returns None and the explorer stops on the way.
    """

    sense: Callable[[], Scan]
    move: Callable[[Move], Moved | None]
    send: Callable[[bytes, int | None], object] | None = None
    receive: Callable[[float], Told] | None = None
    look: Callable[[], Iterable[Sighting]] | None = None
    stop: Callable[[], Moved] | None = None
