"""Names of what recordings store as short keys: stages, choices, orders and reasons.

Summaries, legends, figures, explanations and replays use these names. `docs/glossary.md` defines
those of stages.
"""

from __future__ import annotations

from typing import Final, NamedTuple


class Term(NamedTuple):
    """A name, and what it means.

    Attributes
    ----------
    name : str
        The name, as tables and legends show it.
    meaning : str
        What it means, to follow the name and a colon.
    """

    name: str
    meaning: str


STAGES: Final[dict[str, Term]] = {
    "root": Term("root", "the root of the robot's tree"),
    "draw": Term("random draw", "a new place, drawn at random towards the local frontier"),
    "approach": Term(
        "approach", "a new place, the one nearest to the local frontier, as no draw was accepted"
    ),
    "complete": Term(
        "viewing place", "a place from which a frontier arc that was left open can be seen"
    ),
    "bypass": Term("detour", "a place on the way around a robot that stands and does not answer"),
    "coordinate": Term(
        "master's order",
        "a place that the master assigned, or where a protective stop ended a motion",
    ),
    "passed": Term("passed", "a place on the way to a chosen one"),
    "scan": Term("scan", "a scan that showed something new"),
}
"""Stages by which the place of a node was found, by `stage` of `NodeAdded`."""

CHOICES: Final[dict[str, Term]] = {
    "draw": STAGES["draw"],
    "approach": STAGES["approach"],
    "complete": STAGES["complete"],
    "gain": Term(
        "best arc", "a place that sees the frontier arc of the highest value: most area for its way"
    ),
    "parent": Term("parent", "back to the parent node, as nothing is left to do here"),
    "nearest_open": Term("nearest open node", "the nearest node that has a frontier left"),
    "home": Term("home", "back to the root, as no frontier is left that the robot can open"),
    "transfer": Term("other tree", "to the tree of another robot, or back to its own"),
    "bypass": STAGES["bypass"],
    "stay": Term("stay", "to stay for now"),
    "end": Term("end", "to end the exploration here"),
}
"""Choices of robots of the SRT family, by `choice` of `Decision`."""

ORDERS: Final[dict[str, Term]] = {
    "keep": Term("keep target", "to keep its target"),
    "wait": Term("wait", "to wait where it stands"),
    "new target": Term("new target", "to go to another target"),
    "give way": Term("give way", "to give way"),
}
"""Orders of masters, by `order` of `Coordinated`."""

REASONS: Final[dict[str, str]] = {
    "start": "it had taken its first scan",
    "reached": "it had reached its last goal, or had it in sight",
    "news": "its map had changed",
    "nothing left": "nothing was left to be seen at its last goal",
    "no way": "the path to its last goal turned out to be blocked",
    "blocked": "another robot blocked its path",
    "gave way": "it had given way to another robot",
    "stop signal": "another robot reported that its goal was no longer a frontier",
    "assigned": "another robot took over its last goal, and gave it its own",
    "called on": "it was done, and heard something new",
    "errand": "it had an errand",
    "errand over": "its errand was over",
}
"""Why robots that bid for frontiers chose a goal, by `because` of `GoalChosen`."""

RULES: Final[dict[str, str]] = {
    "closest": "the nearest frontier, regardless of the other robots",
    "greedy": "the shortest paths first; each frontier goes to one robot before any to a second",
    "minpos": "the frontier to which the fewest robots are nearer, and of these the nearest",
    "utility": "a leader assigns frontiers by their utility less the path length",
    "gain": "the largest area to be seen for its cost, after the robots of higher values",
    "room": "of the frontiers in its room, the largest area to be seen for its cost",
    "routes": "the first stop of its own route, of routes planned for the whole team",
    "self-bidding": "the bids of all robots, matched for the least sum",
    "rules": "the unexplored cell with the best score",
    "random": "a random place that it can reach, as it was stuck",
}
"""Rules by which they chose it, by `rule` of `GoalChosen`."""


GIVEN_UP: Final[dict[str, str]] = {
    "too narrow": "too narrow for the body",
    "not reachable": "no known path to where the body fits",
    "seen from near": "scanned from all places near",
    "blocked by a robot": "blocked by a robot",
    "left open": "the frontier was left open",
    "no frontier": "no frontier borders on it",
}
"""Why an area was left uncovered, by the reasons of `multisrt.analysis.given_up.given_up_m2`."""

NO_CONFLICT: Final = "no conflict"
"""The reason of a decision of the SRT family that no master had to coordinate."""

NO_GOAL: Final = "no goal"
"""The choice of a robot that found no place to go to."""


def meanings() -> dict[str, str]:
    """Return what the names in tables of decisions mean.

    Returns
    -------
    dict of str to str
        Choices, rules, orders and reasons by their names, in this order.

    Examples
    --------
    >>> meanings()["master: wait"]
    'the master told it to wait where it stands'
    """
    return {
        **dict(CHOICES.values()),
        **RULES,
        NO_GOAL: "there is none that it can reach",
        NO_CONFLICT: "no paths of robots conflicted, so that no master gave an order",
        **{
            f"master: {order.name}": f"the master told it {order.meaning}"
            for order in ORDERS.values()
        },
        **REASONS,
    }


def stage_name(stage: str) -> str:
    """Return the name of a stage; stages of a strategy of your own have their keys as names.

    Examples
    --------
    >>> stage_name("draw"), stage_name("bypass")
    ('random draw', 'detour')
    """
    return STAGES[stage].name if stage in STAGES else stage
