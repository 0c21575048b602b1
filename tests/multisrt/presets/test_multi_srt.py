import msgspec

from multisrt.experiments.crossing import Condition
from multisrt.presets import multi_srt
from multisrt.presets.multi_srt_ablations import TIMES
from tests.multisrt.presets.constructed import (
    QUICK_SRT,
    claim_on,
    no_results,
    noise_of,
    results_of,
    srt,
)


def test_claims_of_multi_srt_that_hold():
    def time(at):
        # In a cluster four robots are slower than two.
        return 1000.0 / at.robots * (3.0 if at.starts == "clustered" and at.robots == 4 else 1.0)

    found = multi_srt.claims(results_of(QUICK_SRT, srt(time)))
    assert len(found) == 10
    assert {claim.text: claim.verdict for claim in found} == dict.fromkeys(
        (claim.text for claim in found), "holds"
    )
    # With 360 runs: 1 - 0.2 ** (1 / 360), and a limit of each claim.
    assert found[-1].would_show == "0.45 % of bad runs would have been detected"
    assert all(claim.would_show for claim in found)
    # 2 worlds, 2 strategies, 2 radios; from 1 to 2 and from 2 to 4 robots.
    for claim in found[:2]:
        assert "in 16 of 16 comparisons, significantly by itself in 16" in claim.grounds[1]
    # 2 worlds; alone, and 2 sizes, 2 starts, 2 radios.
    for claim in found[5:8]:
        assert "in 18 of 18 comparisons, significantly by itself in 18" in claim.grounds[1]


def test_claims_of_multi_srt_that_do_not_hold():
    spec = msgspec.structs.replace(multi_srt.experiment(False), repetitions=12)

    def values(at: Condition, repetition: int) -> dict[str, object]:
        vary = 1.0 + 0.02 * noise_of(at, repetition, "time")
        # Scattered, four take longer than two, once only; star is as good as radial is said to be.
        odd = at.robots == 4 and at.starts == "scattered" and at.radio == "15 m"
        odd = odd and (at.environment, at.strategy) == ("garden", "srt-star")
        return {
            "makespan_s": 2000.0 if odd else 1000.0 / at.robots * vary,
            "total_distance_m": 500.0
            / at.robots
            * (1.5 if "radial" in at.strategy else 1.0)
            * vary,
        }

    found = multi_srt.claims(results_of(spec, values))
    scattered = claim_on(found, "scattered", "until all are home")
    assert scattered.verdict == "does not hold"
    assert any("garden, srt-star, 15 m radio, 2 to 4 robots" in line for line in scattered.grounds)
    assert claim_on(found, "clustered", "until all are home").verdict == "does not hold"
    assert claim_on(found, "distance grows").verdict == "does not hold"
    assert claim_on(found, "shorter total distance").verdict == "does not hold"
    assert claim_on(found, "completed").verdict == "holds"


def test_one_collision_refutes_that_there_are_none():
    def values(at: Condition, repetition: int) -> dict[str, object]:
        return {"collisions": int(at.robots == 4 and repetition == 3)}

    claim = claim_on(multi_srt.claims(results_of(QUICK_SRT, values)), "collisions")
    assert claim.verdict == "does not hold"
    assert any("repetition 3" in ground for ground in claim.grounds)


def test_claims_of_multi_srt_that_may_be_chance():
    found = multi_srt.claims(
        results_of(
            QUICK_SRT,
            lambda at, k: {
                "makespan_s": 1000.0 + 100.0 * noise_of(at, k, "time"),
                "known_complete_s": 900.0 + 100.0 * noise_of(at, k, "known"),
                "total_distance_m": 500.0 + 100.0 * noise_of(at, k, "way"),
            },
        )
    )
    assert [claim.verdict for claim in found[:8]] == ["not significant"] * 8


def test_claims_of_multi_srt_without_runs_enough():
    for results in (
        no_results(QUICK_SRT),
        results_of(msgspec.structs.replace(QUICK_SRT, repetitions=2), srt(), planned=10_000),
    ):
        assert {claim.verdict for claim in multi_srt.claims(results)} == {"not tested"}


def test_both_times_are_judged():
    def values(at: Condition, repetition: int) -> dict[str, object]:
        # Larger teams are home sooner, but know the map complete no sooner.
        return srt()(at, repetition) | {
            "known_complete_s": 100.0 + noise_of(at, repetition, "known")
        }

    results = results_of(QUICK_SRT, values)
    found = multi_srt.claims(results)
    assert claim_on(found, "scattered", "until all are home").verdict == "holds"
    assert claim_on(found, "scattered", "knows the map complete").verdict == "not significant"
    # Each has a table of its comparisons.
    titles = [table.title for table in multi_srt.tables(results) if "scattered" in table.title]
    assert [
        title.endswith(f"{time.heading}, medians")
        for title, time in zip(titles, TIMES, strict=True)
    ] == [True, True]


def test_a_run_that_was_given_up_is_in_the_grounds():
    def values(at: Condition, repetition: int) -> dict[str, object] | None:
        lost = repetition == 1 and at.robots == 4 and at.strategy == "srt-star"
        return None if lost else srt()(at, repetition)

    claim = claim_on(multi_srt.claims(results_of(QUICK_SRT, values)), "completed")
    assert claim.verdict == "does not hold"
    assert "352 of 360 runs are complete" in claim.grounds[0]
    assert "repetition 1: over time: beyond 900 s" in claim.grounds[1]


def test_table_of_multi_srt_by_team_size():
    results = results_of(QUICK_SRT, lambda at, k: {"makespan_s": 100.0 * at.robots + k})
    table = multi_srt.tables(results)[0]
    assert table.columns[-3:] == ("1 robot", "2 robots", "4 robots")
    assert len(table.rows) == 2 * 2 * (1 + 4)
    # Repetitions 0 to 9.
    assert table.rows[0] == ("garden", "srt-star", "", "", "104.5 (104.5 ± 3.0)", "", "")
    assert table.rows[1][-2:] == ("204.5 (204.5 ± 3.0)", "404.5 (404.5 ± 3.0)")
    assert all(len(row) == len(table.columns) for row in table.rows)
