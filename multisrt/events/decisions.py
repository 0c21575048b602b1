"""Events that explorers put on record about where they go, and why."""

from __future__ import annotations

from typing import Final, Literal

from msgspec import UNSET, UnsetType

from multisrt.events.event import Event, NodeName, Point
from multisrt.geometry.errors import InvalidInputError

Choice = Literal[
    "draw",
    "approach",
    "complete",
    "gain",
    "parent",
    "nearest_open",
    "home",
    "transfer",
    "bypass",
    "stay",
    "end",
]
"""What the planner of the SRT family chose; see `Decision`."""

MAX_TEXT_LENGTH: Final = 1000
"""Longest text of a `Decided`, in characters."""

MAX_OPTIONS: Final = 100
"""Largest number of options of a `Decided`."""

MAX_VALUES: Final = 10
"""Largest number of values that a `Decided` gives for each option."""

MAX_NAME_LENGTH: Final = 40
"""Longest name of such a value, in characters."""


class Decision(Event, frozen=True, kw_only=True, tag="decision"):
    """A robot of the SRT family chose where to go next.

    Attributes
    ----------
    node : (robot, serial)
        The node at which it stood.
    frontier_m : float
        Length of the local frontier there.
    choice : str
        `draw`, `approach`, `complete`: a new place, found by that stage; `gain`: one that sees the
        frontier arc of the highest value; `parent`,
        `nearest_open`, `home`: back to the parent node, to the nearest node with a frontier, to
        its root; `transfer`: to the tree of another robot, or back; `bypass`: round a robot that
        stands; `stay`: where it is, for now; `end`: where it is, finally.
    target : (x, y) or None
        The place chosen.
    draws : int
        Number of candidates that were drawn; those of the stage `approach` are not counted.
    refused : dict of str to int
        Numbers of refused candidates, of both stages, by reason: `no room`, `near a node`,
        `in another region`, `no way for the car`, `blocked by a robot` (the path there passes too
        near to a body that the robot plans around; see `ArcClosed`), `no time` (to go there and
        home again before the time limit).
    candidates : tuple of (x, y, reason)
        The refused candidates, of both stages, in the order in which they were refused.
    gpr, ger : tuple of int
        The groups of pre-engaged and of engaged robots, including the robot itself.
    arcs : tuple of (x, y, area_m2, way_m, value), optional
        Only with ``choice="gain"``: the middles of the frontier arcs of the highest values, with
        the unknown area in sight of each and the way there; the chosen one first. Left out of
        recordings where there are none.
    """

    node: NodeName
    frontier_m: float
    choice: Choice
    target: Point | None
    draws: int = 0
    refused: dict[str, int] = {}
    candidates: tuple[tuple[float, float, str], ...] = ()
    gpr: tuple[int, ...] = ()
    ger: tuple[int, ...] = ()
    arcs: tuple[tuple[float, float, float, float, float], ...] | UnsetType = UNSET


DiagramEnd = Literal["no progress", "no command", "near the goal"]
"""Why a robot that steers by the nearness diagram changed to following its path."""


class DiagramLeft(Event, frozen=True, kw_only=True, tag="diagram_left"):
    """A robot that steered by the nearness diagram follows its path for the rest of a drive.

    Attributes
    ----------
    because : str
        `no progress` for some seconds; `no command` that could be held, as a body or the unknown
        is too near, or no opening is passable; `near the goal`, where the diagram stops short of
        walls.
    """

    because: DiagramEnd


class GoalChosen(Event, frozen=True, kw_only=True, tag="goal_chosen"):
    """A robot that bids for frontiers chose a goal.

    Attributes
    ----------
    rule : str
        The rule that chose: the name of a strategy, or `random` for a robot that was stuck.
    because : str
        Why it chose: `start`, `reached` (its goal), `news` (its map has changed), `nothing left`
        (to see at its goal), `no way` (to its goal), `blocked` (by a robot), `stop signal` (its
        goal is no frontier any more), `assigned` (or swapped, or asked for), `gave way` or
        `called on`.
    goal : (x, y) or None
        The goal; None if it can reach none.
    cost_m : float
        Path length to the goal.
    frontiers : tuple of (x, y)
        The targets, one for each group of frontier cells.
    robots : tuple of int
        The robots that were considered: the rows of the tables.
    costs : tuple of rows
        Path length of each robot to each target; None where there is no path, or where the rule
        did not need it.
    ranks : tuple of rows
        `minpos`: the number of robots that are nearer to each target; None where it was not
        counted. Counting for this robot stops at the lowest number so far.
    rounds : tuple of (robot, target, utility, share)
        `utility` and `greedy`: which robot got which target, in order, with its utility and its
        path length as a share of the longest one. `gain`: with the area that was left to the
        target, in square metres, and its value in place of these. `routes`: the stops of all
        routes, those of each robot in order, with the unknown area in sight of the target, and the
        length of the route up to there in metres, as the rule counts it.
    bids : tuple of rows
        `self-bidding`: the matrix of bids that was matched; None for infinite ones.
    phi_m : tuple of float
        `self-bidding`: the cohesion radii that were tried; the last one was used.
    scores : tuple of (x, y, score, distance, turn, others)
        `rules`: the best cells, with the terms of their scores.
    """

    rule: str
    because: str
    goal: Point | None
    cost_m: float = 0.0
    frontiers: tuple[Point, ...] = ()
    robots: tuple[int, ...] = ()
    costs: tuple[tuple[float | None, ...], ...] = ()
    ranks: tuple[tuple[int | None, ...], ...] = ()
    rounds: tuple[tuple[int, int, float, float], ...] = ()
    bids: tuple[tuple[float | None, ...], ...] = ()
    phi_m: tuple[float, ...] = ()
    scores: tuple[tuple[float, float, float, float, float, float], ...] = ()


class Decided(Event, frozen=True, kw_only=True, tag="decided"):
    """A robot decided where to go next, recorded with the text and numbers of its explorer.

    For explorers of your own; see `multisrt.robots.toolkit.decided`, which makes one of arrays.

    Attributes
    ----------
    text : str
        Why it decided so, in words; at most `MAX_TEXT_LENGTH` characters.
    goal : (x, y) or None
        Where it goes; None if it goes nowhere.
    options : tuple of (x, y)
        The places that it considered; at most `MAX_OPTIONS`.
    values : dict of str to tuple of float or None
        What it weighed them by: for each name one number for each option, None where it has none.
        At most `MAX_VALUES` names of at most `MAX_NAME_LENGTH` characters.

    Raises
    ------
    InvalidInputError
        If it is larger than that, or some values are more or fewer than the options.

    Examples
    --------
    >>> chosen = Decided(
    ...     time_s=12.5,
    ...     robot=0,
    ...     text="the nearest place",
    ...     goal=(1.0, 2.0),
    ...     options=((1.0, 2.0), (7.0, 2.0)),
    ...     values={"path (m)": (2.5, 8.0)},
    ... )
    >>> chosen.values["path (m)"]
    (2.5, 8.0)
    """

    text: str
    goal: Point | None = None
    options: tuple[Point, ...] = ()
    values: dict[str, tuple[float | None, ...]] = {}

    def __post_init__(self) -> None:
        if not isinstance(self.text, str):
            raise InvalidInputError(f"the text of a decision is {self.text!r}; give words: str(x)")
        for what, size, most in (
            ("characters of text", self.text, MAX_TEXT_LENGTH),
            ("options", self.options, MAX_OPTIONS),
            ("kinds of values", self.values, MAX_VALUES),
            *(("characters in the name of values", name, MAX_NAME_LENGTH) for name in self.values),
        ):
            if len(size) > most:
                raise InvalidInputError(
                    f"a decision has {len(size)} {what}; give at most {most}, the most important"
                )
        for name, values in self.values.items():
            if len(values) != len(self.options):
                raise InvalidInputError(
                    f"a decision has {len(values)} values {name!r} for {len(self.options)} "
                    "options; give one for each, None where there is none"
                )
