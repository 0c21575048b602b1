"""One run in the simulator of a clone, which stays as it is; for a process of its own.

The simulator's modules have plain names (``utils``, ``policy``, ``comm``) and are found by the
import path, so a process that has loaded them is fit for nothing else.
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
    """Make the simulator of a clone importable; return the modules with a stand-in."""
    global _replaced
    if _replaced is None:
        _replaced = install()
        sys.path[:0] = [str(clone.folder / "scripts"), str(clone.folder)]
        sys.dont_write_bytecode = True  # the clone stays as it is
    return _replaced


class Timed:
    """A policy, and the time that its decisions take.

    Parameters
    ----------
    policy : object
        A policy of the competition.

    Attributes
    ----------
    seconds : float
        The time.
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
    """Make one run, as the competition's ``main.py`` does, without pictures.

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
        Whether the simulator runs without the functions of `multisrt.competition.faster`, as it
        does for policies of others and for other versions.

    Returns
    -------
    JobResult

    Raises
    ------
    InvalidInputError
        If the policy raises, or names a goal that it may not.
    """
    # The simulator is run in a folder of its own, where relative paths mean something else.
    folder = folder.resolve()
    clone = Clone(folder, any_version=any_version)
    replaced = load(clone)
    fast = not as_it_is and source.path is None and not clone.changed
    options = clone.options()
    options.environment, options.num_robots = job.map, job.robots
    options.max_steps, options.start_pose = job.steps, list(job.start)
    options.traj_sharing, options.save_viz = True, False

    where, quiet = Path.cwd(), io.StringIO()
    os.chdir(folder / "scripts")  # modules add '../' to the import path
    try:
        with contextlib.redirect_stdout(quiet):
            return _run(clone, options, source, job, (replaced, fast))
    finally:
        os.chdir(where)


def _run(
    clone: Clone, options: Any, source: PolicySource, job: Job, how: tuple[tuple[str, ...], bool]
) -> JobResult:
    began = time.perf_counter()
    replaced, fast = how
    part = importlib.import_module
    part("environment")  # first, as in main.py: its modules import one another in a circle
    if not clone.changed:
        faster.install(fast)
    policy = Timed(source.build(part("base_policy").BasePolicy))
    engine = part("policy").PlanningEngine()
    column, row = job.start
    pose = [row + options.pd_size, column + options.pd_size]
    robots = [
        part("robot").Robot(i + 1, pose, engine, policy, options, 5 * i) for i in range(job.robots)
    ]
    base = part("base_station").BaseStation(pose)
    world = part("environment").World(
        str(clone.folder.resolve() / "test_maps" / job.map), robots, base
    )
    for robot in robots:
        robot.initialize_map(world)
    base.initialize_map(world)
    links = part("comm").CommunicationManager()
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
        coverage=part("scoring").base_station_coverage(base, options),
        decision_s=policy.seconds / (job.steps * job.robots),
        wall_s=time.perf_counter() - began,
        replaced=replaced,
        fast=fast,
    )
