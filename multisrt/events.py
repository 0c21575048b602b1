"""What happens in a run, as plain data: what a recording holds, line by line.

Every event says when it happened and to which robot. Lengths are metres, times seconds, angles
radians. The names of the fields are the names in the file.
"""

from __future__ import annotations

import itertools
from typing import Literal

import msgspec
import numpy as np

from multisrt.geometry.numerics.kernel import FloatArray

Point = tuple[float, float]
Segment = tuple[float, float, float, float]
"""x0, y0, x1, y1; a frontier segment has its region on the left."""

Pose = tuple[float, float, float]
"""x, y, heading."""

NodeName = tuple[int, int]
"""The robot that made a node, and the node's serial number among that robot's."""

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
"""What the planner of the SRT family chose."""

Stage = Literal["root", "draw", "approach", "complete", "bypass", "coordinate", "passed", "scan"]
"""How a node's place was found: by a stage of the planner, or by a master that organised; or
that it is where a robot took a scan on its way, of the SRT family or bidding for frontiers."""

Purpose = Literal["explore", "support", "home", "give way"]
"""Why a robot moves."""


# Events hold plain data, which cannot refer back to them: the garbage collector need not look.
class Event(msgspec.Struct, frozen=True, kw_only=True, gc=False, tag_field="event"):
    """Something that happened to a robot.

    Attributes
    ----------
    time_s : float
        When, in the run's own time.
    robot : int
        To whom, counted from 0.
    """

    time_s: float
    robot: int


class Motion(Event, frozen=True, kw_only=True, tag="motion"):
    """A robot moved; `time_s` is when it set out.

    Attributes
    ----------
    waypoints : tuple of (time_s, x, y, heading)
        Times from the start of the run. Between two waypoints the body moves with a constant
        twist: straight where the heading stays, in place where the position stays, else on a
        circular arc. Headings are not wrapped, so turns are signed.
    purpose : {"explore", "support", "home", "give way"}
        Why: for its own tree, to or for another's, back to its root, or out of another's way.
    """

    waypoints: tuple[tuple[float, float, float, float], ...]
    purpose: Purpose = "explore"


class NodeAdded(Event, frozen=True, kw_only=True, tag="node"):
    """A robot added a node to its tree.

    Attributes
    ----------
    serial : int
        The node's number among its robot's.
    parent : (robot, serial) or None
        The node that the robot came from; None at a root.
    configuration : (x, y, heading)
        Where the scan was taken.
    stage : {"root", "draw", "approach", "complete", "bypass", "coordinate", "passed", "scan"}
        How the place was found; `bypass`: on the way round a robot that stands; `coordinate`: by
        a master, or where a protective stop ended a motion; `passed`: not chosen, but on the way
        to a place that was; `scan`: where a robot that bids for frontiers looked round.
    boundary : tuple of (x, y)
        The local safe region, counter-clockwise, not closed.
    tags : str
        One digit for the piece from corner i to corner i + 1: 0 obstacle, 1 range, 2 gap, 3 cut.
    """

    serial: int
    parent: NodeName | None
    configuration: Pose
    stage: Stage
    boundary: tuple[Point, ...]
    tags: str

    def region(self) -> FloatArray:
        """Give the corners of the local safe region as an array, (n, 2), made at every call."""
        numbers = itertools.chain.from_iterable(self.boundary)
        return np.fromiter(numbers, np.float64, 2 * len(self.boundary)).reshape(-1, 2)


class Decision(Event, frozen=True, kw_only=True, tag="decision"):
    """A robot chose where to go next, and what it knew.

    Attributes
    ----------
    node : (robot, serial)
        The node that it stood at.
    frontier_m : float
        Length of the local frontier there.
    choice : str
        `draw`, `approach`, `complete`, `parent`, `nearest_open`, `home`, `transfer` (to
        another's tree and back), `bypass` (round a robot that stands), `stay` (for now) or `end`.
    target : (x, y) or None
        The place chosen.
    draws : int
        How many candidates were drawn.
    refused : dict
        Why candidates were refused, with how often: `no room`, `near a node`, `in another region`,
        `blocked by a robot`.
    candidates : tuple of (x, y, reason)
        The candidates that were refused, in the order in which they were drawn.
    gpr, ger : tuple of int
        The groups of pre-engaged and of engaged robots, itself among them.
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
    """A robot that bids for frontiers chose a goal, and what it knew.

    Attributes
    ----------
    rule : str
        The rule that chose: a strategy's name, or `random` for one that was stuck.
    because : str
        Why it chose: `start`, `reached`, `news` (the map has changed), `nothing left` (to be
        seen at the last goal), `no way` (to it), `blocked` (by a robot), `stop signal`,
        `assigned`, `gave way` or `called on`.
    goal : (x, y) or None
        The goal; None: there is none that it can reach.
    cost_m : float
        How far it is to there.
    frontiers : tuple of (x, y)
        The targets that were to be had, one for each group of frontier cells.
    robots : tuple of int
        Who was reckoned with: the rows of the tables.
    costs : tuple of rows
        How far each of these robots has to each target; None: it cannot get there, or that did
        not need to be worked out.
    ranks : tuple of rows
        `minpos`: how many robots are nearer to each target; None where it was not counted. This
        robot's own are counted up to the lowest so far.
    rounds : tuple of (robot, target, utility, share)
        `utility` and `greedy`: who got which target, in this order; what its utility was; and
        how far it was, as a share of the longest way.
    bids : tuple of rows
        `self-bidding`: the table of bids that was matched; None: infinite.
    phi_m : tuple of float
        `self-bidding`: the radii of cohesion that were tried; the last one was used.
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


class Coordinated(Event, frozen=True, kw_only=True, tag="coordinated"):
    """Paths of a group conflicted; this is what became of a robot's target.

    Attributes
    ----------
    ger : tuple of int
        The group that was coordinated.
    master : int
        Who organised.
    feasible, unfeasible : tuple of int
        Robots whose paths conflicted with no other's, and the rest (paper: G_f and G_u).
    target : (x, y)
        What the robot had planned.
    order : {"keep", "wait", "new target", "give way"}
        What it was told.
    new_target : (x, y)
        Where it goes now; where it stands, if it waits.
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
        Targets as planned and as organised; a robot that waits has its place.
    orders : dict of robot to str
        `keep`, `wait`, `new target` or `give way`.
    conflicts : tuple of (int, int)
        Pairs of robots whose planned paths conflicted; (i, j) with j standing in the way of i
        is among them.
    deadlock : bool
        Whether nobody could be let go.
    """

    feasible: tuple[int, ...]
    unfeasible: tuple[int, ...]
    before: dict[int, Point]
    after: dict[int, Point]
    orders: dict[int, str]
    conflicts: tuple[tuple[int, int], ...]
    deadlock: bool = False


class Supports(Event, frozen=True, kw_only=True, tag="supports"):
    """A robot that is done with its own tree chose another's to support (paper: SELECT).

    Attributes
    ----------
    tree : int or None
        The robot at whose start the chosen tree is rooted; None: no tree needs support.
    open_frontier_m : dict of tree to float
        Open frontier of every tree known.
    active_robots : dict of tree to int
        How many robots are active in it.
    candidates : tuple of int
        The trees that may need support (paper: I).
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
        The message's type.
    size_bytes : int
        Its size.
    reached : tuple of int
        Robots to which the radio carries it.
    lost : tuple of int
        Robots in reach that it does not come to, by loss.
    """

    kind: str
    size_bytes: int
    reached: tuple[int, ...] = ()
    lost: tuple[int, ...] = ()


class Learned(Event, frozen=True, kw_only=True, tag="learned"):
    """A robot learned of nodes that others made.

    Attributes
    ----------
    nodes : tuple of (robot, serial)
        The nodes that were new to it.
    """

    nodes: tuple[NodeName, ...]


class TakenAsLost(Event, frozen=True, kw_only=True, tag="taken_as_lost"):
    """A robot has had no answer from another for so long that it does not wait for it any more.

    Attributes
    ----------
    other : int
        The robot that did not answer.
    """

    other: int


class Blocked(Event, frozen=True, kw_only=True, tag="blocked"):
    """A robot stopped because another's body came too near: its protective stop.

    Attributes
    ----------
    by : int
        The robot whose body it was.
    configuration : (x, y, heading)
        Where it stopped.
    """

    by: int
    configuration: Pose


class Died(Event, frozen=True, kw_only=True, tag="died"):
    """A robot died; its body stays where it is.

    Attributes
    ----------
    configuration : (x, y, heading)
        Where.
    doing : {"moving", "waiting", "master"}
        What it was doing.
    """

    configuration: Pose
    doing: Literal["moving", "waiting", "master"]


class FellSilent(Event, frozen=True, kw_only=True, tag="fell_silent"):
    """A robot's radio failed: it neither sends nor hears, and goes on."""


class CameBack(Event, frozen=True, kw_only=True, tag="came_back"):
    """A robot's radio works again."""


class Joined(Event, frozen=True, kw_only=True, tag="joined"):
    """A robot that stood switched off at its start began."""


class ArcClosed(Event, frozen=True, kw_only=True, tag="arc_closed"):
    """A robot gave up a frontier arc that no place it can reach would open.

    Attributes
    ----------
    node : (robot, serial)
        The arc's node.
    reason : str
        `too narrow`: the body fits nowhere from which the arc can be seen. `not reachable`: it
        would fit, but no known way leads there. `seen from near`: the robot has looked from
        every such place. `blocked by a robot`: a robot that does not answer stands in the way.
    arc : tuple of (x0, y0, x1, y1)
        The arc's segments.
    """

    node: NodeName
    reason: Literal["too narrow", "not reachable", "seen from near", "blocked by a robot"]
    arc: tuple[Segment, ...]


class MapComplete(Event, frozen=True, kw_only=True, tag="map_complete"):
    """No frontier is left in a robot's map; all that remains is the way home."""


class Collision(Event, frozen=True, kw_only=True, tag="collision"):
    """A body touched an obstacle or another body: a defect, which ends the run.

    Attributes
    ----------
    configuration : (x, y, heading)
        Where the motion that touched began.
    account : str
        What was being done.
    """

    configuration: tuple[float, float, float]
    account: str


class Ended(Event, frozen=True, kw_only=True, tag="ended"):
    """A robot is done. One that is called on again ends again; the last end counts.

    Attributes
    ----------
    reason : str
        Why it ended, in words.
    complete : bool
        Whether no frontier was left that it knew a way to open.
    frontier : tuple of (x0, y0, x1, y1)
        The frontier segments that it left open.
    """

    reason: str
    complete: bool
    frontier: tuple[Segment, ...]


AnyEvent = (
    Motion
    | NodeAdded
    | Decision
    | GoalChosen
    | Coordinated
    | Organized
    | Supports
    | ArcClosed
    | MapComplete
    | Sent
    | Learned
    | TakenAsLost
    | Blocked
    | Died
    | FellSilent
    | CameBack
    | Joined
    | Collision
    | Ended
)
