"""The missions of a campaign."""

import json
import subprocess
import sys
from collections import Counter

import msgspec
import pytest

from multisrt.campaign import draws
from multisrt.campaign.bodies import bodies_of
from multisrt.campaign.draws import candidate, draw, drawn
from multisrt.campaign.lasers import finds_all
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.registry import is_built_in, strategies
from multisrt.simulation.setting_up import set_up
from multisrt.spec import Death, LateStart, RunSpec, Silence

SEED = 11
SAMPLE = 250

ELSEWHERE = """
import json, sys
from multisrt.campaign.draws import draw
print(json.dumps([draw(int(seed), int(number)).to_json() for seed, number in json.load(sys.stdin)]))
"""


@pytest.fixture(scope="module")
def candidates() -> list[RunSpec]:
    """First draws of many missions, without those whose parts exclude each other."""
    found = []
    for number in range(SAMPLE):
        try:
            found.append(candidate(SEED, number, 0))
        except InvalidInputError:
            continue
    return found


def test_a_mission_is_the_same_in_another_process_and_order():
    wanted = [(SEED, 5), (SEED, 2), (3, 5)]
    here = [draw(seed, number).to_json() for seed, number in reversed(wanted)]
    done = subprocess.run(
        [sys.executable, "-c", ELSEWHERE],
        input=json.dumps(wanted),
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout) == here[::-1]
    assert len(set(here)) == 3


def test_missions_survive_toml(candidates):
    for spec in candidates:
        assert RunSpec.from_toml(spec.to_toml()) == spec


def test_all_there_is_is_drawn(candidates):
    assert len(candidates) > 0.7 * SAMPLE
    names = {each.name for each in strategies() if is_built_in(each.name)}
    assert {spec.strategy for spec in candidates} == names
    robots = [robot for spec in candidates for robot in spec.robots]
    assert {robot.drive.kind for robot in robots} == {
        "differential",
        "holonomic",
        "reeds-shepp",
        "dubins",
    }
    assert {robot.footprint.partition(":")[0] for robot in robots} == {"disc", "box", "polygon"}
    outlines = [body.outline for spec in candidates for body in bodies_of(spec)]
    assert any(outline is not None and outline.convex_hull != outline for outline in outlines)
    assert {robot.range_finder.beams is None for robot in robots} == {True, False}
    assert {robot.start is None for robot in robots} == {True, False}
    assert {spec.radio.walls for spec in candidates} == {"pass", "block", "weaken"}
    assert {spec.starts for spec in candidates} >= {"scattered", "clustered", "random", "base"}
    assert {spec.base is None for spec in candidates} == {True, False}
    assert {spec.options.get("home") for spec in candidates} >= {"in-time", "chain", "relays"}
    assert any(spec.options.get("pursue") for spec in candidates)
    faults = [fault for spec in candidates for fault in spec.faults]
    assert {type(fault) for fault in faults} == {Death, LateStart, Silence}
    whens = {fault.when for fault in faults if isinstance(fault, Death)}
    assert whens == {"any", "moving", "waiting", "master"}
    at_once = [Counter(fault.time_s for fault in spec.faults) for spec in candidates]
    assert any(times and max(times.values()) > 2 for times in at_once)


def test_most_teams_are_small(candidates):
    teams = [len(spec.robots) for spec in candidates]
    assert max(teams) > 6
    assert sum(team <= 4 for team in teams) > 0.7 * len(teams)


def test_lasers_are_such_that_no_obstacle_is_missed(candidates):
    assert all(finds_all(spec) for spec in candidates)


def test_a_refused_draw_is_drawn_again(monkeypatch):
    number = next(n for n in range(100) if not drawn(SEED, n).refused)
    first = drawn(SEED, number)
    refused: list[RunSpec] = []

    def once(spec, environment):
        if not refused:
            refused.append(spec)
            raise InvalidInputError("impossible")
        return set_up(spec, environment)

    monkeypatch.setattr(draws, "set_up", once)
    again = drawn(SEED, number)
    assert refused == [first.spec]
    assert again.refused > first.refused
    assert again.spec != first.spec
    assert again.spec.strategy == first.spec.strategy


def test_an_error_of_the_program_is_no_refusal(monkeypatch):
    tried = []

    def fails(spec, environment):
        raise KeyError(3)

    monkeypatch.setattr(draws, "set_up", fails)
    found = drawn(SEED, 0, lambda spec, refused: tried.append((spec, refused)))
    assert found.setup is None
    assert tried[-2:] == [(None, found.refused), (found.spec, found.refused)]


def test_a_grammar_that_draws_nothing_possible_is_an_error(monkeypatch):
    def refuses(spec, environment):
        raise InvalidInputError("impossible")

    monkeypatch.setattr(draws, "set_up", refuses)
    monkeypatch.setattr(draws, "MAX_ATTEMPTS", 3)
    with pytest.raises(RuntimeError, match="no draw of mission 0 of seed 11 is possible"):
        drawn(SEED, 0)


def test_missions_can_be_set_up():
    for number in range(6):
        found = drawn(SEED, number)
        assert found.setup is not None
        assert found.setup.spec == found.spec.canonical()
        assert msgspec.json.decode(found.spec.to_json(), type=RunSpec) == found.spec
