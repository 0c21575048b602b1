import math
from collections.abc import Iterable

import pytest

from multisrt.experiments.results import Results
from multisrt.presets import multi_srt
from multisrt.presets.judging import (
    Cells,
    Comparison,
    Saying,
    could_be_significant,
    judge,
    verdict,
    weigh,
)
from tests.multisrt.presets.constructed import QUICK_SRT, results_of

SAYINGS: dict[str, Saying] = {"f": "for", "a": "against", "n": "nothing"}


@pytest.mark.parametrize(
    ("sayings", "always", "mostly", "somewhere"),
    [
        ("ffff", "holds", "holds", "holds"),
        ("fffn", "holds", "holds", "holds"),
        ("ffnn", "not significant", "not significant", "holds"),
        ("fffa", "does not hold", "holds", "holds"),
        ("ffaa", "does not hold", "does not hold", "holds"),
        ("nnna", "does not hold", "does not hold", "not significant"),
        ("nnnn", "not significant", "not significant", "not significant"),
        ("aaaa", "does not hold", "does not hold", "does not hold"),
    ],
)
def test_verdict(sayings, always, mostly, somewhere):
    says = [SAYINGS[letter] for letter in sayings]
    assert verdict(says, "always") == always
    assert verdict(says, "mostly") == mostly
    assert verdict(says, "somewhere") == somewhere


def compared(lower: Iterable[float], higher: Iterable[float], paired: bool = False) -> Comparison:
    return Comparison(where="there", lower=tuple(lower), higher=tuple(higher), paired=paired)


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
def test_how_many_runs_are_enough(n, paired, many, enough):
    family = [compared(range(n), range(n), paired)] * many
    assert could_be_significant(family, "always") is enough
    assert could_be_significant(family, "somewhere") is enough


def test_half_of_the_comparisons_is_not_enough():
    there, missing = compared(range(20), range(20)), compared([], [])
    assert not could_be_significant([there, missing], "always")
    assert could_be_significant([there, there, missing], "always")
    assert could_be_significant([there, missing], "somewhere")
    assert not could_be_significant([], "always")


def test_pairs_are_of_one_repetition_also_where_runs_are_missing():
    whole = results_of(QUICK_SRT, lambda at, k: {"known_complete_s": 100.0 * at.robots + k})
    left = [r for r in whole if (r.condition.robots, r.repetition) not in {(1, 0), (1, 5), (2, 3)}]
    cells = Cells(Results(whole.experiment, left, whole.planned, whole.provenance))
    alone, two = (next(at for at in cells.conditions() if at.robots == n) for n in (1, 2))
    pairs = cells.paired("there", lower=alone, higher=two, measure=multi_srt.TIME)
    assert pairs.lower == (101.0, 102.0, 104.0, 106.0, 107.0, 108.0, 109.0)
    assert pairs.higher == (201.0, 202.0, 204.0, 206.0, 207.0, 208.0, 209.0)
    both = cells.unpaired("there", lower=alone, higher=two, measure=multi_srt.TIME)
    assert (len(both.lower), len(both.higher)) == (8, 9)


def test_grounds_give_the_numbers():
    judged = judge(
        "Tortoises are faster.",
        "Zeno",
        [compared([1, 2, 3, 4, 5], [6, 7, 8, 9, 10])],
        scope="always",
        quantity=multi_srt.TIME,
        so="they are faster",
        otherwise="slower",
        sides=("tortoise", "hare"),
    )
    assert judged.claim.verdict == "holds"
    text = "\n".join(judged.claim.grounds)
    assert "in 1 of 1 comparisons, significantly in 1" in text
    assert "Mann-Whitney" in text
    assert "median 3.0 s (tortoise) and 8.0 s (hare), n = 5, p = 0.008, A = 1.00" in text
    assert judged.table.rows == (("there", "3.0", "8.0", "5", "0.008", "1.00", "for"),)
