"""Why a robot did what it did: its decisions in words, from a recording."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from msgspec import UNSET

from multisrt.events import (
    AnyEvent,
    Coordinated,
    Decided,
    Decision,
    Ended,
    GoalChosen,
    Motion,
    NodeAdded,
    NodeName,
    Organized,
    Point,
    Supports,
)
from multisrt.explain.custom import own_choice_lines, own_lines
from multisrt.explain.frontier import bid_lines, choice_lines
from multisrt.explain.story import ChoiceStory
from multisrt.explain.terms import CHOICES, ORDERS, stage_name
from multisrt.explain.words import (
    SAME_MOMENT_S,
    choice_line,
    decision_lines,
    listed,
    many,
    place,
    troubles,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.spec.numbering import missing

PURPOSES = {
    "explore": "to explore",
    "support": "to support another tree",
    "home": "to go home",
    "give way": "to give way",
}


def explain(
    recording: Recording,
    robot: int,
    time_s: float | None = None,
    *,
    whole: Recording | None = None,
) -> str:
    """Explain the last decision of a robot by a time.

    Parameters
    ----------
    recording : Recording
        The run.
    robot : int
        The robot, from 0.
    time_s : float, optional
        The time in seconds; by default the end of the run.
    whole : Recording, optional
        The run, if `recording` is the part of it from which this decision is explained.

    Returns
    -------
    str
        Several lines. For the SRT family: where the robot stood, what it knew, which candidates
        it refused and why, what it chose; its groups, conflicts of paths and the orders of the
        master; the tree that it supports, and what did not go as planned. For a robot that bids
        for frontiers: the robots that it considered, the tables on which it decided, and what it
        did until it chose again. For an explorer of your own that notes `Decided`: its words, its
        options with their values, and what it did next.

    Raises
    ------
    InvalidInputError
        If there is no such robot, the time is not within the run, or the robot had not decided
        anything by then.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, simulate
    >>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
    >>> print(explain(recording, 0, 0.0).splitlines()[0])
    Robot 0 at 0.00 s: its last decision was at 0.00 s.
    """
    _require_robot(recording, robot)
    end = recording.footer.time_s
    asked = end if time_s is None else time_s
    if not 0.0 <= asked <= end + SAME_MOMENT_S:
        raise InvalidInputError(
            f"{asked:g} s is not within the run, which lasts from 0 to {end:.2f} s"
        )
    if recording.spec.strategy == "informed":
        return (
            f"Robot {robot} at {asked:.2f} s: it drives a route that was planned on the true map "
            "before it set out, and decides nothing on the way.\n"
        )
    index, choice = _last_choice(recording.events, robot, asked)
    if isinstance(choice, GoalChosen):
        lines = choice_lines(recording, index, choice, asked, whole)
    elif isinstance(choice, Decided):
        lines = own_choice_lines(recording, index, choice, asked, whole)
    else:
        lines = _Story(recording, index, choice, asked, whole).lines()
    return "\n".join(lines) + "\n"


def explain_all(recording: Recording, robot: int) -> str:
    """Return a table of all decisions of a robot, one line each under a heading.

    Parameters
    ----------
    recording : Recording
        The run.
    robot : int
        The robot, from 0.

    Returns
    -------
    str
        A heading and a line for each decision.

    Raises
    ------
    InvalidInputError
        If there is no such robot.
    """
    _require_robot(recording, robot)
    if lines := [*bid_lines(recording, robot), *own_lines(recording, robot)]:
        return "\n".join(lines) + "\n"
    rows = []
    for index, event in enumerate(recording.events):
        if isinstance(event, Decision) and event.robot == robot:
            cells = _short_node(event.node, robot), f"{event.frontier_m:.2f} m"
            rows.append((event.time_s, cells, planned(recording.events, index, event)))
    return "\n".join(decision_lines({"node": 8, "frontier": 8}, rows)) + "\n"


def planned(events: Sequence[AnyEvent], index: int, decision: Decision) -> str:
    """Return a decision of a robot of the SRT family in one line.

    Parameters
    ----------
    events : sequence of Event
        The events of a recording.
    index : int
        Index of the decision among them.
    decision : Decision
        The decision.

    Returns
    -------
    str
        The choice and its target, and the order of the master if there was one.
    """
    told = _coordinated(events, index)
    order = "" if told is None else f"; {ORDERS[told.order].name} {place(told.new_target)}"
    return f"{choice_line(decision)}{order}"


class _Story(ChoiceStory[Decision]):
    """The explanation of one decision of a robot of the SRT family."""

    things = "node"
    happened = "its last decision was"

    def __init__(
        self,
        recording: Recording,
        index: int,
        choice: Decision,
        asked_s: float,
        whole: Recording | None = None,
    ) -> None:
        super().__init__(recording, index, choice, asked_s, whole)
        self.index, self.events = index, recording.events
        # Motions are recorded when they end, all other events when they happen.
        self.past = [
            event
            for event in (*self.before, choice, *self.after)
            if event.time_s <= asked_s + SAME_MOMENT_S
        ]
        self.nodes: dict[NodeName, NodeAdded] = {
            (event.robot, event.serial): event for event in recording.of(NodeAdded)
        }

    def sections(self) -> Iterator[tuple[str, Iterator[str]]]:
        decided, group, support = self._times()
        yield f"Where it stood{decided}", self.standing()
        yield f"What it knew{decided}", self.knowledge()
        yield f"What it decided{decided}", self.decided()
        yield f"Its group{group}", self.group()
        yield f"Which tree it supports{support}", self.support()
        yield "What did not go as planned", troubles(self.past)
        yield f"What it did next{decided.replace(' at', ' from')}", self.afterwards()

    def _times(self) -> tuple[str, str, str]:
        # While a robot supports a tree, what is told is of several times, which titles then name.
        supports = [event for event in self.past if isinstance(event, Supports)]
        if not supports or supports[-1].tree is None:
            return "", "", ""
        told = _coordinated(self.events, self.index, self.asked_s)
        group_s = self.time_s if told is None else told.time_s
        return (
            f", at {self.time_s:.2f} s",
            f", at {group_s:.2f} s",
            f", since {supports[-1].time_s:.2f} s",
        )

    def endings(self) -> Iterator[str]:
        yield from ()  # its problems stand before what it did next, to which they led

    def standing(self) -> Iterator[str]:
        node = self.nodes[self.choice.node]
        x, y, heading = node.configuration
        yield (
            f"at {self._node(self.choice.node)}, {place((x, y))}, which was added at "
            f"{node.time_s:.2f} s, heading {math.degrees(heading):.0f} degrees"
        )
        if node.parent is None:
            yield f"the root of the tree of robot {node.robot}"
        else:
            stage = stage_name(node.stage)
            yield f"its parent is {self._node(node.parent)}; the place was found by: {stage}"

    def knowledge(self) -> Iterator[str]:
        yield f"its local frontier there was {self.choice.frontier_m:.2f} m long"
        yield f"its map had {many(self.own_nodes(), 'node')} that it had made"
        yield from self.learned()
        yield from self.to_deliver()
        yield from self.complete()

    def decided(self) -> Iterator[str]:
        chosen = self.choice
        if chosen.draws:
            why = ", ".join(f"{count} {reason}" for reason, count in chosen.refused.items())
            yield f"{many(chosen.draws, 'candidate')} drawn; refused: {why or 'none'}"
            tried = Counter((place((x, y)), reason) for x, y, reason in chosen.candidates)
            for (where, reason), count in tried.items():
                yield f"  {where}: {reason}" + (f", {count} times" if count > 1 else "")
        yield from _arcs(chosen)
        name, meaning = CHOICES[chosen.choice]
        yield f"it chose {name}: {meaning}"
        if chosen.target is not None:
            here = self.nodes[chosen.node].configuration
            yield f"target {place(chosen.target)}, {math.dist(here[:2], chosen.target):.2f} m away"

    def group(self) -> Iterator[str]:
        gpr, ger = self.choice.gpr, self.choice.ger
        if len(self.team) == 1:
            return
        if gpr:
            yield f"pre-engaged (GPR): {listed(gpr)}"
        if ger:
            yield f"engaged (GER): {listed(ger)}"
        told = _coordinated(self.events, self.index, self.asked_s)
        if told is None:
            if len(ger) > 1:
                yield "no paths of the group conflicted, so no robot coordinated it"
            return
        master = "itself" if told.master == self.robot else f"robot {told.master}"
        yield f"paths of the group {listed(told.ger)} conflicted; the master was {master}"
        yield f"feasible: {listed(told.feasible)}; unfeasible: {listed(told.unfeasible)}"
        organized = _organized(self.events, told)
        if organized is not None:
            if organized.conflicts:
                pairs = ", ".join(f"{i} with {j}" for i, j in organized.conflicts)
                yield f"in conflict: {pairs}"
            if organized.deadlock:
                yield "a deadlock: no robot could be let go"
            yield from _table(organized)
        yield (
            f"at {told.time_s:.2f} s its order was {ORDERS[told.order].meaning}"
            + (
                f" {place(told.target)}"
                if told.order == "keep" and told.new_target == told.target
                else f": {place(told.target)} became {place(told.new_target)}"
            )
        )

    def support(self) -> Iterator[str]:
        chosen = [event for event in self.past if isinstance(event, Supports)]
        if not chosen:
            return
        last = chosen[-1]
        none = "no path leads to a tree that may need support"
        what = none if last.tree is None else f"the tree of robot {last.tree}"
        yield f"it chose at {last.time_s:.2f} s: {what}"
        yield f"{'tree':>4}  {'open frontier':>13}  {'active robots':>13}"
        for tree, length in sorted(last.open_frontier_m.items()):
            mark = "  may need support" if tree in last.candidates else ""
            active = last.active_robots.get(tree, 0)
            yield f"{tree:>4}  {length:>11.2f} m  {active:>13}{mark}"

    def afterwards(self) -> Iterator[str]:
        for event in self.past:
            if event.time_s < self.choice.time_s - SAME_MOMENT_S:
                continue
            if isinstance(event, Motion):
                arrival_s, x, y, _ = event.waypoints[-1]
                has_come = arrival_s <= self.asked_s + SAME_MOMENT_S
                yield (
                    f"{event.time_s:.2f} s: it set out {PURPOSES[event.purpose]}, "
                    f"and {'came' if has_come else 'is on its way'} to {place((x, y))}"
                )
            elif isinstance(event, Ended):
                yield f"{event.time_s:.2f} s: it ended: {event.reason}"

    def _node(self, name: NodeName) -> str:
        return f"node {name[1]}" + ("" if name[0] == self.robot else f" of robot {name[0]}")


def _arcs(chosen: Decision) -> Iterator[str]:
    # The arcs that were compared by their values, as shares of the highest one.
    if chosen.arcs is UNSET or not chosen.arcs:
        return
    highest = chosen.arcs[0][-1]
    yield "frontier arcs by their value, the unknown area in sight for the way there:"
    yield f"  {'middle':>18}  {'area':>8}  {'way':>8}  {'value':>7}"
    for x, y, area_m2, way_m, value in chosen.arcs:
        share = value / highest if highest else 0.0
        yield f"  {place((x, y)):>18}  {area_m2:>5.1f} m²  {way_m:>6.2f} m  {share:>7.1%}"


def _last_choice(
    events: Sequence[AnyEvent], robot: int, asked_s: float
) -> tuple[int, Decision | GoalChosen | Decided]:
    found = None
    for index, event in enumerate(events):
        if isinstance(event, Decision | GoalChosen | Decided) and event.robot == robot:
            if event.time_s <= asked_s + SAME_MOMENT_S:
                found = index, event
            elif found is None:
                raise InvalidInputError(
                    f"robot {robot} had not decided anything by {asked_s:g} s; "
                    f"its first decision is at {event.time_s:.2f} s"
                )
    if found is None:
        raise InvalidInputError(
            f"robot {robot} put no decision on record in this run; an explorer of your own notes "
            "Decided (multisrt.robots.toolkit.decided)"
        )
    return found


def _coordinated(
    events: Sequence[AnyEvent], index: int, asked_s: float = -math.inf
) -> Coordinated | None:
    # How a decision was coordinated before the robot moved, or a later step by the time asked for:
    # not all steps on the way to another tree are decisions.
    robot, has_moved, found = events[index].robot, False, None
    for event in events[index + 1 :]:
        if event.robot != robot:
            continue
        if isinstance(event, Decision):
            break
        if isinstance(event, Motion):
            has_moved = True
        elif isinstance(event, Coordinated) and (
            event.time_s <= asked_s + SAME_MOMENT_S or (found is None and not has_moved)
        ):
            found = event
    return found


def _organized(events: Iterable[AnyEvent], told: Coordinated) -> Organized | None:
    # The last arrangement of this group by the master before the robot got its order.
    found = None
    for event in events:
        if (
            isinstance(event, Organized)
            and event.robot == told.master
            and event.time_s <= told.time_s + SAME_MOMENT_S
            and set(event.before) == set(told.ger)
        ):
            found = event
    return found


def _table(organized: Organized) -> Iterator[str]:
    yield f"{'robot':>5}  {'planned':>18}  {'organised':>18}  order"
    for robot in sorted(organized.before):
        yield (
            f"{robot:>5}  {place(organized.before[robot]):>18}  "
            f"{_place_of(organized.after, robot):>18}  {_order(organized, robot)}"
        )


def _order(organized: Organized, robot: int) -> str:
    return ORDERS[organized.orders[robot]].name if robot in organized.orders else ""


def _place_of(places: Mapping[int, Point], robot: int) -> str:
    return place(places[robot]) if robot in places else ""


def _short_node(name: NodeName, robot: int) -> str:
    return str(name[1]) if name[0] == robot else f"{name[0]}:{name[1]}"


def _require_robot(recording: Recording, robot: int) -> None:
    team = len(recording.spec.robots)
    if not 0 <= robot < team:
        raise InvalidInputError(missing(robot, team))
