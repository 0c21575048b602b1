"""Events of the Multi-SRT method: groups whose paths conflict, and support of others' trees."""

from __future__ import annotations

from typing import Literal

from multisrt.events.event import Event, Point


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
        The chosen tree; None if no path leads to any of the candidates.
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
