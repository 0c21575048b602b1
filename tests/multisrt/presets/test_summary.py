import msgspec
import pytest

from multisrt.experiments.results import Results
from multisrt.informed.reference import Reference
from multisrt.presets import PRESETS
from multisrt.presets.summary import summary
from multisrt.reporting.words import HOW_TO_REFER
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
            assert f"| {claim.text} | {claim.told} |" in text
            assert claim.source
            assert claim.grounds
        for table in tables:
            assert f"### {table.title}" in text
            assert all(len(row) == len(table.columns) for row in table.rows)
        for deviation in preset.deviations:
            assert deviation in text
        assert f"{preset.experiment(True).repetitions} repetitions" in text
        assert f"Runs: {len(results)} of {results.planned}" in text
        assert ("runs are missing" in text) == (len(results) < results.planned)


def test_a_summary_tells_times_beside_the_informed_plan():
    preset = PRESETS["alvarez"]
    results = results_of(preset.experiment(True), SOME["alvarez"])
    assert HOW_TO_REFER in summary(preset, results, "it", claims=[], tables=[])
    asked = msgspec.structs.replace(preset.experiment(True), reference="informed")
    waiting = summary(preset, results_of(asked, SOME["alvarez"]), "it", claims=[], tables=[])
    assert HOW_TO_REFER not in waiting
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
