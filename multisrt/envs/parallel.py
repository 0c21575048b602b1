"""A PettingZoo environment: a team whose robots decide one at a time while the others drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.random import Generator
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from multisrt.envs.mission import Mission
from multisrt.envs.mission_env import MissionEnv
from multisrt.envs.missions import Worlds, seed_of
from multisrt.envs.spaces import action_space, observation_space
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.policy import Answer, Observation

MAX_STATE_CELLS = 4096
"""Maximum number of rows and columns of a state."""


class ExploreParallelEnv(MissionEnv, ParallelEnv):  # type: ignore[misc]
    """A team that explores, and whose robots ask where to go.

    The mission goes on until a robot asks, and pauses there: at each step exactly one robot
    decides, while the others are on their way, wait, or are done. Only its action counts. All
    others are to take the last action, ``no_op``, the only one that their masks allow; their
    actions are ignored. Robots that ask at the same moment do so one after the other, in
    the order in which the simulation calls on them, so that a later one may have heard where an
    earlier one goes.

    What a robot on its way observes is what it observed at its last decision. An agent is
    terminated when its robot dies, and all are at the end of the mission: when no robot has a
    frontier left that it can reach, when they have stalled, or at `end_coverage`. All are
    truncated at the time of the stop rule. A robot that is done but may be called on by a message
    remains an agent.

    Parameters
    ----------
    environment : Environment, str, Path, RunSpec or sequence of worlds
        Where the team explores.
    state_cells : int, default 64
        Number of rows and columns of the state.
    **keywords
        See `MissionEnv`.

    Attributes
    ----------
    possible_agents, agents : list of str
        The robots, ``robot_0`` and on, and those that have not come to their end.

    Raises
    ------
    InvalidInputError
        If the arguments contradict each other or describe a run that is impossible.

    Examples
    --------
    >>> from multisrt.envs import parallel_env
    >>> env = parallel_env("apartment", robots=2, starts="clustered")
    >>> observations, infos = env.reset(seed=1)
    >>> [agent for agent in env.agents if infos[agent]["decides"]]
    ['robot_0']
    >>> no_op = env.action_space("robot_1").n - 1
    >>> observations, rewards, *_ = env.step({"robot_0": 0, "robot_1": no_op})
    >>> sorted(rewards)
    ['robot_0', 'robot_1']
    """

    def __init__(self, environment: Worlds, *, state_cells: int = 64, **keywords: Any) -> None:
        if not (isinstance(state_cells, int) and 1 <= state_cells <= MAX_STATE_CELLS):
            raise InvalidInputError(
                f"state_cells is a whole number from 1 to {MAX_STATE_CELLS}, not {state_cells!r}"
            )
        super().__init__(environment, **keywords)
        team = self._episodes.missions.team
        self.possible_agents = [f"robot_{number}" for number in range(team)]
        self.agents: list[str] = []
        self._state_cells = state_cells
        self._chance: Generator | None = None
        # Spaces are one object for each agent, as their random streams are their own.
        spec = self._episodes.decision
        self.observation_spaces = {a: observation_space(team, spec) for a in self.possible_agents}
        self.action_spaces = {a: action_space(spec) for a in self.possible_agents}
        self.state_space = spaces.Box(0.0, 1.0, (3, state_cells, state_cells), np.float32)

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return the space of what an agent observes."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the space of an agent's actions."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin a mission, and go on until a robot asks where to go.

        Parameters
        ----------
        seed : int, optional
            See `ExploreEnv.reset`.
        options : dict, optional
            Not used.

        Returns
        -------
        observations, infos : dict of str to dict
            Of each agent; see `ExploreEnv.reset`.
        """
        seed = None if seed is None else seed_of(seed)
        if seed is not None or self._chance is None:
            self._chance = np.random.default_rng(
                self._episodes.missions.seed if seed is None else seed
            )
        mission = self._episodes.begin(seed, self._chance)
        self.agents = list(self.possible_agents)
        return self._observations(mission), self._infos(mission)

    def step(
        self, actions: Mapping[str, Answer]
    ) -> tuple[
        dict[str, Observation],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Tell the robot that asks where to go, and go on until one asks again.

        Parameters
        ----------
        actions : dict of str to action
            The action of each agent, of which only that of the one that asks counts; see
            `ExploreEnv.step`.

        Returns
        -------
        observations, rewards, terminations, truncations, infos : dict
            By agent, as PettingZoo defines them.

        Raises
        ------
        InvalidInputError
            If the agent that asks has no action, or one that is none; or if the mission is over.
        """
        mission = self._episodes.mission
        answer = None
        if mission.asking is not None:
            asking = self.possible_agents[mission.asking]
            if asking not in actions:
                raise InvalidInputError(f"{asking} asks where to go, and has no action")
            answer = actions[asking]
        rewards = self._episodes.rewards(mission.step(answer))
        stepped = (
            self._observations(mission),
            {agent: rewards[self._robot(agent)] for agent in self.agents},
            {
                agent: mission.end == "terminated" or self._robot(agent) in mission.dead
                for agent in self.agents
            },
            dict.fromkeys(self.agents, mission.end == "truncated"),
            self._infos(mission),
        )
        self.agents = [
            agent
            for agent in self.agents
            if mission.end is None and self._robot(agent) not in mission.dead
        ]
        return stepped

    def state(self) -> NDArray[np.float32]:
        """Return the true state, for centralised training; no robot may decide by it.

        Returns
        -------
        (3, n, n) array of float32
            Layers of 0 and 1 over a square that holds the world, its lowest row first: what the
            team has seen, free space, and the cells in which robots are.
        """
        return self._episodes.state(self._state_cells)

    def _observations(self, mission: Mission) -> dict[str, Observation]:
        return {agent: mission.observation(self._robot(agent)) for agent in self.agents}

    def _infos(self, mission: Mission) -> dict[str, dict[str, Any]]:
        return {agent: mission.info(self._robot(agent)) for agent in self.agents}

    def _robot(self, agent: str) -> int:
        return self.possible_agents.index(agent)


def parallel_env(environment: Worlds, **keywords: Any) -> ExploreParallelEnv:
    """Return a PettingZoo environment of a team.

    Parameters
    ----------
    environment : Environment, str, Path, RunSpec or sequence of worlds
        Where the team explores.
    **keywords
        See `MissionEnv`; and `state_cells` of `ExploreParallelEnv`.

    Returns
    -------
    ExploreParallelEnv
        The environment.

    Examples
    --------
    >>> from multisrt.envs import DecisionSpec, parallel_env
    >>> env = parallel_env("open", robots=3, decision=DecisionSpec(frontiers=5))
    >>> env.possible_agents, env.action_space("robot_0").n.item()
    (['robot_0', 'robot_1', 'robot_2'], 6)
    """
    return ExploreParallelEnv(environment, **keywords)
