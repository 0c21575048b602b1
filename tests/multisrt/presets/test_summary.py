import pytest

from multisrt.presets import PRESETS
from multisrt.presets.summary import summary
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


def test_a_summary_lists_runs_that_failed():
    preset = PRESETS["alvarez"]
    results = results_of(
        preset.experiment(True),
        lambda at, k: None if (at.robots, k) == (4, 1) else SOME["alvarez"](at, k),
    )
    text = summary(preset, results, "it", claims=[], tables=[])
    assert text.count("repetition 1: over time: beyond 900 s") == 3
    assert "6 complete, 60 a success" not in text
    assert "60 complete, 60 a success" in text
