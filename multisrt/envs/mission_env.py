"""What the environments of both libraries share."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multisrt.envs.episodes import METADATA, Episodes
from multisrt.envs.missions import Worlds
from multisrt.envs.rewards import Reward
from multisrt.finished_run import Run
from multisrt.recording import Recording
from multisrt.robots.policy import DecisionSpec


class MissionEnv:
    """Base of `ExploreEnv` and `ExploreParallelEnv`: missions that pause where a robot decides.

    Parameters
    ----------
    environment : Environment, str, Path, RunSpec or sequence of worlds
        The world, by name or as a map file; several, of which one is drawn for each episode; or
        the spec of the run, whose strategy is replaced.
    decision : DecisionSpec, optional
        What robots observe and may be answered.
    reward : callable, optional
        Takes a `Gain` and returns the reward of a robot. Default: `AreaReward`, the area that is
        newly seen (m2), exactly as `multisrt.measure` measures it.
    end_coverage : float, optional
        Share of what can be explored at which the mission is over, checked at each decision.
        Default: it goes on until no frontier is left. Each new world then costs the computing of
        what can be explored there, up to some seconds.
    world_seeds : sequence of int, optional
        Seeds of generated worlds, of which one is drawn for each episode.
    render_mode : {"rgb_array"}, optional
        Whether `render` draws: the truth, what of it was seen, and the robots.
    **mission
        Keywords of `multisrt.explore` that describe the team and the run: `seed`, `options`,
        `robots`, `start`, `starts`, `footprint`, `range_m`, `beams`, `drive`, `radio_range_m`,
        `radio`, `base`, `faults`, `max_time_s`.

    Raises
    ------
    InvalidInputError
        If the arguments contradict each other or describe a run that is impossible.
    """

    metadata: dict[str, Any] = METADATA

    def __init__(
        self,
        environment: Worlds,
        *,
        decision: DecisionSpec | None = None,
        reward: Reward | None = None,
        end_coverage: float | None = None,
        world_seeds: Sequence[int] | None = None,
        render_mode: str | None = None,
        **mission: Any,
    ) -> None:
        self._episodes = Episodes(
            environment,
            decision=decision,
            reward=reward,
            end_coverage=end_coverage,
            world_seeds=world_seeds,
            render_mode=render_mode,
            keywords=mission,
        )
        self.render_mode = render_mode

    @property
    def run(self) -> Run:
        """The mission as a run: so far, as if it were cut off now, or whole once it is over."""
        return self._episodes.run

    @property
    def recording(self) -> Recording:
        """The recording of the mission, so far or whole."""
        return self._episodes.recording

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of the truth and of what was seen, if `render_mode` says so.

        Without a render mode it warns, as environments of Gymnasium do.

        Returns
        -------
        (n, n, 3) array of uint8 or None
            Red, green and blue.
        """
        if self.render_mode != "rgb_array":
            warnings.warn(
                "you are calling render method without specifying any render mode: give "
                'render_mode="rgb_array" when the environment is made',
                stacklevel=2,
            )
            return None
        return self._episodes.picture()

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._episodes.missions.described})"

    def close(self) -> None:
        """End the mission where it is; its run can still be read."""
        self._episodes.close()
