"""Words for the contents of a recording, shared by the explanations of all strategies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from operator import itemgetter

from multisrt.events import (
    AnyEvent,
    ArcClosed,
    ArcReopened,
    Blocked,
    CameBack,
    Collision,
    Coordinated,
    Decided,
    Decision,
    DiagramLeft,
    Died,
    Ended,
    FellSilent,
    GoalChosen,
    Joined,
    MapComplete,
    Motion,
    NodeAdded,
    NodeName,
    Organized,
    PresumedLost,
    Supports,
)
from multisrt.explain.terms import CHOICES, ORDERS, REASONS, stage_name

SAME_MOMENT_S = 1e-6
"""Times that differ by less are the same moment, so that a printed time can be asked for."""


def troubles(events: Iterable[AnyEvent]) -> Iterator[str]:
    """Yield a line, with the time, for each event of a robot that was not planned.

    Consecutive events that are the same in words share a line.
    """
    told = ((event.time_s, trouble(event)) for event in events)
    for what, alike in groupby((each for each in told if each[1]), key=itemgetter(1)):
        first_s, *others_s = (time_s for time_s, _ in alike)
        until = f" to {others_s[-1]:.2f} s, {1 + len(others_s)} times" if others_s else " s"
        yield f"{first_s:.2f}{until}: {what}"


def in_words(event: AnyEvent) -> str:
    """Return what a robot did in an event, or what happened to it, as text.

    Parameters
    ----------
    event : Event
        The event.

    Returns
    -------
    str
        One line, which does not name the robot; empty for scans, messages, and what was learned.

    Examples
    --------
    >>> in_words(Blocked(time_s=2.0, robot=0, by=1, configuration=(1.0, 2.0, 0.0)))
    'protective stop at (1.00, 2.00), before the body of robot 1'
    """
    match event:
        case NodeAdded():
            if event.stage == "scan":
                return f"scan {event.serial} showed something new"
            return f"added node {event.serial} ({stage_name(event.stage)})"
        case Decision():
            return f"decided: {choice_line(event)}"
        case GoalChosen():
            return f"decided: {bid_choice(event)}"
        case Decided():
            return f"decided: {own_choice(event)}"
        case Motion():
            return f"set out {towards(event.waypoints[-1][1:3])}"
        case Supports():
            none = "supports no tree"
            return none if event.tree is None else f"supports the tree of robot {event.tree}"
        case MapComplete():
            return "knows that its map is complete"
        case Ended():
            return f"ended: {event.reason}"
    return _of_team(event) or trouble(event)


def _of_team(event: AnyEvent) -> str:
    match event:
        case Coordinated():
            order = ORDERS[event.order].meaning
            return f"was told by master {event.master} {order}"
        case Organized():
            which = " (deadlock)" if event.deadlock else ""
            return f"organised robots {listed(sorted(event.before))} as their master{which}"
        case ArcClosed():
            return f"gave up a frontier arc: {event.reason}"
        case ArcReopened():
            return "took up a frontier arc again"
        case DiagramLeft():
            return f"follows its path instead of the nearness diagram: {event.because}"
    return ""


def trouble(event: AnyEvent) -> str:
    """Return an event that was not planned in words; empty for other events."""
    match event:
        case PresumedLost(other=other):
            return f"no longer waits for robot {other}, which does not answer"
        case Blocked(by=by, configuration=(x, y, _)):
            return f"protective stop at {place((x, y))}, before the body of robot {by}"
        case FellSilent():
            return "its radio failed"
        case CameBack():
            return "its radio works again"
        case Joined():
            return "was switched on, late"
        case Died(configuration=(x, y, _), doing=doing):
            doing_what = "organising as master" if doing == "master" else doing
            return f"died at {place((x, y))}, {doing_what}"
        case Collision(account=account):
            return f"collided: {account}"
    return ""


def choice_line(choice: Decision) -> str:
    """Return the choice of a robot of the SRT family in one line."""
    goal = "" if choice.target is None else f" {towards(choice.target)}"
    engaged = f", GER {listed(choice.ger)}" if len(choice.ger) > 1 else ""
    return f"{CHOICES[choice.choice].name}{goal}{engaged}"


def bid_choice(choice: GoalChosen) -> str:
    """Return the choice of a robot that bids for frontiers in one line."""
    return f"{choice.rule} {towards(choice.goal)}: {because(choice)}"


def because(choice: GoalChosen) -> str:
    """Return why a robot that bids for frontiers chose a goal, in words."""
    return REASONS.get(choice.because, choice.because)


def own_choice(choice: Decided) -> str:
    """Return a decision that an explorer of your own put on record in one line."""
    return f"{towards(choice.goal)}: {one_line(choice.text)}"


def one_line(text: str) -> str:
    """Return text of others on one line, without characters that would move the cursor."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


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

    Yields
    ------
    str
        The heading, then a line for each decision.
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
