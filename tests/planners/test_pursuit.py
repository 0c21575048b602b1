"""Where a robot out of touch may be on its route: against a chain written as a matrix."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.pursuit import best_meeting, presence

SHARES = st.tuples(*[st.floats(0.01, 1.0)] * 3).map(lambda s: [v / sum(s) for v in s])


def chain(cells, stay, leave, stay_away):
    """Transitions between the cells, and then the places beside them."""
    T = np.zeros((2 * cells, 2 * cells))
    for i in range(cells):
        T[i, i] += stay
        T[i, cells + i] += leave
        T[i, min(i + 1, cells - 1)] += 1.0 - stay - leave
        T[cells + i, cells + i] += stay_away
        T[cells + i, i] += 1.0 - stay_away
    return T


@given(st.integers(1, 6), st.integers(0, 12), SHARES, st.floats(0.0, 1.0))
def test_presence_is_that_of_the_chain(cells, steps, shares, stay_away):
    stay, leave, _ = shares
    found = presence(cells, steps, stay=stay, leave=leave, stay_away=stay_away)
    T = chain(cells, stay, leave, stay_away)
    for k in range(steps + 1):
        expected = np.linalg.matrix_power(T, k)[0]
        assert found[k] == pytest.approx(expected[:cells], abs=1e-12)
        assert expected.sum() == pytest.approx(1.0)


def test_the_defaults_are_those_of_the_source():
    # After one step: stayed 0.35, gone on 0.5, left 0.15. After two, at the first cell: 0.35 twice,
    # or left and come back, 0.15 x 0.5.
    assert presence(4, 2)[1].tolist() == pytest.approx([0.35, 0.5, 0.0, 0.0])
    assert presence(4, 2)[2, 0] == pytest.approx(0.35**2 + 0.15 * 0.5)


@pytest.mark.parametrize(
    ("cells", "steps", "changes"),
    [(0, 1, {}), (1, -1, {}), (2, 2, {"stay": 0.9, "leave": 0.2}), (2, 2, {"stay_away": 1.5})],
)
def test_what_is_no_chain_is_refused(cells, steps, changes):
    with pytest.raises(InvalidInputError):
        presence(cells, steps, **changes)


def test_a_pursuer_from_behind_meets_it_where_it_catches_up():
    # It is as fast as the chain can be: cell k at step 3 + k.
    chances = presence(8, 30)
    arrivals = [3.0 + k for k in range(8)]
    found = best_meeting(arrivals, chances)
    assert found is not None
    assert found.probability == max(chances[3 + k, k] for k in range(8))
    assert found.step == 3 + found.cell


def test_parts_of_steps_count_as_whole_ones():
    assert best_meeting([2.2, math.inf], presence(2, 5)) == best_meeting([3.0, 9.0], presence(2, 5))


def test_equal_probabilities_go_to_the_earliest():
    # With nothing but staying the robot is at the first cell for ever.
    chances = presence(2, 10, stay=1.0, leave=0.0)
    assert best_meeting([4.0, 1.0], chances) == (0, 4, 1.0)
