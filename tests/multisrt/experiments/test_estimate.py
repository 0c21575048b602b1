"""Estimates from a few runs whose computing times are known."""

import math
import time
from itertools import count
from typing import Any

import msgspec
import pytest

from multisrt.experiments import estimate as module
from multisrt.experiments.crossing import Condition, PlannedRun, runs
from multisrt.experiments.estimate import MAX_PROBES, Estimate, estimate
from multisrt.experiments.results import Result, Status
from multisrt.experiments.spec import ExperimentSpec, Limits
from tests.multisrt.experiments.results import result_of

WORLD = {"open": 1.0, "garden": 3.0, "museum": 0.5}
WAY = {"srt-star": 1.0, "srt-radial": 0.4, "minpos": 6.0}

SPEC = ExperimentSpec(
    name="x",
    environments=tuple(WORLD),
    strategies=tuple(WAY),
    robots=(1, 2, 4, 8),
    repetitions=2,
)
PLANNED = runs(SPEC)


def cost(condition: Condition, power: float = 0.7) -> float:
    return 0.05 * WORLD[condition.environment] * WAY[condition.strategy] * condition.robots**power


class Machine:
    """Makes runs of given computing times, on a clock of its own."""

    def __init__(self, monkeypatch, power: float = 0.7, noise: float = 0.0, scale: float = 1.0):
        self.now, self.power, self.noise, self.scale = 0.0, power, noise, scale
        self.made: list[PlannedRun] = []
        self.turns = count()
        monkeypatch.setattr(time, "perf_counter", lambda: self.now)

    def __call__(self, run: PlannedRun, limits: Limits) -> Result:
        wobble = math.exp(self.noise * math.cos(5.0 * next(self.turns)))
        needs = self.scale * cost(run.condition, self.power) * wobble
        took = min(needs, limits.computing_s)
        self.now += took
        self.made.append(run)
        status: Status = "complete" if needs <= limits.computing_s else "over_time"
        return result_of(run, status, computing_s=took, wall_s=took)


def truth(power: float = 0.7, scale: float = 1.0) -> float:
    """Return the computing time of all runs."""
    return sum(scale * cost(run.condition, power) for run in PLANNED)


def estimated(*args: Any, **options: Any) -> Estimate:
    found = estimate(*args, **options)
    assert found is not None
    return found


@pytest.mark.parametrize("power", [0.0, 0.7, 1.5])
@pytest.mark.parametrize("noise", [0.0, 0.15])
def test_products_of_factors_are_estimated_exactly(power, noise, monkeypatch):
    machine = Machine(monkeypatch, power, noise)
    found = estimated(SPEC, PLANNED, machine, budget_s=100.0)
    assert found.low_s <= truth(power) <= found.high_s
    assert found.computing_s == pytest.approx(truth(power), rel=0.2)
    assert found.high_s / found.low_s < 4.0
    assert found.cut_off == 0
    assert found.took_s == machine.now


def test_all_labels_and_sizes_are_tried(monkeypatch):
    found = estimated(SPEC, PLANNED, Machine(monkeypatch), budget_s=1000.0)
    tried = [probe.condition for probe in found.probes]
    assert len(tried) == len(set(tried)) == MAX_PROBES
    assert {one.environment for one in tried} == set(WORLD)
    assert {(one.strategy, one.robots) for one in tried} == {
        (way, robots) for way in WAY for robots in (1, 2, 4, 8)
    }


def test_an_estimate_keeps_to_its_budget(monkeypatch):
    machine = Machine(monkeypatch, scale=10.0)
    found = estimated(SPEC, PLANNED, machine, budget_s=30.0)
    assert machine.now < 45.0
    assert found.computing_s == pytest.approx(truth(scale=10.0), rel=0.5)


def test_trial_runs_are_reproducible(monkeypatch):
    tried = []
    for _ in range(2):
        machine = Machine(monkeypatch)
        estimate(SPEC, PLANNED, machine, budget_s=5.0)
        tried.append([run.key for run in machine.made])
    assert tried[0] == tried[1]
    assert {run.repetition for run in machine.made} == {0}


def test_trial_runs_that_are_cut_off_are_counted(monkeypatch):
    machine = Machine(monkeypatch, scale=1000.0)
    found = estimated(SPEC, PLANNED, machine, budget_s=20.0)
    assert found.cut_off == len(found.probes) > 0
    assert found.computing_s < truth(scale=1000.0)
    assert machine.now <= 40.0


def test_a_single_condition(monkeypatch):
    spec = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",), repetitions=7)
    found = estimated(spec, runs(spec), Machine(monkeypatch), budget_s=9.0)
    assert found.computing_s == pytest.approx(7 * 0.05 * 6.0)
    assert found.low_s == pytest.approx(found.computing_s / math.exp(module.UNKNOWN_SPREAD))
    assert list(found.by_condition_s) == [runs(spec)[0].condition]


def test_there_is_no_estimate_if_no_trial_run_ends():
    def refuse(run: PlannedRun, limits: Limits) -> Result:
        return result_of(run, "refused")

    assert estimate(SPEC, PLANNED, refuse, budget_s=1.0) is None


def test_runs_that_are_the_same_for_every_seed_count_once(monkeypatch):
    machine = Machine(monkeypatch)
    planned = [run for run in PLANNED if run.condition.environment == "open"]
    usual = estimated(SPEC, planned, machine, budget_s=1e4)

    def without_chance(run: PlannedRun, limits: Limits) -> Result:
        return msgspec.structs.replace(machine(run, limits), chance=run.condition.robots > 1)

    # One robot's second repetition need not be made.
    found = estimated(SPEC, planned, without_chance, budget_s=1e4)
    once = sum(cost(run.condition) for run in planned if run.condition.robots == 1) / 2
    assert found.computing_s == pytest.approx(usual.computing_s - once, rel=0.05)
