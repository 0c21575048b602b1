"""Whether a robot that records nodes was sent nodes of other robots."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from multisrt.events import NodeAdded
from multisrt.robots.explorer import Note, Received
from multisrt.robots.knowledge import Node
from multisrt.testing.supervision import SupervisedExplorer

MAX_DEPTH = 6
"""How deep messages are looked into."""


def is_sent_nodes(robot: SupervisedExplorer) -> bool:
    """Return whether a robot has recorded nodes, and was sent messages with nodes of others.

    Parameters
    ----------
    robot : SupervisedExplorer
        The robot, after its run.

    Returns
    -------
    bool
        Whether it did; what it made of the messages is not known.
    """
    notes = any(
        isinstance(turn.action, Note) and isinstance(turn.action.event, NodeAdded)
        for turn in robot.turns
    )
    return notes and any(
        _holds_node(message)
        for turn in robot.turns
        if isinstance(turn.outcome, Received)
        for message in turn.outcome.messages
    )


def _holds_node(value: object, depth: int = 0) -> bool:
    if isinstance(value, Node) or depth > MAX_DEPTH:
        return isinstance(value, Node)
    if isinstance(value, msgspec.Struct):
        parts = [getattr(value, field) for field in value.__struct_fields__]
    elif isinstance(value, Mapping):
        parts = list(value.values())
    elif isinstance(value, tuple | list | set | frozenset):
        parts = list(value)
    else:
        return False
    return any(_holds_node(part, depth + 1) for part in parts)
