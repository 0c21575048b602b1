"""Whether a robot that records nodes was sent nodes of other robots."""

from __future__ import annotations

from multisrt.events import NodeAdded
from multisrt.robots.explorer import Note, Received
from multisrt.robots.knowledge import Node
from multisrt.robots.message_contents import entries_in
from multisrt.testing.supervision import SupervisedExplorer


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
        isinstance(entry, Node)
        for turn in robot.turns
        if isinstance(turn.outcome, Received)
        for message in turn.outcome.messages
        for entry in entries_in(message)
    )
