"""A sequence of missions: what both kinds of environments share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from multisrt.envs.mission import STRATEGY, Mission
from multisrt.envs.missions import Missions, Worlds
from multisrt.envs.picture import PICTURE_CELLS, TruthRaster
from multisrt.envs.rewards import AreaReward, Gain, Reward
from multisrt.finished_run import Run
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.robots.policy import DecisionSpec, policy_strategy

RENDER_MODES = ["rgb_array"]
"""How environments can be drawn."""

METADATA: dict[str, Any] = {
    "name": "multisrt_explore_v0",
    "render_modes": RENDER_MODES,
    "render_fps": 4,
    "is_parallelizable": True,
}
"""Metadata of environments for Gymnasium and PettingZoo."""

MAX_DRAWN = 2**31 - 1
"""Bounds the seeds that are drawn for missions."""


class Episodes:
    """The missions of one environment, of which one is under way.

    Parameters
    ----------
    worlds : World, RunSpec or sequence of World
        Where missions take place; see `Missions`.
    decision : DecisionSpec or None
        What robots observe and may be answered; None: the defaults.
    reward : callable or None
        What a robot is rewarded for; None: `AreaReward`.
    end_coverage : float or None
        See `Mission`.
    world_seeds : sequence of int or None
        See `Missions`.
    render_mode : {"rgb_array"} or None
        Whether `picture` draws.
    keywords : mapping
        Keywords of `multisrt.explore`.

    Raises
    ------
    InvalidInputError
        If a value cannot be used.
    """

    def __init__(
        self,
        worlds: Worlds,
        *,
        decision: DecisionSpec | None,
        reward: Reward | None,
        end_coverage: float | None,
        world_seeds: Sequence[int] | None,
        render_mode: str | None,
        keywords: Mapping[str, Any],
    ) -> None:
        if end_coverage is not None and not (
            isinstance(end_coverage, float | int) and 0.0 < end_coverage <= 1.0
        ):
            raise InvalidInputError(
                f"end_coverage is a share above 0, up to 1, not {end_coverage!r}"
            )
        if not (decision is None or isinstance(decision, DecisionSpec)):
            raise InvalidInputError(f"decision is a DecisionSpec, not {decision!r}")
        if not (reward is None or callable(reward)):
            raise InvalidInputError(f"reward is a function of a Gain, not {reward!r}")
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise InvalidInputError(
                f"render_mode is {' or '.join(RENDER_MODES)} or None, not {render_mode!r}"
            )
        self.decision = DecisionSpec() if decision is None else decision
        self.missions = Missions(worlds, STRATEGY, world_seeds, keywords)
        # What the options or the team cannot be is said now, not at the first mission.
        strategy = policy_strategy(STRATEGY, None, self.decision)
        strategy.parse_options(self.missions.template.options)
        strategy.require_fit(self.missions.template)
        self._reward = AreaReward() if reward is None else reward
        self._end_coverage = end_coverage
        self._mission: Mission | None = None
        self._rasters: dict[int, TruthRaster] = {}

    @property
    def mission(self) -> Mission:
        """The mission under way, or that has ended last."""
        if self._mission is None:
            raise InvalidInputError("no mission has begun: call reset first")
        return self._mission

    @property
    def run(self) -> Run:
        """The run of the mission, so far or whole."""
        return self.mission.run

    @property
    def recording(self) -> Recording:
        """The recording of the mission, so far or whole."""
        return self.run.recording

    def begin(self, seed: int | None, chance: Generator) -> Mission:
        """Begin a mission; without a seed, with one that is drawn."""
        self.close()
        if seed is None:
            seed = int(chance.integers(MAX_DRAWN))
        spec, world = self.missions.draw(seed, chance)
        self._mission = Mission(spec, world, self.decision, self._end_coverage)
        self._rasters.clear()
        return self._mission

    def rewards(self, gains: Sequence[Gain]) -> list[float]:
        """Return the reward of each robot."""
        return [float(self._reward(gain)) for gain in gains]

    def state(self, cells: int) -> NDArray[np.float32]:
        """Return the truth in layers; see `TruthRaster.state`."""
        return self._raster(cells).state(self.mission.regions, self.mission.places)

    def picture(self) -> NDArray[np.uint8]:
        """Return a picture; see `TruthRaster.picture`."""
        raster = self._raster(PICTURE_CELLS)
        return raster.picture(self.mission.regions, self.mission.places)

    def close(self) -> None:
        """End the mission where it is; its run can still be read."""
        if self._mission is not None:
            self._mission.close()

    def _raster(self, cells: int) -> TruthRaster:
        if cells not in self._rasters:
            self._rasters[cells] = TruthRaster(self.mission.world, cells)
        return self._rasters[cells]
