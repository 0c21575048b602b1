"""A self-contained policy for the indoor exploration competition: tours of visible unknown area.

With `grid_kernels` it needs only numpy and numba, and nothing else from the package, so that it can
be submitted: ``multisrt compete --policy-out`` writes both as one file.

The goal that a robot names at each step is a cell of its own path, at most three cells ahead. It
therefore drives exactly the path that it planned:

- **Paths** lead through cells whose neighbours are all known to be free. A cell next to an unknown
  one may turn out to be next to a wall, and a robot that has passed it may be trapped.
- **Targets** are segments of the frontiers between free and unknown cells. From each of them, a
  tour is extended greedily to the target with the most visible unknown area divided by a power of
  the path length. The value of a tour is the sum of the areas that it shows, discounted by time.
  The robot drives to the first target of the most valuable tour.
- **Teams**: tours are planned for all robots in contact, in the order of their numbers, each with
  what the earlier tours leave to it. A target to which another robot is nearer counts less. Each
  robot computes this by itself.
- **Home** is every cell with a certain link to the base, where unknown cells count as walls.
  Targets from which a robot could not be home in time are excluded.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from multisrt.competition.grid_kernels import (
    MARGIN,
    STEP,
    Cells,
    DistanceField,
    Flags,
    Floats,
    Grid,
    Targets,
    TourParameters,
    Visibility,
    best_tour,
    contact_zone,
    cropped,
    descend,
    distance_field,
    frontier_segments,
    is_clear,
    passable_cells,
    path_lengths_between,
    unclaimed_areas,
    unknown_area_of_blocks,
    visible_areas,
    visible_blocks,
    with_filled_walls,
)

COMPARISON_OFFSET = 20.0
"""Added to path lengths, in cells, when those of two robots are compared."""


@dataclass(frozen=True)
class Settings:
    """The parameters of the policy; lengths in cells, areas in square cells, times in steps.

    Attributes
    ----------
    horizon : float
        Time over which the value of area decreases by the factor e, as a share of all steps.
    power : float
        Power of the path length in the rule that extends tours.
    homeward_weight : float
        Weight of the travel time home when the steps are nearly used up.
    min_area : float
        Minimum unknown area visible from a target to which a tour is extended, without the area
        that is visible from earlier targets of the tour.
    max_targets : int
        Maximum number of targets among which tours are planned: those with the most visible unknown
        area for the path length of any robot in contact.
    max_wall_cells : int
        Maximum length of a run of unknown cells between two occupied ones of a row or column that
        counts as wall.
    length_offset : float
        Added to every path length where area is divided by it.
    sight : float
        Range within which unknown area counts as visible.
    keep_factor : float
        Factor on the value of a tour whose first target is less than `segment_half_width` cells
        from the robot's previous target, by the Manhattan distance.
    claim_decay : float
        Arrival time over which the share of an area that a tour claims decreases by the factor e.
    claim_share : float
        Share of an area that another robot claims if it is already there.
    min_share : float
        Minimum factor on the value of a target to which another robot is nearer.
    claim_radius : float
        Distance in cells beyond which the target last planned for a robot out of contact does not
        reduce the value of others.
    contact_decay : float
        Time since the last contact over which this reduction decreases by the factor e.
    replan_steps : int
        Number of steps between two plans.
    reserve_steps : int
        Number of steps kept in reserve for the path home.
    segment_half_width : int
        Maximum number of rows and columns from the first cell of a frontier segment to its others.
    min_frontier_cells : int
        Minimum number of cells of a frontier; smaller ones are ignored.
    """

    horizon: float = 0.3
    power: float = 1.5
    homeward_weight: float = 1.0
    min_area: float = 20.0
    max_targets: int = 60
    max_wall_cells: int = 15
    length_offset: float = 5.0
    sight: float = 60.0
    keep_factor: float = 1.1
    claim_decay: float = 75.0
    claim_share: float = 0.9
    min_share: float = 0.4
    claim_radius: float = 80.0
    contact_decay: float = 100.0
    replan_steps: int = 3
    reserve_steps: int = 4
    segment_half_width: int = 12
    min_frontier_cells: int = 6

    def tour_parameters(self, steps: int) -> TourParameters:
        """Return the parameters of tours for a run with a given number of steps."""
        horizon = self.horizon * steps
        return TourParameters(
            horizon, self.power, self.length_offset, self.homeward_weight, self.min_area
        )


class Situation(NamedTuple):
    """What a target is chosen from.

    Attributes
    ----------
    states : (rows, columns) array
        The map.
    passable : (rows, columns) array of bool
        The cells through which paths lead.
    targets : (m, 2) array
        Rows and columns of the targets.
    costs : (n, m) array
        Path lengths to the targets in cells, from this robot in the first row and from those in
        contact in the others; ``inf`` where there is no path.
    lengths_home : (m,) array
        Path lengths from the targets home.
    robots : tuple of int
        Numbers of the robots, in the order of the rows of `costs`.
    """

    states: Grid
    passable: Flags
    targets: Cells
    costs: Floats
    lengths_home: Floats
    robots: tuple[int, ...]


@dataclass
class Memory:
    """What one robot remembers from step to step.

    One policy object serves the whole team, but robots must not share knowledge through it. Each
    robot therefore has a memory of its own, found by an array that the simulator keeps for this
    robot alone.

    Attributes
    ----------
    mask : object
        That array, referenced here so that its identity stays unique.
    shape : (int, int)
        Number of rows and columns of the cropped map.
    time, max_steps : int
        The present step, and the number of steps of the run.
    next_plan : int
        Step of the next plan.
    to_destination : array or None
        Distance field of the cell or cells to which the robot drives; None to stay.
    target : (row, column) or None
        The target that was chosen.
    home : array or None
        Distance field of `contact_zone`.
    contact_zone : (rows, columns) or None
        The cells of home.
    zone_time : int
        Step at which `contact_zone` was computed.
    visited : list of (row, column)
        Targets at which the robot was.
    contact_times : dict of int to int
        Step of the last contact with each robot, by its number.
    assumed_targets : dict of int to (row, column)
        Target that this robot last planned for each other one, by its number.
    queue : array
        Scratch memory with one entry per cell.
    """

    mask: object
    shape: tuple[int, int]
    time: int = 0
    max_steps: int = 1000
    next_plan: int = 0
    to_destination: DistanceField | None = None
    target: tuple[int, int] | None = None
    home: DistanceField | None = None
    contact_zone: tuple[Cells, Cells] | None = None
    zone_time: int = -1000
    visited: list[tuple[int, int]] = field(default_factory=list)
    contact_times: dict[int, int] = field(default_factory=dict)
    assumed_targets: dict[int, tuple[int, int]] = field(default_factory=dict)
    queue: Cells = field(default_factory=lambda: np.empty(0, np.int64))


class GainHome:
    """Explore by tours of visible unknown area, and end with a link to the base.

    Parameters
    ----------
    settings : Settings, optional
        The parameters of the policy.
    """

    def __init__(self, settings: Settings | None = None) -> None:
        self.settings = settings or Settings()
        self._memories: dict[int, Memory] = {}

    def should_relay(self, obs: Any, collect_opts: Any, t: int, max_steps: int) -> None:
        """Record the time, and stay in the present mode: robots drive home by their own goals."""
        memory = self._memory(obs)
        memory.time, memory.max_steps = t, max_steps

    def decide_relay_handoff(self, obs: Any, collect_opts: Any) -> None:
        """Hand over no data."""

    def decide(self, obs: Any, collect_opts: Any) -> NDArray[np.int64] | None:
        """Return the goal cell (row, column) in the padded map, at most three cells ahead.

        Returns
        -------
        (2,) array or None
            The goal; None to name no goal.
        """
        memory = self._memory(obs)
        offset = obs.pd_size - MARGIN
        row, column = (int(x) - offset for x in obs.pose)
        if memory.to_destination is None or memory.time >= memory.next_plan:
            self._plan(memory, obs, collect_opts, row, column)
        ahead = self._ahead(memory, obs, row, column)
        if ahead is None:  # it has arrived, or a wall was seen on its path
            self._plan(memory, obs, collect_opts, row, column)
            ahead = self._ahead(memory, obs, row, column)
        if ahead is None:  # stay, unless a wall was seen next to the robot: goals there are invalid
            here = is_clear(obs.combined_obs_map, row + offset, column + offset)
            ahead = (row, column) if here else None
        return None if ahead is None else np.array(ahead, np.int64) + offset

    def _ahead(self, memory: Memory, obs: Any, row: int, column: int) -> tuple[int, int] | None:
        """Return the cell one step ahead on the path; None at its end or if it is blocked."""
        if memory.to_destination is None:
            return None
        offset, cell = obs.pd_size - MARGIN, (row, column)
        for _ in range(STEP):
            r, c = descend(memory.to_destination, *cell, 1)
            if (r, c) == cell:
                break
            if not is_clear(obs.combined_obs_map, r + offset, c + offset):
                return None
            cell = int(r), int(c)
        return None if cell == (row, column) else cell

    def _memory(self, obs: Any) -> Memory:
        """Return the memory of the robot that is asked."""
        key = id(obs.unreported_mask)
        if key not in self._memories:
            cropped_cells = 2 * (obs.pd_size - MARGIN)
            rows, columns = obs.combined_obs_map.shape
            shape = rows - cropped_cells, columns - cropped_cells
            self._memories[key] = Memory(
                obs.unreported_mask, shape, queue=np.empty(shape[0] * shape[1], np.int64)
            )
        return self._memories[key]

    def _plan(self, memory: Memory, obs: Any, options: Any, row: int, column: int) -> None:
        """Choose a target, and compute the distance field that the robot descends to it."""
        settings, queue = self.settings, memory.queue
        offset = obs.pd_size - MARGIN
        base = int(obs.base_pose[0]) - offset, int(obs.base_pose[1]) - offset
        states = cropped(obs.combined_obs_map, offset)
        passable = passable_cells(states)
        passable[row, column] = True
        distances = distance_field(passable, np.array([row]), np.array([column]), queue)
        if memory.contact_zone is None or memory.time - memory.zone_time >= 25:
            memory.contact_zone = contact_zone(states, distances, base, link_parameters(options))
            memory.zone_time = memory.time
        memory.home = home = distance_field(passable, *memory.contact_zone, queue)
        memory.next_plan = memory.time + settings.replan_steps

        targets = frontier_segments(
            states,
            distances,
            settings.segment_half_width,
            settings.min_frontier_cells,
            MARGIN,
            queue,
        )
        reached = targets[distances[targets[:, 0], targets[:, 1]] == 0]
        memory.visited.extend(map(tuple, reached.tolist()))
        if memory.visited and len(targets):
            visited = np.array(memory.visited)
            far = np.abs(targets[:, None] - visited[None]).max(axis=2) > 4
            targets = targets[far.all(axis=1)]
        there, back = distances[targets[:, 0], targets[:, 1]], home[targets[:, 0], targets[:, 1]]
        left = memory.max_steps - memory.time
        in_time = np.ceil((there + back) / STEP) + settings.reserve_steps <= left
        targets = targets[(there > 0) & (back >= 0) & in_time]
        if not len(targets):
            memory.target = None
            memory.to_destination = home if home[row, column] > 0 else None
            return
        costs, robots = self._costs(memory, obs, passable, distances, targets, offset)
        lengths_home = home[targets[:, 0], targets[:, 1]].astype(float)
        situation = Situation(states, passable, targets, costs, lengths_home, robots)
        chosen = self.choose(memory, situation)
        if chosen is None:
            memory.target, memory.to_destination = None, None
            return
        memory.target = int(targets[chosen, 0]), int(targets[chosen, 1])
        memory.to_destination = distance_field(
            passable, targets[chosen : chosen + 1, 0], targets[chosen : chosen + 1, 1], queue
        )

    def _costs(
        self,
        memory: Memory,
        obs: Any,
        passable: Flags,
        distances: DistanceField,
        targets: Cells,
        offset: int,
    ) -> tuple[Floats, tuple[int, ...]]:
        """Return path lengths to targets and robots' numbers, as in `Situation`."""
        # All robots start in one cell, so this one has heard from all others: the number that is
        # missing is its own.
        heard = {int(name.removeprefix("robot")) for name in obs.pose_lists_of_others}
        own = next(number for number in range(1, len(heard) + 2) if number not in heard)
        rows, robots = [distances[targets[:, 0], targets[:, 1]].astype(float)], [own]
        for number in obs.connected_robot_ids:
            poses = obs.pose_lists_of_others.get(f"robot{number}")
            if poses is None or not len(poses):
                continue
            row, column = (int(x) - offset for x in poses[-1])
            if not (0 <= row < passable.shape[0] and 0 <= column < passable.shape[1]):
                continue
            memory.contact_times[number] = memory.time
            others = distance_field(passable, np.array([row]), np.array([column]), memory.queue)
            costs = others[targets[:, 0], targets[:, 1]].astype(float)
            costs[costs < 0] = np.inf
            rows.append(costs)
            robots.append(number)
        return np.array(rows), tuple(robots)

    def choose(self, memory: Memory, situation: Situation) -> int | None:
        """Return the index of the first target of this robot's best tour; None if it has none."""
        s = self.settings
        states, passable, targets, costs, lengths_home, robots = situation
        filled = with_filled_walls(states, s.max_wall_cells)
        areas = unknown_area_of_blocks(filled, MARGIN)
        first, blocks = visible_blocks(filled, targets, s.sight, MARGIN)
        visible = visible_areas(areas, first, blocks) + 1.0
        shares = self._unclaimed_shares(memory, targets, robots) * nearness_shares(
            costs, s.min_share
        )
        rates = (visible * shares / (costs + s.length_offset)).max(axis=0)
        best = np.argsort(-rates, kind="stable")[: s.max_targets]

        path_lengths = path_lengths_between(passable, targets[best])
        left = memory.max_steps - memory.time - s.reserve_steps
        blocks = np.concatenate([blocks[first[k] : first[k + 1]] for k in best])
        first = np.concatenate(([0], np.cumsum((first[1:] - first[:-1])[best])))
        for row in np.argsort(robots):
            previous = memory.target if row == 0 else memory.assumed_targets.get(robots[row])
            factors = np.ones(len(best))
            if previous is not None:
                gaps = np.abs(targets[best] - np.array(previous)).sum(axis=1)
                factors[gaps < s.segment_half_width] = s.keep_factor
            visibility = Visibility(areas, first, blocks)
            candidates = Targets(
                shares[row][best], costs[row][best], lengths_home[best], path_lengths, factors
            )
            parameters = s.tour_parameters(memory.max_steps)
            tour, times = best_tour(visibility, candidates, float(left), parameters)
            target = best[tour[0]] if len(tour) else None
            if row == 0:
                return None if target is None else int(target)
            if target is not None:
                memory.assumed_targets[robots[row]] = (
                    int(targets[target, 0]),
                    int(targets[target, 1]),
                )
                areas = unclaimed_areas(visibility, tour, times, s.claim_decay, s.claim_share)
        raise AssertionError("the costs have no row of this robot")

    def _unclaimed_shares(self, memory: Memory, targets: Cells, robots: tuple[int, ...]) -> Floats:
        """Return the share of each target's value that robots out of contact leave, ``(m,)``."""
        s, shares = self.settings, np.ones(len(targets))
        for number, assumed in memory.assumed_targets.items():
            if number not in robots:
                near = np.maximum(0.0, 1.0 - euclidean_distances(targets, assumed) / s.claim_radius)
                age = memory.time - memory.contact_times[number]
                shares *= 1.0 - s.claim_share * math.exp(-age / s.contact_decay) * near
        return shares


def nearness_shares(costs: Floats, min_share: float) -> Floats:
    """Return factors on the values of targets, ``(n, m)``: below 1 if another robot is nearer.

    Parameters
    ----------
    costs : (n, m) array
        Path lengths from robots to targets in cells; ``inf`` where there is no path.
    min_share : float
        Minimum factor.

    Examples
    --------
    >>> nearness_shares(np.array([[10.0, 80.0], [40.0, 20.0]]), 0.45)
    array([[1.  , 0.45],
           [0.5 , 1.  ]])
    """
    shares = np.ones_like(costs)
    for one, own in enumerate(costs):
        for other in np.delete(costs, one, axis=0):
            both = np.isfinite(own) & np.isfinite(other)
            ratio = (other[both] + COMPARISON_OFFSET) / (own[both] + COMPARISON_OFFSET)
            shares[one, both] = np.minimum(shares[one, both], np.clip(ratio, min_share, 1.0))
    return shares


def euclidean_distances(targets: Cells, cell: Any) -> Floats:
    """Return the Euclidean distances of targets from a cell, ``(m,)``."""
    differences = targets - np.asarray(cell)
    distances: Floats = np.hypot(differences[:, 0], differences[:, 1])
    return distances


def link_parameters(options: Any) -> tuple[int, float, float]:
    """Return the parameters of a link to the base.

    A reserve of 1.5 wall cells and 4 cells of length is subtracted.

    Parameters
    ----------
    options : object
        The options of the competition's configuration.

    Returns
    -------
    max_length : int
        Maximum length in cells.
    budget : float
        Number of wall cells that the link tolerates at 1 m.
    slope : float
        Decrease of that number per decade of distance.
    """
    budget = (options.transmitted_power - options.power_threshold) / options.attenuation_constant
    slope = 10.0 * options.path_loss_exponent / options.attenuation_constant
    return int(options.pixel_per_meter * options.comm_range) - 4, budget - 1.5, slope
