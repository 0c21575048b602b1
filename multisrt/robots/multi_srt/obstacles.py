"""Bodies of other robots that a robot plans around."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np

from multisrt.geometry.bodies.clearance import paths_keep_clear
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.distances import inside
from multisrt.geometry.numerics.kernel import BoolArray, FloatArray
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, standing_at
from multisrt.robots.explorer import Sighting
from multisrt.robots.protective_stop import conflict, max_gap

UNMOVED_M = 0.001
"""A body that is seen at most this far from where it was, in metres, has not moved."""


class Obstacles:
    """Robots that are treated as obstacles, where they were last seen.

    Robots that answer are mostly no obstacles: they take part in the coordination of a step, and
    may be ordered to give way.

    Parameters
    ----------
    body : PlanningBody
        The robot's own body.
    guard_m : float
        Distance of its protective stop, in metres.

    Attributes
    ----------
    silent : dict of int to Sighting
        Robots that do not answer.
    avoided : dict of int to Sighting
        Robots that answer, but are left out of the groups or did not clear the way; forgotten
        after the next step.
    """

    def __init__(self, body: PlanningBody, guard_m: float) -> None:
        self.silent: dict[int, Sighting] = {}
        self.avoided: dict[int, Sighting] = {}
        self._body = body
        self._guard_m = guard_m

    def __bool__(self) -> bool:
        return bool(self.silent or self.avoided)

    @property
    def all(self) -> dict[int, Sighting]:
        """All bodies to plan around, by the number of the robot."""
        return {**self.silent, **self.avoided}

    def forget_gone(self, seen: tuple[Sighting, ...], view: FloatArray | None) -> None:
        """Remove the bodies that are not where they were seen last.

        Parameters
        ----------
        seen : tuple of Sighting
            All bodies in sight now.
        view : (n, 2) array or None
            Boundary of the region in which a body would be seen now.
        """
        in_sight = {sighting.robot: sighting for sighting in seen}
        for standing in (self.silent, self.avoided):
            for number, sighting in list(standing.items()):
                if is_gone(sighting, in_sight, view):
                    del standing[number]

    def blocking(self, at: Configuration, motion: Trajectory) -> int | None:
        """Return a robot whose body would stop a motion that begins at `at`, or None."""
        bodies = self.all
        if not bodies:
            return None
        sweep = Sweep(self._body.footprint, motion)
        own_body = Sweep(self._body.footprint, standing_at(at))
        for number, sighting in bodies.items():
            body = Sweep(sighting.footprint, standing_at(sighting.configuration))
            if conflict(sweep, own_body, body, body, self._guard_m):
                return number
        return None

    @property
    def berths(self) -> FloatArray:
        """Position of every body and the minimum distance of this body's centre to it, ``(n, 3)``.

        For straight paths in any heading; x, y and distance in metres.
        """
        return self._berths(self.all)

    def _berths(self, bodies: Mapping[int, Sighting]) -> FloatArray:
        own = self._body.outer_radius_m + max_gap(self._guard_m)
        rows = [
            (*sighting.configuration[:2], own + sighting.footprint.circumscribed_radius_m)
            for sighting in bodies.values()
        ]
        return np.array(rows).reshape(-1, 3)

    def are_passed_by(self, paths: FloatArray) -> BoolArray:
        """Return which straight paths ``(n, 4)`` keep off all bodies, in any heading."""
        return paths_keep_clear(paths, self.berths)

    def on(self, paths: FloatArray) -> dict[int, Sighting]:
        """Return the bodies, by robot, that some of these straight paths do not keep off."""
        return {
            number: sighting
            for number, sighting in self.all.items()
            if not paths_keep_clear(paths, self._berths({number: sighting})).all()
        }

    @contextmanager
    def ignored(self) -> Iterator[None]:
        """Plan as if no body stood there, for the duration of a block."""
        kept = self.silent, self.avoided
        self.silent, self.avoided = {}, {}
        try:
            yield
        finally:
            self.silent, self.avoided = kept


def is_gone(then: Sighting, in_sight: Mapping[int, Sighting], view: FloatArray | None) -> bool:
    """Whether a body is no longer where it was seen.

    Parameters
    ----------
    then : Sighting
        Where it was seen.
    in_sight : mapping of int to Sighting
        All bodies in sight now, by robot.
    view : (n, 2) array or None
        Boundary in metres of the region in which it would be seen now; None: it may be anywhere.
    """
    x, y, _ = place = then.configuration
    if then.robot in in_sight:
        return place.distance(in_sight[then.robot].configuration) > UNMOVED_M
    return view is not None and inside(view, x, y)
