"""A Gymnasium environment: one robot, one decision a step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from multisrt.envs.episodes import METADATA, Episodes
from multisrt.envs.missions import Worlds, seed_of
from multisrt.envs.rewards import Reward
from multisrt.envs.spaces import action_space, observation_space
from multisrt.finished_run import Run
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.robots.advised import Answer, DecisionSpec, Observation


class ExploreEnv(gymnasium.Env[Observation, Answer]):
    """One robot that explores, and asks at each step where to go.

    A step is the way from one decision to the next. An episode is a mission: it is terminated
    when the robot can reach no more frontier or has stalled, or at `end_coverage`; it is truncated
    at the time of the stop rule.

    Parameters
    ----------
    environment : Environment, str, Path, RunSpec or sequence of worlds
        The world, by name or as a map file; several, of which one is drawn for each episode; or
        the spec of the run, whose strategy is replaced.
    decision : DecisionSpec, optional
        What the robot observes and may be answered.
    reward : callable, optional
        Takes a `Gain` and returns the reward. Default: `AreaReward`, the area that is newly seen
        (m2), exactly as `multisrt.measure` measures it.
    end_coverage : float, optional
        Share of what can be explored at which the mission is over, checked at each decision.
        Default: it goes on until no frontier is left. Each new world then costs the computing of
        what can be explored there, up to some seconds.
    world_seeds : sequence of int, optional
        Seeds of generated worlds, of which one is drawn for each episode.
    render_mode : {"rgb_array"}, optional
        Whether `render` draws: the truth, what of it was seen, and the robot.
    **mission
        Keywords of `multisrt.explore` that describe the robot and the run: `seed`, `options`,
        `start`, `footprint`, `range_m`, `beams`, `drive`, `faults`, `max_time_s`.

    Raises
    ------
    InvalidInputError
        If the arguments contradict each other or describe a run that is impossible.

    Examples
    --------
    >>> from multisrt.envs import DecisionSpec, ExploreEnv
    >>> env = ExploreEnv("apartment", decision=DecisionSpec(frontiers=4, parts=("frontiers",)))
    >>> observation, info = env.reset(seed=1)
    >>> sorted(observation), observation["action_mask"].tolist()
    (['action_mask', 'frontiers', 'pose', 'time'], [1, 1, 1, 1, 0])
    >>> observation, reward, terminated, truncated, info = env.step(0)
    >>> reward > 0.0, terminated, info["valid"]
    (True, False, True)
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
        if (team := self._episodes.missions.team) != 1:
            raise InvalidInputError(
                f"an environment for Gymnasium has one robot, not {team}: use "
                "multisrt.envs.parallel_env for a team"
            )
        self.render_mode = render_mode
        self.observation_space: spaces.Space[Any] = observation_space(team, self._episodes.decision)
        self.action_space = action_space(self._episodes.decision)

    @property
    def run(self) -> Run:
        """The mission as a run: so far, as if it were cut off now, or whole once it is over."""
        return self._episodes.run

    @property
    def recording(self) -> Recording:
        """The recording of the mission, so far or whole."""
        return self._episodes.recording

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin a mission, and go on until the robot asks where to go.

        Parameters
        ----------
        seed : int, optional
            Seed of the mission, as in `multisrt.explore`; it also determines which world is
            drawn, and the missions that later calls without a seed begin. Without any, the
            first mission follows from the seed of the spec.
        options : dict, optional
            Not used.

        Returns
        -------
        observation : dict of str to array
            See `multisrt.robots.advised.observing`.
        info : dict
            Measures for the record: `decides`, `valid`, `time_s`, `seen_m2`; at the end also
            `outcome` and `reason`.
        """
        seed = None if seed is None else seed_of(seed)
        is_first = self._np_random is None
        super().reset(seed=self._episodes.missions.seed if seed is None and is_first else seed)
        mission = self._episodes.begin(seed, self.np_random)
        return mission.observation(0), mission.info(0)

    def step(self, action: Answer) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Tell the robot where to go, and go on until it asks again or the mission is over.

        Parameters
        ----------
        action : int or (2,) array
            The number of a frontier, in the order in which they are observed; or the offset of a
            place from the robot along x and y, from -1 to 1, in units of
            `DecisionSpec.place_m`: the robot goes to the place nearest to it where it knows
            that it can stand. An answer that cannot be followed (a number that the mask
            does not allow, or a place that no known path leads to) sends the robot to the
            nearest frontier, and the info says ``valid: False``.

        Returns
        -------
        observation, reward, terminated, truncated, info
            As Gymnasium defines them.

        Raises
        ------
        InvalidInputError
            If the action is neither a whole number nor, with places, two numbers; or if the
            mission is over.
        """
        mission = self._episodes.mission
        [reward] = self._episodes.rewards(mission.step(action))
        return (
            mission.observation(0),
            reward,
            mission.end == "terminated",
            mission.end == "truncated",
            mission.info(0),
        )

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of the truth and of what was seen, if `render_mode` says so.

        Returns
        -------
        (n, n, 3) array of uint8 or None
            Red, green and blue.
        """
        return self._episodes.picture() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """End the mission where it is; its run can still be read."""
        self._episodes.close()


def single_env(environment: Worlds, **keywords: Any) -> ExploreEnv:
    """Return a Gymnasium environment of one robot.

    Parameters
    ----------
    environment : Environment, str, Path, RunSpec or sequence of worlds
        Where the robot explores.
    **keywords
        See `ExploreEnv`, of which it is an instance.

    Returns
    -------
    ExploreEnv
        Without the wrappers that ``gymnasium.make("multisrt/Explore-v0", ...)`` puts around it.

    Examples
    --------
    >>> from multisrt.envs import single_env
    >>> env = single_env(["rooms", "office"], world_seeds=range(100))
    >>> _ = env.reset(seed=7)
    >>> env.run.spec.seed, env.run.spec.environment.name in ("rooms", "office")
    (7, True)
    """
    return ExploreEnv(environment, **keywords)
