"""Why a robot that bids for frontiers went where it did: its choices of goals in words."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from typing import Final

from multisrt.events import Decided, GoalChosen
from multisrt.explain.story import ChoiceStory
from multisrt.explain.terms import RULES
from multisrt.explain.words import because, bid_choice, decision_lines, many, place
from multisrt.recording import Recording
from multisrt.robots.naming import named_robots

MAX_COLUMNS = 6
"""Frontiers that a table shows: of more, the chosen one, those on its route and the nearest."""

MAX_ROWS = 12
"""Rounds of an assignment, and best cells, that are shown."""

ALSO: Final = {
    "in-time": " and come home from in time",
    "worth": " and come home from in time",
    "relays": " and come home from in time",
    "chain": " and from which the chain reaches the base station",
}
"""What else is asked of goals, by the option `home`."""

LEFT_OUT: Final = {
    "in-time": "there is no time to go there and home",
    "worth": "there is no time to go there and home",
    "relays": "there is no time to go there and home",
    "chain": "the chain does not reach the base station from there",
}
"""What else a frontier without a length in a robot's own row may mean, by the option `home`."""

COLUMN = 10
"""Width of a table column, in characters."""

WIDTH: Final = 11 * (MAX_COLUMNS + 1)
"""Width of a whole table, in characters, at which routes are wrapped."""


def choice_lines(
    recording: Recording,
    index: int,
    choice: GoalChosen,
    asked_s: float,
    whole: Recording | None = None,
) -> Iterator[str]:
    """Yield the lines that explain one choice of a goal.

    Parameters
    ----------
    recording : Recording
        The run.
    index : int
        Index of the choice among its events.
    choice : GoalChosen
        The choice.
    asked_s : float
        The time that was asked for, in seconds.
    whole : Recording, optional
        The run, if `recording` is the part of it from which the choice is explained.

    Yields
    ------
    str
        A line of the explanation.
    """
    return _BidStory(recording, index, choice, asked_s, whole).lines()


def bid_lines(recording: Recording, robot: int) -> Iterator[str]:
    """Yield a heading and a line for each choice of a goal by a robot; nothing without any."""
    rows = []
    for choice in recording.of(GoalChosen):
        if choice.robot == robot:
            length = "" if choice.goal is None else f"{choice.cost_m:.2f} m"
            rows.append((choice.time_s, (str(len(choice.frontiers)), length), bid_choice(choice)))
    if rows:
        yield from decision_lines({"frontiers": 9, "path": 9}, rows)


class _BidStory(ChoiceStory[GoalChosen]):
    """The explanation of one choice of a goal."""

    happened = "it last chose a goal"

    def sections(self) -> Iterator[tuple[str, Iterator[str]]]:
        yield "Where it stood", self.standing()
        yield "What it knew", self.knowledge()
        yield "Why it chose again", self.reason()
        yield f"How it chose: {self.choice.rule}", self.rule()
        yield "What it chose", self.goal()
        yield "What it did next", self.afterwards()

    def knowledge(self) -> Iterator[str]:
        yield f"its map had {many(self.own_nodes(), 'scan')} of its own that showed something new"
        yield from self.learned()
        yield from self.to_deliver()
        yield f"{many(len(self.choice.frontiers), 'frontier')} wide enough to go to"
        if len(self.team) > 1 and self.choice.robots:
            others = [robot for robot in self.choice.robots if robot != self.robot]
            without = [r for r in self.team if r != self.robot and r not in others]
            told = f"it considered {named_robots(others) if others else 'no other robot'}"
            if without and self.choice.rule != "closest":
                told += f"; not {named_robots(without)}, idle or not heard from lately"
            yield told
        yield from self.complete()

    def reason(self) -> Iterator[str]:
        yield f"{self.choice.because}: {because(self.choice)}"
        errands = [event for event in self.before if isinstance(event, Decided)]
        if errands and self.choice.because.startswith("errand"):
            yield f"the errand, from {errands[-1].time_s:.2f} s on: {errands[-1].text}"
        last = [event for event in self.before if isinstance(event, GoalChosen)]
        if last:
            goal = last[-1].goal
            where = "it had no goal" if goal is None else f"its goal was {place(goal)}"
            yield f"before, since {last[-1].time_s:.2f} s, {where}"

    def rule(self) -> Iterator[str]:
        choice = self.choice
        yield RULES.get(choice.rule, choice.rule)
        below_m2 = self.whole.spec.options.get("routes_below_m2")
        if below_m2 and choice.rule == "routes":
            yield f"as no frontier that it can go to has {below_m2:g} m2 in sight"
        if choice.rule == "closest" and choice.frontiers:
            yield "only the path to the nearest frontier is computed"
        yield from self._tables()
        yield from self._routes() if choice.rule == "routes" else self._rounds()
        if choice.rule == "utility" and choice.costs and not choice.rounds and choice.goal:
            yield "its leader knew no goal for it that is a frontier on its own map: the nearest"
        if choice.phi_m:
            radii = ", ".join(f"{radius:.1f}" for radius in choice.phi_m)
            yield f"cohesion radii that were tried (phi): {radii} m; the last one was used"
        yield from self._scores()

    def goal(self) -> Iterator[str]:
        choice = self.choice
        if choice.goal is None:
            also = ALSO.get(self.home, "") if choice.frontiers else ""
            yield f"no goal: there is none that it can reach{also}"
            return
        number = self._chosen()
        which = "" if number is None else f"frontier {number}, "
        yield f"{which}{place(choice.goal)}, {choice.cost_m:.2f} m away"

    def afterwards(self) -> Iterator[str]:
        yield from super().afterwards()
        if isinstance(self.next, GoalChosen):
            yield f"at {self.next.time_s:.2f} s it chose again: {because(self.next)}"

    def _chosen(self) -> int | None:
        # The column of the goal; a cell that `rules` chose has none.
        goal = self.choice.goal
        return self.choice.frontiers.index(goal) if goal in self.choice.frontiers else None

    # Tables ---------------------------------------------------------------------------------

    def _tables(self) -> Iterator[str]:
        choice = self.choice
        if not choice.frontiers or not choice.costs:
            return
        shown = self._columns()
        left_out = len(choice.frontiers) - len(shown)
        if left_out:
            yield f"{left_out} of {len(choice.frontiers)} frontiers are not shown"
        yield ">: its own row, *: its choice, -: no path or not computed"
        if self.home in LEFT_OUT:
            yield f"a frontier with a length may be left out, too: {LEFT_OUT[self.home]}"
        yield self._row("frontier", [f"{k}{'*' * (k == self._chosen())}" for k in shown])
        yield self._row("x (m)", [f"{choice.frontiers[k][0]:.2f}" for k in shown])
        yield self._row("y (m)", [f"{choice.frontiers[k][1]:.2f}" for k in shown])
        if choice.ranks:
            yield "path length of each robot (m), and how many robots are nearer than it"
            for robot, costs, ranks in zip(choice.robots, choice.costs, choice.ranks, strict=True):
                cells = [_metres(costs[k]) + _rank(ranks[k]) for k in shown]
                yield self._row(self._name(robot), cells)
            return
        yield (
            "path length of each robot by way of its present goal (m)"
            if choice.rule == "self-bidding"
            else "path length of each robot (m)"
        )
        yield from self._rows(choice.costs, shown)
        if choice.bids:
            yield "bids that were matched (m); -: too far from the others, or no path"
            yield from self._rows(choice.bids, shown)

    def _rows(self, table: Sequence[Sequence[float | None]], shown: Sequence[int]) -> Iterator[str]:
        for robot, values in zip(self.choice.robots, table, strict=True):
            yield self._row(self._name(robot), [_metres(values[k]) for k in shown])

    def _columns(self) -> list[int]:
        # The chosen one, the stops of its own route and the nearest, in the order of the table.
        choice = self.choice
        own = choice.costs[choice.robots.index(self.robot)]
        stops = [target for robot, target, *_ in choice.rounds if robot == self.robot]
        first = [self._chosen(), *(stops if choice.rule == "routes" else ())]
        rest = sorted(
            set(range(len(own))).difference(first),
            key=lambda k: (math.inf if (cost := own[k]) is None else cost, k),
        )
        shown = [k for k in dict.fromkeys(first) if k is not None] + rest
        return sorted(shown[:MAX_COLUMNS])

    def _name(self, robot: int) -> str:
        return f"{'>' if robot == self.robot else ' '} robot {robot}"

    def _row(self, name: str, cells: Sequence[str]) -> str:
        return f"{name:<10}" + "".join(f" {cell:>{COLUMN}}" for cell in cells)

    def _rounds(self) -> Iterator[str]:
        rounds = self.choice.rounds
        for number, (robot, target, worth, share) in enumerate(rounds[:MAX_ROWS], 1):
            where = place(self.choice.frontiers[target])
            mark = ">" if robot == self.robot else " "
            yield (
                f"round {number:>2}: {mark} robot {robot} got frontier {target}, {where}: "
                + self._terms(worth, share)
            )
        if len(rounds) > MAX_ROWS:
            yield f"and {many(len(rounds) - MAX_ROWS, 'more round')}"
        own = [target for robot, target, *_ in rounds if robot == self.robot]
        if self.choice.rule in ("gain", "room") and len(own) > 1:
            tour = "tour there" if self.choice.rule == "room" else "tour"
            yield f"by value and tour length, frontier {own[-1]} is the first stop of its {tour}"

    def _routes(self) -> Iterator[str]:
        if self.choice.goal is None:
            return
        stops: dict[int, list[str]] = {robot: [] for robot in self.choice.robots}
        shown = self._columns()
        for robot, target, _, at_m in self.choice.rounds:
            where = (
                ""
                if target in shown or stops[robot]
                else f", {place(self.choice.frontiers[target])},"
            )
            # Lines break between the stops only.
            stops[robot].append(
                f"{target}{where} at {at_m:.1f} m".replace(" ", "\N{NO-BREAK SPACE}")
            )
        yield "routes: frontiers in the order of visits, and the counted length of the route up to"
        yield "each: with the first turn and exploration on the way, less for a goal that is kept"
        for robot, route in stops.items():
            rest = len(route) - MAX_ROWS
            more = f", and {rest} more" if rest > 0 else ""
            line = f"{self._name(robot)}: {', '.join(route[:MAX_ROWS]) or 'none'}{more}"
            for part in textwrap.wrap(line, WIDTH, subsequent_indent=" " * 11):
                yield part.replace("\N{NO-BREAK SPACE}", " ")
        if not stops[self.robot]:
            yield "its own route is empty, so it goes to the nearest frontier"

    def _terms(self, worth: float, share: float) -> str:
        match self.choice.rule:
            case "gain" | "room":
                return f"{worth:.1f} m2, value {share:.3g}"
            case "utility":
                return f"utility {worth:.2f}, {share:.2f} of the longest path"
        return f"{share:.2f} of the longest path"

    def _scores(self) -> Iterator[str]:
        scores = self.choice.scores
        if self.choice.rule == "rules" and not scores:
            yield "it kept its last goal, which was not explored yet"
        if not scores:
            return
        yield "the best cells; the score falls with distance and turn and rises with the others"
        names = "score", "distance", "turn", "others"
        yield f"  {'cell':>16}" + "".join(f" {name:>{COLUMN}}" for name in names)
        for x, y, *terms in scores[:MAX_ROWS]:
            mark = "*" if (x, y) == self.choice.goal else " "
            yield f"{mark} {place((x, y)):>16}" + "".join(f" {t:>{COLUMN}.2f}" for t in terms)


def _rank(rank: int | None) -> str:
    return "" if rank is None else f" ({rank})"


def _metres(value: float | None) -> str:
    # One digit less where the column is too narrow.
    return "-" if value is None else f"{value:.{2 if abs(value) < 100.0 else 1}f}"
