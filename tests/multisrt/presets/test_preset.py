import dataclasses
from pathlib import Path

import msgspec
import pytest

from multisrt.experiments.crossing import PlannedRun, conditions, runs
from multisrt.experiments.spec import EnvironmentChoice, ExperimentSpec
from multisrt.geometry.errors import InvalidInputError
from multisrt.presets import PRESETS, preset_named
from multisrt.spec import CatalogEnvironment, InlineEnvironment
from tests.multisrt.presets.constructed import SOME, results_of


# By hand. Multi-SRT: 2 worlds, 2 strategies; alone once, else 2 starts and 2 radios for each of 4
# sizes (quick: 2). SBX-R: alone once, else 3 strategies, 3 radios, 4 sizes (1). MinPos: 2 worlds, 3
# strategies and 4 sizes (2). Álvarez: 10 maps of 8 sizes (3 of 3).
@pytest.mark.parametrize(
    ("name", "quick", "cells", "repetitions"),
    [
        ("multi-srt", False, 2 * 2 * (1 + 4 * 2 * 2), 20),
        ("multi-srt", True, 2 * 2 * (1 + 2 * 2 * 2), 10),
        ("sbx-r", False, 1 + 3 * 3 * 4, 31),
        ("sbx-r", True, 1 + 3 * 3 * 1, 6),
        ("minpos", False, 2 * 3 * 4, 40),
        ("minpos", True, 2 * 3 * 2, 8),
        ("alvarez", False, 10 * 8, 20),
        ("alvarez", True, 3 * 3, 7),
    ],
)
def test_an_experiment_has_the_runs_of_its_paper(name, quick, cells, repetitions):
    spec = PRESETS[name].experiment(quick)
    assert len(conditions(spec)) == cells
    assert spec.repetitions == repetitions
    assert min(at.robots for at in conditions(spec)) == (2 if name == "minpos" else 1)


def two_runs_each(name: str, quick: bool = True) -> list[PlannedRun]:
    spec = PRESETS[name].experiment(quick)
    return runs(msgspec.structs.replace(spec, repetitions=2))


@pytest.mark.parametrize("name", PRESETS)
def test_every_run_can_be_planned(name):
    spec = PRESETS[name].experiment(True)
    assert len(two_runs_each(name)) == 2 * len(conditions(spec))
    assert ExperimentSpec.from_toml(spec.to_toml()) == spec


@pytest.mark.parametrize("name", PRESETS)
def test_quick_runs_are_some_of_the_full_ones(name):
    full, quick = (PRESETS[name].experiment(q) for q in (False, True))
    assert set(conditions(quick)) < set(conditions(full))
    assert quick.repetitions < full.repetitions


def test_all_strategies_meet_the_same_worlds_and_starts():
    met: dict[tuple[int, str, int], set[tuple[bytes, object]]] = {}
    for run in two_runs_each("minpos"):
        at = run.condition
        world = (msgspec.json.encode(run.spec.environment), run.spec.robots[0].start)
        met.setdefault((run.repetition, at.environment, at.robots), set()).add(world)
    assert all(len(same) == 1 for same in met.values())
    mazes = {next(iter(met[k, "maze", 2]))[0] for k in (0, 1)}
    hospitals = {next(iter(met[k, "hospital", 2]))[0] for k in (0, 1)}
    assert (len(mazes), len(hospitals)) == (2, 1)


def test_conditions_are_those_of_the_papers():
    for run in two_runs_each("sbx-r"):
        spec = run.spec
        equal = {
            "replan": "arrival",
            "reached": "sight",
            "paths": "eedt",
            "drive": "nearness-diagram",
        }
        own = {
            "closest": {},
            "utility": {"overlap_ranges": 1.0},
            "self-bidding": {"lost_after_s": 14_400.0},
        }
        assert spec.options == equal | own[spec.strategy]
        assert spec.radio.range_m in (15.0, 20.0, 30.0)
        assert spec.starts == "clustered"
        assert spec.robots[0].start is not None
        assert isinstance(spec.environment, CatalogEnvironment)
        assert spec.environment.parameters == {"width_m": 50.0, "height_m": 25.0}
        assert spec.robots[0].range_finder.range_m == 4.0
    for run in two_runs_each("minpos"):
        assert {robot.drive.kind for robot in run.spec.robots} == {"holonomic"}
        assert {robot.footprint for robot in run.spec.robots} == {"disc:0.2"}
        assert run.spec.options["cell_m"] == 0.3
        assert run.spec.radio.range_m is None
    for run in two_runs_each("alvarez"):
        assert run.spec.strategy == "rules"
        assert run.spec.starts == "scattered"
        assert {robot.range_finder.range_m for robot in run.spec.robots} == {4.5}
        assert {robot.drive.speed_m_s for robot in run.spec.robots} == {0.1}
        assert {robot.footprint for robot in run.spec.robots} == {"disc:0.335"}
        assert run.spec.options["cell_m"] == run.spec.options["search_cell_m"] == 0.5
        assert run.spec.options["exchange_when"] == "nearer"
    for run in two_runs_each("multi-srt"):
        assert all(robot.start is None for robot in run.spec.robots)


def test_a_preset_takes_another_map(tmp_path):
    path = tmp_path / "hall.wkt"
    path.write_text("POLYGON ((0 0, 20 0, 20 12, 0 12, 0 0))")
    preset = PRESETS["sbx-r"].with_map(path)
    for quick in (False, True):
        spec = preset.experiment(quick)
        assert {at.environment for at in conditions(spec)} == {"hall"}
        own = PRESETS["sbx-r"].experiment(quick)
        assert len(conditions(spec)) == len(conditions(own))
        assert spec.name == f"{own.name} on hall"
    (world,) = {run.spec.environment for run in runs(preset.experiment(True))}
    assert isinstance(world, InlineEnvironment)
    assert world.name == "hall"
    assert preset.deviations[0].text == "World: the map hall.wkt, in the place of office."
    assert sum(one.text.startswith("World:") for one in preset.deviations) == 1
    with_team = PRESETS["sbx-r"].with_map(Path("plans/plan.png"), 0.05, "teams/team.txt")
    (choice,) = with_team.experiment(True).environments
    assert isinstance(choice, EnvironmentChoice)
    assert (choice.resolution_m, choice.starts_from) == (0.05, "teams/team.txt")
    other = dataclasses.replace(preset, on_map=None)
    with pytest.raises(InvalidInputError, match="cannot be run on another map; leave out --map"):
        other.with_map(path)


def test_presets_have_names():
    assert {name: preset.name for name, preset in PRESETS.items()} == {n: n for n in PRESETS}
    with pytest.raises(InvalidInputError, match="did you mean 'sbx-r'"):
        preset_named("sbxr")


ON_MAPS = [name for name, preset in PRESETS.items() if preset.on_map is not None]


@pytest.mark.parametrize(
    ("name", "label", "worlds"), [("minpos", "hospital", 2), ("alvarez", "floor", 1)]
)
def test_a_map_stands_for_the_hospital_or_for_all_maps(name, label, worlds):
    preset = PRESETS[name]
    with_map = preset.with_map(Path("plans/floor.wkt"))
    given = with_map.experiment(False)
    chosen = [one for one in given.environments if isinstance(one, EnvironmentChoice)]
    (choice,) = [one for one in chosen if one.label == label]
    assert choice.name == "plans/floor.wkt"
    assert len({at.environment for at in conditions(given)}) == worlds
    # The same team sizes as in the experiment.
    sizes = {at.robots for at in conditions(preset.experiment(False))}
    assert {at.robots for at in conditions(given) if at.environment == label} == sizes
    assert any("the map floor.wkt" in one.text for one in with_map.deviations)
    assert not any("generated hospital" in one.text for one in with_map.deviations)


def test_ablations_in_worlds_of_their_own_are_left_out_on_a_map():
    kept = {name: PRESETS[name].with_map(Path("floor.wkt")).ablations for name in ON_MAPS}
    assert {name for name in kept if kept[name] is not None} == {"sbx-r", "minpos"}
    in_mazes = kept["minpos"]
    assert in_mazes is not None
    assert {one.topic.title.split(": ")[1] for one in in_mazes.changes} == {
        *("maze, 4 robots", "maze, 12 robots")
    }
    ablations, preset = kept["sbx-r"], PRESETS["sbx-r"].with_map(Path("floor.wkt"))
    assert ablations is not None
    spec = ablations.experiment(preset.experiment(True), quick=True)
    assert {at.environment for at in conditions(spec)} == {"floor"}


def test_claims_are_judged_on_a_map_of_ones_own():
    by_name = {name: PRESETS[name].with_map(Path("floor.wkt")) for name in ("minpos", "alvarez")}
    verdicts = {
        name: [
            claim.verdict
            for claim in preset.claims(results_of(preset.experiment(False), SOME[name]))
        ]
        for name, preset in by_name.items()
    }
    assert "not tested" not in verdicts["minpos"]
    # The thesis prints no exponents for this map.
    assert [k for k, verdict in enumerate(verdicts["alvarez"]) if verdict == "not tested"] == [1, 2]
