"""Faster functions give what the simulator's own do."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy import ndimage

from multisrt.competition.faster import (
    PLAN_MARGIN,
    draw_line,
    filled_outline,
    local_weights,
    merge,
    write_scan,
)
from multisrt.competition.jobs import Job
from multisrt.competition.policies import PolicySource
from multisrt.competition.running import execute

STATES = st.sampled_from([0.0, 0.5, 1.0])


def widened(known):
    """Return what ``inflate_map`` of the competition computes, by functions of scipy."""
    blocked = ndimage.binary_dilation(known > 0.5, structure=np.ones((3, 3), bool))
    free = (known == 0) & ~blocked
    distances = ndimage.distance_transform_cdt(free)
    return np.where(blocked, np.inf, np.clip(10 - distances, 1, 10)).astype(np.float32)


@pytest.mark.parametrize("walls", [0.0, 0.002, 0.03])
def test_costs_near_a_robot_are_those_of_the_whole_map(walls):
    generator = np.random.default_rng(5)
    known = np.where(generator.random((120, 130)) < walls, 1.0, 0.0)
    known[80:, 70:] = 0.5
    edge = PLAN_MARGIN
    part = local_weights(known, (20, 25), 40)[edge:-edge, edge:-edge]
    assert np.array_equal(part, widened(known)[20 + edge : 101 - edge, 25 + edge : 106 - edge])


@given(*[st.integers(0, 30)] * 4)
def test_lines_are_connected_and_as_long_as_their_ends_are_apart(a, b, c, d):
    grid = np.zeros((31, 31), np.int8)
    draw_line(grid, a, b, c, d)
    assert grid[a, b] == grid[c, d] == 1
    assert grid.sum() == max(abs(a - c), abs(b - d)) + 1
    assert ndimage.label(grid, np.ones((3, 3)))[1] == 1


def test_the_inside_of_an_outline_is_filled():
    square = np.array([[15, 15], [15, 25], [25, 25], [25, 15], [15, 15]])
    inside, closed = filled_outline(square, (10, 10), 10)
    assert closed
    assert np.array_equal(np.argwhere(inside == 2) + 10, np.argwhere(np.ones((9, 9))) + 16)
    _, closed = filled_outline(square[:4], (10, 10), 10)
    assert not closed
    assert not filled_outline(square, (10, 10), 5)[1]  # the robot is on the outline


@given(
    arrays.arrays(np.float64, (3, 4), elements=STATES),
    arrays.arrays(np.float64, (3, 4), elements=STATES),
)
def test_maps_are_merged_as_in_the_simulator(one, other):
    both = np.full_like(one, 0.5)
    both[(one == 0.0) | (other == 0.0)] = 0.0
    both[(one == 1.0) | (other == 1.0)] = 1.0
    merge(one, other)
    assert np.array_equal(one, both)
    assert np.array_equal(other, both)


def test_a_scan_adds_and_walls_stay():
    known = np.full((9, 9), 0.5)
    known[4, 4], known[4, 5] = 1.0, 0.0
    unreported = np.zeros((9, 9), bool)
    inside = np.zeros((3, 3), np.int8)
    inside[1] = 2
    write_scan(inside, (3, 3), np.array([[2, 4]]), known, unreported)
    assert np.argwhere(known != 0.5).tolist() == [[2, 4], [4, 3], [4, 4], [4, 5]]
    assert known[4].tolist()[3:6] == [0.0, 1.0, 0.0]
    assert known[2, 4] == 1.0
    assert np.argwhere(unreported).tolist() == [[2, 4], [4, 3]]


@pytest.mark.parametrize("robots", [1, 3])
def test_runs_are_the_same_as_in_the_simulator_as_it_is(real, robots):
    job = Job(map="env2", robots=robots, start=(251, 20), steps=50)
    source, found = PolicySource.of("gain-home"), []
    for as_it_is in (False, True):
        ((_, result),) = execute(Path(real), False, source, [job], 1, as_it_is=as_it_is)
        assert result.fast is not as_it_is
        found.append(result.coverage)
    assert found[0] == found[1]
