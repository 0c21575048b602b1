"""A Gymnasium environment: one robot, one decision a step."""

from __future__ import annotations

from typing import Any

import gymnasium
from gymnasium import spaces

from multisrt.envs.mission_env import MissionEnv
from multisrt.envs.missions import Worlds, seed_of
from multisrt.envs.spaces import action_space, observation_space
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.policy import Answer, Observation


class ExploreEnv(MissionEnv, gymnasium.Env[Observation, Answer]):
    """One robot that explores, and asks at each step where to go.

    A step lasts from one decision to the next. An episode is a mission: it is terminated
    when the robot can reach no more frontier or has stalled, or at `end_coverage`; it is truncated
    at the time of the stop rule.

    Parameters
    ----------
    environment : Environment, str, Path, RunSpec or sequence of worlds
        Where the robot explores.
    **keywords
        See `MissionEnv`.

    Raises
    ------
    InvalidInputError
        If the arguments contradict each other or describe a run that is impossible, or a
        team.

    Examples
    --------
    >>> from multisrt.envs import DecisionSpec, ExploreEnv
    >>> env = ExploreEnv("apartment", decision=DecisionSpec(frontiers=4, observe=("frontiers",)))
    >>> observation, info = env.reset(seed=1)
    >>> sorted(observation), observation["action_mask"].tolist()
    (['action_mask', 'frontiers', 'pose', 'time'], [1, 1, 1, 1, 0])
    >>> observation, reward, terminated, truncated, info = env.step(0)
    >>> reward > 0.0, terminated, info["valid"]
    (True, False, True)
    """

    def __init__(self, environment: Worlds, **keywords: Any) -> None:
        super().__init__(environment, **keywords)
        if (team := self._episodes.missions.team) != 1:
            raise InvalidInputError(
                f"an environment for Gymnasium has one robot, not {team}: use "
                "multisrt.envs.parallel_env for a team"
            )
        self.observation_space: spaces.Space[Any] = observation_space(team, self._episodes.decision)
        self.action_space = action_space(self._episodes.decision)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin a mission, and go on until the robot asks where to go.

        Parameters
        ----------
        seed : int, optional
            Seed of the mission, as in `multisrt.explore`; it also determines which world is
            drawn, and the missions that later calls without a seed begin. Where no seed was
            ever given, neither here nor as `seed` nor in a `RunSpec`, missions are drawn from
            the entropy of the system, so that each environment begins others.
        options : dict, optional
            Not used.

        Returns
        -------
        observation : dict of str to array
            See `multisrt.robots.policy.observing`.
        info : dict
            Measures for the record: `decides`, `valid`, `time_s`, `seen_m2`; at the end also
            `outcome` and `reason`.
        """
        seed = None if seed is None else seed_of(seed)
        is_first = self._np_random is None
        super().reset(seed=self._episodes.missions.seed if seed is None and is_first else seed)
        # Without any seed, `np_random` is seeded from entropy.
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


def single_env(environment: Worlds, **keywords: Any) -> ExploreEnv:
    """Return a Gymnasium environment of one robot.

    Parameters
    ----------
    environment : Environment, str, Path, RunSpec or sequence of worlds
        Where the robot explores.
    **keywords
        See `MissionEnv`.

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
