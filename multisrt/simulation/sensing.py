"""What range finders measure and which bodies are seen."""

from __future__ import annotations

from collections.abc import Sequence

from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import Scan, take_scan
from multisrt.robots.explorer import Sighting
from multisrt.simulation.robot import Robot
from multisrt.simulation.traffic import Traffic


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
        finder = robot.spec.range_finder
        here = self._traffic.where(robot.number, time_s)
        covered = robot.body.footprint.outline_at(here)
        return take_scan(self._index, here, time_s, finder.range_m, finder.beams, covered)

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
