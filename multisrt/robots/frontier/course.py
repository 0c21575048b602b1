"""The course of one robot: its clock, its configuration, and where it is driving."""

from __future__ import annotations

import math

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.numerics.distances import length_of
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.planners.navigation.path_following import ahead
from multisrt.robots.frontier.goal import Goal, Place

LEFT_M = 0.01
"""A robot that was farther from its start than this has left it, in metres."""


class Course:
    """Where a robot is and where it is going.

    Parameters
    ----------
    at : Configuration
        Where the robot stands.
    time_s : float
        Time of its clock in seconds.

    Attributes
    ----------
    at : Configuration
        Where it stands; during a motion, where that motion began.
    time_s : float
        Time of the last outcome that it received, in seconds.
    goal : Goal or None
        Where it is going.
    goal_chosen_s : float
        When the goal was chosen; ``-inf`` before the first choice.
    goal_revision : int
        Revision of the raster by which it was chosen.
    motion : Trajectory or None
        The motion in progress.
    set_out_s : float
        When the last motion began.
    stuck_at : (x, y) or None
        Where it stood when a path from exactly there was not free.
    has_left : bool
        Whether a motion has ended away from the start.

    Examples
    --------
    >>> from multisrt.planners.motion.kinematics import Holonomic
    >>> course = Course(Configuration(0.0, 0.0, 0.0), 10.0)
    >>> course.now_at()
    Configuration(x=0.0, y=0.0, heading=0.0)
    """

    def __init__(self, at: Configuration, time_s: float) -> None:
        self.at = at
        self.time_s = time_s
        self.goal: Goal | None = None
        self.goal_chosen_s = -math.inf
        self.goal_revision = -1
        self.motion: Trajectory | None = None
        self.set_out_s = 0.0
        self.stuck_at: Place | None = None
        self.has_left = False
        self._start = at[:2]

    @property
    def is_stuck(self) -> bool:
        """Whether paths are to begin beside where the robot stands."""
        return self.stuck_at == self.at[:2]

    def note_no_path(self) -> None:
        """Record that the path was not free: from exactly here, or else from beside here."""
        self.stuck_at = None if self.is_stuck else self.at[:2]

    def set_goal(self, goal: Goal | None, revision: int) -> None:
        """Take a goal that was chosen now, by a revision of the raster."""
        self.goal = goal
        self.goal_chosen_s = self.time_s
        self.goal_revision = revision

    def set_out(self, motion: Trajectory) -> None:
        """Begin a motion."""
        self.motion, self.set_out_s = motion, self.time_s

    def arrive(self, at: Configuration, time_s: float) -> None:
        """End the motion."""
        self.motion = None
        self.at, self.time_s = at, time_s
        self.has_left |= math.dist(at[:2], self._start) > LEFT_M

    def now_at(self) -> Configuration:
        """Return the configuration at this moment, also during a motion."""
        if self.motion is None:
            return self.at
        return self.motion.at(self.time_s - self.set_out_s)

    def remaining_m(self) -> float:
        """Return the length of the path to the goal from where the robot is; 0 without a goal."""
        return 0.0 if self.goal is None else length_of(ahead(self.goal.path, self.now_at()))
