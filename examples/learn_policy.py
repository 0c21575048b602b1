"""A linear policy over frontier features, improved by the cross-entropy method; no torch needed.

The policy goes to the frontier with the highest weighted sum of features. Weights are drawn from a
normal distribution, tried in generated mazes, and the best ones give the next distribution.
`python examples/learn_policy.py` learns in under a minute, and compares what it learned with
random choice and the nearest frontier in mazes that it has not seen, mission by mission. Needs
`multisrt[learn]`.
"""

from functools import partial

import numpy as np

import multisrt as ms
from multisrt.envs import AreaReward, DecisionSpec, single_env
from multisrt.statistics.intervals import student

DECISION = DecisionSpec(observe=("frontiers",))
MAZES = ms.CatalogEnvironment(name="maze", parameters={"size_m": 12, "cells": 6, "loops": 0.3})
FEATURES = ("path length", "length of the frontier", "turn")


def features(seen):
    """Return a row for each frontier: path length, size, and how far to turn, about 1 each."""
    dx, dy, size_m, cost_m = seen["frontiers"].T
    turn = np.arctan2(dy, dx) - seen["pose"][2]
    return np.column_stack([cost_m / 5.0, size_m, 1.0 - np.cos(turn)])


def linear(weights, seen):
    """Return the number of the frontier with the highest weighted sum."""
    allowed = seen["action_mask"][:-1] == 1
    return int(np.argmax(np.where(allowed, features(seen) @ weights, -np.inf)))


def random_choice(chance, seen):
    """Return the number of any frontier."""
    return int(chance.choice(np.flatnonzero(seen["action_mask"][:-1])))


def total_rewards(env, policy, seeds):
    """Return the total reward of each mission."""
    totals = np.zeros(len(seeds))
    for number, seed in enumerate(seeds):
        seen, _ = env.reset(seed=seed)
        is_over = False
        while not is_over:
            seen, reward, terminated, truncated, _ = env.step(policy(seen))
            totals[number] += reward
            is_over = terminated or truncated
    return totals


def main(rounds=4, candidates=10, worlds=3, tests=12):
    """Learn weights and print what they are worth; return total rewards by policy and mission."""
    mazes = partial(
        single_env, MAZES, decision=DECISION, reward=AreaReward(time_cost_per_s=0.2), max_time_s=3e3
    )
    env, chance = mazes(world_seeds=range(1000)), np.random.default_rng(1)
    mean, spread = np.zeros(len(FEATURES)), np.ones(len(FEATURES))
    for number in range(rounds):
        drawn = mean + spread * chance.standard_normal((candidates, len(FEATURES)))
        seeds = chance.integers(2**31, size=worlds).tolist()
        scores = [total_rewards(env, partial(linear, weights), seeds).mean() for weights in drawn]
        best = drawn[np.argsort(scores)[-max(2, candidates // 4) :]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.1
        print(f"round {number + 1}: mean total reward {np.mean(scores):7.1f}")
    print("learned: " + ", ".join(f"{w:+.2f} {f}" for w, f in zip(mean, FEATURES, strict=True)))
    unseen, seeds = mazes(world_seeds=range(1000, 2000)), range(tests)
    policies = {
        "random": partial(random_choice, chance),
        "nearest": lambda seen: 0,
        "learned": partial(linear, mean),
    }
    found = {name: total_rewards(unseen, policy, seeds) for name, policy in policies.items()}
    for name, rewards in found.items():
        print(f"{name:8} {rewards.mean():7.1f} in mazes that it has not seen")
    # All played the same missions: the difference in each of them tells more than two means.
    for name in ("random", "nearest"):
        gain = student(found["learned"] - found[name])
        print(
            f"learned - {name:8} {gain.value:+6.1f} a mission, "
            f"95 % interval {gain.low:+.1f} to {gain.high:+.1f}, {tests} missions"
        )
    return found


if __name__ == "__main__":
    main()
