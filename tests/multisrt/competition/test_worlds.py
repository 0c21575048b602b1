"""The maps of the competition as worlds, by a small stand-in for the clone."""

import math

import pytest

import multisrt as ms
from multisrt.competition.clone import Clone
from multisrt.competition.worlds import RADIO, RANGE_FINDER, competition_worlds
from multisrt.geometry.errors import InvalidInputError
from multisrt.simulation.radio import weakened_range


@pytest.fixture
def worlds(fake):
    return competition_worlds(fake, ("env1",), draws=2)


def test_bases_are_the_drawn_starts(fake, worlds):
    starts = Clone(fake, any_version=True).starts("env1", 2, 0)
    # 120 x 80 cells of 10 cm, the first row at the top.
    assert [world.base for world in worlds] == [
        (pytest.approx(0.1 * column + 0.05), pytest.approx(8.0 - 0.1 * row - 0.05))
        for column, row in starts
    ]
    assert [(world.name, world.size) for world in worlds] == [("env1", "small")] * 2


def test_all_robots_start_at_the_base(worlds):
    for world in worlds:
        gaps = [math.dist(world.base, start) for start in world.environment.starts]
        assert gaps == pytest.approx([0.0, 0.3, 0.3, 0.3, 0.3])


@pytest.mark.parametrize(("robots", "steps"), [(1, 1000.0), (2, 500.0), (5, 500.0)])
def test_a_step_of_the_budget_is_a_second(worlds, robots, steps):
    spec = worlds[0].spec("gain", robots)
    assert spec.stop.max_time_s == steps
    assert len(spec.robots) == robots
    assert {robot.range_finder.range_m for robot in spec.robots} == {15.0}
    assert spec.base is not None
    assert spec.base.place == worlds[0].base


def test_a_team_of_six_is_refused(worlds):
    with pytest.raises(InvalidInputError, match="teams of 1 to 5 robots, not 6"):
        worlds[0].fields(6)


def test_links_have_the_ranges_that_are_told():
    import numpy as np

    reach = weakened_range(RADIO, np.arange(4))
    assert reach == pytest.approx([15.0, 12.3, 10.1, 8.3], abs=0.05)


def test_strategies_run_under_the_conditions(worlds):
    run = ms.explore(worlds[0].spec("gain", 2, seed=1))
    assert run.metrics.coverage > 0.9
    assert run.recording.footer.time_s <= 500.0


def test_worlds_are_used_in_an_experiment(worlds):
    comparison = ms.compare(
        [worlds[0].environment],
        "gain",
        2,
        1,
        starts="suggested",
        radios=RADIO,
        range_finder=RANGE_FINDER,
        base=worlds[0].base,
        workers=0,
        progress=False,
    )
    assert "env1" in str(comparison)
