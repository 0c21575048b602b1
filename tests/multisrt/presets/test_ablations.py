import dataclasses
from collections.abc import Sequence

import msgspec
import pytest

from benchmarks.published import RESULTS
from multisrt.experiments.crossing import Condition, conditions, runs
from multisrt.experiments.measures import measure_named
from multisrt.experiments.spec import Block, Only, StrategyChoice
from multisrt.presets import PRESETS, multi_srt
from multisrt.presets.ablations import Ablation, Ablations, Topic
from multisrt.presets.cells import Cells
from multisrt.reporting.claims import PrintedTable
from tests.multisrt.presets.constructed import SOME, no_results, results_of

MEASURES = (measure_named("makespan_s"), measure_named("coverage"))
GAPS = Topic(title="gaps", measures=MEASURES, claims=("Snails are fast.",))
OTHERS = Topic(title="others", measures=MEASURES)


def ablation(topic: Topic, change: str, robots: tuple[int, ...]) -> Ablation:
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
    )


TWO = Ablations(
    changes=(ablation(GAPS, "no gaps", (1, 4)), ablation(OTHERS, "none", (4,))),
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


def test_conditions_are_in_pairs():
    alone, team = TWO.changes[0].pairs(SPEC)
    assert [(one.strategy, one.robots) for one in (*alone, *team)] == [
        *(("srt-star", 1), ("no gaps", 1)),
        *(("srt-star", 4), ("no gaps", 4)),
    ]
    # Conditions that the experiment leaves out are not left out of ablations.
    without = msgspec.structs.replace(SPEC, exclude=(Only(robots=1),))
    assert len(TWO.changes[0].pairs(without)) == 2


def test_tables_of_the_presets_own_come_first():
    def own(cells: Cells, changes: Sequence[Ablation]) -> list[PrintedTable]:
        runs = sum(len(cells.of(after)) for one in changes for _, after in one.pairs(SPEC))
        return [PrintedTable(title="own", source="", columns=("runs",), rows=((str(runs),),))]

    with_own = dataclasses.replace(TWO, own_tables=own)
    tables = with_own.tables(results_of(SPEC, lambda at, k: {}))
    assert [table.title for table in tables] == ["own", "gaps", "others"]
    # Three conditions with a change.
    assert tables[0].rows == ((str(3 * 6),),)


def test_a_quick_experiment_may_have_fewer_ablations():
    slow = dataclasses.replace(TWO.changes[1], is_quick=False)
    some = dataclasses.replace(TWO, changes=(TWO.changes[0], slow))
    quick, whole = (some.experiment(multi_srt.experiment(q), quick=q) for q in (True, False))
    assert {at.strategy for at in conditions(quick)} == {"srt-star", "no gaps"}
    assert {at.strategy for at in conditions(whole)} == {"srt-star", "no gaps", "none"}
    assert some.made_in(quick).changes == some.changes[:1]
    assert some.made_in(whole).changes == some.changes
    assert [table.title for table in some.tables(no_results(quick))] == ["gaps"]


def test_claims_of_which_ablations_ask_why():
    assert [one.change for one in TWO.asking_why("Snails are fast.")] == ["no gaps"]
    assert TWO.asking_why("Hares are fast.") == []


def ablations_of(name: str) -> Ablations:
    found = PRESETS[name].ablations
    assert found is not None
    return found


@pytest.mark.parametrize("name", PRESETS)
def test_ablations_of_presets_can_be_run_and_shown(name):
    preset, ablations = PRESETS[name], ablations_of(name)
    whole = ablations.experiment(preset.experiment(False), quick=False)
    spec = msgspec.structs.replace(whole, repetitions=6)
    tables = ablations.tables(results_of(spec, SOME[name]))
    assert sum(len(table.rows) for table in tables) >= len(ablations.changes)
    assert all(len(row) == len(table.columns) for table in tables for row in table.rows)
    assert ablations.tables(no_results(spec))
    # Six pairs can be significant, five cannot.
    assert ablations.quick_repetitions >= 6
    for one in ablations.changes:
        # Each change changes something: its conditions are not those without it.
        pairs = one.pairs(spec)
        assert not {before for before, _ in pairs} & {after for _, after in pairs}
        # What it is compared with is what the claims are judged by, perhaps with a setting that
        # both sides have changed. (A single robot of Multi-SRT has starts of the name "scattered"
        # there.)
        teams = {before for before, _ in pairs if before.robots > 1}
        plain = {msgspec.structs.replace(at, strategy=at.strategy.split(",")[0]) for at in teams}
        assert plain <= {*conditions(preset.experiment(False))}


@pytest.mark.parametrize("name", PRESETS)
def test_what_ablations_are_said_to_be_about_is_there(name):
    preset, ablations = PRESETS[name], ablations_of(name)
    texts = {claim.text for claim in preset.claims(no_results(preset.experiment(False)))}
    assert {text for one in ablations.changes for text in one.topic.claims} <= texts
    changes = {one.change for one in ablations.changes}
    assert {change for one in preset.deviations for change in one.ablations} <= changes
    assert any(one.ablations for one in preset.deviations)
    # A claim of which some ablation asks why has two of them.
    for text in texts:
        assert len({one.change for one in ablations.asking_why(text)}) != 1


OPTIONS_CHANGED = {
    "sbx-r": {
        "forgets after 15 s": {"lost_after_s"},
        "twice the radius of cohesion": {"phi_factor"},
        "no stop signals": {"stop_signals"},
        "chooses when nothing is left": {"replan"},
        "to the cell, march": {"reached", "paths"},
        "follows its path": {"drive"},
        "areas overlap up to two ranges": {"overlap_ranges"},
        "beta of 10": {"beta"},
        "self-bidding in the place of closest": {"strategy"},
        "self-bidding in the place of utility": {"strategy"},
        "self-bidding in the place of utility, forgets after 15 s": {"strategy"},
        "self-bidding in the place of utility, twice the radius of cohesion": {"strategy"},
    },
    "alvarez": {
        "swaps by sums": {"exchange_when"},
        "no swaps": {"exchange"},
        "fine cells": {"cell_m"},
        "starts drawn uniformly": {"starts"},
        "no random goals": {"random_goal_after"},
        "waits without end": {"patience"},
    },
    "minpos": {
        "a scan and a choice at every step": {"sense_period_s"},
        "goals kept until nothing is left to be seen there": {"replan"},
        "goals kept until they are reached, as by Yamauchi": {"replan"},
        "a scan at every step, goals kept until they are reached": {"sense_period_s", "replan"},
        "bodies of 1 m, of which two cannot pass in a corridor": {"body"},
        "starts far apart": {"starts"},
    },
}


@pytest.mark.parametrize("name", OPTIONS_CHANGED)
def test_ablations_change_what_they_name_and_nothing_else(name):
    ablations = ablations_of(name)
    spec = ablations.experiment(PRESETS[name].experiment(False), quick=False)
    specs = {run.condition: run.spec for run in runs(msgspec.structs.replace(spec, repetitions=1))}
    changed: dict[str, set[str]] = {}
    for one in ablations.changes:
        for before, after in one.pairs(spec):
            ours, theirs = specs[before], specs[after]
            assert ours.environment == theirs.environment
            assert len(ours.robots) == len(theirs.robots)
            options = {*ours.options, *theirs.options}
            if ours.strategy != theirs.strategy:
                options = {*ours.options} & {*theirs.options}
            differ = {o for o in options if ours.options.get(o) != theirs.options.get(o)}
            differ |= {"strategy"} if ours.strategy != theirs.strategy else set()
            differ |= {what for what in ("body", "starts") if _of(before, what) != _of(after, what)}
            assert changed.setdefault(one.change, differ) == differ
    assert changed == OPTIONS_CHANGED[name]


def _of(at: Condition, what: str) -> str:
    return at.body if what == "body" else at.starts


# A claim that does not hold on a page has two ablations that ask why.
@pytest.mark.parametrize("name", PRESETS)
def test_claims_that_do_not_hold_are_looked_into(name, load_module):
    verdicts = load_module(RESULTS.parent / "verdicts.py")
    page = (RESULTS / f"{name}.md").read_text("utf-8")
    claims = verdicts.claims_of(page)
    assert claims
    now = {claim.text for claim in PRESETS[name].claims(no_results(PRESETS[name].experiment(True)))}
    for text, verdict, _ in claims:
        # Pages of an earlier experiment may have claims that are now worded in another way.
        if verdict == "does not hold" and text in now:
            assert len({one.change for one in ablations_of(name).asking_why(text)}) >= 2, text
