import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics.curves import common_grid, curve_bands, on_grid

steps = st.lists(st.tuples(st.integers(0, 20), st.floats(0.0, 1.0)), min_size=1, max_size=8).map(
    lambda points: tuple(zip(*sorted(points), strict=True))
)


def lines_of(bands):
    return bands.median, bands.lower_quartile, bands.upper_quartile


class TestOnGrid:
    def test_by_hand(self):
        early = ([0.0, 2.0, 2.0, 4.0], [0.1, 0.3, 0.5, 1.0])
        late = ([1.0, 9.0], [0.2, 0.9])
        table = on_grid([early, late], [0.0, 1.0, 1.9, 2.0, 3.0, 4.0, 10.0])
        # The first ended at 4 and stays there; the second has nothing before 1.
        assert table.tolist() == [
            [0.1, 0.1, 0.1, 0.5, 0.5, 1.0, 1.0],
            [0.0, 0.2, 0.2, 0.2, 0.2, 0.2, 0.9],
        ]

    @given(steps, st.integers(-5, 30))
    def test_a_share_is_that_of_the_last_step(self, curve, time):
        past = [share for at, share in zip(*curve, strict=True) if at <= time]
        assert on_grid([curve], [time]).item() == (past[-1] if past else 0.0)

    def test_common_grid_ends_with_the_last_change(self):
        curves = [([0.0, 4.0], [0.0, 1.0]), ([0.0, 8.0], [0.0, 0.5])]
        assert common_grid(curves, 5).tolist() == [0.0, 2.0, 4.0, 6.0, 8.0]

    @pytest.mark.parametrize(
        ("curves", "words"),
        [
            ([], "at least one curve"),
            ([([], [])], "times of curve 0"),
            ([([0.0], [0.1]), ([0.0, 1.0], [0.1])], "curve 1 must have a share for each time"),
            ([([1.0, 0.0], [0.1, 0.2])], "times of curve 0 must not descend"),
            ([([0.0], [math.inf])], "shares of curve 0 must be finite"),
        ],
    )
    def test_bad_curves_are_refused(self, curves, words):
        for use in (lambda: on_grid(curves, [0.0]), lambda: common_grid(curves)):
            with pytest.raises(InvalidInputError, match=words):
                use()

    def test_bad_grids_are_refused(self):
        with pytest.raises(InvalidInputError, match="no span"):
            common_grid([([0.0], [1.0])])
        with pytest.raises(InvalidInputError, match="at least 2 points"):
            common_grid([([0.0, 1.0], [0.0, 1.0])], 1)
        with pytest.raises(InvalidInputError, match="times must ascend"):
            on_grid([([0.0], [1.0])], [0.0, 0.0])


class TestBands:
    def test_by_hand(self):
        # Runs are complete at 1, 2, 3, 4 and 5.
        curves = [([0.0, end], [0.0, 1.0]) for end in (1.0, 2.0, 3.0, 4.0, 5.0)]
        bands = curve_bands(curves, [0.5, 1.5, 2.5, 3.5, 4.5, 5.5])
        assert bands.times.tolist() == [0.5, 1.5, 2.5, 3.5, 4.5, 5.5]
        assert bands.median.tolist() == [0, 0, 0, 1, 1, 1]
        assert bands.lower_quartile.tolist() == [0, 0, 0, 0, 1, 1]
        assert bands.upper_quartile.tolist() == [0, 0, 1, 1, 1, 1]

    @given(st.lists(steps, min_size=1, max_size=6))
    def test_bands_are_quartiles_at_each_time(self, curves):
        times = np.arange(0.0, 22.0, 3.0)
        bands = curve_bands(curves, times)
        for i, own in enumerate(on_grid(curves, times).T):
            low, middle, high = np.percentile(own, [25, 50, 75])
            assert bands.lower_quartile[i] == pytest.approx(low)
            assert bands.median[i] == pytest.approx(middle)
            assert bands.upper_quartile[i] == pytest.approx(high)

    def test_a_single_run_is_its_own_band(self):
        bands = curve_bands([([0.0, 1.0], [0.2, 0.7])], [0.0, 1.0])
        for line in lines_of(bands):
            assert line.tolist() == [0.2, 0.7]

    def test_bands_of_rising_shares_never_fall(self):
        rng = np.random.default_rng(4)
        curves = [(np.sort(rng.random(30)), np.sort(rng.random(30))) for _ in range(12)]
        bands = curve_bands(curves, common_grid(curves, 40))
        for line in lines_of(bands):
            assert (np.diff(line) >= 0.0).all()
