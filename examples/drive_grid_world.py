"""Explore a simulator of someone else's making with SRT-Radial: one robot, then two.

`grid_world.py` knows nothing of multisrt. Three callables drive one robot in it: `sense`, `move`
and `send`; two robots that talk to each other need a fourth, `receive`. Run it:

    python examples/drive_grid_world.py

Two robots cover 95 % of so small a world sooner than one does. What is left along its walls takes
them longer, as they wait for each other there.
"""

import math
import sys
from functools import partial
from pathlib import Path

import numpy as np
import shapely

import multisrt as ms
from multisrt.driving import Arrived, Body, Driver, recording_of, scan_of_ranges
from multisrt.events import Sent
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.explorer import Moved, RobotSelf, Sighting, TimedOut

sys.path.insert(0, str(Path(__file__).parent))
from grid_world import GridRobot, GridWorld

MAP = """
########################
#..........#...........#
#..........#...........#
#..........#...........#
#..........#....##.....#
#...............##.....#
#......................#
#..........#...........#
#####..#####...........#
#..........#####..######
#..........#...........#
#..........#...........#
#......................#
#......................#
#..........#...........#
########################
"""
CELL_M, RANGE_M, BEAMS = 0.5, 4.0, 720
SPEC = ms.RobotSpec(
    footprint="disc:0.2", range_finder=ms.RangeFinderSpec(range_m=RANGE_M, beams=BEAMS)
)


class GridBody:
    """Commands one robot of the grid world, in the words of multisrt."""

    def __init__(self, world: GridWorld, number: int) -> None:
        self.world, self.number = world, number
        self.robot = world.robots[number]
        self.guard_m: float | None = None
        self.is_moving = False

    def sense(self):
        """Return a scan."""
        ranges = self.world.laser(self.robot, BEAMS, RANGE_M)
        return scan_of_ranges(ranges, self.place(), time_s=self.world.time_s, range_m=RANGE_M)

    def move(self, move):
        """Set out on the way; `receive` tells when it has ended."""
        self.robot.route = [waypoint[1:] for waypoint in move.trajectory.waypoints]
        self.guard_m, self.is_moving = move.guard_m, True

    def drive_to_the_end(self, move):
        """Drive to the end of the path: for a robot alone, which nothing else has to wait for."""
        self.move(move)
        while self.robot.route:
            self.world.step()
        return self.stop()

    def stop(self, blocked_by=None):
        """End the motion here and now."""
        self.robot.route, self.is_moving = [], False
        here = self.place()
        return Moved(configuration=here, time_s=self.world.time_s, blocked_by=blocked_by)

    def send(self, data, to):
        """Send bytes to one robot, or to all others."""
        others = [k for k in range(len(self.world.robots)) if k != self.number]
        receivers = others if to is None else [to]
        self.world.send(data, [self.world.robots[k] for k in receivers])

    def receive(self, until_s):
        """Report what has happened: the end of the motion, messages, or that it is time."""
        if self.is_moving:
            near = [seen for seen in self.look() if self.is_too_near(seen)]
            if near or not self.robot.route:
                return self.stop(near[0] if near else None)
        if self.robot.inbox:
            data, self.robot.inbox = tuple(self.robot.inbox), []
            return Arrived(data=data, time_s=self.world.time_s)
        return TimedOut(self.world.time_s) if self.world.time_s >= until_s else None

    def look(self):
        """Return the other robots in sight."""
        return [
            Sighting(
                robot=k,
                configuration=Configuration(other.x, other.y, other.heading),
                footprint=ms.Footprint.disc(other.radius_m),
            )
            for k, other in enumerate(self.world.robots)
            if k != self.number and self.world.sees(self.robot, other, RANGE_M)
        ]

    def is_too_near(self, seen):
        """Whether the robot drives towards another that is nearer than the guard distance."""
        if self.guard_m is None:
            return False
        x, y = seen.configuration.x - self.robot.x, seen.configuration.y - self.robot.y
        ahead = x * math.cos(self.robot.heading) + y * math.sin(self.robot.heading)
        radii_m = self.robot.radius_m + seen.footprint.radius_m
        return math.hypot(x, y) - radii_m < self.guard_m and ahead > 0.0

    def place(self):
        """Return where the robot is."""
        return Configuration(self.robot.x, self.robot.y, self.robot.heading)

    def knows(self):
        """Return what the robot knows of itself."""
        return RobotSelf(
            robot=self.number,
            start=self.place(),
            footprint=ms.Footprint.disc(self.robot.radius_m),
            kinematics=Differential(
                speed_m_s=self.robot.speed_m_s, turn_rate_rad_s=self.robot.turn_rad_s
            ),
            range_m=RANGE_M,
            rng=np.random.default_rng([1, self.number]),
            team=len(self.world.robots),
        )


def explore_alone() -> tuple[GridWorld, list[Driver]]:
    """Explore with one robot: every motion is driven to its end before the next decision."""
    world = GridWorld(MAP, CELL_M)
    world.robots = [GridRobot(2.0, 6.0, 0.0)]
    body = GridBody(world, 0)
    driver = ms.drive("srt-radial", body.knows(), sense=body.sense, move=body.drive_to_the_end)
    return world, [driver]


def explore_together() -> tuple[GridWorld, list[Driver]]:
    """Explore with two robots that talk: a loop lets time pass, and asks each what it does."""
    world = GridWorld(MAP, CELL_M)
    world.robots = [GridRobot(2.0, 6.0, 0.0), GridRobot(10.0, 6.0, math.pi)]
    bodies = [GridBody(world, k) for k in range(2)]
    team = []
    for body in bodies:
        commands = Body(
            sense=body.sense,
            move=body.move,
            send=body.send,
            receive=body.receive,
            look=body.look,
            stop=body.stop,
        )
        team.append(Driver("srt-radial", body.knows(), commands))
    while True:
        for driver in team:
            driver.poll()
        if all(driver.is_done for driver in team):
            break
        world.step()
    return world, team


def environment(world: GridWorld) -> ms.Environment:
    """Return the grid as an environment, to measure and to draw what was explored."""
    row, column = np.nonzero(~world.walls)
    boxes = shapely.box(column, row, column + 1, row + 1)
    free = shapely.transform(shapely.union_all(boxes), partial(np.multiply, world.cell_m))
    return ms.Environment("grid world", free)


def main(folder: Path = Path("out/examples")) -> None:
    """Explore, and save pictures to a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, explore in (("alone", explore_alone), ("together", explore_together)):
        world, team = explore()
        recording = recording_of(team, environment(world), robots=[SPEC] * len(team))
        run = ms.Run(recording)
        run.save_svg(folder / f"drive_grid_world_{name}.svg")
        sent = sum(isinstance(event, Sent) for event in recording.events)
        print(
            f"{name}: 95 % covered after {run.metrics.time_to_95_s:.0f} s, "
            f"{run.outcome} after {world.time_s:.0f} s, "
            f"{100 * run.metrics.coverage:.1f} % covered, {sent} messages"
        )


if __name__ == "__main__":
    main()
