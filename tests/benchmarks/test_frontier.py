import itertools
import math

import pytest

from benchmarks.frontier import travelled_m
from multisrt import explore
from multisrt.environments import environment


@pytest.fixture(scope="module")
def run():
    return explore(environment("open"), strategy="closest", robots=2, seed=1, max_time_s=40.0)


@pytest.mark.slow
def test_the_total_path_length_is_that_of_the_metrics(run):
    assert math.fsum(travelled_m(run.recording, math.inf)) == pytest.approx(
        run.metrics.total_distance_m, rel=1e-9
    )


@pytest.mark.slow
def test_the_path_length_per_second_is_bounded_by_the_speed(run):
    speed_m_s = run.spec.robots[0].drive.speed_m_s
    driven = [travelled_m(run.recording, 0.5 * second) for second in range(81)]
    assert driven[0] == [0.0, 0.0]
    assert driven[-1] == travelled_m(run.recording, math.inf)
    for before, after in itertools.pairwise(driven):
        for a, b in zip(before, after, strict=True):
            assert 0.0 <= b - a <= 0.5 * speed_m_s + 1e-9
