import math

import msgspec
import pytest

from multisrt.experiments.crossing import Condition
from multisrt.experiments.results import Results
from multisrt.presets import minpos
from multisrt.presets.minpos_ablations import (
    ABLATIONS,
    APART,
    ARRIVAL,
    SCANS,
    SCANS_ARRIVAL,
    TARGETS,
    WIDE,
)
from multisrt.presets.minpos_claims import LARGEST_GAINS, MEAN_GAINS
from multisrt.presets.minpos_experiment import RULES, STEP_S, experiment
from multisrt.presets.minpos_gains import (
    Ratios,
    Times,
    complete,
    gain,
    largest,
    reaches,
    rule,
)
from multisrt.statistics.intervals import Interval
from tests.multisrt.presets.constructed import (
    claim_on,
    no_results,
    noise_of,
    results_of,
    times,
)

FULL_MINPOS = experiment(False)
QUICK_AT = Condition(environment="maze", strategy="", robots=2)


def test_figures_of_minpos_are_the_printed_ones():
    # Section V A: "improvements of 8% and 12%", "15% on the hospital and 20% on the maze".
    assert MEAN_GAINS == {"greedy": 8.0, "minpos": 12.0}
    assert LARGEST_GAINS == {"hospital": 15.0, "maze": 20.0}


def gain_of(ratios: Ratios) -> Interval:
    found = gain([ratios])
    assert found is not None
    return found


def test_gains_are_those_of_the_constructed_times():
    of = Times(results_of(FULL_MINPOS, times(10.0, 20.0, spread=0.0)))
    for strategy, percent in (("greedy", 10.0), ("minpos", 20.0)):
        found = gain_of(of.ratios("maze", 4, strategy, "closest"))
        assert [found.value, found.low, found.high] == pytest.approx([percent] * 3)
    # 0.8 over 0.9 of the time.
    over = gain_of(of.ratios("hospital", 12, "minpos", "greedy"))
    assert over.value == pytest.approx(100.0 / 9.0)


def test_claims_of_minpos_that_hold():
    def growing(at: Condition) -> float:
        return (40.0 if at.environment == "maze" else 24.0) * at.robots / 12.0

    found = minpos.claims(
        results_of(FULL_MINPOS, times(lambda at: 0.8 * growing(at), growing, spread=0.005))
    )
    assert {claim.text: claim.verdict for claim in found} == dict.fromkeys(
        (claim.text for claim in found), "holds"
    )
    assert len(found) == 9
    assert "is that of minpos with 12 robots" in claim_on(found, "In the maze").grounds[1]


def test_claims_of_minpos_that_do_not_hold():
    def falling(at: Condition) -> float:
        return (-20.0 if at.environment == "maze" else -8.0) * at.robots / 12.0

    found = minpos.claims(results_of(FULL_MINPOS, times(0.0, falling)))
    for words in (
        *("minpos is faster than closest", "On average minpos shortens"),
        *("slightly faster", "larger the team", "In the maze", "In the hospital"),
        "more on greedy in mazes",
    ):
        assert claim_on(found, words).verdict == "does not hold", words
    # No better than closest: less than 8 %, and no better at all.
    assert claim_on(found, "On average greedy").verdict == "does not hold"
    assert claim_on(found, "greedy is faster than closest").verdict == "inconclusive"


def test_claims_of_minpos_that_may_be_chance_or_are_not_tested():
    wide = minpos.claims(results_of(experiment(True), times(5.0, 5.0, spread=0.9)))
    assert claim_on(wide, "On average minpos shortens").verdict == "inconclusive"
    assert claim_on(wide, "slightly faster").verdict == "inconclusive"
    assert claim_on(wide, "minpos is faster than closest").verdict == "inconclusive"
    few = msgspec.structs.replace(FULL_MINPOS, repetitions=5)
    for results in (no_results(FULL_MINPOS), results_of(few, times(10.0, 20.0))):
        by_text = {claim.text: claim.verdict for claim in minpos.claims(results)}
        # Ratios in two worlds are no pairs: five of each can differ.
        by_text.pop("Minpos gains more on greedy in mazes than in the hospital.")
        assert set(by_text.values()) == {"not tested"}


def test_pairs_of_which_one_failed_are_left_out_of_gains():
    def values(at: Condition, repetition: int) -> dict[str, object] | None:
        lost = repetition < 3 and at.strategy == "minpos"
        return None if lost else times(10.0, 20.0, spread=0.0)(at, repetition)

    of = Times(results_of(FULL_MINPOS, values))
    ratios = of.ratios("maze", 4, "minpos", "closest")
    assert [k for k in ratios if ratios[k] == math.inf] == [0, 1, 2]
    assert len(complete(ratios)) == 37
    assert gain_of(ratios).value == pytest.approx(20.0)
    # The test counts them as lost.
    lower = of.compared("maze", 4, "minpos", "closest").lower
    assert [k for k in lower if math.isinf(lower[k])] == [0, 1, 2]
    table = minpos.gains(of)
    assert table.rows[0][-1] == "40/37"
    assert table.rows[-3] == ("paper: mean", "", "+8.0", "+12.0", "")
    assert table.rows[-4] == ("mean of all, by ratios of mean times", "", "+10.0", "+20.0", "")


def test_repetitions_are_drawn_in_all_conditions_together():
    # Twelve conditions that share their chance are no more evidence than one.
    ratios = {k: 0.1 * noise_of(QUICK_AT, k, "world") for k in range(20)}
    alone, many = gain([ratios]), gain([ratios] * 12)
    assert alone is not None
    assert many is not None
    assert [many.low, many.high] == pytest.approx([alone.low, alone.high])


@pytest.mark.parametrize(
    ("low", "high", "decision"),
    [
        (1.0, 9.0, "holds"),
        (9.0, 12.0, "holds"),
        (-1.0, 9.0, "inconclusive"),
        (1.0, 7.0, "does not hold"),
        (-9.0, -1.0, "does not hold"),
    ],
)
def test_when_a_gain_reaches_eight_percent(low, high, decision):
    found = Interval(value=0.5 * (low + high), low=low, high=high)
    assert reaches(found, 8.0) == decision
    assert "above 0 and not smaller than 8 %" in rule(8.0)


@pytest.mark.parametrize(
    ("other", "decision"),
    [
        # The largest estimate is the least certain one.
        (Interval(18.0, -2.0, 38.0), "holds"),
        (Interval(18.0, 17.0, 19.0), "does not hold"),
        (Interval(18.0, 17.0, 20.0), "holds"),
    ],
)
def test_the_largest_gain_is_between_the_largest_bounds(other, decision):
    found = largest({"few": Interval(15.0, 12.0, 18.0), "many": other})
    assert found.gain == Interval(18.0, max(12.0, other.low), max(18.0, other.high))
    assert (found.at, found.high_at) == ("many", "many")
    assert found.low_at == ("few" if other.low < 12.0 else "many")
    assert reaches(found.gain, 20.0) == decision


def test_an_uncertain_largest_gain_does_not_hide_a_certain_one():
    # In the largest team minpos gains most, in runs that spread so much that no gain is shown.
    def values(at: Condition, repetition: int) -> dict[str, object]:
        wild = at.robots == 12 and at.strategy == "minpos"
        return times(10.0, 30.0 if wild else 18.0, spread=0.6 if wild else 0.02)(at, repetition)

    claim = claim_on(minpos.claims(results_of(FULL_MINPOS, values)), "In the maze")
    assert "largest estimate is that of minpos with 12 robots" in claim.grounds[1]
    assert "largest lower bound that of minpos with 12" not in claim.grounds[1]
    assert "largest upper bound that of minpos with 12" in claim.grounds[1]
    assert claim.verdict == "holds"
    # A condition without runs may be the one with the largest gain.
    lacking = results_of(FULL_MINPOS, lambda at, k: values(at, k))
    few = [run for run in lacking if run.condition.robots != 8 or run.repetition < 5]
    part = Results(FULL_MINPOS, few, planned=len(lacking), provenance=lacking.provenance)
    assert claim_on(minpos.claims(part), "In the maze").verdict == "not tested"


def test_slopes_are_those_of_all_teams():
    # With each doubling of the team a tenth less time; and a run that failed with 12 robots.
    def values(at: Condition, repetition: int) -> dict[str, object] | None:
        if (at.robots, at.strategy, repetition) == (12, "minpos", 3):
            return None
        percent = 100.0 * (1.0 - 0.9 ** math.log2(at.robots))
        return times(0.0, percent, spread=0.0)(at, repetition)

    slopes = Times(results_of(FULL_MINPOS, values)).slopes("maze", "minpos", "closest")
    assert slopes.pop(3) == math.inf
    assert len(slopes) == 39
    assert {round(slope, 9) for slope in slopes.values()} == {round(math.log(0.9), 9)}
    claim = claim_on(minpos.claims(results_of(FULL_MINPOS, values)), "larger the team")
    assert claim.verdict == "holds"
    # Of minpos alone: greedy has no gain in any team.
    assert "in 2 of 4 cells and nothing changes in 2" in claim.grounds[1]


def test_time_that_robots_stood_still_is_a_share_of_their_time():
    def values(at: Condition, repetition: int) -> dict[str, object]:
        return {"makespan_s": 100.0, "waiting_time_s": 25.0 if at.strategy == "closest" else 0.0}

    table = minpos.waits(Times(results_of(FULL_MINPOS, values)))
    # Two robots in 100 s: 200 s.
    assert table.rows[0] == ("maze", "2", "12.5", "0.0", "0.0")
    assert minpos.waits(Times(no_results(FULL_MINPOS))).rows[0][2:] == ("-", "-", "-")


def test_ratios_of_mean_times_weigh_long_runs_more():
    # Half of the runs take ten times as long, and only these are sooner done with minpos.
    def values(at: Condition, repetition: int) -> dict[str, object]:
        long = repetition % 2 == 0
        ours = 0.8 if long and at.strategy == "minpos" else 1.0
        return {"known_complete_s": ours * (1000.0 if long else 100.0), "time_to_99_s": 1.0}

    of = Times(results_of(FULL_MINPOS, values))
    found = of.gain_of_means("minpos", "closest")
    # 1 - 900 / 1100.
    assert found == pytest.approx(100.0 * 2.0 / 11.0)
    assert gain_of(of.ratios("maze", 4, "minpos", "closest")).value < 11.0
    claim = claim_on(minpos.claims(results_of(FULL_MINPOS, values)), "minpos shortens")
    (line,) = [ground for ground in claim.grounds if "ratios of mean times" in ground]
    assert "+18.2 %" in line


@pytest.mark.slow
def test_gains_are_shown_without_and_with_each_change():
    spec = msgspec.structs.replace(ABLATIONS.experiment(FULL_MINPOS, quick=False), repetitions=6)
    gains = {
        after: 2.0 * k for k, one in enumerate(ABLATIONS.changes) for _, after in one.pairs(spec)
    }

    def values(at: Condition, repetition: int) -> dict[str, object]:
        return times(5.0, gains.get(at, 12.0), spread=0.0)(at, repetition)

    tables = ABLATIONS.tables(results_of(spec, values))[:3]
    assert [table.title.partition(": ")[2] for table in tables] == [
        *("maze, 4 robots", "hospital, 4 robots", "maze, 12 robots")
    ]
    assert [[row[0] for row in table.rows] for table in tables] == [
        ["as in the experiment", SCANS, TARGETS, ARRIVAL, SCANS_ARRIVAL, APART],
        ["as in the experiment", SCANS, TARGETS, ARRIVAL, SCANS_ARRIVAL, APART],
        ["as in the experiment", WIDE, APART],
    ]
    assert [[row[2].split()[0] for row in table.rows] for table in tables] == [
        ["+12.0", *(f"+{k:.1f}" for k in (0, 2, 4, 6, 8))],
        ["+12.0", *(f"+{k:.1f}" for k in (10, 12, 14, 16, 18))],
        ["+12.0", "+20.0", "+22.0"],
    ]
    assert {row[1].split()[0] for table in tables for row in table.rows} == {"+5.0"}
    # Minpos on greedy, by their ratios of times to that of closest.
    assert tables[0].rows[0][3].split()[0] == f"{100.0 * (1.0 - 0.88 / 0.95):+.1f}"
    assert {row[4] for table in tables for row in table.rows} == {"6/6/6"}


def test_times_are_given_in_steps_as_well():
    def values(at: Condition, repetition: int) -> dict[str, object]:
        return {"known_complete_s": 100.0 * at.robots, "time_to_99_s": 1.0, "makespan_s": 1000.0}

    table = minpos.times_table(Times(results_of(FULL_MINPOS, values)))
    # 0.3 m at 0.5 m/s.
    assert pytest.approx(0.6) == STEP_S
    assert table.rows[0] == ("maze", "2", *["200 s, 333 steps"] * len(RULES))


def test_gains_are_judged_by_all_cells_together():
    of = Times(results_of(FULL_MINPOS, times(10.0, 20.0, spread=0.01)))
    found = of.family_gain(of.places, "minpos", "closest")
    assert found is not None
    assert found.value == pytest.approx(20.0, abs=0.5)
    assert found.low < 20.0 < found.high
    claim = claim_on(minpos.claims(results_of(FULL_MINPOS, times(10.0, 20.0))), "minpos shortens")
    assert "signed ranks of all cells together" in claim.grounds[0]
    # Those who read that it does not hold, or holds, learn what would have been found.
    assert "not smaller than 12 %" in claim.grounds[1]
    assert "80 % would find a true gain of" in claim.grounds[2]
    assert "geometric means" in claim.grounds[3]
    assert claim.would_show.startswith("known to ±")


def test_a_failed_run_counts_as_the_slowest():
    def values(at: Condition, repetition: int) -> dict[str, object] | None:
        lost = repetition < 25 and at.strategy == "minpos"
        return None if lost else times(10.0, 20.0)(at, repetition)

    of = Times(results_of(FULL_MINPOS, values))
    found = of.family_gain(of.places, "minpos", "closest")
    assert found is not None
    assert found.high < 0.0
