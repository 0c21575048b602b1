"""The motion that a car is making, and the motions by which it can always continue from there.

A car must never be caught. The *exit* from a configuration is a sequence of motions, known to be
free, that lead away from it. A car that can reverse goes back as it came. One that cannot sets out
only on motions from whose end it knows another one back to its exit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from multisrt.planners.motion.kinematics import Car
from multisrt.planners.motion.trajectory import Trajectory, standing_at
from multisrt.robots.frontier.course import Course

MAX_STARTS = 16
"""Bounds the number of places on the exit to which a car that cannot reverse may come back..."""

START_SPACING = 1.0
"""... and their spacing, in turning radii."""

DRIVEN_SHARE = 1.0 - 1e-12
"""A motion of which this share has been driven is over."""

SAME_TIME_S = 1e-9
"""Times that differ by less than this are equal."""

Exit = tuple[Trajectory, ...]
"""Motions, each of which begins where the one before it ends. The last in the tuple comes first."""


class Excursion(NamedTuple):
    """A motion to somewhere, from here or from a place on the exit, and how to continue from there.

    Attributes
    ----------
    first : Trajectory
        The beginning of the exit, up to that place.
    out : Trajectory
        The motion from there.
    back : Trajectory
        A motion from the end of `out` to the exit.
    home_s : float
        Time in seconds along the exit at which `back` meets it.
    """

    first: Trajectory
    out: Trajectory
    back: Trajectory
    home_s: float


@dataclass(frozen=True, slots=True)
class Leg:
    """A motion in progress, or to come.

    Attributes
    ----------
    motion : Trajectory
        The whole motion.
    exit : tuple of Trajectory
        The exit from its end, or from where `back` ends.
    back : Trajectory or None
        From its end to the exit; None if the motion itself is part of an exit.
    driven_s : float
        How long it has been driven, in seconds.
    """

    motion: Trajectory
    exit: Exit
    back: Trajectory | None
    driven_s: float = 0.0

    @property
    def rest(self) -> Trajectory:
        """The rest of the motion."""
        return self.motion.after(self.driven_s)

    @property
    def is_driven(self) -> bool:
        """Whether the motion is over."""
        left_s = self.motion.duration_s - self.driven_s
        return left_s <= SAME_TIME_S or self.driven_s >= self.motion.duration_s * DRIVEN_SHARE

    def exit_from_end(self) -> Exit:
        """Return the exit from its end."""
        return self.exit if self.back is None else (*self.exit, self.back)

    def exit_from_here(self, reverse: bool) -> Exit:
        """Return the exit from where the car is; a car that reverses need not go to the end."""
        if reverse and self.back is not None:
            return *self.exit, self.motion.until(self.driven_s).reversed()
        return *self.exit_from_end(), self.rest


class Route:
    """The current motion of a car, and its exit.

    Parameters
    ----------
    car : Car
        How it moves.
    course : Course
        Where it is.
    """

    def __init__(self, car: Car, course: Course) -> None:
        self._car = car
        self._course = course
        # The motion in progress: perhaps along a part of the exit first, then out.
        self._legs: list[Leg] = []
        # The exit from the end of the last leg that was driven.
        self._exit: Exit = ()

    @property
    def rest(self) -> Trajectory | None:
        """The rest of the leg in progress; None if there is none."""
        return self._legs[0].rest if self._legs else None

    def take(self, plan: Excursion) -> None:
        """Replace the legs by those of a plan."""
        exit = self.exit()
        self._legs = [Leg(plan.out, exit_after(exit, plan.home_s), plan.back)]
        if plan.first.duration_s > 0.0:
            self._legs.insert(0, Leg(plan.first, exit_after(exit, plan.first.duration_s), None))

    def take_exit(self, first: Trajectory) -> None:
        """Replace the legs by the beginning of the exit."""
        self._legs = [Leg(first, exit_after(self.exit(), first.duration_s), None)]

    def note_driven(self, duration_s: float) -> None:
        """Record for how long the leg in progress was driven."""
        leg = replace(self._legs[0], driven_s=self._legs[0].driven_s + duration_s)
        if leg.is_driven:
            self._exit = leg.exit_from_end()
            del self._legs[0]
        else:
            self._legs[0] = leg

    def exit(self) -> Exit:
        """Return the exit from where the car is."""
        return self._legs[0].exit_from_here(self._car.reverse) if self._legs else self._exit

    def exit_starts(self) -> list[Trajectory]:
        """Return beginnings of the exit, in equal steps of time; the first has no length."""
        apart_s = START_SPACING * self._car.turning_radius_m / self._car.speed_m_s
        motion = standing_at(self._course.at)
        for piece in reversed(self.exit()):
            if motion.duration_s >= MAX_STARTS * apart_s:
                break
            motion = motion.then(piece)
        count = min(MAX_STARTS, math.ceil(motion.duration_s / apart_s))
        return [motion.until(k * apart_s) for k in range(count + 1)]


def exit_after(exit: Exit, time_s: float) -> Exit:
    """Return what remains of an exit after following it for some time."""
    for k in reversed(range(len(exit))):
        if exit[k].duration_s > time_s + SAME_TIME_S:
            return *exit[:k], exit[k].after(time_s)
        time_s -= exit[k].duration_s
    return ()
