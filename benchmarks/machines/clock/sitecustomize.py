"""A clock that is set back again and again; Python imports it if its folder is in PYTHONPATH.

`CLOCK_JUMPS` holds the times since the process began (s) at which the clock is set back by an hour.
Monotonic clocks and those of processors go on, as they do if somebody sets the clock of a machine.
The class `datetime` is written in C, as libraries demand, and has a clock of its own.
Each process adds its number to the file `CLOCK_LOG`.
"""

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


time.time = shifted_s
time.time_ns = lambda: int(shifted_s() * 1e9)
with open(os.environ["CLOCK_LOG"], "a") as log:
    log.write(f"{os.getpid()}\n")
