"""How often robots decided what, and why, from the decisions that they put on record."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from typing import Final, NamedTuple

from multisrt.events import Coordinated, Decided, Decision, GoalChosen
from multisrt.explain.terms import CHOICES, NO_CONFLICT, NO_GOAL, ORDERS
from multisrt.explain.words import one_line
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording

MAX_REASON: Final = 60
"""Upper bound of the characters of a reason; longer ones are cut."""

ANY_NUMBER: Final = "#"
"""Stands for each number in the words of an explorer of your own."""


class Choice(NamedTuple):
    """What a robot decided, and why.

    Attributes
    ----------
    choice : str
        Of the SRT family: the name of `choice` of `Decision`. Of robots that bid for frontiers: the
        rule that chose, or ``no goal``. Of explorers of your own: ``goal`` or ``no goal``. Names
        are those of `multisrt.explain.terms`.
    reason : str
        Of the SRT family: the order of the master if paths conflicted, else ``no conflict``. Of
        robots that bid: `because` of `GoalChosen`. Of explorers of your own: the first line of
        their words, with `ANY_NUMBER` for each number, so that words that differ in numbers only
        are counted together.
    """

    choice: str
    reason: str


def decision_counts(recording: Recording) -> list[Counter[Choice]]:
    """Count the decisions of each robot by what it chose and why.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    list of Counter
        For each robot the number of its events `Decision`, `GoalChosen` and `Decided`, by choice
        and reason.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", strategy="minpos", seed=1)
    >>> (counts,) = decision_counts(run.recording)
    >>> counts[Choice("minpos", "start")]
    1
    """
    counts: list[Counter[Choice]] = [Counter() for _ in recording.spec.robots]
    # The last decision of each robot of the SRT family, until it is known how it was coordinated.
    pending: dict[int, Decision] = {}

    def settle(robot: int, order: str) -> None:
        if (decision := pending.pop(robot, None)) is not None:
            counts[robot][Choice(CHOICES[decision.choice].name, order)] += 1

    for event in recording.events:
        match event:
            case Decision():
                settle(event.robot, NO_CONFLICT)
                pending[event.robot] = event
            case Coordinated():
                settle(event.robot, f"master: {ORDERS[event.order].name}")
            case GoalChosen():
                choice = NO_GOAL if event.goal is None else event.rule
                counts[event.robot][Choice(choice, event.because)] += 1
            case Decided():
                choice = NO_GOAL if event.goal is None else "goal"
                counts[event.robot][Choice(choice, _general(event.text))] += 1
    for robot in sorted(pending):
        settle(robot, NO_CONFLICT)
    return counts


class DecisionRow(NamedTuple):
    """How often the robots of a strategy decided one thing for one reason.

    Attributes
    ----------
    strategy : str
        The strategy.
    choice, reason : str
        See `Choice`.
    counts : tuple of int
        One for each robot that counts, summed over the runs of the strategy.
    share : float
        Share of all decisions of these robots, from 0 to 1.
    """

    strategy: str
    choice: str
    reason: str
    counts: tuple[int, ...]
    share: float

    @property
    def total(self) -> int:
        """The sum over all robots."""
        return sum(self.counts)


def decision_rows(
    recordings: Sequence[Recording], robots: Sequence[int] | None = None
) -> list[DecisionRow]:
    """Return the table of the decisions of several runs.

    Parameters
    ----------
    recordings : sequence of Recording
        The runs; those of one strategy are added up.
    robots : sequence of int, optional
        The robots whose decisions count; by default all of the largest team.

    Returns
    -------
    list of DecisionRow
        Strategies in the order of their first run; of each the most frequent decisions first.
        Each row has a count for each robot, also for those that its team lacks.

    Raises
    ------
    InvalidInputError
        If the runs hold no decision.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", strategy="minpos", robots=2, seed=1)
    >>> rows = decision_rows([run.recording])
    >>> len(rows[0].counts), round(sum(row.share for row in rows), 9)
    (2, 1.0)
    """
    if robots is None:
        robots = range(max((len(recording.spec.robots) for recording in recordings), default=0))
    by_strategy: dict[str, list[Counter[Choice]]] = {}
    for recording in recordings:
        team = by_strategy.setdefault(recording.spec.strategy, [Counter() for _ in robots])
        found = decision_counts(recording)
        for robot, sums in zip(robots, team, strict=True):
            sums.update(found[robot] if robot < len(found) else {})
    rows = []
    for strategy, team in by_strategy.items():
        whole: Counter[Choice] = sum(team, Counter())
        for choice in sorted(whole, key=lambda one: (-whole[one], one)):
            counts = tuple(own[choice] for own in team)
            rows.append(DecisionRow(strategy, *choice, counts, whole[choice] / whole.total()))
    if not rows:
        raise InvalidInputError(
            "the robots put no decision on record in these runs; explorers of your own note "
            "Decided (multisrt.robots.toolkit.decided)"
        )
    return rows


def _general(text: str) -> str:
    # The first line, without what differs from one decision to the next.
    shown = one_line(next(iter(text.splitlines()), ""))
    plain = re.sub(r"[-+]?\d+(?:[.,]\d+)*(?:[eE][-+]?\d+)?", ANY_NUMBER, shown)
    return plain if len(plain) <= MAX_REASON else plain[: MAX_REASON - 1] + "…"
