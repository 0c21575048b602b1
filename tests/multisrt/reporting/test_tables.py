import csv
import io
import math
import re
import statistics
from collections.abc import Callable, Mapping, Sequence
from html.parser import HTMLParser

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import multisrt as ms
from multisrt.analysis.metrics import Metrics
from multisrt.drawing.svg import printable
from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import MEASURES, measure_named
from multisrt.experiments.provenance import provenance
from multisrt.experiments.results import Result, Results
from multisrt.experiments.spec import ExperimentSpec
from multisrt.geometry.errors import InvalidInputError
from multisrt.informed.reference import Reference
from multisrt.reporting import overall_figures
from multisrt.reporting.layout import Cell, Table, latex_escaped, number, slug
from multisrt.reporting.study import Study, chosen_measures
from multisrt.reporting.tables import (
    computing_table,
    gap_table,
    gaps_above,
    growth_table,
    measure_table,
    settings_with,
    success_table,
    summary_table,
)
from multisrt.reporting.words import (
    HOW_TO_REFER,
    difference,
    findings,
    p_value,
    significance_note,
    what_was_run,
)
from tests.multisrt.experiments.results import metrics_of

TIME = measure_named("known_complete_s")
Times = Mapping[tuple[str, str, int], Sequence[float | None]]
Make = Callable[..., Results]


@pytest.fixture(scope="module")
def measured() -> Metrics:
    return ms.explore("open", seed=1).metrics


@pytest.fixture(scope="module")
def make(measured: Metrics) -> Make:
    def results(times: Times, *, planned: int | None = None) -> Results:
        # Times by (environment, strategy, robots); None is a run that crashed.
        found = [
            result_of(Condition(environment=environment, strategy=strategy, robots=robots), k, time)
            for (environment, strategy, robots), own in times.items()
            for k, time in enumerate(own)
        ]
        spec = ExperimentSpec(name="made up", environments=("open",), strategies=("srt-star",))
        return Results(spec, found, len(found) if planned is None else planned, provenance())

    def result_of(condition: Condition, repetition: int, time: float | None) -> Result:
        key = f"{condition}-{repetition}"
        if time is None:
            return Result(
                key=key,
                condition=condition,
                repetition=repetition,
                status="crashed",
                reason="its process died",
            )
        metrics = msgspec.structs.replace(
            measured,
            known_complete_s=time,
            makespan_s=time,
            coverage=1.0,
            lower_bound_s=10.0,
        )
        return Result(
            key=key,
            condition=condition,
            repetition=repetition,
            status="complete",
            reason="",
            metrics=metrics,
        )

    return results


def growth_of(results: Results) -> Table:
    table = growth_table(Study(results), TIME)
    assert table is not None
    return table


def value(cell: Cell, name: str) -> float:
    """Return one of the numbers of a cell."""
    assert cell.data is not None
    found = cell.data[name]
    assert isinstance(found, int | float)
    return found


def lognormal(seed: int, scale: float, count: int = 20) -> list[float]:
    return [float(t) for t in scale * np.random.default_rng(seed).lognormal(0.0, 0.2, count)]


def holm_by_hand(p_values: list[float]) -> list[float]:
    order = sorted(range(len(p_values)), key=p_values.__getitem__)
    adjusted, worst = [0.0] * len(p_values), 0.0
    for place, i in enumerate(order):
        worst = max(worst, min(1.0, (len(p_values) - place) * p_values[i]))
        adjusted[i] = worst
    return adjusted


# Numbers ------------------------------------------------------------------------------------


def test_table_holds_the_numbers_of_the_runs(make):
    times = {
        ("garden", "a", 1): lognormal(1, 300.0),
        ("garden", "b", 1): lognormal(2, 200.0),
        ("office", "a", 1): lognormal(3, 300.0),
        ("office", "b", 1): lognormal(4, 310.0),
    }
    table = summary_table(make(times), TIME)
    assert table.columns == ("World", "Team", "a", "b")
    tests = [
        float(stats.wilcoxon(times[world, "b", 1], times[world, "a", 1]).pvalue)
        for world in ("garden", "office")
    ]
    adjusted = holm_by_hand(tests)
    for row, world, p in zip(table.rows, ("garden", "office"), adjusted, strict=True):
        assert (row[0].text, row[1].text) == (world, "1 robot")
        for cell, strategy in zip(row[2:], ("a", "b"), strict=True):
            own = times[world, strategy, 1]
            assert value(cell, "median") == pytest.approx(statistics.median(own))
            assert value(cell, "iqm") == pytest.approx(statistics.mean(sorted(own)[5:15]))
            assert value(cell, "low") < value(cell, "iqm") < value(cell, "high")
            assert cell.text == number(statistics.median(own), 1)
        assert value(row[3], "p") == pytest.approx(p)
        assert row[2].mark == ""
        assert row[3].mark == ("+" if p < 0.05 else "")
    assert [row[3].mark for row in table.rows] == ["+", ""]


def test_marks_turn_round_with_the_baseline(make):
    results = make({("w", "a", 1): lognormal(1, 300.0), ("w", "b", 1): lognormal(2, 150.0)})
    assert [cell.mark for cell in summary_table(results, TIME).rows[0][2:]] == ["", "+"]
    turned = summary_table(results, "known_complete_s", baseline="b")
    assert [cell.mark for cell in turned.rows[0][2:]] == ["-", ""]


def test_higher_is_better_where_it_is(make, measured):
    results = make({("w", "a", 1): lognormal(1, 1.0), ("w", "b", 1): lognormal(2, 1.0)})
    better = [
        msgspec.structs.replace(
            result,
            metrics=msgspec.structs.replace(
                result.metrics,
                coverage=(0.9 if result.condition.strategy == "a" else 0.95)
                + 0.001 * result.repetition,
            ),
        )
        for result in results
    ]
    changed = Results(results.experiment, better, len(better), results.provenance)
    (row,) = summary_table(changed, "coverage").rows
    assert row[3].mark == "+"
    assert value(row[3], "A") > 0.9


def test_failed_runs_count_as_worst(make):
    good = lognormal(1, 100.0, 9)
    results = make({("w", "a", 1): [*good, None], ("w", "b", 1): [*good[:4], *[None] * 6]})
    (row,) = summary_table(results, TIME).rows
    assert value(row[2], "median") == pytest.approx(np.median([*good, math.inf]))
    assert (value(row[2], "runs"), value(row[2], "measured")) == (10, 9)
    assert row[3].text == "∞"
    assert row[3].sort == math.inf
    assert any("∞" in note for note in summary_table(results, TIME).notes)
    (success,) = success_table(Study(results)).rows
    assert [cell.text for cell in success[2:]] == ["9 of 10", "4 of 10"]
    low = stats.binomtest(9, 10).proportion_ci(method="wilson").low
    assert value(success[2], "low") == pytest.approx(low)


@pytest.mark.parametrize(("runs", "warned"), [(1, False), (2, True), (9, True), (10, False)])
def test_intervals_of_few_runs_come_with_a_warning(make, runs, warned):
    results = make({("w", "a", 1): lognormal(1, 9.0, runs), ("w", "b", 1): lognormal(2, 9.0, 20)})
    notes = summary_table(results, TIME).notes
    assert any(f"only {runs} runs" in note for note in notes) is warned


def test_conditions_without_runs_are_empty(make):
    results = make({("w", "a", 1): [1.0, 2.0], ("w", "b", 2): [1.0, 2.0]})
    rows = summary_table(results, TIME).rows
    assert [cell.text for cell in rows[0][2:]] == ["1.5", ""]
    assert [cell.text for cell in rows[1][2:]] == ["", "1.5"]
    said = findings(Study(results), TIME)
    assert said.significant == ()
    assert "nothing to compare" in said.others[0]


def test_gap_is_that_of_the_interquartile_mean(make):
    times = lognormal(5, 40.0)
    table = gap_table(Study(make({("w", "a", 1): times})))
    assert table is not None
    middle = statistics.mean(sorted(times)[5:15])
    assert value(table.rows[0][1], "gap") == pytest.approx(middle / 10.0 - 1.0)


def with_plans(results: Results, by_team: dict[int, float | None]) -> Results:
    """Return results with the times of informed plans to 99 %, by team size."""
    made = []
    for result in results:
        time_s = by_team[result.condition.robots]
        plan = Reference(
            time_to_90_s=5.0,
            time_to_95_s=5.0,
            time_to_99_s=time_s,
            makespan_s=20.0,
            distance_m=5.0,
            coverage=0.98 if time_s is None else 0.99,
        )
        made.append(msgspec.structs.replace(result, reference=plan))
    return Results(results.experiment, made, results.planned, results.provenance)


def test_gaps_beside_the_informed_plan_by_hand(make):
    # Runs of a are at 99 % after 30 s, those of b after 50 s; plans of one robot take 20 s.
    times: Times = {("w", s, n): [t] * 4 for s, t in (("a", 30.0), ("b", 50.0)) for n in (1, 2)}
    made = make(times)
    at_99 = [
        msgspec.structs.replace(
            result,
            metrics=msgspec.structs.replace(
                metrics_of(result), time_to_99_s=metrics_of(result).makespan_s
            ),
        )
        for result in made
    ]
    results = Results(made.experiment, at_99, len(at_99), made.provenance)
    table = gap_table(Study(with_plans(results, {1: 20.0, 2: None})))
    assert table is not None
    assert table.columns == ("Strategy", "99 % above informed", "Makespan above bound")
    found = [(value(row[1], "gap"), value(row[2], "gap")) for row in table.rows]
    # The bound is 10 s.
    assert found == [pytest.approx((0.5, 2.0)), pytest.approx((1.5, 4.0))]
    notes = " ".join(table.notes)
    assert "Informed: 1 setting;" in notes
    assert "Bound: 2 settings;" in notes
    assert "w, 2 robots (the informed plan covers 98.0 %)" in notes
    assert HOW_TO_REFER not in notes
    pictures = overall_figures.gaps(
        Study(with_plans(results, {1: 20.0, 2: 40.0})),
    )
    assert [picture.name for picture in pictures] == ["gap-over-informed", "gap-over-bound"]


def test_without_plans_the_gap_says_how_to_get_them(make):
    table = gap_table(Study(make({("w", "a", 1): [20.0, 30.0]})))
    assert table is not None
    assert table.title == "Makespan above its lower bound"
    assert table.notes[-1] == HOW_TO_REFER


def test_who_never_covers_99_percent_is_infinitely_above_the_plan(make):
    made = make({("w", "a", 1): [20.0, 30.0]})
    never = [
        msgspec.structs.replace(
            result, metrics=msgspec.structs.replace(metrics_of(result), time_to_99_s=None)
        )
        for result in made
    ]
    results = Results(made.experiment, never, len(never), made.provenance)
    found = gaps_above(Study(with_plans(results, {1: 20.0})), "over_informed")
    assert found["a"].value == math.inf


def test_growth_finds_the_exponent_that_was_put_in(make):
    noise = lognormal(7, 1.0, 10)
    results = make({("w", "a", n): [300.0 * n**-0.8 * e for e in noise] for n in (1, 2, 4)})
    (row,) = growth_of(results).rows
    assert value(row[1], "low") < -0.8 < value(row[1], "high")
    assert value(row[1], "exponent") == pytest.approx(-0.8)
    assert growth_table(Study(make({("w", "a", 1): noise})), TIME) is None


def test_growth_by_hand(make):
    # Two sizes of the team, two runs each. In logarithms to base 2 the runs of a are 8 and 6, then
    # 5 and 3: the slope is the difference of the means, -3, and the residuals are 1, -1, 1, -1.
    # Their variance is 4 / 2, that of the slope 2 / (4 / 4), and Student's t for 2 degrees of
    # freedom is 4.302653.
    results = make(
        {
            ("w", "a", 1): [256.0, 64.0],
            ("w", "a", 2): [32.0, 8.0],
            ("w", "b", 1): [64.0, 64.0],
            ("w", "b", 2): [128.0, 128.0],
            ("v", "b", 1): [10.0, 20.0],
            ("v", "b", 4): [10.0, 20.0],
        }
    )
    table = growth_of(results)
    assert table.columns == ("World", "a", "b")
    (world, of_a, of_b), (other, none, flat) = table.rows
    assert (world.text, other.text) == ("w", "v")
    half = 4.302653 * math.sqrt(2.0)
    assert value(of_a, "exponent") == pytest.approx(-3.0)
    assert value(of_a, "low") == pytest.approx(-3.0 - half, abs=1e-4)
    assert value(of_a, "high") == pytest.approx(-3.0 + half, abs=1e-4)
    assert of_a.text == "\N{MINUS SIGN}3.00"
    assert of_a.detail == "(\N{MINUS SIGN}9.08 to 3.08)"
    assert [value(of_b, key) for key in ("exponent", "low", "high")] == pytest.approx([1.0] * 3)
    assert (none.text, none.data) == ("", None)
    assert value(flat, "exponent") == pytest.approx(0.0, abs=1e-12)


def test_no_growth_where_a_run_has_no_value(make):
    results = make({("w", "a", n): [10.0 / n, None if n == 2 else 9.0 / n] for n in (1, 2, 4)})
    assert growth_table(Study(results), TIME) is None


def test_computing_by_hand(make):
    took = {("v", "a"): (1.0, 2.0, 6.0), ("v", "b"): (3.0, 5.0, 4.0)}
    results = make({(world, strategy, 1): own for (world, strategy), own in took.items()})
    changed = [
        msgspec.structs.replace(
            result,
            computing_s=took["v", result.condition.strategy][result.repetition],
            memory_mb=100.0 * (1 + result.repetition) + (result.condition.strategy == "b"),
        )
        for result in results
    ]
    study = Study(Results(results.experiment, changed, 6, results.provenance))
    (row,) = computing_table(study).rows
    assert [cell.text for cell in row] == ["v", "1 robot", "2.00", "4.00"]
    assert [cell.detail for cell in row[2:]] == [
        "(at most 6.00 s, 300 MB)",
        "(at most 5.00 s, 301 MB)",
    ]
    assert row[2].data == {"median_s": 2.0, "most_s": 6.0, "most_mb": 300.0}


def test_gaps_are_of_settings_that_all_strategies_met(make):
    study = Study(
        make(
            {
                ("v", "a", 1): [20.0, 20.0],
                ("v", "b", 1): [15.0, 15.0],
                ("w", "a", 1): [90.0, 90.0],
                ("x", "a", 1): [40.0, 40.0],
                ("x", "b", 1): [25.0, 25.0],
            }
        )
    )
    assert [setting.environment for setting in settings_with(study, "over_bound")] == ["v", "x"]
    # Over a bound of 10 s: 1, 1, 3, 3 and 0.5, 0.5, 1.5, 1.5, of which the middle half is taken.
    found = gaps_above(study, "over_bound")
    assert {name: gap.value for name, gap in found.items()} == pytest.approx({"a": 2.0, "b": 1.0})
    # Equal runs of a setting leave nothing to chance.
    assert (found["a"].low, found["a"].high) == pytest.approx((2.0, 2.0))


def test_settings_and_scenes_are_in_order(make):
    times = {(w, s, n): [1.0] for w in ("w", "v") for n in (4, 1) for s in ("b", "a")}
    study = Study(make(times | {("w", "a", 2): [1.0]}), "a")
    assert study.strategies == ["b", "a"]
    assert study.rivals == ["b"]
    assert [(s.environment, s.robots) for s in study.settings] == [
        ("w", 4), ("w", 1), ("v", 4), ("v", 1), ("w", 2),
    ]  # fmt: skip
    assert [
        (scene.environment, [s.robots for s in own]) for scene, own in study.scenes().items()
    ] == [("w", [1, 2, 4]), ("v", [1, 4])]
    assert ("w", 2) not in [(s.environment, s.robots) for s in study.shared_settings()]
    assert study.here(study.settings[-1]) == ["a"]


def test_runs_are_compared_pair_by_pair(make):
    # Alike on the whole, but b is a little better in each world.
    worlds = lognormal(9, 300.0)
    results = make({("w", "a", 1): worlds, ("w", "b", 1): [t - 1.0 for t in worlds]})
    (found,) = Study(results).comparisons(TIME)
    assert found.mark == "+"
    assert found.size == "negligible"
    assert found.pairs == 20


# Words --------------------------------------------------------------------------------------


def test_sentences_agree_with_the_figures(make):
    slow, fast = [300.0 + k for k in range(20)], [200.0 + k for k in range(20)]
    study = Study(make({("garden", "srt-star", 4): slow, ("garden", "srt-radial", 4): fast}))
    (found,) = study.comparisons(TIME)
    p = 2.0**-19
    assert found.p_value == pytest.approx(p)
    assert difference(study, found) == (
        "In garden with 4 robots srt-radial needs 32 % less time than srt-star (median 209.5 s "
        "against 309.5 s; 20 pairs, paired rank test, Holm-corrected p < 0.001; A = 1.00, large)."
    )
    turned = Study(study.results, "srt-radial")
    (other,) = turned.comparisons(TIME)
    assert "srt-star needs 48 % more time than srt-radial" in difference(turned, other)
    assert "A = 0.00, large" in difference(turned, other)


def test_no_percentage_where_there_is_no_median(make):
    times = lognormal(1, 100.0)
    study = Study(make({("w", "a", 1): times, ("w", "b", 1): [None] * 20}))
    (said,) = findings(study, TIME).significant
    assert "b does significantly worse than a by time until one robot's map is complete" in said
    assert "nan" not in said
    assert "100 %" not in said


def test_no_claim_beyond_the_numbers(make):
    times = lognormal(1, 100.0)
    same = Study(make({("w", "a", 1): times, ("w", "b", 1): times}))
    said = findings(same, TIME)
    assert said.significant == ()
    assert said.others == (
        "No significant difference between b and a: w, 1 robot (p = 1, A = 0.50).",
    )


@pytest.mark.parametrize(("runs", "enough"), [(5, False), (6, True)])
def test_too_few_runs_are_said_to_be_too_few(make, runs, enough):
    # The clearest that 5 pairs can be is p = 2 / 2^5 = 0.0625, that 6 can be half of it.
    times = [100.0 + k for k in range(runs)]
    study = Study(make({("w", "a", 1): times, ("w", "b", 1): [t / 2 for t in times]}))
    said = findings(study, TIME)
    assert bool(said.significant) is enough
    assert bool(said.too_few) is not enough
    assert any("Too few runs" in text for text in said.others) is not enough
    note = significance_note(study, TIME)
    assert note.startswith("+ significantly better") is enough
    assert ("no difference can be significant; take at least 6 rep" in note) is not enough


def test_holm_makes_more_runs_necessary(make):
    times = [100.0 + k for k in range(6)]
    study = Study(
        make(
            {
                (w, s, 1): times if s == "a" else [t / 2 for t in times]
                for w in ("v", "w")
                for s in ("a", "b")
            }
        )
    )
    assert not any(found.mark or found.decidable for found in study.comparisons(TIME))


def test_single_strategy_has_nothing_to_be_compared_with(make):
    said = findings(Study(make({("w", "a", 1): [1.0, 2.0]})), TIME)
    assert said.others == ("There is only one strategy, so there is nothing to compare.",)


def test_missing_runs_are_said_to_be_missing(make):
    text = what_was_run(Study(make({("w", "a", 1): [1.0, None]}, planned=5)))
    assert "5 runs asked for, 2 made (3 still missing" in text
    assert "1 of the runs is unsuccessful (1 crashed)" in text


def test_p_values_are_rounded_to_two_digits():
    assert (p_value(0.0321), p_value(1.0), p_value(4e-9)) == ("= 0.032", "= 1", "< 0.001")


# Refusals -----------------------------------------------------------------------------------


def test_unknown_names_are_refused_with_the_nearest(make):
    results = make({("w", "srt-star", 1): [1.0]})
    with pytest.raises(InvalidInputError, match="did you mean 'srt-star'"):
        Study(results, "srt-stat")
    with pytest.raises(InvalidInputError, match="did you mean 'makespan_s'"):
        chosen_measures(Study(results), ["makespan"])


def test_every_measure_has_a_table(make):
    results = make({("w", "a", 1): [1.0, 2.0], ("w", "b", 1): [1.0, None]})
    for measure in MEASURES:
        assert measure_table(Study(results), measure).title == measure.heading


# Writing ------------------------------------------------------------------------------------

labels = st.text(st.characters(codec="utf-8"), min_size=1, max_size=30)


def table_of(labels_: list[str]) -> Table:
    rows = tuple(
        (Cell(text=label), *(Cell(text="1,234.5", detail="[1: 2 to 3]", mark="+"),) * len(labels_))
        for label in labels_
    )
    return Table(name="t", title="Title", columns=("World", *labels_), rows=rows)


@given(st.lists(labels, min_size=1, max_size=8))
def test_text_fits_the_terminal(names):
    text = table_of(names).text(80)
    assert all(len(line) <= 80 for line in text.split("\n"))
    assert text.count("1,234.5 + [1: 2 to 3]") == len(names) ** 2


@given(labels)
def test_labels_cannot_break_out_of_the_page(label):
    class Reader(HTMLParser):
        def __init__(self):
            super().__init__()
            self.tags, self.texts = [], []

        def handle_starttag(self, tag, attrs):
            self.tags.append(tag)

        def handle_data(self, data):
            self.texts.append(data)

    reader = Reader()
    reader.feed(table_of([label]).html())
    reader.close()
    usual = table_of(["w"]).html()
    assert reader.tags == re.findall(r"<([a-z]+)", usual)
    if printable(label):
        assert reader.texts.count(printable(label)) >= 2


def test_latex_is_escaped():
    assert latex_escaped("50 % of a_b & $x") == r"50 \% of a\_b \& \$x"
    text = table_of(["{evil}\\input{x}"]).latex()
    assert r"\{evil\}\textbackslash{}input\{x\}" in text
    assert r"\toprule" in text
    assert "1,234.5 $+$" in text


def test_csv_has_full_numbers(make):
    times = {("w", "a", 1): lognormal(1, 100.0), ("w", 'b,"c"', 1): lognormal(2, 100.0)}
    rows = list(csv.DictReader(io.StringIO(summary_table(make(times), TIME).csv())))
    assert float(rows[0]["a median"]) == np.median(times["w", "a", 1])
    assert float(rows[0]['b,"c" median']) == np.median(times["w", 'b,"c"', 1])
    assert rows[0]["World"] == "w"


def test_numbers_are_short():
    assert number(-0.04, 1) == "0.0"
    assert number(-2.5, 1) == "\N{MINUS SIGN}2.5"
    assert slug("../../etc/passwd\x00") == "etc-passwd"


def test_reports_with_a_base_station_discuss_what_was_delivered(make):
    results = make({("w", "srt-star", 1): [1.0, 2.0]})
    names = [measure.name for measure in chosen_measures(Study(results))]
    assert "coverage" in names
    assert "delivered_coverage" not in names
    told = [
        msgspec.structs.replace(
            one,
            metrics=msgspec.structs.replace(
                metrics_of(one), delivered_coverage=0.5, delivery_delay_s=9.0
            ),
        )
        for one in results
    ]
    with_base = Study(Results(results.experiment, told, 2, results.provenance))
    chosen = chosen_measures(with_base)
    assert [one.name for one in chosen] == [*names, "delivered_coverage", "delivery_delay_s"]
    assert [one.name for one in chosen_measures(with_base, ["coverage"])] == ["coverage"]


def test_a_measure_that_some_runs_lack_varies(make):
    # 95 % was delivered in one run and not in the other; a run that crashed has no say.
    results = make({("w", "srt-star", 1): [1.0, 2.0, None]})
    measure = measure_named("delivered_95_s")
    assert not Study(results).varies(measure)
    one, *others = results
    measured = msgspec.structs.replace(metrics_of(one), delivered_95_s=9.0)
    some = [msgspec.structs.replace(one, metrics=measured), *others]
    assert Study(Results(results.experiment, some, 3, results.provenance)).varies(measure)
    alone = [some[0], others[1]]
    assert not Study(Results(results.experiment, alone, 2, results.provenance)).varies(measure)
