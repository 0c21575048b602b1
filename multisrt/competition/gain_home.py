"""A policy for the indoor exploration competition that stands alone: gain over way, home in time.

With `grid_kernels` it needs numpy and numba only, and nothing of the package that it is part of, so
that it can be handed in: ``multisrt compete --policy-out`` writes both as one file.

A robot is asked for a goal at every step, since it names cells of its way that are three cells
ahead. So it drives exactly the way that it planned:

- **Ways** lead through cells all of whose neighbours are known to be free. A cell next to an
  unknown one may turn out to be too near to a wall, and a robot that has passed it is shut in.
- **Targets** are pieces of the borders between free and unknown cells. A robot goes to the first
  target of the best tour: for each first target, a greedy tour of unknown area in sight over a
  power of the way is worked out, and what it would show is added up, less the later it is.
- **Teams**: robots in contact are planned tours in the order of their numbers, each for what the
  tours before leave to it. A target that another robot is nearer to counts less. Each robot works
  this out for itself.
- **Home** is every cell from which a link to the base holds on what is known, unknown cells counted
  as walls. Targets from which a robot could not be there in time are none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from multisrt.competition.grid_kernels import (
    BORDER,
    STEP,
    Cells,
    Flags,
    Floats,
    Grid,
    Rules,
    Sights,
    Targets,
    Way,
    areas_after,
    areas_in_sight,
    best_tour,
    blocks_in_sight,
    border_pieces,
    cropped,
    descend,
    field_from,
    is_clear,
    passable_cells,
    path_lengths_between,
    unknown_blocks,
    with_walls,
    zone,
)

NEAR = 20.0
"""Cells that are added to ways when those of two robots are compared."""


@dataclass(frozen=True)
class Settings:
    """The constants of the policy; lengths in cells, areas in cells, times in steps.

    Attributes
    ----------
    horizon : float
        Time by which area that is seen later counts less by the factor e, as a share of all steps.
    power : float
        Power of the way, in the rule by which tours go on.
    homeward : float
        Weight of the way home as time, at the end of the time.
    least_area : float
        Least area for which a tour goes on.
    most_targets : int
        Targets among which tours are sought, those of the highest area over way.
    wall : int
        Unknown cells between two occupied ones of a row or column that are taken as wall.
    nearest : float
        Added to every way.
    sight : float
        Range up to which unknown area counts.
    keep : float
        Factor on the value of a tour to the present target.
    claim : float
        Time by which the claim of a tour on an area is weaker by the factor e.
    strength : float
        Share of an area that the tour of another robot claims at once.
    others : float
        Lower bound of what a target counts that another robot is nearer to.
    claim_range : float
        Distance at and beyond which the target of a robot out of contact claims no other target.
    recall : float
        Time by which such a target counts less by the factor e.
    every : int
        Steps between two plans.
    margin : int
        Steps that are kept in reserve on the way home.
    piece : int
        Half the width of a piece of a border.
    least : int
        Cells of the shortest border that counts.
    """

    horizon: float = 0.3
    power: float = 1.5
    homeward: float = 1.0
    least_area: float = 20.0
    most_targets: int = 60
    wall: int = 15
    nearest: float = 5.0
    sight: float = 60.0
    keep: float = 1.1
    claim: float = 75.0
    strength: float = 0.9
    others: float = 0.4
    claim_range: float = 80.0
    recall: float = 100.0
    every: int = 3
    margin: int = 4
    piece: int = 12
    least: int = 6

    def rules(self, steps: int) -> Rules:
        """Return the constants of tours for a number of steps of the whole run."""
        horizon = self.horizon * steps
        return Rules(horizon, self.power, self.nearest, self.homeward, self.least_area)


class Situation(NamedTuple):
    """What a target is chosen by.

    Attributes
    ----------
    states : (rows, columns) array
        The map.
    passable : (rows, columns) array of bool
        Cells that ways lead through.
    targets : (m, 2) array
        Cells.
    costs : (n, m) array
        Ways in cells of this robot, the first, and of those in contact; ``inf`` for none.
    home : (m,) array
        Ways from targets home.
    robots : tuple of int
        Numbers of the robots, in the order of the rows of `costs`.
    """

    states: Grid
    passable: Flags
    targets: Cells
    costs: Floats
    home: Floats
    robots: tuple[int, ...]


@dataclass
class Memory:
    """What one robot remembers between two questions.

    A policy is one object for the whole team; what robots know must not pass through it. So each
    has a memory of its own, found by an array that the simulator keeps for it alone.
    """

    mask: object
    shape: tuple[int, int]
    time: int = 0
    end: int = 1000
    next_plan: int = 0
    route: Way | None = None
    target: tuple[int, int] | None = None
    home: Way | None = None
    zone: tuple[Cells, Cells] | None = None
    zone_time: int = -1000
    done: list[tuple[int, int]] = field(default_factory=list)
    heard: dict[int, int] = field(default_factory=dict)
    believed: dict[int, tuple[int, int]] = field(default_factory=dict)
    queue: Cells = field(default_factory=lambda: np.empty(0, np.int64))


class GainHome:
    """Drive to the target of the highest gain over way, and be in touch with the base at the end.

    Parameters
    ----------
    settings : Settings, optional
        The constants.
    """

    def __init__(self, settings: Settings | None = None) -> None:
        self.settings = settings or Settings()
        self._memories: dict[int, Memory] = {}

    def should_relay(self, obs: Any, collect_opts: Any, t: int, max_steps: int) -> None:
        """Note the time; robots drive home by goals of their own, never by the relay mode."""
        memory = self._memory(obs)
        memory.time, memory.end = t, max_steps

    def decide_relay_handoff(self, obs: Any, collect_opts: Any) -> None:
        """Hand nothing over."""

    def decide(self, obs: Any, collect_opts: Any) -> NDArray[np.int64] | None:
        """Return the cell three cells ahead on the robot's way."""
        memory = self._memory(obs)
        corner = obs.pd_size - BORDER
        row, column = (int(x) - corner for x in obs.pose)
        if memory.route is None or memory.time >= memory.next_plan:
            self._plan(memory, obs, collect_opts, row, column)
        ahead = self._ahead(memory, obs, row, column)
        if ahead is None:  # it has arrived, or a wall was seen on its way
            self._plan(memory, obs, collect_opts, row, column)
            ahead = self._ahead(memory, obs, row, column)
        if ahead is None:  # it stays, unless a wall was seen beside it: no goal may be there
            here = is_clear(obs.combined_obs_map, row + corner, column + corner)
            ahead = (row, column) if here else None
        return None if ahead is None else np.array(ahead, np.int64) + corner

    def _ahead(self, memory: Memory, obs: Any, row: int, column: int) -> tuple[int, int] | None:
        """Return the cell a step ahead on the way; None if there is none, or it is blocked."""
        if memory.route is None:
            return None
        corner, place = obs.pd_size - BORDER, (row, column)
        for _ in range(STEP):
            r, c = descend(memory.route, *place, 1)
            if (r, c) == place:
                break
            if not is_clear(obs.combined_obs_map, r + corner, c + corner):
                return None
            place = int(r), int(c)
        return None if place == (row, column) else place

    def _memory(self, obs: Any) -> Memory:
        key = id(obs.unreported_mask)
        if key not in self._memories:
            margin = 2 * (obs.pd_size - BORDER)
            rows, columns = obs.combined_obs_map.shape
            shape = rows - margin, columns - margin
            self._memories[key] = Memory(
                obs.unreported_mask, shape, queue=np.empty(shape[0] * shape[1], np.int64)
            )
        return self._memories[key]

    def _plan(self, memory: Memory, obs: Any, options: Any, row: int, column: int) -> None:
        """Choose a target, and set the field down which the robot drives."""
        settings, queue = self.settings, memory.queue
        corner = obs.pd_size - BORDER
        base = int(obs.base_pose[0]) - corner, int(obs.base_pose[1]) - corner
        states = cropped(obs.combined_obs_map, corner)
        passable = passable_cells(states)
        passable[row, column] = True
        ways = field_from(passable, np.array([row]), np.array([column]), queue)
        if memory.zone is None or memory.time - memory.zone_time >= 25:
            memory.zone = zone(states, ways, base, radio(options))
            memory.zone_time = memory.time
        memory.home = home = field_from(passable, *memory.zone, queue)
        memory.next_plan = memory.time + settings.every

        targets = border_pieces(states, ways, settings.piece, settings.least, BORDER, queue)
        near = targets[ways[targets[:, 0], targets[:, 1]] == 0]
        memory.done.extend(map(tuple, near.tolist()))
        if memory.done and len(targets):
            done = np.array(memory.done)
            far = np.abs(targets[:, None] - done[None]).max(axis=2) > 4
            targets = targets[far.all(axis=1)]
        there, back = ways[targets[:, 0], targets[:, 1]], home[targets[:, 0], targets[:, 1]]
        left = memory.end - memory.time
        in_time = np.ceil((there + back) / STEP) + settings.margin <= left
        targets = targets[(there > 0) & (back >= 0) & in_time]
        if not len(targets):
            memory.target = None
            memory.route = home if home[row, column] > 0 else None
            return
        costs, robots = self._costs(memory, obs, passable, ways, targets, corner)
        homeward = home[targets[:, 0], targets[:, 1]].astype(float)
        chosen = self.choose(memory, Situation(states, passable, targets, costs, homeward, robots))
        if chosen is None:
            memory.target, memory.route = None, None
            return
        memory.target = int(targets[chosen, 0]), int(targets[chosen, 1])
        memory.route = field_from(
            passable, targets[chosen : chosen + 1, 0], targets[chosen : chosen + 1, 1], queue
        )

    def _costs(
        self,
        memory: Memory,
        obs: Any,
        passable: Flags,
        ways: Way,
        targets: Cells,
        corner: int,
    ) -> tuple[Floats, tuple[int, ...]]:
        """Return the ways of this robot, the first, and of those in contact, and their numbers."""
        # All start at one place, so a robot has heard all others once: its number is the other one.
        heard = {int(name.removeprefix("robot")) for name in obs.pose_lists_of_others}
        own = next(number for number in range(1, len(heard) + 2) if number not in heard)
        rows, robots = [ways[targets[:, 0], targets[:, 1]].astype(float)], [own]
        for number in obs.connected_robot_ids:
            places = obs.pose_lists_of_others.get(f"robot{number}")
            if places is None or not len(places):
                continue
            row, column = (int(x) - corner for x in places[-1])
            if not (0 <= row < passable.shape[0] and 0 <= column < passable.shape[1]):
                continue
            memory.heard[number] = memory.time
            field = field_from(passable, np.array([row]), np.array([column]), memory.queue)
            costs = field[targets[:, 0], targets[:, 1]].astype(float)
            costs[costs < 0] = np.inf
            rows.append(costs)
            robots.append(number)
        return np.array(rows), tuple(robots)

    def choose(self, memory: Memory, situation: Situation) -> int | None:
        """Return the number of the first target of this robot's best tour."""
        s = self.settings
        states, passable, targets, costs, home, robots = situation
        filled = with_walls(states, s.wall)
        areas = unknown_blocks(filled, BORDER)
        first, blocks = blocks_in_sight(filled, targets, s.sight, BORDER)
        seen = areas_in_sight(areas, first, blocks) + 1.0
        shares = self._left_by_absent(memory, targets, robots) * nearer_to(costs, s.others)
        rates = (seen * shares / (costs + s.nearest)).max(axis=0)
        best = np.argsort(-rates, kind="stable")[: s.most_targets]

        lengths = path_lengths_between(passable, targets[best])
        left = memory.end - memory.time - s.margin
        blocks = np.concatenate([blocks[first[k] : first[k + 1]] for k in best])
        first = np.concatenate(([0], np.cumsum((first[1:] - first[:-1])[best])))
        for row in np.argsort(robots):
            before = memory.target if row == 0 else memory.believed.get(robots[row])
            favour = np.ones(len(best))
            if before is not None:
                favour[np.abs(targets[best] - np.array(before)).sum(axis=1) < s.piece] = s.keep
            sights = Sights(areas, first, blocks)
            ours = Targets(shares[row][best], costs[row][best], home[best], lengths, favour)
            tour, times = best_tour(sights, ours, float(left), s.rules(memory.end))
            target = best[tour[0]] if len(tour) else None
            if row == 0:
                return None if target is None else int(target)
            if target is not None:
                memory.believed[robots[row]] = int(targets[target, 0]), int(targets[target, 1])
                areas = areas_after(sights, tour, times, s.claim, s.strength)
        raise AssertionError("the rows of costs have none of this robot")

    def _left_by_absent(self, memory: Memory, targets: Cells, robots: tuple[int, ...]) -> Floats:
        """Return the factors on targets, as robots that are out of contact may have taken them."""
        s, shares = self.settings, np.ones(len(targets))
        for number, place in memory.believed.items():
            if number not in robots:
                near = np.maximum(0.0, 1.0 - distances(targets, place) / s.claim_range)
                ago = memory.time - memory.heard[number]
                shares *= 1.0 - s.strength * math.exp(-ago / s.recall) * near
        return shares


def nearer_to(costs: Floats, least: float) -> Floats:
    """Return the factors on targets for each robot, less than 1 if another robot is nearer.

    Examples
    --------
    >>> nearer_to(np.array([[10.0, 80.0], [40.0, 20.0]]), 0.45)
    array([[1.  , 0.45],
           [0.5 , 1.  ]])
    """
    shares = np.ones_like(costs)
    for one, own in enumerate(costs):
        for other in np.delete(costs, one, axis=0):
            both = np.isfinite(own) & np.isfinite(other)
            ratio = (other[both] + NEAR) / (own[both] + NEAR)
            shares[one, both] = np.minimum(shares[one, both], np.clip(ratio, least, 1.0))
    return shares


def distances(targets: Cells, place: Any) -> Floats:
    """Return the Euclidean distances of targets from a cell."""
    gaps = targets - np.asarray(place)
    found: Floats = np.hypot(gaps[:, 0], gaps[:, 1])
    return found


def radio(options: Any) -> tuple[int, float, float]:
    """Return the range of a link in cells, the walls it bears at 1 m, and how many less at 10 m.

    One wall and four cells are kept in reserve.
    """
    budget = (options.transmitted_power - options.power_threshold) / options.attenuation_constant
    slope = 10.0 * options.path_loss_exponent / options.attenuation_constant
    return int(options.pixel_per_meter * options.comm_range) - 4, budget - 1.5, slope
