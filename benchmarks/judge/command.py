"""The command line of the judge; see `benchmarks.judge`."""

from __future__ import annotations

import argparse
import multiprocessing
import os
import time
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from typing import Final

import numpy as np

from benchmarks.judge.areas import World
from benchmarks.judge.draws import draw, worlds
from benchmarks.judge.verdict import Figure, judge, part_of
from multisrt.environments.environment import Environment
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import build_environment
from multisrt.spec import RunSpec
from multisrt.spec.environments import EnvironmentSpec

DRAWS: Final = 20
"""Draws of which one must be a run that the package accepts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A run, and its figures."""

    spec: RunSpec
    world: str
    figures: list[Figure]

    @property
    def name(self) -> str:
        """What to say of it in a line."""
        robots = self.spec.robots
        kinds = ", ".join(dict.fromkeys(f"{r.footprint} {r.drive.kind}" for r in robots))
        return f"{self.spec.strategy}, {self.world}, {len(robots)} x {kinds}, seed {self.spec.seed}"


def main() -> None:
    """Execute the runs, and print exceptions as they are found, and the table."""
    given = _arguments()
    begin = time.perf_counter()
    places = worlds()
    print(f"{given.runs} runs in {len(places)} worlds, seed {given.seed}", flush=True)
    cases: list[Case] = []
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(given.workers, mp_context=context) as pool:
        jobs = [
            pool.submit(judged_runs, where, list(range(k, given.runs, len(places))), given.seed)
            for k, where in enumerate(places[: given.runs])
        ]
        for job in as_completed(jobs):
            cases += job.result()
            print(f"{len(cases)} runs judged, {time.perf_counter() - begin:.0f} s", flush=True)
            for case in job.result():
                print("\n".join(exceptions(case, given.specs)), end="", flush=True)
    print("\n" + "\n".join(table(cases)))


def judged_runs(where: EnvironmentSpec, numbers: list[int], seed: int) -> list[Case]:
    """Make and judge the runs with some numbers in one world."""
    world = build_environment(where)
    parts: dict[str, World] = {}
    cases = []
    for number in numbers:
        spec, recording = _accepted(where, world, number, seed)
        part = part_of(recording)
        judged = parts.setdefault(part.wkb_hex, World(part))
        figures = judge(recording, world, judged)
        cases.append(Case(spec=spec, world=world.name, figures=figures))
    return cases


def exceptions(case: Case, specs: bool = False) -> list[str]:
    """Return the lines of the figures of a run that differ by more than is allowed."""
    lines = [
        f"{case.name}: {figure.name} is {figure.ours:.9g}, judged {figure.judged:.9g}; "
        f"they differ by {figure.difference:.2g}, allowed is {figure.allowed:.2g}"
        for figure in case.figures
        if not figure.holds
    ]
    return [*lines, case.spec.to_toml(), ""] if lines and specs else [*lines, ""] if lines else []


def _accepted(
    where: EnvironmentSpec, world: Environment, number: int, seed: int
) -> tuple[RunSpec, Recording]:
    # Some draws are refused: bodies find no room to start, or a strategy does not fit.
    refusals = []
    for attempt in range(DRAWS):
        spec = draw(np.random.default_rng([seed, number, attempt]), number, where, world)
        try:
            return spec, simulate(spec, world)
        except InvalidInputError as error:
            refusals.append(str(error))
    raise InvalidInputError(f"no run of {DRAWS} in {world.name} was accepted: {refusals}")


def table(cases: list[Case]) -> list[str]:
    """Return a line for every figure."""
    by_name: dict[str, list[Figure]] = defaultdict(list)
    for case in cases:
        for figure in case.figures:
            by_name[figure.name].append(figure)
    lines = [
        f"{'figure':26} {'judged':>7} {'largest difference':>19} {'allowed':>9} {'exceptions':>11}"
    ]
    for name, figures in by_name.items():
        worst = max(figures, key=lambda figure: figure.difference / figure.allowed)
        lines.append(
            f"{name:26} {len(figures):7} {worst.difference:19.2e} {worst.allowed:9.2e} "
            f"{sum(not figure.holds for figure in figures):11}"
        )
    return lines


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.judge",
        description="an independent judge of what is measured of runs",
    )
    parser.add_argument("--runs", type=int, default=104, help="number of runs (default: 104)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the draws (default: 0)")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="default: one a core")
    parser.add_argument("--specs", action="store_true", help="print the spec of each exception")
    return parser.parse_args()
