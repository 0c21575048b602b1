"""Words for the contents of a recording, shared by the explanations of all strategies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from multisrt.events import (
    AnyEvent,
    Blocked,
    CameBack,
    Died,
    FellSilent,
    Joined,
    NodeName,
    PresumedLost,
)

SAME_MOMENT_S = 1e-6
"""Times that differ by less are the same moment, so that a printed time can be asked for."""


def troubles(events: Iterable[AnyEvent]) -> Iterator[str]:
    """Yield a line for each event of a robot that was not planned."""
    for event in events:
        if what := trouble(event):
            yield f"{event.time_s:.2f} s: {what}"


def trouble(event: AnyEvent) -> str:
    """Return an event that was not planned in words; empty for other events."""
    match event:
        case PresumedLost(other=other):
            return f"it no longer waited for robot {other}, which did not answer"
        case Blocked(by=by, configuration=(x, y, _)):
            return f"protective stop at {place((x, y))}, before the body of robot {by}"
        case FellSilent():
            return "its radio failed"
        case CameBack():
            return "its radio worked again"
        case Joined():
            return "it was switched on, late"
        case Died(configuration=(x, y, _), doing=doing):
            doing_what = "organising as master" if doing == "master" else doing
            return f"it died at {place((x, y))}, {doing_what}"
    return ""


def titled(title: str, lines: Iterable[str]) -> Iterator[str]:
    """Yield the lines of a section with a title; nothing if it is empty."""
    indented = [f"  {line}" for line in lines]
    if indented:
        yield from ("", title, *indented)


def decision_lines(
    columns: Mapping[str, int], rows: Iterable[tuple[float, tuple[str, ...], str]]
) -> Iterator[str]:
    """Yield a heading and a line for each decision of a robot.

    Parameters
    ----------
    columns : mapping of str to int
        Names and widths, in characters, of the columns between the time and the decision.
    rows : iterable of (time_s, cells, decision)
        When it decided, what is in these columns, and what it decided, in words.
    """
    heads = [f"{name:>{width}}" for name, width in columns.items()]
    yield "  ".join((f"{'time (s)':>9}", *heads, "decision"))
    for time_s, cells, decision in rows:
        aligned = [f"{cell:>{width}}" for cell, width in zip(cells, columns.values(), strict=True)]
        yield "  ".join((f"{time_s:9.2f}", *aligned, decision))


def towards(goal: Sequence[float] | None) -> str:
    """Return where a robot goes, as text."""
    return "no goal" if goal is None else f"to {place(goal)}"


def by_robot(nodes: Iterable[NodeName]) -> str:
    """Return the numbers of nodes by the robot that made them, as text."""
    counts = Counter(robot for robot, _ in nodes)
    return ", ".join(f"{count} of robot {robot}" for robot, count in sorted(counts.items()))


def place(point: Sequence[float]) -> str:
    """Return a position as text, to centimetres."""
    return f"({point[0]:.2f}, {point[1]:.2f})"


def listed(robots: Sequence[int]) -> str:
    """Return the numbers of robots as text; `none` if there are none."""
    return ", ".join(map(str, robots)) or "none"


def many(count: int, what: str) -> str:
    """Return a number of things as text: `1 node`, `2 nodes`."""
    return f"{count} {what}" + ("" if count == 1 else "s")
