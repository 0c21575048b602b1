"""Events: what happens in a run, as plain data.

They are the lines of a recording, and `docs/recording.md` describes them as such: the names of
fields here are those in the file. Lengths are in metres, times in seconds from the start of the
run, angles in radians counter-clockwise from +x, positions in the frame of the environment. Robots
count from 0.

Examples
--------
>>> from multisrt import CatalogEnvironment, RunSpec, simulate
>>> from multisrt.events import Motion, NodeAdded
>>> recording = simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1))
>>> nodes = recording.of(NodeAdded)
>>> nodes[0].stage, nodes[0].parent
('root', None)
>>> recording.of(Motion)[0].robot
0
"""

from __future__ import annotations

import itertools
from typing import Final, Literal

import msgspec
import numpy as np

from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray

Point = tuple[float, float]
Segment = tuple[float, float, float, float]
"""x0, y0, x1, y1; a frontier segment has its region on the left, seen from its first end."""

Pose = tuple[float, float, float]
"""x, y, heading."""

NodeName = tuple[int, int]
"""The robot that made a node, and the serial number of the node among those of that robot."""

Choice = Literal[
    "draw",
    "approach",
    "complete",
    "parent",
    "nearest_open",
    "home",
    "transfer",
    "bypass",
    "stay",
    "end",
]
"""What the planner of the SRT family chose; see `Decision`."""

Stage = Literal["root", "draw", "approach", "complete", "bypass", "coordinate", "passed", "scan"]
"""How the place of a node was found; see `NodeAdded`."""

ClosingReason = Literal["too narrow", "seen from near", "not reachable"]
"""Why a robot gave up a frontier arc for good; see `ArcClosed`."""

ArcReason = Literal[ClosingReason, "blocked by a robot"]
"""Why a robot gave up a frontier arc, for good or until a body is gone; see `ArcClosed`."""

BLOCKED: Final = "blocked by a robot"
"""The one reason that passes: such an arc is taken up again when the body is gone."""

Purpose = Literal["explore", "support", "home", "give way"]
"""Why a robot moves; see `Motion`."""

MAX_WORDS: Final = 1000
"""Longest text of a `Decided`, in characters."""

MAX_OPTIONS: Final = 100
"""Largest number of options of a `Decided`."""

MAX_VALUES: Final = 10
"""Largest number of values that a `Decided` gives for each option."""

MAX_NAME: Final = 40
"""Longest name of such a value, in characters."""


# Events hold plain data without cycles, which the garbage collector need not track.
class Event(msgspec.Struct, frozen=True, kw_only=True, gc=False, tag_field="event"):
    """Something that happened to a robot.

    Attributes
    ----------
    time_s : float
        When it happened.
    robot : int
        The robot.
    """

    time_s: float
    robot: int


class Motion(Event, frozen=True, kw_only=True, tag="motion"):
    """A robot moved; `time_s` is when it set out. It is recorded when the motion ends.

    Attributes
    ----------
    waypoints : tuple of (time_s, x, y, heading)
        Times are from the start of the run and never fall. Between two waypoints the body moves
        with a constant twist: straight where the heading stays, in place where the position
        stays, else on a circular arc. Headings are not wrapped, so turns are signed.
    purpose : {"explore", "support", "home", "give way"}
        For its own tree (or any goal of a robot that bids for frontiers), for the tree of another
        robot, back to its root, or out of the way of another robot.
    """

    waypoints: tuple[tuple[float, float, float, float], ...]
    purpose: Purpose = "explore"


class Sensed(Event, frozen=True, kw_only=True, tag="sensed"):
    """A range finder took a scan, whatever the robot did with it; recorded by the simulation.

    Attributes
    ----------
    configuration : (x, y, heading)
        Where the robot was.
    """

    configuration: Pose


class NodeAdded(Event, frozen=True, kw_only=True, tag="node"):
    """A robot added a node to its tree.

    Attributes
    ----------
    serial : int
        The serial number of the node among those of its robot.
    parent : (robot, serial) or None
        The node from which the robot came; None for a root.
    configuration : (x, y, heading)
        Where the scan was taken.
    stage : {"root", "draw", "approach", "complete", "bypass", "coordinate", "passed", "scan"}
        How the place was found. `draw`, `approach`, `complete`: by that stage of the planner;
        `bypass`: on the way round a robot that stands; `coordinate`: by a master, or where a
        protective stop ended a motion; `passed`: on the way to a chosen place; `scan`: where a
        robot that bids for frontiers took a scan that showed something new.
    boundary : tuple of (x, y)
        Corners of the local safe region, counter-clockwise, not closed.
    tags : str
        One digit for the edge from corner i to corner i + 1: 0 obstacle, 1 range, 2 gap, 3 cut.
    """

    serial: int
    parent: NodeName | None
    configuration: Pose
    stage: Stage
    boundary: tuple[Point, ...]
    tags: str

    def region(self) -> FloatArray:
        """Return the corners of the local safe region as a new array, ``(n, 2)``."""
        numbers = itertools.chain.from_iterable(self.boundary)
        return np.fromiter(numbers, np.float64, 2 * len(self.boundary)).reshape(-1, 2)


class Decision(Event, frozen=True, kw_only=True, tag="decision"):
    """A robot of the SRT family chose where to go next.

    Attributes
    ----------
    node : (robot, serial)
        The node at which it stood.
    frontier_m : float
        Length of the local frontier there.
    choice : str
        `draw`, `approach`, `complete`: a new place, found by that stage; `parent`,
        `nearest_open`, `home`: back to the parent node, to the nearest node with a frontier, to
        its root; `transfer`: to the tree of another robot, or back; `bypass`: round a robot that
        stands; `stay`: where it is, for now; `end`: where it is, finally.
    target : (x, y) or None
        The place chosen.
    draws : int
        Number of candidates that were drawn; those of the stage `approach` are not counted.
    refused : dict of str to int
        Numbers of refused candidates, of both stages, by reason: `no room`, `near a node`,
        `in another region`, `no way for the car`, `blocked by a robot` (the way there passes too
        near to a body that the robot plans around; see `ArcClosed`).
    candidates : tuple of (x, y, reason)
        The refused candidates, of both stages, in the order in which they were refused.
    gpr, ger : tuple of int
        The groups of pre-engaged and of engaged robots, including the robot itself.
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
        path length as a share of the longest one.
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
    """A robot decided where to go next, told in the words and numbers of its explorer.

    For explorers of your own; see `multisrt.robots.toolkit.decided`, which makes one of arrays.

    Attributes
    ----------
    text : str
        Why it decided so, in words; at most `MAX_WORDS` characters.
    goal : (x, y) or None
        Where it goes; None if it goes nowhere.
    options : tuple of (x, y)
        The places that it considered; at most `MAX_OPTIONS`.
    values : dict of str to tuple of float or None
        What it weighed them by: for each name one number for each option, None where it has none.
        At most `MAX_VALUES` names of at most `MAX_NAME` characters.

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
            ("characters of text", self.text, MAX_WORDS),
            ("options", self.options, MAX_OPTIONS),
            ("kinds of values", self.values, MAX_VALUES),
            *(("characters in the name of values", name, MAX_NAME) for name in self.values),
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


class Coordinated(Event, frozen=True, kw_only=True, tag="coordinated"):
    """Paths of a group conflicted, and a master decided on the target of this robot.

    Attributes
    ----------
    ger : tuple of int
        The group that was coordinated.
    master : int
        The robot that organised it.
    feasible, unfeasible : tuple of int
        Robots whose paths conflicted with no other, and the rest (paper: G_f and G_u).
    target : (x, y)
        The target that the robot had planned.
    order : {"keep", "wait", "new target", "give way"}
        The order of the master.
    new_target : (x, y)
        The target that it has now; its position if it waits.
    """

    ger: tuple[int, ...]
    master: int
    feasible: tuple[int, ...]
    unfeasible: tuple[int, ...]
    target: Point
    order: Literal["keep", "wait", "new target", "give way"]
    new_target: Point


class Organized(Event, frozen=True, kw_only=True, tag="organized"):
    """A master rearranged the targets of its group (paper: ORGANIZE).

    Attributes
    ----------
    feasible, unfeasible : tuple of int
        As in `Coordinated`.
    before, after : dict of robot to (x, y)
        Targets as planned and as organised; the position of a robot that waits.
    orders : dict of robot to str
        `keep`, `wait`, `new target` or `give way`.
    conflicts : tuple of (int, int)
        Pairs of robots, the lower number first, that would come too near to one another on their
        planned paths. A robot that stays takes part with its body where it stands.
    deadlock : bool
        Whether no robot could be let go.
    """

    feasible: tuple[int, ...]
    unfeasible: tuple[int, ...]
    before: dict[int, Point]
    after: dict[int, Point]
    orders: dict[int, str]
    conflicts: tuple[tuple[int, int], ...]
    deadlock: bool = False


class Supports(Event, frozen=True, kw_only=True, tag="supports"):
    """A robot that is done with its own tree chose another tree to support (paper: SELECT).

    Attributes
    ----------
    tree : int or None
        The chosen tree; None if no way leads to any of the candidates.
    open_frontier_m : dict of tree to float
        Length of the open frontier of every known tree.
    active_robots : dict of tree to int
        Number of other robots that are active in each tree, as far as this one knows.
    candidates : tuple of int
        The trees that may need support (paper: I); never empty.

    Notes
    -----
    A tree has the number of the robot that made its root.
    """

    tree: int | None
    open_frontier_m: dict[int, float]
    active_robots: dict[int, int]
    candidates: tuple[int, ...]


class Sent(Event, frozen=True, kw_only=True, tag="sent"):
    """A robot sent a message.

    Attributes
    ----------
    kind : str
        The type of the message.
    size_bytes : int
        Its size.
    reached : tuple of int
        Robots to which it is delivered.
    lost : tuple of int
        Robots in reach to which it is lost.
    """

    kind: str
    size_bytes: int
    reached: tuple[int, ...] = ()
    lost: tuple[int, ...] = ()


class Learned(Event, frozen=True, kw_only=True, tag="learned"):
    """A robot learned of nodes that other robots made.

    Attributes
    ----------
    nodes : tuple of (robot, serial)
        The nodes that were new to it.
    """

    nodes: tuple[NodeName, ...]


class PresumedLost(Event, frozen=True, kw_only=True, tag="taken_as_lost"):
    """A robot no longer waits for another one, which has not answered for too long.

    Attributes
    ----------
    other : int
        The robot that did not answer.
    """

    other: int


class Blocked(Event, frozen=True, kw_only=True, tag="blocked"):
    """A protective stop ended the motion of a robot, as another body came too near.

    Attributes
    ----------
    by : int
        The robot whose body came too near.
    configuration : (x, y, heading)
        Where the robot stopped.
    """

    by: int
    configuration: Pose


class Died(Event, frozen=True, kw_only=True, tag="died"):
    """A robot died; its body stays where it is.

    Attributes
    ----------
    configuration : (x, y, heading)
        Where it died.
    doing : {"moving", "waiting", "master"}
        What it was doing: moving, standing, or organising a group as its master.
    """

    configuration: Pose
    doing: Literal["moving", "waiting", "master"]


class FellSilent(Event, frozen=True, kw_only=True, tag="fell_silent"):
    """The radio of a robot failed: it neither sends nor receives. The robot goes on."""


class CameBack(Event, frozen=True, kw_only=True, tag="came_back"):
    """The radio of a robot works again."""


class Joined(Event, frozen=True, kw_only=True, tag="joined"):
    """A robot that starts late was switched on."""


class ArcClosed(Event, frozen=True, kw_only=True, tag="arc_closed"):
    """A robot gave up a frontier arc: for good, or `blocked by a robot` until `ArcReopened`.

    Attributes
    ----------
    node : (robot, serial)
        The node of the arc.
    reason : str
        `too narrow`: the body fits nowhere from which the arc can be seen. `not reachable`: it
        would fit, but no known path leads there. `seen from near`: the robot has taken scans from
        every such place, or has set out for the spot `max_views` times. `blocked by a robot`: a
        known path leads there, but past a body that the robot plans around: that of a robot that
        does not answer, that is left out of its group, or that did not clear the way; such an
        arc is left for later, and stays part of the frontier.
    arc : tuple of (x0, y0, x1, y1)
        The segments of the arc.
    """

    node: NodeName
    reason: ArcReason
    arc: tuple[Segment, ...]


class ArcReopened(Event, frozen=True, kw_only=True, tag="arc_reopened"):
    """A robot takes up an arc that was `blocked by a robot`: a body is gone, or responds again."""

    node: NodeName
    arc: tuple[Segment, ...]


class MapComplete(Event, frozen=True, kw_only=True, tag="map_complete"):
    """No frontier is left in the map of a robot, not even behind bodies of other robots.

    For a robot that bids: none that it could reach if no body stood in its way.
    """


class Collision(Event, frozen=True, kw_only=True, tag="collision"):
    """A body touched an obstacle or another body: a defect, which ends the run.

    Attributes
    ----------
    configuration : (x, y, heading)
        Where the robot was: at the start of the leg that touches an obstacle, or at contact with
        another body.
    account : str
        What it touched, in words.
    """

    configuration: tuple[float, float, float]
    account: str


class Ended(Event, frozen=True, kw_only=True, tag="ended"):
    """A robot is done. A robot that is called on ends again, and its last end counts.

    Attributes
    ----------
    reason : str
        Why it ended, in words.
    complete : bool
        Whether it left no frontier that it knew a way to open, if robots that answer went.
    frontier : tuple of (x0, y0, x1, y1)
        The frontier segments that it left open.
    """

    reason: str
    complete: bool
    frontier: tuple[Segment, ...]


NotedEvent = (
    NodeAdded
    | Decision
    | GoalChosen
    | Decided
    | Coordinated
    | Organized
    | Supports
    | ArcClosed
    | ArcReopened
    | MapComplete
    | Learned
    | PresumedLost
)
"""Events that explorers put on record. All others are recorded by the simulation: they say what
robots did, not what they say of it."""

AnyEvent = (
    NotedEvent
    | Motion
    | Sensed
    | Sent
    | Blocked
    | Died
    | FellSilent
    | CameBack
    | Joined
    | Collision
    | Ended
)
