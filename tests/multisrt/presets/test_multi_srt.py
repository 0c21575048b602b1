import msgspec

from multisrt.experiments.crossing import Condition
from multisrt.experiments.results import Results
from multisrt.presets import multi_srt
from multisrt.presets.multi_srt_ablations import ABLATIONS, NONE_SUPPORTED, PAPERS_PLANNER_ALONE
from multisrt.presets.multi_srt_claims import (
    DISTANCE_GROWS,
    NOT_IN_EVERY_STEP,
    TIME,
    TIME_FALLS,
    TIMES,
)
from multisrt.presets.summary import summary
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
    assert found[-1].would_show == "a collision in 0.45 % of runs would have been detected"
    assert all(claim.would_show for claim in found)
    # 2 worlds, 2 strategies, 2 radios; from 1 to 2 and from 2 to 4 robots.
    for claim in found[:2]:
        assert "in 16 of 16 cells, significantly by itself in 16" in claim.grounds[1]
    # 2 worlds, 2 strategies, 2 starts; from 1 to 2 and from 2 to 4 robots.
    for claim in found[4:6]:
        assert "in 16 of 16 cells, significantly by itself in 16" in claim.grounds[1]
    # 2 worlds; alone, and 2 sizes, 2 starts, 2 radios.
    for claim in found[6:9]:
        assert "in 18 of 18 cells, significantly by itself in 18" in claim.grounds[1]


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
    scattered = claim_on(found, "scattered", "until all are done")
    assert scattered.verdict == "does not hold"
    assert any("garden, srt-star, 15 m radio, 2 to 4 robots" in line for line in scattered.grounds)
    assert claim_on(found, "clustered", "until all are done").verdict == "does not hold"
    for text in DISTANCE_GROWS.values():
        assert claim_on(found, text).verdict == "does not hold"
    assert claim_on(found, "shorter total distance").verdict == "does not hold"


def test_the_distance_is_judged_by_radio():
    def values(at: Condition, repetition: int) -> dict[str, object]:
        grows = at.radio == "unlimited"
        return srt(distance=lambda at: 500.0 + (50.0 if grows else -50.0) * at.robots)(
            at, repetition
        ) | ({"total_distance_m": 500.0 + repetition} if at.robots == 1 else {})

    found = multi_srt.claims(results_of(QUICK_SRT, values))
    unlimited, limited = (claim_on(found, text) for text in DISTANCE_GROWS.values())
    assert (unlimited.verdict, limited.verdict) == ("holds", "does not hold")
    lines = [line for line in limited.grounds if "robots: median" in line]
    assert lines
    assert all("15 m radio" in line for line in lines)
    assert "only used when an unlimited communication range is handled" in unlimited.source
    # Scattered and clustered starts are told apart.
    parts = unlimited.grounds[0].split("\n  - ")[1:]
    assert [part.split(":")[0] for part in parts] == [
        *("scattered starts, 1 to 2 robots", "scattered starts, larger teams"),
        *("clustered starts, 1 to 2 robots", "clustered starts, larger teams"),
    ]


def ablated(coverage: float) -> Results:
    """Return results of the ablations in which larger teams take longer by the paper's planner."""

    def values(at: Condition, repetition: int) -> dict[str, object]:
        if not at.strategy.endswith(PAPERS_PLANNER_ALONE):
            return srt()(at, repetition)
        return {
            "makespan_s": 1000.0 + 100.0 * at.robots + repetition,
            "total_distance_m": 1000.0 / at.robots + repetition,
            "known_complete_s": None,
            "coverage": coverage,
        }

    return results_of(ABLATIONS.experiment(multi_srt.experiment(False), quick=False), values)


def test_claims_are_judged_by_the_papers_planner_as_well():
    # Runs count that cover less than a success.
    for coverage in (1.0, 0.8):
        beside = ABLATIONS.verdicts_beside(ablated(coverage))
        verdicts = {
            text: [(change, claim.verdict) for change, claim in judged]
            for text, judged in beside.items()
        }
        assert verdicts == {
            TIME_FALLS[TIME]: [(PAPERS_PLANNER_ALONE, "does not hold")],
            NOT_IN_EVERY_STEP[TIME]: [(PAPERS_PLANNER_ALONE, "holds")],
            DISTANCE_GROWS["unlimited"]: [
                (PAPERS_PLANNER_ALONE, "does not hold"),
                (NONE_SUPPORTED, "holds"),
            ],
        }
        ((_, clustered),) = beside[NOT_IN_EVERY_STEP[TIME]]
        # From 1 to 2, 4, 8 and 16 robots.
        assert "in 4 of 4 cells, significantly by itself in 4" in clustered.grounds[0]


def test_verdicts_by_the_papers_planner_are_beside_those_of_the_experiment():
    results = results_of(QUICK_SRT, srt())
    claims = multi_srt.claims(results)
    text = summary(
        multi_srt.MULTI_SRT, results, "it", claims=claims, tables=[], ablations=ablated(0.8)
    )
    claim = claim_on(claims, NOT_IN_EVERY_STEP[TIME])
    assert claim.verdict == "does not hold"
    row = (
        f"| {claim.text} | does not hold (the paper's planner alone: holds) | {claim.would_show} |"
    )
    assert row in text
    section = text.split(f"### {claim.text}")[1].split("\n### ")[0]
    assert "- by the ablation “the paper's planner alone”, over all runs" in section
    assert (
        "\n  - garden, srt-radial, the paper's planner alone, unlimited radio, 8 to 16" in section
    )


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
    assert [claim.verdict for claim in found[:9]] == ["inconclusive"] * 9


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
    assert claim_on(found, "scattered", "until all are done").verdict == "holds"
    assert claim_on(found, "scattered", "map is complete").verdict == "inconclusive"
    # Each has a table of its comparisons.
    titles = [table.title for table in multi_srt.tables(results) if "scattered" in table.title]
    assert [
        title.endswith(f"{time.heading}, medians")
        for title, time in zip(titles, TIMES, strict=True)
    ] == [True, True]


def test_table_of_multi_srt_by_team_size():
    results = results_of(QUICK_SRT, lambda at, k: {"makespan_s": 100.0 * at.robots + k})
    table = multi_srt.tables(results)[0]
    assert table.columns[-3:] == ("1 robot", "2 robots", "4 robots")
    assert len(table.rows) == 2 * 2 * (1 + 4)
    # Repetitions 0 to 9.
    assert table.rows[0] == ("garden", "srt-star", "", "", "104.5 (104.5 ± 3.0)", "", "")
    assert table.rows[1][-2:] == ("204.5 (204.5 ± 3.0)", "404.5 (404.5 ± 3.0)")
    assert all(len(row) == len(table.columns) for row in table.rows)
