"""A little simulator of its own: robots with lasers and wheels in an occupancy grid.

It stands for a simulator, or a robot's driver, that knows nothing of multisrt: it has its own map,
its own clock of fixed steps, its own lasers, and robots that turn and drive by their wheels.
`drive_grid_world.py` explores it.
"""

import math
from dataclasses import dataclass, field

import numpy as np

STEP_S = 0.05
MARCH_M = 0.01


@dataclass
class GridRobot:
    """A round robot with two wheels and a radio."""

    x: float
    y: float
    heading: float
    radius_m: float = 0.2
    speed_m_s: float = 0.5
    turn_rad_s: float = 1.5
    inbox: list[bytes] = field(default_factory=list)
    route: list[tuple[float, float, float]] = field(default_factory=list)

    def step(self) -> None:
        """Turn or drive towards the next place of the route for one step of the clock."""
        if not self.route:
            return
        x, y, heading = self.route[0]
        left_m = math.hypot(x - self.x, y - self.y)
        aim = heading if left_m < 1e-6 else math.atan2(y - self.y, x - self.x)
        turn = math.remainder(aim - self.heading, math.tau)
        if abs(turn) > 1e-6:
            most = self.turn_rad_s * STEP_S
            self.heading += min(most, max(-most, turn))
        elif left_m >= 1e-6:
            drive_m = min(left_m, self.speed_m_s * STEP_S)
            self.x += drive_m * math.cos(aim)
            self.y += drive_m * math.sin(aim)
        else:
            self.route.pop(0)


class GridWorld:
    """Robots in an occupancy grid, drawn in letters: # is a wall."""

    def __init__(self, drawing: str, cell_m: float) -> None:
        rows = drawing.split()
        self.walls = np.array([[letter == "#" for letter in row] for row in rows[::-1]])
        self.cell_m = cell_m
        self.time_s = 0.0
        self.robots: list[GridRobot] = []

    def step(self) -> None:
        """Let a step of time pass for all robots; none may touch a wall or another."""
        self.time_s += STEP_S
        for robot in self.robots:
            robot.step()
        for k, robot in enumerate(self.robots):
            around = np.linspace(0.0, math.tau, 24)
            rim = robot.radius_m * np.array([np.cos(around), np.sin(around)])
            if self.is_wall(robot.x + rim[0], robot.y + rim[1]).any():
                raise RuntimeError(f"robot {k} has hit a wall at ({robot.x:.2f}, {robot.y:.2f})")
            for other in self.robots[:k]:
                apart_m = math.hypot(other.x - robot.x, other.y - robot.y)
                if apart_m < other.radius_m + robot.radius_m:
                    raise RuntimeError(f"robot {k} has hit another at {self.time_s:.2f} s")

    def is_wall(self, x, y):
        """Whether places in metres are in a wall; arrays are looked up at once."""
        row = np.clip(np.floor(np.asarray(y) / self.cell_m).astype(int), 0, len(self.walls) - 1)
        column = np.floor(np.asarray(x) / self.cell_m).astype(int)
        return self.walls[row, np.clip(column, 0, self.walls.shape[1] - 1)]

    def laser(self, robot: GridRobot, beams: int, range_m: float) -> np.ndarray:
        """March along each beam from the heading on, and return how far it gets in metres."""
        angle = robot.heading + math.tau * np.arange(beams) / beams
        reach = np.arange(MARCH_M, range_m + MARCH_M, MARCH_M)
        x = robot.x + reach[:, None] * np.cos(angle)
        y = robot.y + reach[:, None] * np.sin(angle)
        hit = self.is_wall(x, y)
        first = reach[np.argmax(hit, axis=0)] - MARCH_M
        return np.where(hit.any(axis=0), np.maximum(first, MARCH_M / 2), np.inf)

    def sees(self, robot: GridRobot, other: GridRobot, range_m: float) -> bool:
        """Whether another robot is in range and in sight."""
        apart_m = math.hypot(other.x - robot.x, other.y - robot.y)
        between = np.linspace(0.0, 1.0, max(2, int(apart_m / MARCH_M)))
        x = robot.x + between * (other.x - robot.x)
        y = robot.y + between * (other.y - robot.y)
        return apart_m - other.radius_m <= range_m and not self.is_wall(x, y).any()

    def send(self, data: bytes, receivers: list[GridRobot]) -> None:
        """Put a message into the inbox of others."""
        for robot in receivers:
            robot.inbox.append(data)
