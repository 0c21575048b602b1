import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.power_law import fit_power_law


def test_an_exact_power_law_is_recovered():
    x = np.array([1.0, 2.0, 4.0, 8.0])
    fit = fit_power_law(x, 3.0 / np.sqrt(x))
    assert fit.exponent.value == pytest.approx(-0.5)
    assert fit.factor.value == pytest.approx(3.0)
    assert fit.r_squared == pytest.approx(1.0)
    assert fit.exponent.high - fit.exponent.low < 1e-6
    assert fit.at([4.0, 16.0]) == pytest.approx([1.5, 0.75])


def test_three_points_by_hand():
    # Logarithms (0, 0), (1, 2), (2, 1): slope 1/2, intercept 1/2, residuals -1/2, 1, -1/2. So
    # s² = 1.5 with one degree of freedom, whose t at 0.975 is 12.7062.
    fit = fit_power_law(np.exp([0, 1, 2]), np.exp([0, 2, 1]))
    assert fit.exponent.value == pytest.approx(0.5)
    assert fit.exponent.low == pytest.approx(0.5 - 12.7062 * math.sqrt(0.75), abs=1e-4)
    assert fit.exponent.high == pytest.approx(0.5 + 12.7062 * math.sqrt(0.75), abs=1e-4)
    assert fit.factor.value == pytest.approx(math.exp(0.5))
    assert math.log(fit.factor.low) == pytest.approx(0.5 - 12.7062 * math.sqrt(1.25), abs=1e-4)
    assert math.log(fit.factor.high) == pytest.approx(0.5 + 12.7062 * math.sqrt(1.25), abs=1e-4)
    assert fit.r_squared == pytest.approx(0.25)


def test_equal_values_have_exponent_zero():
    fit = fit_power_law([1, 2, 4], [7, 7, 7])
    assert fit.factor.value == fit.factor.low == fit.factor.high == 7.0
    assert fit.exponent.value == fit.exponent.low == fit.exponent.high == 0.0
    assert fit.r_squared == 1.0


@given(
    st.lists(st.tuples(st.integers(1, 8), st.floats(0.1, 100.0)), min_size=3, max_size=12).filter(
        lambda points: len({x for x, _ in points}) > 1 and len({round(y, 3) for _, y in points}) > 1
    ),
    st.floats(0.1, 10.0),
)
def test_units_change_only_the_factor(points, unit):
    x, y = (np.array(side, dtype=float) for side in zip(*points, strict=True))
    fit, scaled = fit_power_law(x, y), fit_power_law(x, unit * y)
    assert scaled.exponent.value == pytest.approx(fit.exponent.value, abs=1e-6)
    assert scaled.factor.value == pytest.approx(unit * fit.factor.value, rel=1e-6)
    assert scaled.r_squared == pytest.approx(fit.r_squared, abs=1e-6)
    assert fit.exponent.low <= fit.exponent.value <= fit.exponent.high
    assert fit.factor.low <= fit.factor.value <= fit.factor.high


def test_intervals_have_their_nominal_coverage():
    rng = np.random.default_rng(1)
    x = np.repeat([1.0, 2.0, 4.0, 8.0], 3)
    exponents = factors = 0
    for _ in range(1000):
        fit = fit_power_law(x, 50.0 * x**-0.7 * rng.lognormal(sigma=0.3, size=x.size), level=0.9)
        exponents += fit.exponent.low <= -0.7 <= fit.exponent.high
        factors += fit.factor.low <= 50.0 <= fit.factor.high
    low, high = stats.binom(1000, 0.9).interval(0.9999)
    assert low <= exponents <= high
    assert low <= factors <= high


@pytest.mark.parametrize(
    ("x", "y", "words"),
    [
        ([1, 2], [1, 2], "three points.*not 2 points at 2"),
        ([2, 2, 2], [1, 2, 3], "not 3 points at 1"),
        ([1, 2, 3], [1, 2], "not 2 for 3"),
        ([0, 1, 2], [1, 2, 3], "x has 0"),
        ([1, 2, 3], [1, 2, -3], "y has -3"),
        ([1, 2, 3], [1, 2, math.inf], "y must be finite"),
    ],
)
def test_bad_input_is_refused(x, y, words):
    with pytest.raises(InvalidInputError, match=words):
        fit_power_law(x, y)
