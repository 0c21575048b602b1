"""Explorers outside the simulation: on a real robot, or in another simulator."""

from multisrt.driving.body import Arrived, Body
from multisrt.driving.driver import Driver, drive
from multisrt.driving.team_recording import recording_of
from multisrt.geometry.regions.readings import scan_of_polygon, scan_of_ranges
from multisrt.robots.encoding import decode, encode

__all__ = [
    "Arrived",
    "Body",
    "Driver",
    "decode",
    "drive",
    "encode",
    "recording_of",
    "scan_of_polygon",
    "scan_of_ranges",
]
