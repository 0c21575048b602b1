"""What a robot that is to deliver its data knew of the path home, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from multisrt.events import BaseLearned, Learned, NodeAdded, NodeName
from multisrt.explain.words import SAME_MOMENT_S, many
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.recording import Recording
from multisrt.robots.homing.contact import is_certain_contact
from multisrt.robots.robot_self import RadioSelf
from multisrt.spec import StopRule


def delivers(recording: Recording) -> bool:
    """Return whether the robots of a run are to deliver their data to a base station."""
    spec = recording.spec
    return spec.base is not None and spec.options.get("home", "never") != "never"


def home_lines(recording: Recording, robot: int, time_s: float, things: str) -> Iterator[str]:
    """Yield what a robot had to deliver at a time, and whether it knew where; nothing at first.

    Parameters
    ----------
    recording : Recording
        The whole run.
    robot : int
        The robot.
    time_s : float
        The time in seconds.
    things : str
        Name for one of its nodes.

    Yields
    ------
    str
        A line of an explanation; none if the robot does not deliver data.
    """
    if not delivers(recording):
        return
    account, until_s = _account(recording, robot), time_s + SAME_MOMENT_S
    known = account.known_s <= until_s
    lacking = np.count_nonzero(known & (account.at_base_s > until_s))
    number = int(np.count_nonzero(known))
    yield f"of the {many(number, things)} that it knew, the base station in fact lacked {lacking}"
    limit_s = recording.spec.stop.max_time_s
    if limit_s < StopRule().max_time_s:
        yield f"{limit_s - time_s:.0f} s were left of the time limit of {limit_s:g} s"
    if account.contact_s > until_s:
        yield "it knew no place where the base station is certain to hear it"


def knows_contact(recording: Recording, robot: int) -> bool:
    """Return whether a robot came to know a place where the base station is certain to hear it.

    Parameters
    ----------
    recording : Recording
        A run with a base station.
    robot : int
        The robot.
    """
    return math.isfinite(_account(recording, robot).contact_s)


class _Account(NamedTuple):
    """When a robot knew each node and the base station did (s, ``inf``: never), and a contact."""

    known_s: FloatArray
    at_base_s: FloatArray
    contact_s: float


_ACCOUNTS: WeakKeyDictionary[Recording, dict[int, _Account]] = WeakKeyDictionary()


def _account(recording: Recording, robot: int) -> _Account:
    accounts = _ACCOUNTS.setdefault(recording, {})
    if robot not in accounts:
        accounts[robot] = _account_of(recording, robot)
    return accounts[robot]


def _account_of(recording: Recording, robot: int) -> _Account:
    nodes = {(node.robot, node.serial): node for node in recording.of(NodeAdded)}
    known_s = {name: node.time_s for name, node in nodes.items() if node.robot == robot}
    for event in recording.of(Learned):
        if event.robot == robot:
            for name in event.nodes:
                known_s.setdefault(name, event.time_s)
    at_base_s: dict[NodeName, float] = {}
    for learned in recording.of(BaseLearned):
        for name in learned.nodes:
            at_base_s.setdefault(name, learned.time_s)
    base, radio = recording.spec.base, recording.spec.radio
    assert base is not None
    sheet = RadioSelf(range_m=radio.reach_m, walls_matter=radio.walls_matter)
    contacts = (
        time_s
        for name, time_s in known_s.items()
        if is_certain_contact(
            base.place, sheet, nodes[name].configuration, recording.region(nodes[name])
        )
    )
    return _Account(
        np.array([*known_s.values()], dtype=np.float64),
        np.array([at_base_s.get(name, math.inf) for name in known_s], dtype=np.float64),
        min(contacts, default=math.inf),
    )
