import math
from collections.abc import Iterable
from dataclasses import replace

import pytest

from multisrt.experiments.results import Results
from multisrt.presets.cells import Cells, Comparison, Family
from multisrt.presets.findings import Saying, weigh, weigh_family
from multisrt.presets.judging import could_be_significant, judge, verdict
from multisrt.presets.multi_srt_claims import KNOWN, TIME
from tests.multisrt.presets.constructed import QUICK_SRT, noise_of, results_of

SAYINGS: dict[str, Saying] = {"f": "for", "a": "against", "n": "nothing"}


@pytest.mark.parametrize(
    ("family", "cells", "always", "mostly", "somewhere"),
    [
        ("f", "ffff", "holds", "holds", "holds"),
        ("f", "nnnn", "holds", "holds", "inconclusive"),
        ("f", "fffa", "does not hold", "holds", "holds"),
        ("n", "ffaa", "does not hold", "inconclusive", "holds"),
        ("n", "nnnn", "inconclusive", "inconclusive", "inconclusive"),
        ("a", "nnnn", "does not hold", "does not hold", "inconclusive"),
        ("a", "nnna", "does not hold", "does not hold", "inconclusive"),
        ("a", "aaaa", "does not hold", "does not hold", "does not hold"),
    ],
)
def test_verdict(family, cells, always, mostly, somewhere):
    says = [SAYINGS[letter] for letter in cells]
    assert verdict(SAYINGS[family], says, "always") == always
    assert verdict(SAYINGS[family], says, "mostly") == mostly
    assert verdict(SAYINGS[family], says, "somewhere") == somewhere


def compared(lower: Iterable[float], higher: Iterable[float], paired: bool = False) -> Comparison:
    return Comparison(
        where="there",
        lower=dict(enumerate(lower)),
        higher=dict(enumerate(higher)),
        paired=paired,
    )


def family_of(*comparisons: Comparison, paired: bool = True) -> Family:
    return Family(comparisons=[*comparisons], quantity=TIME, paired=paired)


def test_p_values_are_adjusted_over_the_comparisons_of_a_claim():
    # Four below four others: 2 of the 70 ways to choose four of eight, two-sided.
    apart = compared([1, 2, 3, 4], [5, 6, 7, 8])
    (alone,) = weigh([apart])
    assert alone.p_value == pytest.approx(2 / 70)
    assert (alone.saying, alone.effect) == ("for", 1.0)
    both = weigh([apart, compared([5, 6, 7, 8], [1, 2, 3, 4])])
    assert [finding.p_value for finding in both] == pytest.approx([4 / 70, 4 / 70])
    assert [finding.saying for finding in both] == ["nothing", "nothing"]
    assert [finding.effect for finding in both] == [1.0, 0.0]


def test_a_comparison_against_the_claim_is_found():
    (finding,) = weigh([compared([5, 6, 7, 8, 9], [0, 1, 2, 3, 4])])
    assert finding.saying == "against"


def test_runs_that_failed_are_worse_than_all_others():
    (finding,) = weigh([compared([1, 2, 3, 4, 5], [math.inf] * 5)])
    assert (finding.saying, finding.effect) == ("for", 1.0)


@pytest.mark.parametrize(
    ("n", "paired", "many", "enough"),
    [
        (5, False, 6, True),  # 6 * 2 / 252 = 0.048
        (5, False, 7, False),
        (6, True, 1, True),  # 2 / 64 = 0.031
        (5, True, 1, False),
        (10, True, 25, True),  # 25 * 2 / 1024 = 0.049
        (10, True, 26, False),
    ],
)
def test_how_many_runs_are_enough_for_one_of_many_cells(n, paired, many, enough):
    family = family_of(*[compared(range(n), range(n), paired)] * many)
    assert could_be_significant(family, "somewhere") is enough


@pytest.mark.parametrize(
    ("n", "paired", "enough"),
    # 2 / 32, 2 / 64; 2 of 20 and of 70 ways to choose half of six and of eight.
    [(5, True, False), (6, True, True), (3, False, False), (4, False, True)],
)
def test_how_many_repetitions_are_enough_for_a_family(n, paired, enough):
    family = family_of(*[compared(range(n), range(n))] * 3, paired=paired)
    assert could_be_significant(family, "always") is enough


def test_half_of_the_comparisons_is_not_enough():
    there, missing = compared(range(20), range(20)), compared([], [])
    assert not could_be_significant(family_of(there, missing), "always")
    assert could_be_significant(family_of(there, there, missing), "always")
    assert could_be_significant(family_of(there, missing), "somewhere")
    assert not could_be_significant(family_of(), "always")
    assert not could_be_significant(family_of(missing), "mostly")


def test_pairs_are_of_one_repetition_also_where_runs_are_missing():
    whole = results_of(QUICK_SRT, lambda at, k: {"known_complete_s": 100.0 * at.robots + k})
    left = [r for r in whole if (r.condition.robots, r.repetition) not in {(1, 0), (1, 5), (2, 3)}]
    cells = Cells(Results(whole.experiment, left, whole.planned, whole.provenance))
    alone, two = (next(at for at in cells.conditions() if at.robots == n) for n in (1, 2))
    found = cells.compared("there", lower=alone, higher=two, measure=KNOWN)
    assert found.repetitions == [1, 2, 4, 6, 7, 8, 9]
    assert found.sides == found.pairs
    assert found.pairs == (
        [101.0, 102.0, 104.0, 106.0, 107.0, 108.0, 109.0],
        [201.0, 202.0, 204.0, 206.0, 207.0, 208.0, 209.0],
    )
    apart = cells.compared("there", lower=alone, higher=two, measure=KNOWN, paired=False)
    assert [len(side) for side in apart.sides] == [8, 9]


def small_gains(cells: int, pairs: int) -> list[Comparison]:
    """Return cells in which the first set is lower by a tenth, in noise of four tenths."""

    def value(cell: int, repetition: int, side: str) -> float:
        return 100.0 * (1.0 + 0.4 * noise_of(QUICK_AT, 100 * cell + repetition, side))

    return [
        compared(
            [0.9 * value(cell, k, "lower") for k in range(pairs)],
            [value(cell, k, "higher") for k in range(pairs)],
        )
        for cell in range(cells)
    ]


QUICK_AT = Cells(results_of(QUICK_SRT, lambda at, k: {})).conditions()[0]


def judged_gains(*comparisons: Comparison, scope="always", beside=None):
    return judge(
        "Tortoises are faster.",
        "Zeno",
        family_of(*comparisons),
        scope=scope,
        so="they are faster",
        otherwise="slower",
        sides=("tortoise", "hare"),
        beside=beside,
    )


def test_a_family_holds_where_no_cell_is_significant():
    cells = small_gains(12, 8)
    assert {finding.saying for finding in weigh(cells)} == {"nothing"}
    claim = judged_gains(*cells).claim
    assert (claim.verdict, claim.told) == ("holds", "holds")
    # What would have been found is named whatever the verdict.
    assert claim.would_show.endswith("% would have been detected")
    assert "all 12 cells together, by 8 paired repetitions: tortoise -" in claim.grounds[0]


def test_the_order_of_cells_and_repetitions_is_irrelevant():
    cells = small_gains(4, 8)
    turned = [
        Comparison(
            where=cell.where,
            lower={k: cell.lower[k] for k in reversed(cell.repetitions)},
            higher=cell.higher,
        )
        for cell in reversed(cells)
    ]
    assert weigh_family(family_of(*turned)) == weigh_family(family_of(*cells))


def test_what_is_not_significant_comes_with_what_would_have_shown():
    few = judged_gains(*small_gains(2, 8)).claim
    assert few.verdict == "inconclusive"
    assert few.would_show.endswith("% would have been detected")
    assert few.told == f"inconclusive ({few.would_show})"
    assert any(ground.startswith("detectable difference: ") for ground in few.grounds)
    many = judged_gains(*small_gains(4, 8)).claim
    one = judged_gains(*small_gains(2, 8), scope="somewhere").claim
    assert one.would_show.endswith("% would have been detected in one cell")

    def percent(claim):
        return float(claim.would_show.split()[3])

    assert percent(many) < percent(few) < percent(one)


def test_runs_that_show_nothing_say_so():
    # Of nothing there is no share; of values without spread any share would show.
    equal = judged_gains(*[compared([0.0] * 8, [0.0] * 8)] * 2).claim
    assert equal.verdict == "inconclusive"
    assert equal.would_show == "no difference would have been detected in these runs"
    equal = judged_gains(*[compared([5.0] * 8, [5.0] * 8)] * 2).claim
    assert equal.would_show == "a difference of 0.0 % would have been detected"


def test_another_quantity_is_judged_beside():
    lower, higher = [1, 2, 3, 4, 5, 6], [6, 7, 8, 9, 10, 12]
    slower = Family(comparisons=[compared(higher, lower)], quantity=KNOWN)
    claim = judged_gains(compared(lower, higher), beside=slower).claim
    assert claim.verdict == "holds"
    (line,) = [ground for ground in claim.grounds if KNOWN.title in ground]
    assert "does not hold" in line
    assert claim.other_verdicts == ((KNOWN.heading, "does not hold"),)


def test_parts_of_a_family_are_tested_by_themselves():
    lower, higher = [1, 2, 3, 4, 5, 6], [6, 7, 8, 9, 10, 12]
    clear, opposite = compared(lower, higher), compared(higher, lower)
    whole = replace(family_of(clear, opposite), parts={"pairs": family_of(clear)})
    judged = judge(
        "Tortoises are faster.",
        "Zeno",
        whole,
        scope="mostly",
        so="",
        otherwise="",
        sides=("a", "b"),
    )
    first, *parts = judged.claim.grounds[0].split("\n  - ")
    assert judged.claim.verdict == "inconclusive"
    assert first.startswith("both cells together, by 6 paired")
    assert len(parts) == 1
    assert judged.claim.other_verdicts == (("pairs", "holds"),)
    assert parts[0].startswith("pairs: the one cell, by 6 paired repetitions: a -")


def test_grounds_give_the_numbers():
    judged = judged_gains(compared([1, 2, 3, 4, 5, 6], [11, 12, 13, 14, 15, 16]))
    assert judged.claim.verdict == "holds"
    text = "\n".join(judged.claim.grounds)
    assert "the one cell, by 6 paired repetitions: tortoise -" in text
    assert "against hare, p = 0.031" in text
    assert "by medians" not in text  # of one cell
    assert "Mann-Whitney" in text
    # 2 of the 924 ways to choose six of twelve.
    assert "median 3.5 s (tortoise) and 13.5 s (hare), n = 6, p = 0.002, A = 1.00" in text
    assert judged.table.rows == (
        ("in pairs", "", "", "6 repetitions", "0.031", "", "for"),
        ("there", "3.5", "13.5", "6", "0.002", "1.00", "for"),
    )


def test_differences_in_single_cells_are_told_beside_that_of_the_family():
    halves = compared([1, 2, 3, 4, 5, 6], [2, 4, 6, 8, 10, 12])
    equal = compared([2, 3, 4, 5, 6, 7], [2, 3, 4, 5, 6, 7])
    lost = compared([1, 2, 3, 4, 5, 6], [math.inf] * 6)
    found = judged_gains(halves, equal, lost).claim.grounds
    assert any(
        line == "by cell: tortoise -50.0 to +0.0 % against hare by medians, -25.0 % in the median "
        "cell; without 1 in which there is no ratio"
        for line in found
    ), found
    assert any(
        line == "by medians they are faster in 2 of 3 cells and nothing changes in 1, "
        "significantly by itself in 1; slower significantly in 0"
        for line in found
    ), found
    assert not any("by cell:" in line for line in judged_gains(halves).claim.grounds)
