from collections import Counter

import msgspec
import pytest

from multisrt.presets import sbx_r
from multisrt.presets.cells import Cells
from multisrt.presets.sbx_r_claims import ALL, CLAIMS
from multisrt.presets.sbx_r_settings import diagram_table
from multisrt.presets.sbx_r_tables import PAPER
from tests.multisrt.presets.constructed import bidding, claim_on, no_results, results_of

FULL_SBX = sbx_r.experiment(False)


def test_figures_of_sbx_r_are_the_printed_ones():
    one, two, three, four, five = PAPER
    # Table I, Stachniss, 15 m, 3 robots; SBX-R, 20 m, 5 robots.
    assert (one.median("utility", 15, 3), one.mark("utility", 15, 3)) == ("503.10", "+")
    assert one.median("self-bidding", 20, 5) == "3.45"
    # Table II, Yamauchi, 20 m, 3 robots.
    assert (two.median("closest", 20, 3), two.mark("closest", 20, 3)) == ("145.55", "+")
    # Table III, Yamauchi, 15 m, 3 robots, and the misprint of Stachniss.
    assert three.median("closest", 15, 3) == "26.997"
    assert three.median("utility", 15, 3) == "2.881"
    # Table IV, Yamauchi, 15 m, 2 robots; SBX-R, 30 m, 5 robots.
    assert (four.median("closest", 15, 2), four.mark("closest", 15, 2)) == ("668", "-")
    assert four.median("self-bidding", 30, 5) == "363.4"
    # Table V, Stachniss, 15 m, 5 robots; 30 m, 2 robots.
    assert (five.median("utility", 15, 5), five.mark("utility", 15, 5)) == ("487.20", "-")
    assert (five.median("utility", 30, 2), five.mark("utility", 30, 2)) == ("419.30", "")


# As its text counts them (section IV). It has Table III as 12 of 13, where the table marks 11; and
# says of Table I that most are better and none is worse.
@pytest.mark.parametrize(
    ("number", "other", "better", "worse"),
    [
        ("I", "closest", 8, 0),
        ("I", "utility", 9, 0),
        ("II", "closest", 11, 0),
        ("II", "utility", 11, 0),
        ("III", "closest", 11, 0),
        ("III", "utility", 11, 0),
        ("IV", "closest", 6, 1),
        ("IV", "utility", 7, 1),
        ("V", "closest", 6, 1),
        ("V", "utility", 2, 5),
    ],
)
def test_marks_of_sbx_r_agree_with_the_counts_in_its_text(number, other, better, worse):
    (table,) = [table for table in PAPER if table.number == number]
    signs = Counter(table.mark(*cell) for cell in ALL[other])
    assert (signs["+"], signs["-"], sum(signs.values())) == (better, worse, 12)


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.text)
def test_the_marks_of_sbx_r_bear_its_own_claims_out(claim):
    sign = "+" if claim.better else "-"
    marks = Counter(claim.table.mark(*cell) for cell in claim.cells)
    assert 2 * marks[sign] > len(claim.cells)
    assert set(marks) <= {sign, ""}


def test_claims_of_sbx_r_that_hold_and_do_not():
    better = sbx_r.claims(results_of(FULL_SBX, bidding(lambda at: 0.5)))
    worse = sbx_r.claims(results_of(FULL_SBX, bidding(lambda at: 2.0)))
    assert len(better) == len(worse) == len(CLAIMS) == 12
    for claimed, up, down in zip(CLAIMS, better, worse, strict=True):
        held, not_held = (up, down) if claimed.better else (down, up)
        assert (held.verdict, not_held.verdict) == ("holds", "does not hold"), claimed.text


def test_claims_of_sbx_r_that_may_be_chance_or_are_not_tested():
    same = sbx_r.claims(results_of(FULL_SBX, bidding()))
    assert {claim.verdict for claim in same} == {"not significant"}
    few = sbx_r.claims(results_of(msgspec.structs.replace(FULL_SBX, repetitions=3), bidding()))
    assert {claim.verdict for claim in few} == {"not tested"}
    assert {claim.verdict for claim in sbx_r.claims(no_results(FULL_SBX))} == {"not tested"}


def test_a_quick_sbx_r_omits_cells_without_teams():
    found = sbx_r.claims(results_of(sbx_r.experiment(True), bidding(lambda at: 0.5)))
    assert claim_on(found, "isolated for less time than with closest").verdict == "holds"
    assert claim_on(found, "Two robots").verdict == "not tested"
    assert "no runs that the claim refers to" in claim_on(found, "Two robots").grounds[0]


def test_marks_beside_those_of_the_paper():
    # As good as half with 15 m, twice as bad with 30 m, the same with 20 m.
    results = results_of(
        FULL_SBX, bidding(lambda at: {"15 m": 0.5, "30 m": 2.0}.get(at.radio, 1.0))
    )
    cells = Cells(results)
    table = PAPER[4]
    found = sbx_r.marks(cells, table)
    assert {cell: mark for cell, mark in found.items() if cell[1] == 15 and mark != "+"} == {}
    assert {cell: mark for cell, mark in found.items() if cell[1] == 20 and mark} == {}
    assert {cell: mark for cell, mark in found.items() if cell[1] == 30 and mark != "-"} == {}
    beside = sbx_r.beside(cells, table)
    assert beside.rows[0][:2] == ("closest", "15 m")
    assert [field[-1] for field in beside.rows[0][2:]] == ["+"] * 4
    assert beside.rows[1] == (
        *("paper: Yamauchi", "15 m"),
        *("445.03", "534.86", "642.52 +", "544.81"),
    )
    # Against closest, Table V has . . + . / - . + + / . + + + for 15, 20 and 30 m.
    agreement = {row[0]: row[1:] for row in sbx_r.agreement(cells).rows}
    assert agreement["Table V, against closest"] == ("12", "2", "4", "3", "3")


def test_too_few_runs_have_no_marks():
    few = results_of(msgspec.structs.replace(FULL_SBX, repetitions=3), bidding(lambda at: 0.1))
    assert set(sbx_r.marks(Cells(few), PAPER[0]).values()) == {""}


def test_the_nearness_diagram_is_left_so_often_in_100_m():
    def values(at, repetition):
        left = {"no progress": 2, "no command": 1} if at.strategy == "utility" else {}
        return {"diagram_left": left, "total_distance_m": 50.0}

    table = diagram_table(
        Cells(results_of(msgspec.structs.replace(FULL_SBX, repetitions=2), values))
    )
    assert table.columns == ("strategy", "no progress", "no command", "near the goal")
    assert table.rows == (
        ("closest", "0.0", "0.0", "0.0"),
        ("utility", "4.0", "2.0", "0.0"),
        ("self-bidding", "0.0", "0.0", "0.0"),
    )
