"""A hall and a robot in it, for helpers that are tested without a simulation."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import Scan, take_scan
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.explorer import RobotSelf


def _robot(**changes) -> RobotSelf:
    known: dict[str, Any] = {
        "robot": 0,
        "start": Configuration(10.0, 1.5, 0.0),
        "footprint": Footprint.disc(0.25),
        "kinematics": Differential(),
        "range_m": 4.0,
        "rng": np.random.default_rng(0),
    }
    return RobotSelf(**known | changes)


def _scans(*rings) -> Callable[..., Scan]:
    edges = [np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in map(np.array, rings)]
    index = EdgeIndex(np.vstack(edges).astype(float), 4.0 / 3.0)

    def scan(x: float, y: float, time_s: float = 0.0) -> Scan:
        return take_scan(index, Configuration(x, y), time_s, 4.0)

    return scan


@pytest.fixture(scope="session")
def robot() -> Callable[..., RobotSelf]:
    """Build what a robot in the middle of the hall knows of itself."""
    return _robot


@pytest.fixture(scope="session")
def scans() -> Callable[..., Callable]:
    """Return a function that takes scans in a world of rings, outline first."""
    return _scans


@pytest.fixture(scope="session")
def hall() -> Callable:
    """Take scans in a hall of 20 m x 3 m."""
    return _scans([(0, 0), (20, 0), (20, 3), (0, 3)])
