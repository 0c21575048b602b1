"""What a mission costs that is stepped through by actions, beside the same mission run whole.

The same policy, nearest frontier, is an explorer of `simulate` and chooses the actions of an
environment. Both make the same run; the environment also measures what is newly seen, for rewards.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from benchmarks.harness import Benchmark, Claim, installed, skipped
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.robots.policy import DecisionSpec, Observation, policy_strategy
from multisrt.robots.registry import registered
from multisrt.simulation.simulate import simulate
from multisrt.spec import CatalogEnvironment, RobotSpec, RunSpec

MISSIONS = (("apartment", 1), ("apartment", 4), ("museum", 1), ("museum", 4))
"""Worlds and numbers of robots."""

ROUNDS = 5
"""Number of alternating runs of both sides; the shortest counts."""

MAX_RATIO = 1.2
"""Upper bound of the time in steps over that of the whole run."""

DECISION = DecisionSpec(observe=("frontiers",))
"""What the policy needs."""


def nearest(observation: Observation) -> int:
    """Return the number of the nearest frontier."""
    costs = observation["frontiers"][:, 3]
    return int(np.where(observation["action_mask"][:-1], costs, np.inf).argmin())


def stepped() -> Iterator[Claim | str]:
    """Measure missions in steps against the same missions as whole runs."""
    text = "mission in steps of an environment: the same run whole"
    if not (installed("gymnasium") and installed("pettingzoo")):
        yield skipped(text, "multisrt[learn]")
        return
    from multisrt.envs import parallel_env
    from multisrt.envs.mission import STRATEGY

    for name, robots in MISSIONS:
        world = environment(name)
        spec = RunSpec(
            environment=CatalogEnvironment(name=name),
            strategy=STRATEGY,
            robots=(RobotSpec(),) * robots,
            seed=1,
        )
        env = parallel_env(spec, decision=DECISION)
        sides = {"steps": partial(in_steps, env), "whole": partial(whole, spec, world)}
        best_s, digests = dict.fromkeys(sides, math.inf), dict.fromkeys(sides, "")
        with registered(policy_strategy(STRATEGY, nearest, DECISION)):
            for _ in range(ROUNDS):
                for side, run in sides.items():
                    begin_s = time.process_time()
                    digests[side] = run()
                    best_s[side] = min(best_s[side], time.process_time() - begin_s)
        yield Claim(
            text=f"mission in steps, {robots} robots, {name}: the same run whole",
            ours=best_s["steps"] * 1e3,
            theirs=best_s["whole"] * 1e3,
            unit="ms",
            at_most=MAX_RATIO,
            holds=digests["steps"] == digests["whole"],
        )


def in_steps(env: Any) -> str:
    """Play a mission of an environment to its end; return the digest of the run."""
    observations, infos = env.reset(seed=1)
    while env.agents:
        actions = {a: nearest(observations[a]) for a in env.agents if infos[a]["decides"]}
        observations, _, _, _, infos = env.step(actions)
    return str(env.recording.footer.digest)


def whole(spec: RunSpec, world: Environment) -> str:
    """Execute a run; return its digest."""
    return simulate(spec, world).footer.digest


BENCHMARKS: dict[str, Benchmark] = {"missions in steps": stepped}
