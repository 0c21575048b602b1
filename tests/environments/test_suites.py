"""Suites: ninety worlds that are the same everywhere, by name in runs and experiments."""

import re
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

import multisrt as ms
from multisrt import suites
from multisrt.environments.catalog import environment
from multisrt.environments.suites import loading
from multisrt.experiments.crossing import conditions, runs
from multisrt.experiments.spec import EnvironmentChoice, ExperimentSpec
from multisrt.geometry.errors import InvalidInputError
from multisrt.simulation.worlds import build_environment, environment_spec

ROOT = Path(__file__).parents[2]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of suites instead of that of the package."""
    monkeypatch.setattr(loading, "FILES", tmp_path)
    for cached in (suites.names, suites.load):
        cached.cache_clear()
    yield tmp_path
    for cached in (suites.names, suites.load):
        cached.cache_clear()


@pytest.mark.slow
@pytest.mark.parametrize("name", suites.names())
def test_all_worlds_have_the_digests_of_the_suite(name):
    suite = suites.load(name)
    worlds = list(suite)
    assert [world.name for world in worlds] == list(suite.world_names)
    assert len({world.digest for world in worlds}) == len(suite) == 30
    assert all(len(world.free.geoms) == 1 and world.starts for world in worlds)
    assert all(200.0 < world.area_m2 < 6000.0 for world in worlds)


@pytest.mark.parametrize("name", suites.names())
def test_the_worlds_of_a_suite_differ_in_kind_and_difficulty(name):
    entries = suites.load(name).entries
    assert 2 <= len({entry.generator for entry in entries}) <= 5
    for kind in {entry.generator for entry in entries}:
        shares = [e.parameters["difficulty"] for e in entries if e.generator == kind]
        assert min(shares) < 0.15
        assert max(shares) > 0.85


def test_worlds_are_kept_apart_from_all_else():
    seeds = [entry.seed for name in suites.names() for entry in suites.load(name).entries]
    assert len(set(seeds)) == 90
    assert all(731_000 <= seed < 732_000 for seed in seeds)
    texts = [
        path
        for folder in ("examples", "tests", "docs", "benchmarks", "multisrt", "environments")
        for path in (ROOT / folder).rglob("*")
        if path.suffix in (".py", ".md", ".toml", ".ipynb")
        and path.parent.name != "suites"
        and path.name != "test_suites.py"
        and path.name != "suites.md"
    ]
    found = [path for path in texts if re.search(r"\b731_?\d{3}\b", path.read_text())]
    assert not found


def test_a_suite_is_a_sequence_of_worlds():
    mazes = suites.load("mazes-30")
    assert len(mazes) == 30
    assert mazes[1].name == "mazes-30/01"
    assert mazes[-1] == mazes[29] == suites.world("mazes-30/29")
    assert mazes[1].origin.startswith("dungeon(")
    assert next(iter(mazes)) == mazes[0]
    with pytest.raises(IndexError):
        mazes[30]


def test_another_process_builds_the_same_world():
    code = "from multisrt import suites; print(suites.world('outdoor-30/04').digest)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == suites.world("outdoor-30/04").digest


def test_names_load_no_geometry():
    code = (
        "import sys; from multisrt import suites; suites.load(suites.names()[0]).world_names\n"
        "print([name for name in ('shapely', 'numpy', 'numba') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_world_with_another_digest_is_refused(folder):
    hall = environment("open", size_m=8)
    wrong = suites.digest_of(environment("open", size_m=9))
    (folder / "own-2.toml").write_text(
        'version = 4\nabout = "halls"\n'
        + "".join(
            f'[[worlds]]\ngenerator = "open"\nseed = 0\nparameters = {{ size_m = 8 }}\n'
            f'digest = "{digest}"\n'
            for digest in (suites.digest_of(hall), wrong)
        )
    )
    assert suites.names() == ("own-2",)
    assert suites.world("own-2/00").digest == hall.digest
    with pytest.raises(
        InvalidInputError, match=r"own-2/01 is not the world of version 4"
    ) as caught:
        suites.world("own-2/01")
    assert wrong[:12] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_starts_count_for_the_digest():
    hall = environment("open", size_m=8)
    moved = ms.Environment(hall.name, hall.free, starts=[(1.0, 1.0)])
    assert hall.digest == moved.digest
    assert suites.digest_of(hall) != suites.digest_of(moved)


def test_wrong_names_and_versions_are_refused():
    with pytest.raises(InvalidInputError, match="did you mean 'indoor-30'"):
        suites.load("indoor-3")
    with pytest.raises(InvalidInputError, match="indoor-30/00 to indoor-30/29"):
        suites.world("indoor-30/7")
    with pytest.raises(InvalidInputError, match="version 1 in this release, and version 2"):
        suites.world("indoor-30/07", version=2)
    with pytest.raises(InvalidInputError, match="has no world 'mazes-30/30'"):
        environment_spec("mazes-30/30")
    with pytest.raises(InvalidInputError, match="'mazes-30' is a suite of 30 worlds"):
        environment_spec("mazes-30")
    with pytest.raises(InvalidInputError, match="suites are: indoor-30, mazes-30, outdoor-30"):
        environment_spec("nowhere")
    with pytest.raises(InvalidInputError, match="of the suite: a resolution"):
        environment_spec("mazes-30/00", resolution_m=0.1)


def test_specs_name_the_world_and_the_version():
    where = environment_spec("mazes-30/12")
    assert where == ms.SuiteEnvironment(name="mazes-30/12", version=1)
    assert build_environment(where) == suites.world("mazes-30/12")
    spec = ms.RunSpec(environment=where, seed=1)
    assert ms.RunSpec.from_toml(spec.to_toml()) == spec
    assert 'from = "suite"' in spec.to_toml()
    assert "version = 1" in spec.to_toml()


def test_a_run_in_a_world_of_a_suite_repeats_itself():
    run = ms.explore("mazes-30/12", seed=1, max_time_s=20.0)
    assert run.environment.name == "mazes-30/12"
    assert ms.explore(run.spec).digest == run.digest


def spec_of(*environments):
    return ExperimentSpec(
        name="x", environments=environments, strategies=("minpos",), repetitions=1
    )


def test_an_experiment_in_a_suite_has_a_condition_for_each_world():
    own = conditions(spec_of("mazes-30", "open"))
    assert [one.environment for one in own] == [*suites.load("mazes-30").world_names, "open"]
    labelled = EnvironmentChoice(name="mazes-30", label="mazes")
    assert conditions(spec_of(labelled))[3].environment == "mazes/03"
    assert conditions(spec_of("mazes-30/03"))[0].environment == "mazes-30/03"


def test_planned_runs_name_the_world(tmp_path):
    (tmp_path / "mazes-30").mkdir()
    (planned,) = runs(spec_of("mazes-30/03"), tmp_path)
    assert planned.spec.environment == ms.SuiteEnvironment(name="mazes-30/03", version=1)
    assert len(runs(spec_of("mazes-30"))) == 30


@pytest.mark.parametrize("field", [{"seed": 3}, {"parameters": {"cells": 4}}, {"seeds": "0-2"}])
def test_worlds_of_a_suite_take_no_parameters(field):
    choice = msgspec.convert({"name": "mazes-30/03"} | field, EnvironmentChoice)
    with pytest.raises(InvalidInputError, match="'mazes-30/03' is of a suite: parameters and"):
        runs(spec_of(choice))
