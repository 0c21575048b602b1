"""Execution of one run in the simulator of a clone, in a separate process.

The clone is not changed. Its modules have common names (``utils``, ``policy``, ``comm``) and are
found by the import path, so that a process that has imported them should not do anything else.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import io
import os
import sys
import time
from pathlib import Path
from typing import Any

from multisrt.competition import faster
from multisrt.competition.clone import Clone
from multisrt.competition.jobs import Job, JobResult
from multisrt.competition.policies import PolicySource
from multisrt.competition.stand_ins import install
from multisrt.geometry.errors import InvalidInputError

_replaced: tuple[str, ...] | None = None


def load(clone: Clone) -> tuple[str, ...]:
    """Make the simulator of a clone importable; return the modules that stand-ins replace."""
    global _replaced
    if _replaced is None:
        _replaced = install()
        sys.path[:0] = [str(clone.folder / "scripts"), str(clone.folder)]
        sys.dont_write_bytecode = True  # the clone is not changed
    return _replaced


class TimedPolicy:
    """A wrapper of a policy that measures the time of its decisions.

    Parameters
    ----------
    policy : object
        A policy of the competition.

    Attributes
    ----------
    seconds : float
        Total time of all calls of its methods.
    """

    def __init__(self, policy: Any) -> None:
        self._policy = policy
        self.seconds = 0.0

    def __getattr__(self, name: str) -> Any:
        method = getattr(self._policy, name)

        def timed(*arguments: Any) -> Any:
            began = time.perf_counter()
            try:
                return method(*arguments)
            finally:
                self.seconds += time.perf_counter() - began

        return timed


def simulate(
    folder: Path, any_version: bool, source: PolicySource, job: Job, as_it_is: bool = False
) -> JobResult:
    """Execute one run, as the competition's ``main.py`` does, without pictures.

    Parameters
    ----------
    folder : Path
        The clone.
    any_version : bool
        As for `Clone`.
    source : PolicySource
        The policy.
    job : Job
        The map, the team and its start.
    as_it_is : bool
        Whether to run the original simulator, without the functions of
        `multisrt.competition.faster`. This is always so for policies of others and for other
        versions of the simulator.

    Returns
    -------
    JobResult

    Raises
    ------
    InvalidInputError
        If the policy raises an error, or names an invalid goal.
    """
    # The simulator runs in its own working directory, so the path has to be absolute.
    folder = folder.resolve()
    clone = Clone(folder, any_version=any_version)
    replaced = load(clone)
    fast = not as_it_is and source.path is None and not clone.changed
    options = clone.options()
    options.environment, options.num_robots = job.map, job.robots
    options.max_steps, options.start_pose = job.steps, list(job.start)
    options.traj_sharing, options.save_viz = True, False

    previous, output = Path.cwd(), io.StringIO()
    os.chdir(folder / "scripts")  # modules add '../' to the import path
    try:
        with contextlib.redirect_stdout(output):
            return _run(clone, options, source, job, replaced=replaced, fast=fast)
    finally:
        os.chdir(previous)


def _run(
    clone: Clone,
    options: Any,
    source: PolicySource,
    job: Job,
    *,
    replaced: tuple[str, ...],
    fast: bool,
) -> JobResult:
    began = time.perf_counter()
    module = importlib.import_module
    module("environment")  # first, as in main.py: the simulator's imports are circular
    if not clone.changed:
        faster.install(fast)
    policy = TimedPolicy(source.build(module("base_policy").BasePolicy))
    engine = module("policy").PlanningEngine()
    column, row = job.start
    pose = [row + options.pd_size, column + options.pd_size]
    robots = [
        module("robot").Robot(i + 1, pose, engine, policy, options, 5 * i)
        for i in range(job.robots)
    ]
    base = module("base_station").BaseStation(pose)
    world = module("environment").World(
        str(clone.folder.resolve() / "test_maps" / job.map), robots, base
    )
    for robot in robots:
        robot.initialize_map(world)
    base.initialize_map(world)
    links = module("comm").CommunicationManager()
    for step in range(job.steps):
        world.t = step
        try:
            world.step(links, options)
        except Exception as error:
            raise InvalidInputError(
                f"{source.name} on {job.map}, {job.robots} robots from {job.start}, step {step}: "
                f"{type(error).__name__}: {error}"
            ) from error
    return JobResult(
        coverage=module("scoring").base_station_coverage(base, options),
        decision_s=policy.seconds / (job.steps * job.robots),
        wall_s=time.perf_counter() - began,
        replaced=replaced,
        fast=fast,
    )
