import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.statistics import families
from multisrt.statistics.families import paired_family, unpaired_family
from multisrt.statistics.rank_tests import holm, paired, unpaired

INF = math.inf

coarse = st.integers(0, 9).map(lambda value: INF if value == 9 else float(value))
pair = st.tuples(coarse, coarse)


@st.composite
def paired_cells(draw, max_pairs=6):
    """Draw values of a, values of b and repetitions of one to three cells."""
    cells = []
    for _ in range(draw(st.integers(1, 3))):
        numbers = draw(
            st.lists(st.integers(0, max_pairs - 1), min_size=1, max_size=max_pairs, unique=True)
        )
        a, b = zip(*(draw(pair) for _ in numbers), strict=True)
        cells.append((list(a), list(b), numbers))
    return tuple(list(part) for part in zip(*cells, strict=True))


def signed_ranks(a, b):
    """Return Wilcoxon's signed ranks by definition, 0 for equal pairs."""
    d = [0.0 if x == y else y - x for x, y in zip(a, b, strict=True)]
    sizes = [abs(x) for x in d if x]
    return [
        math.copysign(
            0.5 + sum(s < abs(x) for s in sizes) + 0.5 * sum(s == abs(x) for s in sizes), x
        )
        if x
        else 0.0
        for x in d
    ]


def p_of_all_sums(sums, seen):
    low = sum(s <= seen + 1e-9 for s in sums) / len(sums)
    high = sum(s >= seen - 1e-9 for s in sums) / len(sums)
    return min(1.0, 2.0 * min(low, high))


def p_of_all_swaps(a, b, repetitions):
    """Return the p-value by swapping a and b in all subsets of the repetitions."""
    numbers = sorted({number for cell in repetitions for number in cell})
    sums = []
    for swapped in itertools.product([False, True], repeat=len(numbers)):
        swap = dict(zip(numbers, swapped, strict=True))
        total = 0.0
        for of_a, of_b, of in zip(a, b, repetitions, strict=True):
            pairs = [
                (y, x) if swap[number] else (x, y)
                for x, y, number in zip(of_a, of_b, of, strict=True)
            ]
            total += sum(signed_ranks(*zip(*pairs, strict=True)))
        sums.append(total)
    return p_of_all_sums(sums, sums[0])


def ranks_of(pool):
    """Return mean ranks by definition."""
    return [0.5 + sum(y < x for y in pool) + 0.5 * sum(y == x for y in pool) for x in pool]


def p_of_all_choices(a, b):
    """Return the p-value of van Elteren's statistic by all assignments within the cells."""
    by_cell = []
    for of_a, of_b in zip(a, b, strict=True):
        pool = [*of_a, *of_b]
        ranks = ranks_of(pool)
        by_cell.append(
            [
                sum(ranks[i] for i in chosen) / (len(pool) + 1)
                for chosen in itertools.combinations(range(len(pool)), len(of_a))
            ]
        )
    # The first combination is the observed one.
    sums = [sum(parts) for parts in itertools.product(*by_cell)]
    return p_of_all_sums(sums, sums[0])


class TestPaired:
    def test_two_cells_by_hand(self):
        # Signed ranks 1, 2, 3 and 1, -2, 3 by repetition: sums 2, 0, 6. Of the four sign vectors
        # of 2 and 6 one is as large.
        found = paired_family([[0, 0, 0], [0, 2, 0]], [[1, 2, 3], [1, 0, 3]])
        assert found.p_value == 0.5
        assert found.a_lower == pytest.approx(10 / 12)

    @given(paired_cells())
    @settings(max_examples=60, deadline=None)
    def test_p_values_are_those_of_all_swaps(self, cells):
        a, b, repetitions = cells
        found = paired_family(a, b, repetitions=repetitions)
        assert found.p_value == pytest.approx(p_of_all_swaps(a, b, repetitions), abs=1e-12)

    @given(st.lists(pair, min_size=1, max_size=12))
    def test_of_one_cell_it_is_wilcoxons_test(self, pairs):
        a, b = zip(*pairs, strict=True)
        family, single = paired_family([a], [b]), paired(a, b)
        assert family.p_value == pytest.approx(single.p_value, abs=1e-12)
        assert family.a_lower == pytest.approx(single.a_lower)

    def test_of_many_pairs_it_is_scipys_approximation(self):
        rng = np.random.default_rng(1)
        a = rng.normal(size=80)
        b = a + rng.normal(0.3, 1.0, 80)
        assert paired_family([a], [b]).p_value == pytest.approx(paired(a, b).p_value, rel=1e-9)

    @given(paired_cells(), st.randoms(use_true_random=False))
    def test_order_is_irrelevant_and_sides_mirror(self, cells, random):
        a, b, repetitions = cells
        found = paired_family(a, b, repetitions=repetitions)
        mirrored = paired_family(b, a, repetitions=repetitions)
        assert mirrored.p_value == pytest.approx(found.p_value, abs=1e-12)
        assert mirrored.a_lower == pytest.approx(1.0 - found.a_lower)
        mixed = []
        for of_a, of_b, of in zip(a, b, repetitions, strict=True):
            rows = list(zip(of_a, of_b, of, strict=True))
            random.shuffle(rows)
            mixed.append(tuple(list(column) for column in zip(*rows, strict=True)))
        random.shuffle(mixed)
        a, b, repetitions = (list(part) for part in zip(*mixed, strict=True))
        assert paired_family(a, b, repetitions=repetitions) == found

    @given(paired_cells(), st.lists(st.floats(0.1, 1000.0), min_size=3, max_size=3))
    def test_the_scale_of_a_cell_is_irrelevant(self, cells, scales):
        a, b, repetitions = cells
        # Powers of two: products are exact.
        scales = [2.0 ** round(math.log2(scale)) for scale in scales]
        of_a, of_b = (
            [[scale * x for x in cell] for cell, scale in zip(side, scales, strict=False)]
            for side in (a, b)
        )
        found = paired_family(of_a, of_b, repetitions=repetitions)
        assert found == paired_family(a, b, repetitions=repetitions)

    @pytest.mark.slow
    def test_a_family_finds_what_no_cell_finds(self):
        # The same small gain in twelve cells with ten repetitions each, a hundred times.
        rng = np.random.default_rng(7)
        by_family, by_cells = 0, 0
        for _ in range(100):
            b = rng.uniform(50.0, 150.0, (12, 10))
            a = 0.85 * b * np.exp(rng.normal(0.0, 0.35, (12, 10)))
            cells = holm([paired(x, y).p_value for x, y in zip(a, b, strict=True)])
            by_cells += int(np.count_nonzero(cells < 0.05) > 6)
            by_family += int(paired_family(list(a), list(b)).p_value < 0.05)
        assert by_cells == 0
        assert by_family > 90

    def test_cells_that_share_all_chance_are_no_more_evidence_than_one(self):
        rng = np.random.default_rng(8)
        a, b = rng.normal(size=(2, 10))
        assert paired_family([a] * 12, [b] * 12).p_value == paired(a, b).p_value

    @pytest.mark.slow
    @pytest.mark.parametrize("shared", [0.0, 0.9])
    def test_false_positives_are_at_most_five_percent(self, shared):
        # With cells that are independent, and with cells that share most of their chance.
        rng = np.random.default_rng(9)
        found = 0
        for _ in range(1000):
            common = rng.normal(size=10)
            d = shared * common + math.sqrt(1.0 - shared**2) * rng.standard_t(2, (6, 10))
            found += paired_family([np.zeros(10)] * 6, list(d)).p_value < 0.05
        # Three standard deviations: 3 sqrt(0.05 * 0.95 / 1000) = 0.021.
        assert 0.03 < found / 1000 < 0.071

    def test_repetitions_without_difference_are_no_evidence(self):
        same = paired_family([[1.0, INF], [2.0, 3.0]], [[1.0, INF], [2.0, 3.0]])
        assert (same.p_value, same.a_lower) == (1.0, 0.5)

    @pytest.mark.parametrize(
        ("repetitions", "message"),
        [
            ([[0, 1]], "cell 1 has 2 values"),
            ([[0, 1], [0]], "cell 1 has 2 values"),
            ([[0, 0], [0, 1]], "cell 0 has 2 values"),
        ],
    )
    def test_wrong_repetitions_are_refused(self, repetitions, message):
        values = [[1.0, 2.0], [3.0, 4.0]]
        with pytest.raises(InvalidInputError, match=message):
            paired_family(values, values, repetitions=repetitions)

    def test_wrong_cells_are_refused(self):
        with pytest.raises(InvalidInputError, match="cell 0 of a paired family"):
            paired_family([[1.0, 2.0]], [[1.0]])
        with pytest.raises(InvalidInputError, match="a has 1 and b has 2"):
            paired_family([[1.0]], [[1.0], [2.0]])
        with pytest.raises(InvalidInputError, match="nan"):
            paired_family([[math.nan]], [[1.0]])
        for ratio in (0.0, -1.0, INF, math.nan):
            with pytest.raises(InvalidInputError, match="ratio must be positive"):
                paired_family([[1.0]], [[1.0]], ratio=ratio)
        with pytest.raises(InvalidInputError, match="at least 0, not -1"):
            paired_family([[-1.0]], [[1.0]], ratio=2.0)


small = st.lists(coarse, min_size=1, max_size=3)
strata = st.lists(st.tuples(small, small), min_size=1, max_size=3)


class TestUnpaired:
    def test_migraine_trial_of_the_sas_manual(self, monkeypatch):
        # SAS/STAT User's Guide, PROC FREQ, "Cochran-Mantel-Haenszel statistics": better or same,
        # by sex: 16, 11 and 5, 20 of the women, 12, 16 and 7, 19 of the men; CMH 8.3052,
        # p 0.0040. Of two outcomes van Elteren's statistic is this one but for the weights
        # N / (N + 1) of the strata, 52 / 53 and 54 / 55. Its p-value is the normal approximation.
        monkeypatch.setattr(families, "MAX_EXACT", 50)

        def side(better, same):
            return [0.0] * better + [1.0] * same

        found = unpaired_family([side(16, 11), side(12, 16)], [side(5, 20), side(7, 19)])
        assert found.p_value == pytest.approx(0.0040, abs=0.00005)

    @given(strata)
    @settings(max_examples=60, deadline=None)
    def test_p_values_are_those_of_all_choices(self, cells):
        a, b = zip(*cells, strict=True)
        found = unpaired_family(a, b)
        assert found.p_value == pytest.approx(p_of_all_choices(a, b), abs=1e-9)

    @given(st.lists(st.lists(coarse, min_size=5, max_size=5), min_size=1, max_size=3))
    @settings(max_examples=60, deadline=None)
    def test_shared_repetitions_are_exchanged_as_a_whole(self, cells):
        # Two repetitions of a, three of b, in all cells.
        a, b = [cell[:2] for cell in cells], [cell[2:] for cell in cells]
        numbers = ([[0, 1]] * len(cells), [[0, 1, 2]] * len(cells))
        found = unpaired_family(a, b, repetitions=numbers)
        sums = [sum(ranks_of(cell)[i] for cell in cells) for i in range(5)]
        chosen = [sum(pair) for pair in itertools.combinations(sums, 2)]
        assert found.p_value == pytest.approx(p_of_all_sums(chosen, chosen[0]), abs=1e-9)

    def test_repetitions_are_exchanged_with_those_of_the_same_cells(self):
        # Repetitions 0 and 1 of each side are in both cells: of the 6 choices of two of these four
        # one is as extreme. Repetition 2 is in the first cell only: one of 2.
        a, b = [[1.0, 2.0, 3.0], [1.0, 2.0]], [[4.0, 5.0, 6.0], [3.0, 4.0]]
        numbers = ([[0, 1, 2], [0, 1]],) * 2
        assert unpaired_family(a, b, repetitions=numbers).p_value == pytest.approx(2 / 12)

    @given(st.lists(coarse, min_size=1, max_size=6), st.lists(coarse, min_size=1, max_size=6))
    def test_of_one_cell_it_is_mann_and_whitneys_test(self, a, b):
        family, single = unpaired_family([a], [b]), unpaired(a, b)
        assert family.p_value == pytest.approx(single.p_value, abs=1e-12)
        assert family.a_lower == pytest.approx(single.a_lower)

    def test_exact_and_approximate_agree(self, monkeypatch):
        rng = np.random.default_rng(3)
        a = [rng.integers(0, 12, n).astype(float) for n in (12, 15, 9)]
        b = [rng.integers(2, 14, n).astype(float) for n in (10, 15, 14)]
        exact = unpaired_family(a, b)
        monkeypatch.setattr("multisrt.statistics.families.MAX_SUMS", 0)
        assert unpaired_family(a, b).p_value == pytest.approx(exact.p_value, rel=0.1)
        assert exact.p_value < 0.05

    @given(strata, st.randoms(use_true_random=False))
    def test_order_is_irrelevant_and_sides_mirror(self, cells, random):
        a, b = zip(*cells, strict=True)
        found, mirrored = unpaired_family(a, b), unpaired_family(b, a)
        assert mirrored.p_value == pytest.approx(found.p_value, abs=1e-9)
        assert mirrored.a_lower == pytest.approx(1.0 - found.a_lower)
        random.shuffle(cells)
        a, b = zip(*cells, strict=True)
        mixed = unpaired_family(a, b)
        assert (mixed.p_value, mixed.a_lower) == pytest.approx((found.p_value, found.a_lower))

    def test_cells_of_many_sizes_have_rounded_weights(self):
        # The common multiple of these sizes is beyond any integer of an array.
        rng = np.random.default_rng(4)
        sizes = range(30, 75)
        a, b = ([rng.normal(shift, 1.0, n) for n in sizes] for shift in (0.0, 0.1))
        assert unpaired_family(a, b).p_value < 0.05 < unpaired_family(a, a).p_value

    def test_values_that_are_all_equal_show_nothing(self):
        equal = [[INF] * 60, [2.0] * 60]
        assert unpaired_family(equal, equal).p_value == 1.0
        few = [[INF] * 3, [2.0] * 3]
        assert unpaired_family(few, few).p_value == 1.0

    @pytest.mark.slow
    def test_false_positives_are_at_most_five_percent(self):
        rng = np.random.default_rng(10)
        found = sum(
            unpaired_family(
                list(rng.standard_t(2, (4, 6))), list(rng.standard_t(2, (4, 8)))
            ).p_value
            < 0.05
            for _ in range(1000)
        )
        assert 0.03 < found / 1000 < 0.071
