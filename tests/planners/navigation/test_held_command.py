import math

import numpy as np
import pytest

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic
from multisrt.planners.navigation.held_command import known_clearance, motion, safe_time
from multisrt.planners.navigation.nearness_diagram import Command

DRIVE = Differential(speed_m_s=0.5, turn_rate_rad_s=math.pi / 2)
ANYWAYS = Holonomic(speed_m_s=0.5)
AHEAD = Command(0.5, 0.0, 0.0, "goal", 0.0, math.nan, math.nan)


def test_a_differential_drive_follows_an_arc():
    held = Command(0.5, 1.0, 0.4, "goal", 0.4, math.nan, math.nan)
    driven = motion(held, DRIVE, Configuration(1.0, 2.0, 0.3), 0.5)
    assert driven.length_m == pytest.approx(0.25)
    assert driven.duration_s == 0.5
    assert driven.waypoints[-1].heading == pytest.approx(0.8)
    # About the centre that lies v / w = 0.5 m to the left.
    centre = (1.0 - 0.5 * math.sin(0.3), 2.0 + 0.5 * math.cos(0.3))
    assert math.dist(driven.end[:2], centre) == pytest.approx(0.5)
    straight = motion(held._replace(turn_rate_rad_s=0.0), DRIVE, Configuration(1.0, 2.0, 0.0), 0.5)
    assert straight.end == pytest.approx((1.25, 2.0, 0.0))


def test_a_holonomic_drive_does_not_turn():
    held = Command(0.5, 0.0, math.pi / 2, "goal", 0.4, math.nan, math.nan)
    assert motion(held, ANYWAYS, Configuration(1.0, 2.0, math.pi / 2), 0.2).end == pytest.approx(
        (0.9, 2.0, math.pi / 2)
    )


def test_cars_and_zero_durations_are_rejected():
    with pytest.raises(InvalidInputError, match="car cannot turn in place"):
        motion(AHEAD, Car(), Configuration(0.0, 0.0), 0.2)
    with pytest.raises(InvalidInputError, match="positive time"):
        motion(AHEAD, DRIVE, Configuration(0.0, 0.0), 0.0)


def test_safe_time():
    assert safe_time(AHEAD, 0.45, 0.25) == pytest.approx(0.4)
    assert safe_time(AHEAD, 0.45, 0.25, margin_m=0.1) == pytest.approx(0.2)
    assert safe_time(AHEAD, 0.2, 0.25) == 0.0
    assert safe_time(AHEAD._replace(speed_m_s=0.0), 0.2, 0.25) == math.inf


def test_known_clearance():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    at = Configuration(1.0, 2.0)
    assert known_clearance(square, at) == 1.0
    assert known_clearance(square, at, np.array([[2.0, 2.0, 0.3]])) == pytest.approx(0.7)
    assert known_clearance(square, at, np.array([[1.2, 2.0, 0.3]])) == 0.0
    assert known_clearance(square, at, np.empty((0, 3))) == 1.0
    assert known_clearance(square, Configuration(5.0, 2.0)) == 0.0
