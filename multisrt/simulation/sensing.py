"""What range finders measure and which bodies are seen."""

from __future__ import annotations

from collections.abc import Sequence

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import Scan, take_scan
from multisrt.robots.explorer import Sighting
from multisrt.simulation.robot import Robot
from multisrt.simulation.traffic import Traffic
from multisrt.spec import RobotSpec


def measured(robot: RobotSpec, index: EdgeIndex, here: Configuration, time_s: float) -> Scan:
    """Return what the range finder of a robot measures at a configuration.

    Parameters
    ----------
    robot : RobotSpec
        The robot.
    index : EdgeIndex
        The edges of the world.
    here : Configuration
        Its configuration, in metres and radians.
    time_s : float
        Time of the scan in seconds.

    Raises
    ------
    ClearanceError
        If it is not in free space.
    """
    finder, covered = robot.range_finder, None
    if finder.beams is not None:
        covered = Footprint.parse(robot.footprint).outline_at(here)
    return take_scan(index, here, time_s, finder.range_m, finder.beams, covered)


class Sensing:
    """The range finders of all robots.

    Parameters
    ----------
    index : EdgeIndex
        The edges of the world.
    traffic : Traffic
        Where all bodies are.
    robots : sequence of Robot
        The team.
    """

    def __init__(self, index: EdgeIndex, traffic: Traffic, robots: Sequence[Robot]) -> None:
        self._index = index
        self._traffic = traffic
        self._robots = robots

    def scan(self, robot: Robot, time_s: float) -> Scan:
        """Take a scan from where a robot is at a time."""
        return measured(robot.spec, self._index, self._traffic.where(robot.number, time_s), time_s)

    def look(self, robot: Robot, time_s: float) -> tuple[Sighting, ...]:
        """Return the bodies that a robot sees at a time, in the order of their numbers."""
        range_m = robot.spec.range_finder.range_m
        seen = self._traffic.in_sight(robot.number, time_s, range_m)
        return tuple(self.sighting(other, time_s) for other in seen)

    def sighting(self, number: int, time_s: float) -> Sighting:
        """Return a robot's body as others see it at a time."""
        return Sighting(
            robot=number,
            configuration=self._traffic.where(number, time_s),
            footprint=self._robots[number].body.footprint,
        )
