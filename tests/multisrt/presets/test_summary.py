import dataclasses

import msgspec
import pytest

from multisrt.experiments.results import Results
from multisrt.informed.reference import Reference
from multisrt.presets import PRESETS
from multisrt.presets.minpos_ablations import WIDE
from multisrt.presets.summary import summary
from tests.multisrt.experiments.results import metrics_of
from tests.multisrt.presets.constructed import SOME, no_results, results_of


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS)
def test_a_summary_has_everything(name):
    preset = PRESETS[name]
    for results in (
        results_of(preset.experiment(True), SOME[name]),
        no_results(preset.experiment(True)),
    ):
        claims, tables = preset.claims(results), preset.tables(results)
        text = summary(preset, results, "multisrt reproduce it", claims=claims, tables=tables)
        for claim in claims:
            judged = text.split("## Claims")[1].split("###")[0].splitlines()
            (row,) = [line for line in judged if line.startswith(f"| {claim.text} |")]
            assert row.startswith(f"| {claim.text} | {claim.verdict}")
            assert row.endswith(f"| {claim.would_show} |")
            for _, verdict in claim.other_verdicts:
                assert f": {verdict}" in row
            assert bool(claim.would_show) == (claim.verdict != "not tested")
            assert claim.source
            assert claim.grounds
        for table in tables:
            assert f"### {table.title}" in text
            assert all(len(row) == len(table.columns) for row in table.rows)
        for deviation in preset.deviations:
            assert deviation.text in text
        assert f"{preset.experiment(True).repetitions} repetitions" in text
        assert f"Runs: {len(results)} of {results.planned}" in text
        assert ("runs are missing" in text) == (len(results) < results.planned)


def test_a_summary_tells_times_beside_the_informed_plan():
    preset = PRESETS["alvarez"]
    results = results_of(preset.experiment(True), SOME["alvarez"])
    assert "knows the map" not in summary(preset, results, "it", claims=[], tables=[])
    asked = msgspec.structs.replace(preset.experiment(True), reference="informed")
    plan = Reference(
        time_to_90_s=1.0,
        time_to_95_s=1.0,
        time_to_99_s=2.0,
        makespan_s=2.0,
        distance_m=1.0,
        coverage=1.0,
    )
    planned = [
        msgspec.structs.replace(
            result,
            reference=plan,
            metrics=msgspec.structs.replace(metrics_of(result), time_to_99_s=5.0),
        )
        for result in results
    ]
    text = summary(
        preset,
        Results(asked, planned, len(planned), results.provenance),
        "it",
        claims=[],
        tables=[],
    )
    assert "| Strategy | 99 % above informed |" in text
    assert "| 150 % (150 % to 150 %) |" in text


def test_a_summary_lists_runs_that_failed():
    preset = PRESETS["alvarez"]
    results = results_of(
        preset.experiment(True),
        lambda at, k: None if (at.robots, k) == (4, 1) else SOME["alvarez"](at, k),
    )
    text = summary(preset, results, "it", claims=[], tables=[])
    assert text.count("repetition 1: over time: beyond 900 s") == 3
    assert "6 complete, 60 successful" not in text
    assert "60 complete, 60 successful" in text


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS)
def test_a_summary_with_ablations_names_them(name):
    preset = PRESETS[name]
    results = results_of(preset.experiment(True), SOME[name])
    claims = [dataclasses.replace(one, verdict="does not hold") for one in preset.claims(results)]
    assert preset.ablations is not None
    spec = preset.ablations.experiment(preset.experiment(False), quick=False)
    made = no_results(spec)
    text = summary(preset, results, "it", claims=claims, tables=[], ablations=made)
    with_why = [claim for claim in claims if preset.ablations.asking_why(claim.text)]
    assert text.count("- ablations that ask why: ") == len(with_why) > 0
    others = len(claims) - len(with_why)
    assert text.count("- no ablation asks why it does not hold") == others
    measured, others_text = text.split("Differences whose effect is not measured:")
    for deviation in preset.deviations:
        assert deviation.text in (measured if deviation.ablations else others_text)
        for change in deviation.ablations:
            assert f"“{change}”" in measured
    tables = text.split("## Ablations")[1]
    for one in preset.ablations.changes:
        assert f"| {one.change} |" in tables
        assert f"| {one.change} | {one.setting} |" in tables
        assert f"### {one.topic.title}" in tables
    # Without them nothing refers to them.
    without = summary(preset, results, "it", claims=claims, tables=[])
    assert "ablation" not in without.lower()


def test_a_difference_is_measured_by_ablations_that_were_made():
    preset = PRESETS["minpos"]
    (obstructed,) = [one for one in preset.deviations if one.ablations == (WIDE,)]
    assert preset.ablations is not None
    for quick in (True, False):
        whole = preset.experiment(quick)
        made = no_results(preset.ablations.experiment(whole, quick=quick))
        text = summary(preset, no_results(whole), "it", claims=[], tables=[], ablations=made)
        measured, others = text.split("Differences whose effect is not measured:")
        # Bodies of 1 m are tried in teams that a quick experiment does not have.
        assert obstructed.text in (others if quick else measured)
        assert (f"“{WIDE}”" in text) != quick
