"""Shrinking: a planted defect is left with what it needs, and with nothing else."""

import pytest

from multisrt.campaign import mission, shrinking
from multisrt.campaign.draws import draw
from multisrt.campaign.mission import JUDGED, Verdict, judge
from multisrt.campaign.shrinking import is_alike, shrink
from multisrt.campaign.violations import Violation
from multisrt.campaign.worlds import world_of
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    DriveSpec,
    LateStart,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)

BROKE = Violation(invariant="planted", says="robot 1 has a fault", robot=1)

TEAM = RunSpec(
    environment=CatalogEnvironment(name="maze", parameters={"size_m": 8.0, "cells": 4}, seed=9),
    strategy="closest",
    options={"cell_m": 0.15, "pause_s": 3.0, "patience": 2, "sense": "targets"},
    robots=(
        RobotSpec(footprint="box:0.3x0.2", drive=DriveSpec(kind="holonomic")),
        RobotSpec(footprint="disc:0.17"),
        RobotSpec(range_finder=RangeFinderSpec(range_m=3.0)),
        RobotSpec(footprint="disc:0.2"),
    ),
    radio=RadioSpec(range_m=6.0, walls="block", latency_s=0.2),
    faults=(
        LateStart(robot=3, time_s=1.5),
        Silence(robot=1, time_s=2.5, duration_s=3.0),
        Death(robot=0, time_s=4.0),
    ),
    stop=StopRule(max_time_s=20.0, max_idle_s=100.0),
    seed=77,
)


def _planted(run) -> list[Violation]:
    spec = run.recording.spec
    return [BROKE] if len(spec.robots) >= 2 and spec.faults else []


@pytest.fixture
def planted(monkeypatch):
    """An invariant that fails whenever there are two robots and a fault."""
    monkeypatch.setattr(mission, "check", _planted)


def test_a_planted_defect_is_shrunk_to_what_it_needs(planted):
    shrunk = shrink(TEAM, judge(TEAM).violations[0], judge)
    spec = shrunk.spec
    assert judge(spec).violations == (BROKE,)
    assert len(spec.robots) == 2
    assert len(spec.faults) == 1
    assert spec.robots == (RobotSpec(),) * 2
    assert spec.environment == CatalogEnvironment(name="open", parameters={"size_m": 5.0})
    assert (spec.options, spec.radio) == ({}, RadioSpec())
    assert spec.stop == StopRule(max_time_s=spec.stop.max_time_s)
    assert spec.stop.max_time_s <= 4.0
    assert (spec.starts, spec.seed) == ("clustered", 0)
    assert shrunk.tries <= 80


def test_shrinking_is_repeatable(planted):
    shrunk = [shrink(TEAM, BROKE, judge, max_tries=12) for _ in range(2)]
    assert shrunk[0] == shrunk[1]
    assert shrunk[0].tries == 12


def test_a_mission_as_drawn_is_shrunk(monkeypatch):
    # By what a spec says, without making the runs; only worlds are built.
    def asks(spec: RunSpec) -> Verdict:
        try:
            world_of(spec.environment)
        except InvalidInputError:
            return Verdict(outcome="refused")
        fails = spec.strategy == "utility" and any(r.drive.is_car for r in spec.robots)
        return Verdict(outcome="complete", violations=(BROKE,) * fails)

    specs = (draw(6, number) for number in range(1000))
    drawn = next(spec for spec in specs if asks(spec).violations and len(spec.robots) > 3)
    shrunk = shrink(drawn, BROKE, asks, max_tries=400).spec
    assert len(shrunk.robots) == 1
    assert shrunk.robots[0].drive.is_car
    assert (shrunk.faults, shrunk.options, shrunk.base) == ((), {}, None)
    assert isinstance(shrunk.environment, CatalogEnvironment)
    assert shrunk.environment.name == "open"


def test_another_failure_is_not_taken_for_the_same(monkeypatch):
    found = Violation(invariant="no-error", says="KeyError in team.py:7: 3")

    def asks(spec: RunSpec) -> Verdict:
        line = 7 if len(spec.robots) > 2 else 9
        error = Violation(invariant="no-error", says=f"KeyError in team.py:{line}: 4")
        return Verdict(outcome="error", violations=(error,))

    shrunk = shrink(TEAM, found, asks)
    assert len(shrunk.spec.robots) == 3
    assert shrunk.violation.says == "KeyError in team.py:7: 4"


def test_specs_with_lasers_that_miss_walls_are_no_simpler(monkeypatch):
    monkeypatch.setattr(shrinking, "finds_all", lambda spec: len(spec.robots) > 2)
    asked = []

    def asks(spec: RunSpec) -> Verdict:
        asked.append(spec)
        return Verdict(outcome="complete", violations=(BROKE,))

    assert len(shrink(TEAM, BROKE, asks).spec.robots) == 3
    assert min(len(spec.robots) for spec in asked) == 3


def test_a_world_whose_generator_fails_is_no_simpler(monkeypatch):
    def fails(spec: RunSpec) -> bool:
        if len(spec.robots) < 3:
            raise ZeroDivisionError
        return True

    monkeypatch.setattr(shrinking, "finds_all", fails)
    shrunk = shrink(TEAM, BROKE, lambda spec: Verdict(outcome="complete", violations=(BROKE,)))
    assert len(shrunk.spec.robots) == 3


def test_errors_of_checks_are_alike_if_raised_at_one_place():
    one = Violation(invariant=JUDGED, says="IndexError in completeness.py:288: 3")
    other = Violation(invariant=JUDGED, says="ValueError in free_space.py:109: 3")
    assert is_alike(one, one)
    assert not is_alike(one, other)


def test_violations_of_one_invariant_are_alike_wherever_they_are():
    assert is_alike(BROKE, Violation(invariant="planted", says="other"))
    assert not is_alike(BROKE, Violation(invariant="other", says=BROKE.says))
