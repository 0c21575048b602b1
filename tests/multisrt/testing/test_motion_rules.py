import numpy as np
import pytest

from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import Move, Sense
from multisrt.spec import DriveSpec, RobotSpec
from tests.multisrt.testing.explorers import check, explorer, refused


def move_along(*waypoints: tuple[float, float, float, float]) -> Move:
    return Move(trajectory=Trajectory(tuple(Waypoint(*w) for w in waypoints)))


@pytest.mark.parametrize(
    ("move", "match"),
    [
        (move_along((0, 3.5, 3, 0), (9, 4, 3, 0)), r"begins at \(3.500.*is at \(3.000"),
        (move_along((0, 3, 3, 0.1), (9, 3, 3, 0)), "begins at"),
        (move_along((0, 3, 3, 0), (9, float("nan"), 3, 0)), "waypoint 1"),
        (move_along((0, 3, 3, 0), (float("inf"), 4, 3, 0)), "waypoint 1"),
        (move_along((0, 3, 3, 0), (4, 3.1, 3, 0), (3, 3.2, 3, 0)), "waypoint 2 .* at 3 s"),
        (move_along((1, 3, 3, 0), (4, 3.1, 3, 0)), "waypoint 0 .* at 1 s"),
        (move_along((0, 3, 3, 0), (1, 3.6, 3, 0)), "0.5 m/s"),
        (move_along((0, 3, 3, 0), (0, 3.6, 3, 0)), "0.5 m/s"),
        (move_along((0, 3, 3, 0), (1.99, 4, 3, 0)), "0.5 m/s"),
        (move_along((0, 3, 3, 0), (1, 3, 3, 1.6)), "rad/s"),
        (move_along((0, 3, 3, 0), (9, 3, 3.5, 0)), "sideways"),
    ],
)
def test_motions_that_the_body_cannot_make(move, match):
    refused(explorer(lambda self: iter([Sense(), move])), match)


def test_the_limits_themselves_are_allowed():
    turn = move_along((0, 3, 3, 0), (1, 3, 3, 0.5 * np.pi))
    drive = move_along((0, 3, 3, 0.5 * np.pi), (2, 3, 4, 0.5 * np.pi))
    check(explorer(lambda self: iter([Sense(), turn, drive])))


@pytest.mark.parametrize(
    ("drive", "move", "match"),
    [
        ("holonomic", move_along((0, 3, 3, 0), (9, 3.5, 3.5, 0.1)), "keeps its heading"),
        ("reeds-shepp", move_along((0, 3, 3, 0), (9, 3, 3, 1)), "too tight"),
        ("dubins", move_along((0, 3, 3, 0), (9, 2.5, 3, 0)), "backwards"),
        ("holonomic", move_along((0, 3, 3, 0), (9, 3.5, 3.5, 0.0)), None),
        ("reeds-shepp", move_along((0, 3, 3, 0), (9, 2.5, 3, 0)), None),
        ("reeds-shepp", move_along((0, 3, 3, 0), (9, 3.6, 3.6, 0.5 * np.pi)), None),
    ],
)
def test_each_drive_allows_only_its_own_motions(drive, move, match):
    make = explorer(lambda self: iter([Sense(), move]))
    robot = RobotSpec(start=(3.0, 3.0), drive=DriveSpec(kind=drive))
    if match is None:
        check(make, robot=robot)
    else:
        refused(make, match, robot=robot)
