"""Costs of robots to frontiers for `gain` and `routes`, on a robot's own map."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from multisrt.planners.motion.kinematics import Car, Differential
from multisrt.robots.frontier.path_costs import first_turns, lengths_among, present_goals

CELL_M = 0.1


def robot_at(place: tuple[float, float, float], **others: Any) -> Any:
    """A robot, in place of a `FrontierRobot`, with what turns and areas need."""
    return SimpleNamespace(
        me=SimpleNamespace(
            robot=0, range_m=4.0, kinematics=others.pop("kinematics", Differential())
        ),
        at=place,
        options=SimpleNamespace(saves_turns=others.pop("saves_turns", False)),
        team=SimpleNamespace(teammates=SimpleNamespace(reports=others.pop("reports", {}))),
        **others,
    )


TARGETS = np.array([[5.0, 1.0], [-3.0, 1.0], [1.0, 4.0], [0.0, 0.0]])


def test_first_turns_face_the_targets():
    robot = robot_at((1.0, 1.0, 0.0))
    found = first_turns(robot, (0,), TARGETS)
    assert found[0] == pytest.approx([0.0, math.pi, 0.5 * math.pi, 0.75 * math.pi])


def test_robots_that_drive_backwards_turn_by_a_right_angle_at_most():
    robot = robot_at((1.0, 1.0, 0.0), saves_turns=True)
    found = first_turns(robot, (0,), TARGETS)
    assert found[0] == pytest.approx([0.0, 0.0, 0.5 * math.pi, 0.25 * math.pi])


@pytest.mark.parametrize("reverse", [True, False])
def test_only_cars_that_drive_backwards_save_turns(reverse: bool):
    robot = robot_at((1.0, 1.0, 0.0), saves_turns=True, kinematics=Car(reverse=reverse))
    found = first_turns(robot, (0,), TARGETS)
    assert found[0, 1] == pytest.approx(0.0 if reverse else math.pi)


def test_first_turns_of_others_are_those_of_their_reports():
    reports = {3: SimpleNamespace(place=(1.0, 0.0, -math.pi))}
    found = first_turns(robot_at((1.0, 1.0, 0.0), reports=reports), (0, 3), TARGETS)
    assert found.shape == (2, 4)
    assert found[1] == pytest.approx(
        [math.atan2(1.0, 4.0) * -1 + math.pi, math.atan2(1.0, 4.0), 0.5 * math.pi, 0.0]
    )


def test_present_goals_are_targets_near_by():
    # Robot 0 drives to 0.6 m from target 1, robot 3 to more than 1 m from all; robot 4 has no goal.
    reports = {3: SimpleNamespace(goal=(8.0, 8.0)), 4: SimpleNamespace(goal=None)}
    robot = robot_at((0.0, 0.0, 0.0), reports=reports, goal=SimpleNamespace(place=(-3.0, 1.6)))
    found = present_goals(robot, (0, 3, 4), TARGETS)
    assert np.argwhere(found).tolist() == [[0, 1]]
    reports[3].goal = (5.2, 1.0)
    assert np.argwhere(present_goals(robot, (0, 3, 4), TARGETS)).tolist() == [[0, 1], [1, 0]]


def test_lengths_among_targets_lie_between_their_bounds():
    # A wall without a gap in reach: the path leads past the robot, 30 cells and 20 cells away.
    passable = np.ones((20, 90), bool)
    passable[:, 40:45] = False
    raster = SimpleNamespace(cell_m=CELL_M, passable=passable)
    cells = np.array([[10, 10], [10, 34], [10, 60]])
    robot = robot_at((0.0, 0.0, 0.0), raster=raster, indices_of=lambda _: cells)
    targets = cells[:, ::-1] * CELL_M
    distances = np.hypot(*(targets[:, None] - targets).transpose(2, 0, 1))
    found = lengths_among(robot, targets, np.array([3.0, 2.0, 9.0]), distances)
    assert found[0, 1] == pytest.approx(2.4)
    assert found[0, 2] == 12.0
    assert found[1, 2] == 11.0
