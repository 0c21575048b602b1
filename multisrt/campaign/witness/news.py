"""Robots learn only nodes that reached them in messages; the base station learns all of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import msgspec

from multisrt.campaign.judged_run import ROUNDING_S
from multisrt.campaign.violations import Violation
from multisrt.events import BaseLearned, Learned, NodeName, Sent
from multisrt.robots.knowledge import Node
from multisrt.robots.messages import Message
from multisrt.spec import RunSpec

NAME: Final = "learns-from-messages"


class News:
    """Follows nodes in messages.

    A robot records as learned only nodes that were in messages that it received; the base station
    only those in messages that reach it, no later than latency and jitter after they were sent, and
    all of them. Tolerance: 1e-6 s.

    Parameters
    ----------
    spec : RunSpec
        The run.
    """

    def __init__(self, spec: RunSpec) -> None:
        self._base = len(spec.robots)
        self._delay_s = spec.radio.latency_s + spec.radio.jitter_s
        self._told: list[set[NodeName]] = [set() for _ in spec.robots]
        # By node, until when the base station has to know it.
        self._due_s: dict[NodeName, float] = {}
        self._learned: set[NodeName] = set()
        self._found: Violation | None = None

    def received(self, robot: int, messages: tuple[Message, ...]) -> None:
        """Take what a robot received."""
        for message in messages:
            self._told[robot].update(nodes_in(message))

    def sent(self, event: Sent, message: Message | None) -> None:
        """Take what is sent; of the base station itself the message is None."""
        if message is not None and self._base in event.reached:
            for name in nodes_in(message):
                self._due_s.setdefault(name, event.time_s + self._delay_s)

    def learned(self, event: Learned) -> None:
        """Take what a robot records that it has learned."""
        names = {(name[0], name[1]) for name in event.nodes}
        new = {name for name in names if name[0] != event.robot} - self._told[event.robot]
        if new:
            says = f"robot {event.robot} learns of node {min(new)}, which nobody told it"
            self._violated(says, event.robot, event.time_s)

    def base_learned(self, event: BaseLearned) -> None:
        """Take what the base station records that it has learned."""
        for name in ((name[0], name[1]) for name in event.nodes):
            self._learned.add(name)
            due_s = self._due_s.get(name, math.inf)
            if due_s == math.inf:
                says = f"the base station learns of node {name}, which nobody told it"
                self._violated(says, event.robot, event.time_s)
            elif event.time_s > due_s + ROUNDING_S:
                says = f"the base station learns of node {name} only at {event.time_s:.3f} s"
                self._violated(f"{says}, not by {due_s:.3f} s", event.robot, event.time_s)

    def violations(self, end_s: float) -> Iterator[Violation]:
        """Yield the first violation, if there is one, in a run that ended at a time."""
        for name, due_s in self._due_s.items():
            if name not in self._learned and due_s < end_s - ROUNDING_S:
                says = f"the base station does not learn of node {name}, told by {due_s:.3f} s"
                self._violated(says, name[0], due_s)
        if self._found is not None:
            yield self._found

    def _violated(self, says: str, robot: int, time_s: float) -> None:
        if self._found is None:
            self._found = Violation(invariant=NAME, says=says, robot=robot, time_s=time_s)


def nodes_in(content: object) -> Iterator[NodeName]:
    """Yield the names of the nodes in a message, however deep."""
    if isinstance(content, Node):
        yield content.id.robot, content.id.serial
    elif isinstance(content, msgspec.Struct):
        for name in content.__struct_fields__:
            yield from nodes_in(getattr(content, name))
    elif isinstance(content, tuple | list):
        for part in content:
            yield from nodes_in(part)
