"""Environments for reinforcement learning, in which actions are the goals of robots.

`parallel_env` makes a PettingZoo `ParallelEnv` of a team, `single_env` a Gymnasium environment of
a single robot; Gymnasium knows the latter as ``multisrt/Explore-v0`` once this module is imported.
Both run the same simulation as `multisrt.explore`, with its worlds, robots, radios and faults, and
pause whenever a robot needs a goal. `policy_strategy` makes a strategy of what was learned.

>>> from multisrt.envs import DecisionSpec, single_env
>>> env = single_env("apartment", decision=DecisionSpec(observe=("frontiers",)))
>>> observation, info = env.reset(seed=1)
>>> is_over = False
>>> while not is_over:
...     nearest = 0
...     observation, reward, terminated, truncated, info = env.step(nearest)
...     is_over = terminated or truncated
>>> env.run.outcome
'complete'

Observations are computed from a robot's scans, messages and pose alone. Rewards, the state and the
info dict are computed from the true world.
"""

from multisrt.extras import extra

with extra("learn", "multisrt.envs"):
    import gymnasium
    import pettingzoo  # noqa: F401

from multisrt.envs.mission_env import MissionEnv
from multisrt.envs.parallel import ExploreParallelEnv, parallel_env
from multisrt.envs.rewards import AreaReward, Gain
from multisrt.envs.single import ExploreEnv, single_env
from multisrt.robots.policy import DecisionSpec, policy_strategy

__all__ = [
    "AreaReward",
    "DecisionSpec",
    "ExploreEnv",
    "ExploreParallelEnv",
    "Gain",
    "MissionEnv",
    "parallel_env",
    "policy_strategy",
    "single_env",
]

ENV_ID = "multisrt/Explore-v0"
"""The name by which Gymnasium knows the environment of a single robot."""

if ENV_ID not in gymnasium.registry:
    gymnasium.register(id=ENV_ID, entry_point="multisrt.envs:single_env")
