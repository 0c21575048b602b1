import msgspec
import pytest

from multisrt.experiments.crossing import Condition, conditions
from multisrt.experiments.measures import measure_named
from multisrt.experiments.spec import Block, StrategyChoice
from multisrt.presets import PRESETS, multi_srt
from multisrt.presets.ablations import Ablation, Ablations
from tests.multisrt.presets.constructed import no_results, results_of

WITH_ABLATIONS = [name for name, preset in PRESETS.items() if preset.ablations is not None]


def ablation(topic: str, change: str, robots: tuple[int, ...]) -> Ablation:
    base = Block(
        environments=("garden",),
        strategies=("srt-star",),
        robots=robots,
        starts=("scattered",),
        radios=("unlimited",),
    )
    named = StrategyChoice(name="srt-star", label=change, options={"gaps_count": False})
    return Ablation(
        topic=topic,
        change=change,
        base=base,
        changed=msgspec.structs.replace(base, strategies=(named,)),
        measures=(measure_named("makespan_s"), measure_named("coverage")),
    )


TWO = Ablations(
    changes=(ablation("gaps", "no gaps", (1, 4)), ablation("others", "none", (4,))),
    repetitions=8,
    quick_repetitions=6,
)
SPEC = TWO.experiment(multi_srt.experiment(True), quick=True)


def test_conditions_that_ablations_share_are_run_once():
    assert [(at.strategy, at.robots) for at in conditions(SPEC)] == [
        ("srt-star", 1),
        ("srt-star", 4),
        ("no gaps", 1),
        ("no gaps", 4),
        ("none", 4),
    ]
    assert (SPEC.name, SPEC.repetitions) == ("multi-srt ablations quick", 6)
    whole = TWO.experiment(multi_srt.experiment(False), quick=False)
    assert (whole.name, whole.repetitions) == ("multi-srt ablations", 8)


def test_a_table_has_a_row_for_each_change_and_condition():
    def values(at: Condition, repetition: int) -> dict[str, object] | None:
        if at.strategy == "no gaps":
            # A tenth less each time: 2 of the 64 vectors of signs are as extreme.
            if at.robots == 1:
                return {"makespan_s": 90.0 + 9.0 * repetition, "coverage": 1.0}
            return None
        return {"makespan_s": 100.0 + 10.0 * repetition, "coverage": 1.0}

    gaps, others = TWO.tables(results_of(SPEC, values))
    assert (gaps.title, others.title) == ("gaps", "others")
    assert gaps.columns == (
        "change",
        "where",
        "pairs",
        "successful",
        "Time until all are done (s)",
        "Coverage",
    )
    alone, team = gaps.rows
    assert alone == (
        "no gaps",
        "garden, srt-star, 1 robot",
        "6",
        "6 of 6 → 6 of 6",
        "125.0 → 112.5 (-10 %, p 0.031)",
        "1.0000 → 1.0000 (+0 %, p 1.000)",
    )
    assert team[1:4] == (
        "garden, srt-star, 4 robots, scattered, unlimited radio",
        "6",
        "6 of 6 → 0 of 6",
    )
    assert team[4] == "125.0 → incomplete (p 0.031)"
    assert others.rows[0][4] == "125.0 → 125.0 (+0 %, p 1.000)"


def test_tables_of_an_experiment_that_has_not_begun():
    gaps, others = TWO.tables(no_results(SPEC))
    assert len(gaps.rows) == 2
    assert {row[2:] for row in (*gaps.rows, *others.rows)} == {("0", "- → -", "-", "-")}


def test_figures_of_unsuccessful_runs_are_shown():
    tables = TWO.tables(results_of(SPEC, lambda at, k: {"makespan_s": 7.0, "coverage": 0.5}))
    assert tables[0].rows[0][3:5] == ("0 of 6 → 0 of 6", "7.0 → 7.0 (+0 %, p 1.000)")


@pytest.mark.parametrize("name", WITH_ABLATIONS)
def test_ablations_of_presets_can_be_run_and_shown(name):
    preset = PRESETS[name]
    assert preset.ablations is not None
    spec = preset.ablations.experiment(preset.experiment(True), quick=True)
    tables = preset.ablations.tables(results_of(spec, lambda at, k: {"makespan_s": 9.0 + k}))
    assert sum(len(table.rows) for table in tables) >= len(preset.ablations.changes)
    assert all(len(row) == len(table.columns) for table in tables for row in table.rows)
    # Six pairs can be significant, five cannot.
    assert preset.ablations.quick_repetitions >= 6
    # Each change changes something: its conditions are not those without it.
    for one in preset.ablations.changes:
        before, after = (
            conditions(msgspec.structs.replace(spec, blocks=(block,)))
            for block in (one.base, one.changed)
        )
        assert len(before) == len(after)
        assert not set(before) & set(after)
