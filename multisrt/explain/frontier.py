"""Why a robot that bids for frontiers went where it went: its choices of goals in plain words."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise

from multisrt.events import Ended, GoalChosen, Learned, MapComplete, Motion, NodeAdded, Pose, Sent
from multisrt.explain.words import SAME_MOMENT_S, by_robot, listed, many, place, titled, troubles
from multisrt.planners.motion.trajectory import leg_length
from multisrt.recording import Recording

MOST_COLUMNS = 8
"""A table of more frontiers shows so many: those nearest to the robot, and the one it chose."""

MOST_ROUNDS = 12
"""So many rounds of an assignment are told, and so many of the best cells."""

COLUMN = 10
"""Letters of a table's column."""

BECAUSE = {
    "start": "it had looked round for the first time",
    "reached": "it had reached its last goal",
    "news": "its map had changed",
    "nothing left": "nothing was left to be seen at its last goal",
    "no way": "the way to its last goal turned out not to be free",
    "blocked": "another robot stood in its way",
    "gave way": "it had given way to another robot",
    "stop signal": "another robot told it that its goal was no frontier any more",
    "assigned": "its leader gave it another goal",
    "called on": "it was done, and heard something new",
}

RULES = {
    "closest": "the nearest frontier, whatever the others do",
    "greedy": "the shortest ways first; every frontier goes to one robot before any to a second",
    "minpos": "the frontier to which fewest robots are nearer, and of these the nearest",
    "utility": "a leader gives out frontiers by their utility less the way to them",
    "self-bidding": "bids of all robots, matched for the least sum",
    "rules": "the unexplored cell of the best score",
    "random": "any place that it can reach, as it was stuck",
}


def choice_lines(
    recording: Recording, index: int, choice: GoalChosen, asked_s: float
) -> Iterator[str]:
    """Tell one choice of a goal, and what came of it.

    Parameters
    ----------
    recording : Recording
        The run.
    index : int
        Where in it the choice stands.
    choice : GoalChosen
        The choice.
    asked_s : float
        The time that was asked for.
    """
    return _BidStory(recording, index, choice, asked_s).lines()


def bid_lines(recording: Recording, robot: int) -> Iterator[str]:
    """Tell a robot's choices of goals, one line each; nothing of one that made none."""
    choices = [e for e in recording.events if isinstance(e, GoalChosen) and e.robot == robot]
    if choices:
        yield f"{'time (s)':>9}  {'frontiers':>9}  {'to go':>9}  choice"
    for choice in choices:
        goal = "no goal" if choice.goal is None else f"to {place(choice.goal)}"
        way = "" if choice.goal is None else f"{choice.cost_m:.2f} m"
        yield (
            f"{choice.time_s:9.2f}  {len(choice.frontiers):>9}  {way:>9}  "
            f"{choice.rule} {goal}: {_because(choice)}"
        )


class _BidStory:
    # What there is to tell of one choice of a goal.

    def __init__(
        self, recording: Recording, index: int, choice: GoalChosen, asked_s: float
    ) -> None:
        self.robot, self.choice, self.asked_s = choice.robot, choice, asked_s
        self.team = range(len(recording.spec.robots))
        self.start = recording.starts[choice.robot]
        of_robot = [event.robot == choice.robot for event in recording.events]
        self.before = [e for e, own in zip(recording.events[:index], of_robot, strict=False) if own]
        later = [e for e, own in zip(recording.events, of_robot, strict=True) if own]
        later = later[len(self.before) + 1 :]
        choices = [number for number, e in enumerate(later) if isinstance(e, GoalChosen)]
        self.next: GoalChosen | None = None
        if choices:
            following = later[choices[0]]
            assert isinstance(following, GoalChosen)
            self.next, later = following, later[: choices[0]]
        self.meanwhile = later

    def lines(self) -> Iterator[str]:
        choice = self.choice
        yield (
            f"Robot {self.robot} at {self.asked_s:.2f} s: it last chose a goal at "
            f"{choice.time_s:.2f} s."
        )
        past = [*self.before, *self.meanwhile]
        until = max(self.asked_s, choice.time_s) + SAME_MOMENT_S
        for title, lines in (
            ("Where it stood", self.standing()),
            ("What it knew", self.knowledge()),
            ("Why it chose anew", self.reason()),
            (f"How it chose: {choice.rule}", self.rule()),
            ("What it chose", self.goal()),
            ("What it did then", self.afterwards()),
            ("What it sent and learned meanwhile", self.messages()),
            (
                "What went otherwise than planned",
                troubles(e for e in past if e.time_s <= until),
            ),
        ):
            yield from titled(title, lines)

    def standing(self) -> Iterator[str]:
        x, y, heading = self._pose()
        yield f"at {place((x, y))}, heading {math.degrees(heading):.0f} degrees"

    def knowledge(self) -> Iterator[str]:
        own = sum(isinstance(event, NodeAdded) for event in self.before)
        yield f"its map had {many(own, 'scan')} of its own that showed something new"
        learned = [event for event in self.before if isinstance(event, Learned)]
        names = [name for event in learned for name in event.nodes]
        if names:
            yield (
                f"it had learned {many(len(names), 'scan')} of others: {by_robot(names)}; "
                f"last at {learned[-1].time_s:.2f} s"
            )
        yield f"{many(len(self.choice.frontiers), 'frontier')} wide enough to go to"
        if len(self.team) > 1 and self.choice.robots:
            others = [robot for robot in self.choice.robots if robot != self.robot]
            without = [r for r in self.team if r != self.robot and r not in others]
            told = f"it reckoned with these other robots: {listed(others)}"
            if without and self.choice.rule != "closest":
                told += f"; not with {listed(without)}, idle or not heard of lately"
            yield told
        complete = [event for event in self.before if isinstance(event, MapComplete)]
        if complete:
            yield f"it knew since {complete[0].time_s:.2f} s that its map was complete"

    def reason(self) -> Iterator[str]:
        yield f"{self.choice.because}: {_because(self.choice)}"
        last = [event for event in self.before if isinstance(event, GoalChosen)]
        if last:
            goal = last[-1].goal
            where = "it had no goal" if goal is None else f"its goal was {place(goal)}"
            yield f"before, since {last[-1].time_s:.2f} s, {where}"

    def rule(self) -> Iterator[str]:
        choice = self.choice
        yield RULES.get(choice.rule, choice.rule)
        if choice.rule == "closest" and choice.frontiers:
            yield "only the way to the nearest is worked out"
        yield from self._tables()
        yield from self._rounds()
        if choice.rule == "utility" and choice.costs and not choice.rounds and choice.goal:
            yield "it did as its leader said; without a word of it, it goes to the nearest"
        if choice.phi_m:
            radii = ", ".join(f"{radius:.1f}" for radius in choice.phi_m)
            yield f"radii of cohesion that were tried (phi): {radii} m; the last one was used"
        yield from self._scores()

    def goal(self) -> Iterator[str]:
        choice = self.choice
        if choice.goal is None:
            yield "no goal: there is none that it can reach"
            return
        number = self._chosen()
        which = "" if number is None else f"frontier {number}, "
        yield f"{which}{place(choice.goal)}, {choice.cost_m:.2f} m to go"

    def afterwards(self) -> Iterator[str]:
        motions = [event for event in self.meanwhile if isinstance(event, Motion)]
        for purpose, group in groupby(motions, key=lambda motion: motion.purpose):
            several = list(group)
            legs = [leg for motion in several for leg in pairwise(motion.waypoints)]
            way = math.fsum(leg_length(*leg) for leg in legs)
            begin, end = several[0].time_s, several[-1].waypoints[-1]
            did = "gave way and drove" if purpose == "give way" else "drove"
            yield (
                f"from {begin:.2f} s on it {did} {way:.2f} m in {end[0] - begin:.2f} s, "
                f"to {place(end[1:3])}"
            )
        for event in self.meanwhile:
            if isinstance(event, Ended):
                yield f"{event.time_s:.2f} s: it ended: {event.reason}"
        if self.next is not None:
            yield f"at {self.next.time_s:.2f} s it chose again: {_because(self.next)}"

    def messages(self) -> Iterator[str]:
        kinds = Counter(event.kind for event in self.meanwhile if isinstance(event, Sent))
        if kinds:
            told = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
            yield f"it sent {many(kinds.total(), 'message')}: {told}"
        names = [n for event in self.meanwhile if isinstance(event, Learned) for n in event.nodes]
        if names:
            yield f"it learned {many(len(names), 'scan')} of others: {by_robot(names)}"

    def _pose(self) -> Pose:
        # Goals are chosen between motions; a motion is recorded when it ends.
        motions = [event for event in self.before if isinstance(event, Motion)]
        if not motions:
            return self.start.x, self.start.y, self.start.heading
        return motions[-1].waypoints[-1][1:]

    def _chosen(self) -> int | None:
        # The column of the goal; a cell that `rules` chose is none.
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
            yield f"{left_out} of {len(choice.frontiers)} frontiers, farther away, are left out"
        yield "own row: >, chosen: *, no way or not worked out: -"
        yield self._row("frontier", [f"{k}{'*' * (k == self._chosen())}" for k in shown])
        yield self._row("x (m)", [f"{choice.frontiers[k][0]:.2f}" for k in shown])
        yield self._row("y (m)", [f"{choice.frontiers[k][1]:.2f}" for k in shown])
        if choice.ranks:
            yield "how far each robot has (m), and how many robots are nearer than it"
            for robot, costs, ranks in zip(choice.robots, choice.costs, choice.ranks, strict=True):
                cells = [_metres(costs[k]) + _rank(ranks[k]) for k in shown]
                yield self._row(self._name(robot), cells)
            return
        yield (
            "how far each robot has by way of its present goal (m)"
            if choice.rule == "self-bidding"
            else "how far each robot has (m)"
        )
        yield from self._rows(choice.costs, shown)
        if choice.bids:
            yield "bids that were matched (m); -: too far from the others, or no way"
            yield from self._rows(choice.bids, shown)

    def _rows(self, table: Sequence[Sequence[float | None]], shown: Sequence[int]) -> Iterator[str]:
        for robot, values in zip(self.choice.robots, table, strict=True):
            yield self._row(self._name(robot), [_metres(values[k]) for k in shown])

    def _columns(self) -> list[int]:
        # The nearest to this robot, and the chosen one whatever it is; in the table's order.
        choice = self.choice
        own = choice.costs[choice.robots.index(self.robot)]
        chosen = self._chosen()
        nearest = sorted(
            range(len(own)),
            key=lambda k: (k != chosen, math.inf if (cost := own[k]) is None else cost, k),
        )
        return sorted(nearest[:MOST_COLUMNS])

    def _name(self, robot: int) -> str:
        return f"{'>' if robot == self.robot else ' '} robot {robot}"

    def _row(self, name: str, cells: Sequence[str]) -> str:
        return f"{name:<10}" + "".join(f" {cell:>{COLUMN}}" for cell in cells)

    def _rounds(self) -> Iterator[str]:
        rounds = self.choice.rounds
        for number, (robot, target, utility, share) in enumerate(rounds[:MOST_ROUNDS], 1):
            where = place(self.choice.frontiers[target])
            mark = ">" if robot == self.robot else " "
            worth = f"utility {utility:.2f}, " if self.choice.rule == "utility" else ""
            yield (
                f"round {number:>2}: {mark} robot {robot} got frontier {target}, {where}: "
                f"{worth}{share:.2f} of the longest way"
            )
        if len(rounds) > MOST_ROUNDS:
            yield f"and {many(len(rounds) - MOST_ROUNDS, 'more round')}"

    def _scores(self) -> Iterator[str]:
        scores = self.choice.scores
        if self.choice.rule == "rules" and not scores:
            yield "it kept its last goal, which is not explored yet"
        if not scores:
            return
        yield "the best cells; the score falls with distance and turn, and rises with others"
        names = "score", "distance", "turn", "others"
        yield f"  {'cell':>16}" + "".join(f" {name:>{COLUMN}}" for name in names)
        for x, y, *terms in scores[:MOST_ROUNDS]:
            mark = "*" if (x, y) == self.choice.goal else " "
            yield f"{mark} {place((x, y)):>16}" + "".join(f" {t:>{COLUMN}.2f}" for t in terms)


def _because(choice: GoalChosen) -> str:
    return BECAUSE.get(choice.because, choice.because)


def _rank(rank: int | None) -> str:
    return "" if rank is None else f" ({rank})"


def _metres(value: float | None) -> str:
    # Columns are not wide enough for more digits.
    return "-" if value is None else f"{value:.{2 if abs(value) < 100.0 else 1}f}"
