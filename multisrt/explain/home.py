"""What a robot that is to deliver its data knew of the path home, in words."""

from __future__ import annotations

from collections.abc import Iterator

from multisrt.events import BaseLearned, Learned, NodeAdded, NodeName
from multisrt.explain.words import SAME_MOMENT_S, many
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
        The run.
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
    known = _known(recording, robot, time_s)
    at_base = {
        name
        for event in recording.of(BaseLearned)
        if event.time_s <= time_s + SAME_MOMENT_S
        for name in event.nodes
    }
    lacking = len(known.keys() - at_base)
    yield (
        f"of the {many(len(known), things)} that it knew, the base station in fact lacked {lacking}"
    )
    limit_s = recording.spec.stop.max_time_s
    if limit_s < StopRule().max_time_s:
        yield f"{limit_s - time_s:.0f} s were left of the time limit of {limit_s:g} s"
    if not _has_contact(recording, known):
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
    return _has_contact(recording, _known(recording, robot, recording.footer.time_s))


def _known(recording: Recording, robot: int, time_s: float) -> dict[NodeName, NodeAdded]:
    """Return the nodes that a robot had made or learned by a time."""
    until_s = time_s + SAME_MOMENT_S
    made = {
        (node.robot, node.serial): node
        for node in recording.of(NodeAdded)
        if node.time_s <= until_s
    }
    learned = (
        name
        for event in recording.of(Learned)
        if event.robot == robot and event.time_s <= until_s
        for name in event.nodes
    )
    own = (name for name in made if name[0] == robot)
    return {name: made[name] for name in (*own, *learned)}


def _has_contact(recording: Recording, nodes: dict[NodeName, NodeAdded]) -> bool:
    base, radio = recording.spec.base, recording.spec.radio
    assert base is not None
    sheet = RadioSelf(range_m=radio.reach_m, walls_matter=radio.walls_matter)
    return any(
        is_certain_contact(base.place, sheet, node.configuration, recording.region(node))
        for node in nodes.values()
    )
