"""A clock that is set back again and again; Python imports it if its folder is in PYTHONPATH.

`CLOCK_JUMPS` holds the times since the process began (s) at which the clock is set back by an hour.
Monotonic clocks and those of processors go on, as they do if somebody sets the clock of a machine.
Each process adds its number to the file `CLOCK_LOG`.
"""

import datetime
import os
import time

BACK_S = 3600.0
"""What the clock is set back by, each time (s)."""

_JUMPS = tuple(float(word) for word in os.environ["CLOCK_JUMPS"].split())
_BEGIN_S = time.monotonic()
_TRUE = time.time


def shifted_s() -> float:
    """Return the time of the clock (s)."""
    since_s = time.monotonic() - _BEGIN_S
    return _TRUE() - BACK_S * sum(jump_s <= since_s for jump_s in _JUMPS)


class Datetime(datetime.datetime):
    """Dates and times whose present is that of the clock."""

    @classmethod
    def now(cls, tz: datetime.tzinfo | None = None) -> "Datetime":
        """Return the present."""
        return cls.fromtimestamp(shifted_s(), tz)

    @classmethod
    def today(cls) -> "Datetime":
        """Return the present, in local time."""
        return cls.now()

    @classmethod
    def utcnow(cls) -> "Datetime":
        """Return the present, in UTC and without a zone."""
        return cls.now(datetime.UTC).replace(tzinfo=None)


time.time = shifted_s
time.time_ns = lambda: int(shifted_s() * 1e9)
datetime.datetime = Datetime  # type: ignore[misc]
with open(os.environ["CLOCK_LOG"], "a") as log:
    log.write(f"{os.getpid()}\n")
