"""Nobody wins by ending, and nobody is judged by what it says of itself."""

import math
import re

import msgspec
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from multisrt.experiments.crossing import runs
from multisrt.experiments.measures import INTEGRALS, MEASURES, measure_named
from multisrt.experiments.mission import make_run
from multisrt.experiments.provenance import provenance
from multisrt.experiments.results import Results
from multisrt.reporting import overall_figures
from multisrt.reporting.overview import overview
from multisrt.reporting.study import Study
from multisrt.reporting.tables import gaps_above, measure_table, success_table
from multisrt.reporting.words import UNCLAIMED, findings, what_was_run
from multisrt.robots.explorer import Done, Note, Sense
from multisrt.robots.registry import _registry, register, strategy
from multisrt.robots.strategy import Strategy
from tests.multisrt.experiments.results import metrics_of
from tests.multisrt.experiments.small import HALL, experiment

REPETITIONS = 7
"""Pairs of which the clearest difference is significant, as one of two: p = 2 x 2 / 2^7."""


class NoOptions(msgspec.Struct, frozen=True):
    pass


class SensesOnce:
    """An explorer that senses once and says that it is done."""

    def __init__(self, me, options):
        pass

    def run(self):
        yield Sense()
        yield Done(complete=True, reason="all is explored")


class SaysNothing:
    """An explorer that drives like `closest` and notes nothing."""

    def __init__(self, me, options):
        usual = strategy("closest")
        self._usual = usual.explorer(me, usual.options())

    def run(self):
        steps, answer = self._usual.run(), None
        while True:
            try:
                action = steps.send(answer)
            except StopIteration:
                return
            answer = None if isinstance(action, Note) else (yield action)


@pytest.fixture(scope="module")
def study():
    before = set(_registry())
    for name, explorer in (("once", SensesOnce), ("silent", SaysNothing)):
        register(Strategy(name=name, summary="", options=NoOptions, explorer=explorer))
    spec = experiment(
        environments=[{"name": "hall", "wkt": HALL}],
        strategies=["closest", "once", "silent"],
        starts=[{"first": "drawn"}],
        range_finder={"range_m": 2.5},
        repetitions=REPETITIONS,
    )
    found = [make_run(run, spec.limits) for run in runs(spec)]
    yield Study(Results(spec, found, len(found), provenance()))
    for name in set(_registry()) - before:
        del _registry()[name]


def of(study, name):
    (setting,) = study.settings
    return study.of(setting, name)


def test_whoever_senses_once_is_complete_and_no_success(study):
    assert {r.status for r in of(study, "once")} == {"complete"}
    assert not any(r.success for r in of(study, "once"))
    assert all(r.success for r in (*of(study, "closest"), *of(study, "silent")))
    (row,) = success_table(study).rows
    assert [cell.text for cell in row[2:]] == ["7 of 7", "0 of 7", "7 of 7"]
    assert "7 of the runs are unsuccessful (7 complete)" in what_was_run(study)
    assert "at least 95 % of the explorable area covered" in what_was_run(study)


def test_it_is_behind_in_every_table(study):
    (setting,) = study.settings
    for measure in MEASURES:
        if not study.has(measure, setting):
            continue
        mine, theirs = (
            measure.values(of(study, name))
            if measure.lower_is_better
            # Higher is better: turned round.
            else [-value for value in measure.values(of(study, name))]
            for name in ("once", "closest")
        )
        if min(theirs) == math.inf:  # no run of the other has a value
            continue
        assert min(mine) > max(theirs), measure.name
        (found,) = (c for c in study.comparisons(measure) if c.strategy == "once")
        assert (found.better_share, found.mark) == (0.0, "-"), measure.name
        (row,) = measure_table(study, measure).rows
        assert row[3].mark == "-"
        assert row[3].text == "∞" or not measure.lower_is_better


def test_it_is_behind_in_every_rank_and_probability(study, monkeypatch):
    found: dict[str, Axes] = {}
    alts: dict[str, str] = {}

    def kept(name, title, alt, height_in, draw):
        found[name] = Figure(figsize=(4.0, height_in)).add_subplot()
        draw(found[name])
        alts[name] = alt

    monkeypatch.setattr(overall_figures, "drawn", kept)
    for name in ("time_to_95_s", "makespan_s", "total_distance_m", *INTEGRALS):
        overall_figures.improvement(study, measure_named(name))
        # No run of it wins, which few runs cannot show to be always so.
        told = alts[f"improvement-{name.replace('_', '-')}"]
        assert (found_ := re.search(r"once: 0\.00 \(0\.00 to (0\.\d\d)\)", told)), told
        assert 0.1 < float(found_[1]) < 0.5
    overall_figures.profiles(study)
    lines = {line.get_label(): line for line in found["profiles-0"].lines}
    assert np.max(np.asarray(lines["once"].get_ydata())) == 0.0
    assert np.max(np.asarray(lines["closest"].get_ydata())) == 1.0
    gaps = gaps_above(study, "over_bound")
    assert gaps["once"].value == math.inf
    assert math.isfinite(gaps["closest"].value)


def test_its_integral_is_the_larger_one_even_uncounted(study):
    # All runs of the hall have one horizon, at which the shorter runs have not stopped.
    horizons = {r.horizon_s for r in study.results}
    assert horizons == {max(metrics_of(r).makespan_s for r in study.results)}
    once = [metrics_of(r).coverage_integral_s for r in of(study, "once")]
    closest = [metrics_of(r).coverage_integral_s for r in of(study, "closest")]
    assert min(once) > max(closest)


def test_whoever_notes_nothing_is_measured_by_its_scans(study):
    for mine, usual in zip(of(study, "silent"), of(study, "closest"), strict=True):
        m, u = metrics_of(mine), metrics_of(usual)
        assert (m.nodes, m.known_complete_s) == (0, None)
        assert m.coverage == m.seen == pytest.approx(u.seen)
        assert m.makespan_s == u.makespan_s
        assert m.time_to_95_s is not None
    # By the main measure it is compared on equal terms; only the claim it did not make is missing.
    assert MEASURES[0].name == "time_to_95_s"
    (found,) = (c for c in study.comparisons(MEASURES[0]) if c.strategy == "silent")
    assert found.mark == ""
    assert math.isfinite(found.median)
    rows = {row[0].text: [cell.line for cell in row] for row in overview(study).rows}
    assert rows["silent"][1] == "7 of 7"
    assert rows["silent"][4] == UNCLAIMED
    assert rows["once"][4] == "∞ -"
    claim = measure_named("known_complete_s")
    assert {c.strategy for c in study.comparisons(claim)} == {"once"}
    (setting,) = study.settings
    assert study.summary(claim, setting, "silent") is None
    assert study.finite(claim, setting, "silent") == []
    (row,) = measure_table(study, claim).rows
    assert row[4].text == UNCLAIMED
    for table in (overview(study), measure_table(study, claim)):
        assert "no run of silent records a MapComplete that counts" in " ".join(table.notes)
    assert rows["silent"][5] == rows["closest"][5]


# One run for every seed ----------------------------------------------------------------------


def constant(study, *names):
    """Return the study as if the runs of some strategies did not depend on the seed."""
    made = []
    for result in study.results:
        first = of(study, result.condition.strategy)[0]
        if result.condition.strategy in names:
            result = msgspec.structs.replace(
                first,
                key=result.key,
                repetition=result.repetition,
                chance=False,
                same_as=None if result.key == first.key else 0,
            )
        made.append(result)
    results = Results(study.results.experiment, made, len(made), study.results.provenance)
    return Study(results)


def test_copies_count_once(study):
    fixed = constant(study, "silent")
    (setting,) = fixed.settings
    measure = measure_named("makespan_s")
    summary = fixed.summary(measure, setting, "silent")
    assert (summary.runs, summary.distinct, summary.measured) == (7, 1, 1)
    assert fixed.is_constant(setting, "silent")
    assert not fixed.is_constant(setting, "closest")
    (row,) = measure_table(fixed, measure).rows
    assert row[4].detail == "(1 run)"
    assert row[2].detail.startswith("[")
    assert any("7 repetitions, 1 distinct run" in n for n in measure_table(fixed, measure).notes)
    (row,) = success_table(fixed).rows
    assert [(cell.text, cell.detail) for cell in row[3:]] == [
        ("0 of 7", "(0 to 35 %)"),
        ("1 of 1", "(1 run)"),
    ]
    assert "21 runs, 15 of them distinct" in what_was_run(fixed)


def test_a_sample_is_tested_against_one_run(study):
    fixed = constant(study, "closest")
    measure = measure_named("makespan_s")
    by_name = {c.strategy: c for c in fixed.comparisons(measure)}
    assert {c.kind for c in by_name.values()} == {"one-sample"}
    found = by_name["once"]
    # All seven are worse than the one: the clearest test of seven, twice over by Holm.
    assert (found.pairs, found.mark) == (7, "-")
    assert found.p_value == pytest.approx(2 * 2.0**-6)
    (said,) = (text for text in findings(fixed, measure).significant if "once" in text)
    assert "7 runs against one, one-sample rank test" in said


def test_two_single_runs_differ_without_a_test(study):
    fixed = constant(study, "closest", "once", "silent")
    measure = measure_named("makespan_s")
    found = fixed.comparisons(measure)
    assert {(c.kind, c.pairs, c.p_value, c.mark) for c in found} == {("none", 1, None, "")}
    said = findings(fixed, measure)
    assert said.significant == ()
    assert said.too_few == ""
    assert said.counts[0] == "once against closest, 1 setting: one run each in 1."
    assert (
        "once and closest have one run each, the same for every seed: ∞ against" in said.others[0]
    )
    table = measure_table(fixed, measure)
    assert not any("Wilcoxon" in note for note in table.notes)
    assert "p" not in (table.rows[0][3].data or {})
