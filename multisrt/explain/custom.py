"""Explanations of the decisions that custom explorers record with `Decided`."""

from __future__ import annotations

import math
from collections.abc import Iterator

from multisrt.events import Decided
from multisrt.explain.story import ChoiceStory
from multisrt.explain.words import decision_lines, many, one_line, own_choice, place
from multisrt.recording import Recording

MAX_ROWS = 12
"""Options that a table shows: the chosen one, and then those with the least first value."""

SAME_PLACE_M = 1e-6
"""An option this near to the goal is the chosen one."""

COLUMN = 12
"""Minimum width of a table column, in characters."""


def own_choice_lines(
    recording: Recording,
    index: int,
    choice: Decided,
    asked_s: float,
    whole: Recording | None = None,
) -> Iterator[str]:
    """Yield the lines that explain one decision, as its explorer recorded it.

    Parameters
    ----------
    recording : Recording
        The run.
    index : int
        Index of the decision among its events.
    choice : Decided
        The decision.
    asked_s : float
        The time that was asked for, in seconds.
    whole : Recording, optional
        The run, if `recording` is the part of it from which the choice is explained.

    Yields
    ------
    str
        A line of the explanation.
    """
    return _OwnStory(recording, index, choice, asked_s, whole).lines()


def own_lines(recording: Recording, robot: int) -> Iterator[str]:
    """Yield a heading and a line for each decision of a robot; nothing without any."""
    decisions = [event for event in recording.of(Decided) if event.robot == robot]
    rows = [(event.time_s, (str(len(event.options)),), own_choice(event)) for event in decisions]
    if rows:
        yield from decision_lines({"options": 7}, rows)


class _OwnStory(ChoiceStory[Decided]):
    """The explanation of one decision."""

    things = "node"
    happened = "its last decision was"

    def sections(self) -> Iterator[tuple[str, Iterator[str]]]:
        yield "Where it stood", self.standing()
        yield "What it knew", self.knowledge()
        yield "What it decided", self.decision()
        yield "What it considered", self.options()
        yield "What it did next", self.afterwards()

    def knowledge(self) -> Iterator[str]:
        yield f"its map had {many(self.own_nodes(), 'node')} that it had made"
        yield from self.learned()
        yield from self.to_deliver()
        yield from self.complete()

    def decision(self) -> Iterator[str]:
        choice = self.choice
        yield from filter(None, map(one_line, choice.text.splitlines()))
        if choice.goal is None:
            yield "no goal"
        else:
            away_m = math.dist(self._pose()[:2], choice.goal)
            yield f"goal {place(choice.goal)}, {away_m:.2f} m away in a straight line"

    def options(self) -> Iterator[str]:
        options, values = self.choice.options, self.choice.values
        if not options:
            return
        chosen = [k for k, option in enumerate(options) if self._is_goal(option)]
        first = next(iter(values.values()), (None,) * len(options))
        shown = sorted(
            range(len(options)),
            key=lambda k: (k not in chosen, math.inf if (v := first[k]) is None else v, k),
        )[:MAX_ROWS]
        wide = [max(COLUMN, len(one_line(name)) + 2) for name in values]
        named = zip(map(one_line, values), wide, strict=True)
        yield f"  {'place':>16}" + "".join(f"{name:>{width}}" for name, width in named)
        for k in shown:
            row = zip((column[k] for column in values.values()), wide, strict=True)
            yield f"{'*' if k in chosen else ' '} {place(options[k]):>16}" + "".join(
                f"{'-' if value is None else f'{value:.2f}':>{width}}" for value, width in row
            )
        if len(options) > len(shown):
            yield f"and {many(len(options) - len(shown), 'more option')}"

    def afterwards(self) -> Iterator[str]:
        yield from super().afterwards()
        if self.next is not None:
            yield f"at {self.next.time_s:.2f} s it decided again"

    def _is_goal(self, option: tuple[float, float]) -> bool:
        goal = self.choice.goal
        return goal is not None and math.dist(option, goal) <= SAME_PLACE_M
