"""Faults of robots during a run."""

from __future__ import annotations

import math
from typing import Literal

from multisrt.geometry.errors import InvalidInputError
from multisrt.spec.part import Part


class Death(Part, frozen=True, kw_only=True, tag_field="fault", tag="death"):
    """A robot dies; its body stays where it is.

    Attributes
    ----------
    robot : int
        The robot, from 0.
    time_s : float
        The earliest time, in seconds from the start of the run.
    when : {"any", "moving", "waiting", "master"}
        State in which the robot dies. ``any``: at `time_s`, whatever it does. Otherwise the first
        time from `time_s` on that it moves (immediately if it is moving at `time_s`, else halfway
        through its next motion, or where that is stopped before), waits, or organises a group as
        its master (Multi-SRT; after it has recorded `multisrt.events.Organized`, and before it
        sends its orders).

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.events import Died
    >>> death = ms.Death(robot=1, time_s=10.0, when="moving")
    >>> run = ms.explore("open", robots=2, seed=1, faults=[death], max_time_s=30.0)
    >>> [event.robot for event in run.recording.of(Died)]
    [1]
    """

    robot: int
    time_s: float
    when: Literal["any", "moving", "waiting", "master"] = "any"


class Silence(Part, frozen=True, kw_only=True, tag_field="fault", tag="silence"):
    """The radio of a robot fails for a while.

    Attributes
    ----------
    robot : int
        The robot, from 0.
    time_s : float
        Time of the failure, in seconds from the start of the run.
    duration_s : float
        Duration of the failure, in seconds.

    Raises
    ------
    InvalidInputError
        If the duration is not positive and finite.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.events import CameBack, FellSilent
    >>> silence = ms.Silence(robot=0, time_s=5.0, duration_s=10.0)
    >>> run = ms.explore("open", robots=2, seed=1, faults=[silence], max_time_s=30.0)
    >>> run.recording.of(FellSilent)[0].time_s, run.recording.of(CameBack)[0].time_s
    (5.0, 15.0)
    """

    robot: int
    time_s: float
    duration_s: float

    def __post_init__(self) -> None:
        if not 0.0 < self.duration_s < math.inf:
            raise InvalidInputError(
                f"a silence lasts a positive number of seconds, not {self.duration_s:g}"
            )


class LateStart(Part, frozen=True, kw_only=True, tag_field="fault", tag="late_start"):
    """A robot is switched off at its start and begins late.

    Attributes
    ----------
    robot : int
        The robot, from 0.
    time_s : float
        Time at which it begins, in seconds from the start of the run.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.events import Joined
    >>> late = ms.LateStart(robot=1, time_s=12.0)
    >>> run = ms.explore("open", robots=2, seed=1, faults=[late], max_time_s=30.0)
    >>> [(event.robot, event.time_s) for event in run.recording.of(Joined)]
    [(1, 12.0)]
    """

    robot: int
    time_s: float


Fault = Death | Silence | LateStart
