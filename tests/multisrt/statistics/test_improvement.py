import pytest

from multisrt.statistics.improvement import probability_of_improvement
from multisrt.statistics.intervals import wilson


@pytest.mark.parametrize("lower_is_better", [True, False])
def test_certain_wins_have_wilsons_interval_of_disjoint_pairs(lower_is_better):
    a, b = [[1.0, 2.0, 3.0], [1.0, 1.5]], [[4.0, 5.0], [7.0, 8.0, 9.0]]
    found = probability_of_improvement(a, b, lower_is_better=lower_is_better, rng=0)
    # Two tasks of two pairs that share no run each.
    assert found == wilson(4 if lower_is_better else 0, 4)
    assert 0.3 < found.high - found.low < 0.7
