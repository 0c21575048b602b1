"""A few of the runs of benchmarks/bounds.py, and that it would see a bound that is beaten."""

import dataclasses

import pytest

from benchmarks.bounds import KINDS, draw, reached_by
from multisrt.analysis.bounds import LowerBounds


@pytest.mark.slow
@pytest.mark.parametrize("number", range(2 * len(KINDS)))
def test_no_run_beats_its_bounds(number):
    case = draw(number)
    assert case is not None
    found = list(reached_by(case))
    assert not [reached for reached in found if reached.is_beaten]


def test_a_beaten_bound_is_seen():
    case = draw(2)
    assert case is not None
    last = list(reached_by(case))[-1]
    assert last.share > 0.9
    assert not last.is_beaten
    high = LowerBounds(reach_s=last.time_s + 1.0, area_s=0.0, witness_s=None)
    assert dataclasses.replace(last, bounds=high).is_beaten


def test_equal_numbers_draw_equal_cases():
    assert draw(5) == draw(5) != draw(11)
