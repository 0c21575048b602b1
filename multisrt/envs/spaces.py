"""The spaces of observations, actions and states."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces

from multisrt.robots.policy import DecisionSpec
from multisrt.robots.policy.observing import (
    FAR_M,
    FRONTIER_COLUMNS,
    MAX_TIME_S,
    OTHER_COLUMNS,
    PLACE_M,
)


def observation_space(team: int, decision: DecisionSpec) -> spaces.Dict:
    """Return the space of what a robot of a team observes; see `multisrt.robots.policy`."""
    turn = np.float32(np.pi)
    place = np.array([PLACE_M, PLACE_M, turn], np.float32)
    parts: dict[str, spaces.Space[Any]] = {
        "pose": spaces.Box(-place, place, dtype=np.float32),
        "time": spaces.Box(0.0, MAX_TIME_S, (1,), np.float32),
    }
    if "frontiers" in decision.observe:
        least = _rows(decision.frontiers, FRONTIER_COLUMNS, dx=-FAR_M, dy=-FAR_M)
        parts["frontiers"] = spaces.Box(least, np.full_like(least, FAR_M), dtype=np.float32)
    if "others" in decision.observe and team > 1:
        offsets = dict.fromkeys(OTHER_COLUMNS[:4], -FAR_M)
        least = _rows(team - 1, OTHER_COLUMNS, **offsets)
        most = np.full_like(least, FAR_M)
        most[:, 4] = MAX_TIME_S
        parts["others"] = spaces.Box(least, most, dtype=np.float32)
        parts["others_mask"] = spaces.Box(0, 1, (team - 1, 2), np.int8)
    if "map" in decision.observe:
        cells = decision.map_cells
        parts["map"] = spaces.Box(0, 2, (cells, cells), np.uint8)
    if decision.actions == "place":
        parts["decides"] = spaces.Box(0, 1, (1,), np.int8)
    else:
        parts["action_mask"] = spaces.Box(0, 1, (decision.no_op + 1,), np.int8)
    return spaces.Dict(parts)


def action_space(decision: DecisionSpec) -> spaces.Space[Any]:
    """Return the space of what a robot may be answered."""
    if decision.actions == "place":
        return spaces.Box(-1.0, 1.0, (2,), np.float32)
    return spaces.Discrete(decision.no_op + 1)


def _rows(count: int, columns: tuple[str, ...], **least: float) -> np.ndarray[Any, Any]:
    row = [least.get(column, 0.0) for column in columns]
    return np.tile(np.array(row, np.float32), (count, 1))
