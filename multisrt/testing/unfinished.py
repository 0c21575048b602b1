"""Robots that end without having completed their exploration, and which body blocks them."""

from __future__ import annotations

from dataclasses import dataclass

from multisrt.events import Blocked, Ended, Motion
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.recording import Recording
from multisrt.robots.defects import brief

MAX_GAP_M = 0.5
"""Maximum distance between the circles round two bodies that stand beside each other, in metres."""

MAX_REASON_LENGTH = 40
"""Characters to which the reason of an end is cut in messages."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unfinished:
    """A robot that has ended without having completed its exploration.

    Attributes
    ----------
    robot : int
        Its number.
    reason : str
        Why it ended, in the words of its explorer.
    blocked_by : int or None
        The robot before which its last motion ended; None if it arrived.
    beside : int or None
        The nearest robot that stands beside it at the end of the run.

    Examples
    --------
    >>> print(Unfinished(robot=1, reason="no way", blocked_by=2, beside=2))
    robot 1 ('no way', stopped before robot 2)
    """

    robot: int
    reason: str
    blocked_by: int | None = None
    beside: int | None = None

    def __str__(self) -> str:
        where = ""
        if self.blocked_by is not None:
            where = f", stopped before robot {self.blocked_by}"
        elif self.beside is not None:
            where = f", beside robot {self.beside}"
        return f"robot {self.robot} ({brief(self.reason, MAX_REASON_LENGTH)}{where})"


def unfinished(recording: Recording) -> tuple[Unfinished, ...]:
    """Return the robots that have ended a run without having completed their exploration.

    Parameters
    ----------
    recording : Recording
        The run.

    Returns
    -------
    tuple of Unfinished
        In the order of their numbers.

    Examples
    --------
    >>> from multisrt import CatalogEnvironment, RunSpec, simulate
    >>> unfinished(simulate(RunSpec(environment=CatalogEnvironment(name="apartment"), seed=1)))
    ()
    """
    places = list(recording.starts)
    blocked_by: dict[int, int | None] = {}
    ends: dict[int, Ended] = {}
    for event in recording.events:
        if isinstance(event, Motion):
            places[event.robot] = Configuration(*event.waypoints[-1][1:])
            blocked_by[event.robot] = None
        elif isinstance(event, Blocked):
            blocked_by[event.robot] = event.by
        elif isinstance(event, Ended):
            ends[event.robot] = event
    radii = [
        Footprint.parse(robot.footprint).circumscribed_radius_m for robot in recording.spec.robots
    ]
    return tuple(
        Unfinished(
            robot=robot,
            reason=end.reason,
            blocked_by=blocked_by.get(robot),
            beside=_beside(robot, places, radii),
        )
        for robot, end in sorted(ends.items())
        if not end.complete
    )


def _beside(robot: int, places: list[Configuration], radii: list[float]) -> int | None:
    gaps = {
        other: place.distance(places[robot]) - radii[other] - radii[robot]
        for other, place in enumerate(places)
        if other != robot
    }
    nearest = min(gaps, key=gaps.__getitem__, default=None)
    return nearest if nearest is not None and gaps[nearest] <= MAX_GAP_M else None
