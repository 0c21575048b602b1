"""The knowledge that robots exchange: nodes and closings, numbered by their makers."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import ClassVar, Final, NamedTuple, get_args

import numpy as np

from multisrt.events import ClosingReason, NodeAdded, Stage
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.geometry.regions.safe_region import LocalSafeRegion
from multisrt.robots.messages import Message

REASONS: Final[tuple[ClosingReason, ...]] = get_args(ClosingReason)
"""Reasons for which an arc is given up for good, as recordings have them."""

CountsByRobot = Mapping[int, tuple[int, int]]
"""By robot, how many of its nodes and of its closings are known without a gap from its first."""

Counts = tuple[tuple[int, int, int], ...]
"""The same in messages: robot, nodes and closings, ordered by robot."""


class NodeId(NamedTuple):
    """The id of a node, unique in the team.

    Attributes
    ----------
    robot : int
        The robot that made it.
    serial : int
        Its number among that robot's nodes, from 0.

    Examples
    --------
    >>> sorted([NodeId(1, 0), NodeId(0, 12), NodeId(0, 3)])[0]
    NodeId(robot=0, serial=3)
    """

    robot: int
    serial: int


class ClosingId(NamedTuple):
    """The id of a closing, unique in the team.

    Attributes
    ----------
    robot : int
        The robot that gave the arc up.
    number : int
        Its number among that robot's closings, from 0.

    Examples
    --------
    >>> ClosingId(0, 3) < ClosingId(1, 0)
    True
    """

    robot: int
    number: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Node:
    """A place at which a robot took a scan, with its local safe region.

    Attributes
    ----------
    id : NodeId
        Unique in the team.
    configuration : Configuration
        Where the scan was taken, in metres and radians.
    region : LocalSafeRegion
        What the robot took as surely free around it.
    parent : NodeId or None
        The node that the robot came from; None at a root.
    time_s : float
        When the scan was taken, in seconds.

    Examples
    --------
    >>> import numpy as np
    >>> corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> tags = np.zeros(4, np.int8)  # obstacles all around
    >>> room = LocalSafeRegion(x=1.0, y=1.0, range_m=2.0, boundary=corners, tags=tags)
    >>> here = Configuration(1.0, 1.0)
    >>> node = Node(id=NodeId(0, 0), configuration=here, region=room, parent=None, time_s=0.0)
    >>> node.id.robot, node.region.polygon().area
    (0, 4.0)
    """

    id: NodeId
    configuration: Configuration
    region: LocalSafeRegion
    parent: NodeId | None
    time_s: float

    def added(self, stage: Stage) -> NodeAdded:
        """Return the event that records this node.

        Parameters
        ----------
        stage : Stage
            How the place was chosen.

        Returns
        -------
        NodeAdded
            The event, for `multisrt.robots.explorer.Note`.

        Examples
        --------
        >>> import numpy as np
        >>> corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
        >>> tags = np.array([0, 1, 0, 0], np.int8)
        >>> room = LocalSafeRegion(x=1.0, y=1.0, range_m=2.0, boundary=corners, tags=tags)
        >>> here = Configuration(1.0, 1.0)
        >>> node = Node(id=NodeId(0, 0), configuration=here, region=room, parent=None, time_s=0.0)
        >>> event = node.added("root")
        >>> event.stage, event.tags
        ('root', '0100')
        """
        return NodeAdded(
            time_s=self.time_s,
            robot=self.id.robot,
            serial=self.id.serial,
            parent=self.parent,
            configuration=(*self.configuration,),
            stage=stage,
            boundary=tuple(zip(*self.region.boundary.T.tolist(), strict=True)),
            tags=(self.region.tags + ord("0")).tobytes().decode(),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Closing:
    """A frontier arc that a robot gave up for good.

    Attributes
    ----------
    id : ClosingId
        Unique in the team.
    node : NodeId
        The node to whose frontier the arc belongs.
    arc : (k, 4) array
        The arc's segments x0, y0, x1, y1 in metres; read-only.
    reason : ClosingReason
        One of `REASONS`, which `multisrt.events.ArcClosed` explains.
    width_m : float
        Width in metres of the body of the robot that gave the arc up.

    Raises
    ------
    InvalidInputError
        For an unknown reason, or an arc that is not an array of segments.

    Examples
    --------
    >>> import numpy as np
    >>> arc = np.array([[0.0, 0.0, 0.0, 0.2]])
    >>> closing = Closing(
    ...     id=ClosingId(0, 0), node=NodeId(1, 5), arc=arc, reason="too narrow", width_m=0.4
    ... )
    >>> closing.arc.flags.writeable
    False
    """

    id: ClosingId
    node: NodeId
    arc: FloatArray
    reason: ClosingReason
    width_m: float

    def __post_init__(self) -> None:
        if self.reason not in REASONS:
            raise InvalidInputError(
                f"an arc is closed for one of {', '.join(REASONS)}, not {self.reason!r}"
            )
        arc = np.array(self.arc, np.float64)
        if arc.ndim != 2 or arc.shape[1] != 4:
            raise InvalidInputError(
                f"a closed arc has segments x0, y0, x1, y1, not the shape {arc.shape}"
            )
        arc.setflags(write=False)
        object.__setattr__(self, "arc", arc)


Entry = Node | Closing

EntryKey = tuple[int, int, int]
"""Which entry: its robot, 0 for a node and 1 for a closing, and its number."""


def key_of(entry: Entry) -> EntryKey:
    """Return which entry this is.

    Examples
    --------
    >>> arc = np.array([[0.0, 0.0, 0.0, 0.2]])
    >>> key_of(
    ...     Closing(
    ...         id=ClosingId(2, 7), node=NodeId(0, 0), arc=arc, reason="too narrow", width_m=0.5
    ...     )
    ... )
    (2, 1, 7)
    """
    robot, number = entry.id
    return robot, int(isinstance(entry, Closing)), number


class WantMessage(Message, frozen=True, kw_only=True):
    """A request to a robot that knows more for what the sender lacks.

    Attributes
    ----------
    have : tuple of (robot, nodes, closings)
        What the sender knows; see `Counts`.
    """

    kind: ClassVar[str] = "want"

    have: Counts

    @property
    def wakes(self) -> bool:
        """True: the message reaches even a moving robot at once."""
        return True


class EntriesMessage(Message, frozen=True, kw_only=True):
    """Nodes and closings that another robot lacks.

    Attributes
    ----------
    entries : tuple of Node or Closing
        Ordered by robot, nodes first, by number.
    """

    kind: ClassVar[str] = "entries"

    entries: tuple[Node | Closing, ...]


class AcknowledgementMessage(Message, frozen=True, kw_only=True, omit_defaults=True):
    """Tells a robot what the base station knows.

    Attributes
    ----------
    have : tuple of (robot, nodes, closings)
        What the base station knows; see `Counts`.
    beyond : tuple of EntryKey
        What it knows besides: entries after a gap, which nobody may ever fill if their maker died.
    """

    kind: ClassVar[str] = "acknowledgement"

    have: Counts
    beyond: tuple[EntryKey, ...] = ()


class Entries:
    """All nodes and closings that a robot knows, by id, with a count by maker.

    Attributes
    ----------
    nodes : dict of NodeId to Node
        In the order in which they became known.
    closings : dict of ClosingId to Closing
        In the order in which they became known.

    Examples
    --------
    >>> import numpy as np
    >>> arc = np.array([[0.0, 0.0, 0.0, 0.2]])
    >>> entries = Entries()
    >>> for number in (0, 1, 3):
    ...     entries.add_closing(
    ...         Closing(
    ...             id=ClosingId(7, number),
    ...             node=NodeId(7, 0),
    ...             arc=arc,
    ...             reason="not reachable",
    ...             width_m=0.4,
    ...         )
    ...     )
    True
    True
    True
    >>> entries.have()
    {7: (0, 2)}
    >>> entries.beyond()
    ((7, 1, 3),)
    >>> [closing.id.number for closing in entries.missing_from({7: (0, 1)})]
    [1, 3]
    """

    __slots__ = ("_counts", "_have", "_lines", "_makers", "closings", "nodes")

    def __init__(self) -> None:
        self.nodes: dict[NodeId, Node] = {}
        self.closings: dict[ClosingId, Closing] = {}
        # By robot, ascending: its nodes and closings that are known, and their counts for messages.
        self._makers: dict[int, tuple[_Numbers, _Numbers]] = {}
        self._lines: dict[int, tuple[int, int, int]] = {}
        self._have: dict[int, tuple[int, int]] | None = None
        self._counts: Counts | None = None

    def add_node(self, node: Node) -> bool:
        """Add a node, unless it is known; return whether it was new."""
        if node.id in self.nodes:
            return False
        self._note(node.id.robot, 0, node.id.serial)
        self.nodes[node.id] = node
        return True

    def add_closing(self, closing: Closing) -> bool:
        """Add a closing, unless it is known; return whether it was new."""
        if closing.id in self.closings:
            return False
        self._note(closing.id.robot, 1, closing.id.number)
        self.closings[closing.id] = closing
        return True

    def have(self) -> dict[int, tuple[int, int]]:
        """Return by robot, ascending, how many nodes and closings are known without a gap.

        The dictionary that is returned never changes.
        """
        if self._have is None:
            self._have = {robot: (nodes, closings) for robot, nodes, closings in self.counts()}
        return self._have

    def counts(self) -> Counts:
        """Return the same as `have`, for a message."""
        if self._counts is None:
            self._counts = (*self._lines.values(),)
        return self._counts

    def beyond(self) -> tuple[EntryKey, ...]:
        """Return what is known beyond `have`: after a gap in the numbers of a robot."""
        return tuple(
            (robot, which, number)
            for robot, both in self._makers.items()
            for which, numbers in enumerate(both)
            for number in sorted(numbers.beyond)
        )

    def missing_from(
        self, theirs: CountsByRobot, beyond: Collection[EntryKey] = ()
    ) -> tuple[Entry, ...]:
        """Return the entries that another robot lacks.

        Parameters
        ----------
        theirs : mapping of int to (nodes, closings)
            What that robot has, as `have` returns it.
        beyond : collection of EntryKey
            What it has besides, as `beyond` returns it, as far as that is known.

        Returns
        -------
        tuple of Node or Closing
            All others that are known, ordered by robot, nodes first, by number.
        """
        missing: list[Entry] = []
        for robot, (nodes, closings) in self._makers.items():
            node_count, closing_count = theirs.get(robot, (0, 0))
            if nodes.end > node_count:
                missing += [self.nodes[NodeId(robot, n)] for n in nodes.since(node_count)]
            if closings.end > closing_count:
                known = closings.since(closing_count)
                missing += [self.closings[ClosingId(robot, n)] for n in known]
        return tuple(entry for entry in missing if key_of(entry) not in beyond)

    def has_more_than(self, theirs: CountsByRobot, beyond: Collection[EntryKey] = ()) -> bool:
        """Whether another robot lacks anything; see `missing_from` for what it has."""
        for robot, (nodes, closings) in self._makers.items():
            node_count, closing_count = theirs.get(robot, (0, 0))
            if nodes.end > node_count or closings.end > closing_count:
                return not beyond or len(self.missing_from(theirs, beyond)) > 0
        return False

    def _note(self, robot: int, which: int, number: int) -> None:
        # Count a node of a robot (which: 0), or a closing (1).
        numbers = self._makers.get(robot)
        if numbers is None:
            numbers = _Numbers(), _Numbers()
            self._makers = dict(sorted([*self._makers.items(), (robot, numbers)]))
            self._lines = {maker: self._lines.get(maker, (maker, 0, 0)) for maker in self._makers}
        numbers[which].add(number)
        self._lines[robot] = robot, numbers[0].count, numbers[1].count
        self._have = self._counts = None


class _Numbers:
    # Numbers from 0, added in any order: all below `count`, and some beyond the first gap.

    __slots__ = ("beyond", "count", "end")

    def __init__(self) -> None:
        self.count = 0
        self.end = 0
        self.beyond: set[int] = set()

    def add(self, number: int) -> None:
        if number < 0:
            raise InvalidInputError(f"nodes and closings are numbered from 0, not {number}")
        self.end = max(self.end, number + 1)
        if number != self.count:
            self.beyond.add(number)
            return
        self.count += 1
        while self.count in self.beyond:
            self.beyond.remove(self.count)
            self.count += 1

    def since(self, first: int) -> list[int]:
        known = [*range(first, self.count)]
        if self.beyond:
            known += sorted(n for n in self.beyond if n >= first)
        return known
