"""A small competition with the interface of the real one, to run policies in."""

from pathlib import Path

import numpy as np

FILES = {
    "base_policy.py": """
class InvalidGoalError(Exception):
    pass

class BasePolicy:
    def decide(self, obs, collect_opts):
        raise NotImplementedError

    def should_relay(self, obs, collect_opts, t, max_steps):
        return None

    def decide_relay_handoff(self, obs, collect_opts):
        return None
""",
    "base_station.py": """
import numpy as np

class BaseStation:
    def __init__(self, start_pose):
        self.pose = np.array(start_pose)

    def initialize_map(self, world):
        self.obs_map = np.full(world.occ_map.shape, 0.5)
""",
    "comm.py": """
import numpy as np
from skimage.draw import line

class CommunicationManager:
    def linked(self, one, other, world, opts):
        rows, columns = line(*one, *other)
        walls = (world.occ_map[rows, columns] == 1).sum()
        gap = np.linalg.norm(one - other) / opts.pixel_per_meter
        return gap <= opts.comm_range and walls < 4

    def merge(self, one, other):
        both = np.where((one == 1) | (other == 1), 1.0, np.minimum(one, other))
        return both, both.copy()
""",
    "environment.py": """
import os
import numpy as np
from skimage.measure import block_reduce
from scripts import utils
import matplotlib
matplotlib.use('TkAgg')

class World:
    def __init__(self, folder, robots, base_station):
        occupied = np.where(np.load(os.path.join(folder, 'occ_map.npy')) == 0, 1, 2)
        occupied = block_reduce(occupied, block_size=(2, 2), func=np.min, cval=1) == 1
        self.occ_map = np.pad(occupied.astype(np.float32), 200)
        self.robots, self.base_station, self.timestep = robots, base_station, 0

    def step(self, links, opts):
        for robot in self.robots:
            robot.observe(self)
        for robot in self.robots:
            robot.linked = []
            for other in self.robots:
                if other is not robot and links.linked(robot.pose, other.pose, self, opts):
                    robot.linked.append(other.id)
                    maps = links.merge(robot.combined_obs_map, other.combined_obs_map)
                    robot.combined_obs_map, other.combined_obs_map = maps
                    robot.heard[f'robot{other.id}'] = np.array(other.pose_list)
        for robot in self.robots:
            if self.timestep >= robot.start_delay:
                robot.pose = robot.engine.plan(robot, self, opts)
                robot.pose_list.append(robot.pose)
        for robot in self.robots:
            if links.linked(robot.pose, self.base_station.pose, self, opts):
                maps = links.merge(robot.combined_obs_map, self.base_station.obs_map)
                robot.combined_obs_map, self.base_station.obs_map = maps
        self.timestep += 1
""",
    "policy.py": """
from types import SimpleNamespace
import numpy as np
import pyastar2d
from base_policy import InvalidGoalError
import policy_utils

class PlanningEngine:
    def plan(self, robot, world, opts):
        obs = SimpleNamespace(
            combined_obs_map=robot.combined_obs_map, pose=robot.pose,
            unreported_mask=robot.unreported_mask, delegated_mask=robot.unreported_mask,
            pose_lists_of_others=robot.heard, intents_of_others={},
            base_pose=world.base_station.pose, pd_size=opts.pd_size,
            connected_robot_ids=robot.linked)
        robot.user_policy.should_relay(obs, opts, world.t, opts.max_steps)
        goal = robot.user_policy.decide(obs, opts)
        if goal is None:
            return robot.pose
        weights = policy_utils.inflate_map(robot.combined_obs_map)
        path = pyastar2d.astar_path(weights, robot.pose, goal, allow_diagonal=False)
        if weights[goal[0], goal[1]] == np.inf or path is None:
            raise InvalidGoalError(f'{goal} cannot be reached')
        return path[min(3, len(path) - 1)].astype(int)
""",
    "policy_utils.py": """
import numpy as np
from scipy.ndimage import binary_dilation

def inflate_map(known):
    near = binary_dilation(known > 0.5, structure=np.ones((3, 3)))
    return np.where(near, np.inf, 1).astype(np.float32)
""",
    "robot.py": """
import numpy as np
import range_libc
from scripts import utils

def makePyOMap(grid):
    return range_libc.PyOMap(grid)

class Robot:
    def __init__(self, id, start_pose, engine, user_policy, opts, start_delay=0):
        self.id, self.pose = id, np.array(start_pose)
        self.engine, self.user_policy = engine, user_policy
        self.opts, self.start_delay, self.heard, self.linked = opts, start_delay, {}, []
        self.pose_list = [self.pose]

    def initialize_map(self, world):
        self.map = makePyOMap(world.occ_map)
        self.combined_obs_map = np.full(world.occ_map.shape, 0.5)
        self.unreported_mask = np.zeros(world.occ_map.shape, bool)

    def observe(self, world):
        utils.see(self, world)
""",
    "scoring.py": """
import numpy as np

def base_station_coverage(base, opts):
    known = base.obs_map[opts.pd_size:-opts.pd_size, opts.pd_size:-opts.pd_size]
    return float(np.mean(known != 0.5))
""",
    "utils.py": """
import cv2
import matplotlib.pyplot as plt
import numpy as np
import range_libc
from tqdm import tqdm
from tqdm.contrib.concurrent import process_map
from robot import makePyOMap

def see(robot, world):
    print('seeing')
    reach, count = 150.0, 720
    queries = np.zeros((count, 3), np.float32)
    queries[:, :2] = robot.pose
    queries[:, 2] = np.linspace(0, 2 * np.pi, count)
    ranges = np.zeros(count, np.float32)
    range_libc.PyBresenhamsLine(robot.map, reach).calc_range_many(queries, ranges)
    for angle, far in zip(queries[:, 2], ranges):
        along = np.append(np.arange(0.0, far, 0.5), far)
        rows = np.rint(robot.pose[0] + along * np.cos(angle)).astype(int)
        columns = np.rint(robot.pose[1] + along * np.sin(angle)).astype(int)
        inside = (rows >= 0) & (columns >= 0)
        inside &= (rows < world.occ_map.shape[0]) & (columns < world.occ_map.shape[1])
        rows, columns = rows[inside], columns[inside]
        robot.combined_obs_map[rows, columns] = world.occ_map[rows, columns]
""",
}

CONFIG = """\
root_path: '/nowhere'
start_pose: [15,15]
lidar_range: 15
num_laser: 2500
pixel_per_meter: 10
comm_range: 15
attenuation_constant: 10
transmitted_power: 20
path_loss_exponent: 3.5
power_threshold: -80
pd_size: 200
num_robots: 3
relay_transfer: True
"""


def make_fake_clone(folder: Path) -> Path:
    """Write the competition with one map of 12 m by 8 m: two rooms and a door of 1.2 m."""
    scripts = folder / "scripts"
    scripts.mkdir(parents=True)
    for name, text in FILES.items():
        (scripts / name).write_text(text)
    (folder / "configs").mkdir()
    (folder / "configs" / "multi-robot.yaml").write_text(CONFIG)
    pixels = np.full((160, 240), 254, np.uint8)
    pixels[:6] = pixels[-6:] = 0
    pixels[:, :6] = pixels[:, -6:] = 0
    pixels[:, 120:126] = 0
    pixels[100:124, 120:126] = 254
    where = folder / "test_maps" / "env1"
    where.mkdir(parents=True)
    np.save(where / "occ_map.npy", pixels)
    np.save(where / "valid_space.npy", (pixels > 0).astype(np.uint8))
    return folder
