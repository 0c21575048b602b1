"""Words for what a recording holds, as `multisrt.explain.srt` tells it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from multisrt.events import (
    AnyEvent,
    Blocked,
    CameBack,
    Died,
    FellSilent,
    Joined,
    NodeName,
    TakenAsLost,
)

SAME_MOMENT_S = 1e-6
"""A time may be asked for as it is printed."""


def troubles(events: Iterable[AnyEvent]) -> Iterator[str]:
    """Tell what went otherwise than planned with a robot."""
    for event in events:
        match event:
            case TakenAsLost(other=other):
                what = f"it took robot {other} as lost: no answer came"
            case Blocked(by=by, configuration=(x, y, _)):
                what = f"protective stop at {place((x, y))}, before the body of robot {by}"
            case FellSilent():
                what = "its radio failed"
            case CameBack():
                what = "its radio worked again"
            case Joined():
                what = "it began, late"
            case Died(configuration=(x, y, _), doing=doing):
                doing_what = "organising as master" if doing == "master" else doing
                what = f"it died at {place((x, y))}, {doing_what}"
            case _:
                continue
        yield f"{event.time_s:.2f} s: {what}"


def titled(title: str, lines: Iterable[str]) -> Iterator[str]:
    """Give a section, if there is anything in it."""
    told = [f"  {line}" for line in lines]
    if told:
        yield from ("", title, *told)


def by_robot(nodes: Iterable[NodeName]) -> str:
    """Say how many nodes are of which robot."""
    of_whom = Counter(name[0] for name in nodes)
    return ", ".join(f"{n} of robot {who}" for who, n in sorted(of_whom.items()))


def place(point: Sequence[float]) -> str:
    """Write a place."""
    return f"({point[0]:.2f}, {point[1]:.2f})"


def listed(robots: Sequence[int]) -> str:
    """Write the numbers of robots."""
    return ", ".join(map(str, robots)) or "none"


def many(count: int, what: str) -> str:
    """Write a number of things."""
    return f"{count} {what}" + ("" if count == 1 else "s")
