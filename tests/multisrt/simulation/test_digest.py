import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from multisrt.environments.catalog import environment
from multisrt.events import Died, Event, Organized, Sent
from multisrt.recording import Recording
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    DriveSpec,
    FileEnvironment,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

ROOT = Path(__file__).parents[3]

APARTMENT = RunSpec(environment=CatalogEnvironment(name="apartment"), seed=5)
CAVE = RunSpec(
    environment=CatalogEnvironment(name="cave"),
    strategy="srt-star",
    robots=(RobotSpec(footprint="box:0.5x0.3"),),
    seed=6,
)
TEAMS = [
    RunSpec(
        environment=CatalogEnvironment(name="rooms", parameters={"size_m": 16.0}),
        strategy=strategy,
        robots=(RobotSpec(),) * 4,
        starts="clustered",
        radio=RadioSpec(loss=0.2, latency_s=0.5, jitter_s=0.2),
        faults=(Death(robot=1, time_s=20.0, when="moving"),),
        seed=seed,
    )
    for strategy, seed in (("srt-radial", 1), ("srt-star", 2), ("srt-radial", 3))
]

IN_A_PROCESS_OF_ITS_OWN = """
import json, sys
from multisrt.simulation.simulate import simulate
from multisrt.spec import RunSpec
for order, text in enumerate(json.load(sys.stdin)):
    recording = simulate(RunSpec.from_json(text), path=f"{sys.argv[1]}/{order}.jsonl")
    print(recording.footer.digest)
"""

IN_A_POOL = """
import json, sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from multisrt.simulation.simulate import simulate
from multisrt.spec import RunSpec

def digest(text):
    return simulate(RunSpec.from_json(text)).footer.digest

if __name__ == "__main__":
    with ProcessPoolExecutor(int(sys.argv[1]), mp_context=get_context("spawn")) as pool:
        print(*pool.map(digest, json.load(sys.stdin)))
"""


def digests(folder: Path, *specs: RunSpec, hash_seed: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", IN_A_PROCESS_OF_ITS_OWN, str(folder)],
        input=json.dumps([spec.to_json() for spec in specs]),
        env=os.environ | {"PYTHONHASHSEED": hash_seed},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


def test_equal_specs_give_equal_bytes_in_one_process(tmp_path):
    runs = [simulate(APARTMENT, path=tmp_path / f"{k}.jsonl") for k in range(2)]
    assert runs[0].footer.digest == runs[1].footer.digest
    assert (tmp_path / "0.jsonl").read_bytes() == (tmp_path / "1.jsonl").read_bytes()


@pytest.mark.slow
def test_equal_specs_give_equal_bytes_in_any_process_and_order(tmp_path):
    here = simulate(APARTMENT), simulate(CAVE)
    folders = tmp_path / "forwards", tmp_path / "backwards"
    for folder in folders:
        folder.mkdir()
    forwards = digests(folders[0], APARTMENT, CAVE, hash_seed="0")
    backwards = digests(folders[1], CAVE, APARTMENT, hash_seed="4242")
    assert forwards == backwards[::-1] == [run.footer.digest for run in here]
    for k, run in enumerate(here):
        run.save(tmp_path / "here.jsonl")
        bytes_here = (tmp_path / "here.jsonl").read_bytes()
        assert (folders[0] / f"{k}.jsonl").read_bytes() == bytes_here
        assert (folders[1] / f"{1 - k}.jsonl").read_bytes() == bytes_here


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["srt-star", "srt-radial", "minpos", "self-bidding"])
def test_whole_and_fractional_numbers_give_equal_bytes(strategy):
    def spec(number):
        seeing = RangeFinderSpec(range_m=number(4))
        body = RobotSpec(range_finder=seeing, drive=DriveSpec(speed_m_s=number(1)))
        return RunSpec(
            environment=CatalogEnvironment(name="open"),
            strategy=strategy,
            robots=(msgspec.structs.replace(body, start=(number(3), number(3))), body),
            radio=RadioSpec(range_m=number(20), latency_s=number(0)),
            stop=StopRule(max_time_s=number(60)),
        )

    assert spec(int) == spec(float)
    assert simulate(spec(int)).footer.digest == simulate(spec(float)).footer.digest


@pytest.fixture(scope="module")
def teams():
    """The runs of `TEAMS`, made in this process; each has the events that it is there for."""
    runs = [simulate(spec) for spec in TEAMS]
    for run in runs:
        assert [event.robot for event in run.events if isinstance(event, Died)] == [1]
        assert any(isinstance(event, Organized) for event in run.events)
        sent = [event for event in run.events if isinstance(event, Sent)]
        assert any(len(event.reached) < 3 for event in sent if event.time_s < 20.0)
    assert len({run.footer.digest for run in runs}) == len(TEAMS)
    return runs


@pytest.mark.slow
def test_teams_give_equal_digests_in_a_pool_of_workers(teams, tmp_path):
    # Each process has its own string hashes, and one of the two makes a run after another one.
    order = [2, 0, 1]
    script = tmp_path / "pool.py"
    script.write_text(IN_A_POOL)
    done = subprocess.run(
        [sys.executable, str(script), "2"],
        input=json.dumps([TEAMS[k].to_json() for k in order]),
        env=os.environ | {"PYTHONHASHSEED": "random"},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == [teams[k].footer.digest for k in order]


def test_a_given_world_and_one_built_from_the_spec_are_equal():
    world = environment("apartment")
    assert simulate(APARTMENT, world).footer.digest == simulate(APARTMENT).footer.digest


def test_an_inline_world_is_explored_in_the_same_way():
    world = environment("apartment")
    spec = RunSpec(environment=inline(world), seed=5)
    assert simulate(spec).events == simulate(APARTMENT).events


def test_a_recording_is_the_same_with_a_watcher_and_without():
    seen: list[Event] = []
    assert simulate(APARTMENT, watch=seen.append).footer == simulate(APARTMENT).footer
    assert seen


@pytest.mark.slow
@pytest.mark.parametrize(
    "other",
    [
        {"seed": 6},
        {"strategy": "srt-star"},
        {"options": {"alpha": 0.7}},
        {"robots": (RobotSpec(footprint="disc:0.24"),)},
        {"environment": CatalogEnvironment(name="open")},
    ],
)
def test_another_spec_gives_another_digest(other):
    spec = RunSpec(**{"environment": APARTMENT.environment, "seed": 5} | other)
    assert simulate(spec).footer.digest != simulate(APARTMENT).footer.digest


SHORT = RunSpec(
    environment=CatalogEnvironment(name="open", parameters={"size_m": 8.0}),
    stop=StopRule(max_time_s=5.0),
)


@pytest.mark.parametrize(
    "more",
    [
        {"radio": RadioSpec(loss=float("0"))},
        {"robots": (RobotSpec(range_finder=RangeFinderSpec(range_m=float("4"))),)},
        {"stop": StopRule(max_time_s=5)},
        {"strategy": "-".join(["srt", "radial"])},
    ],
)
def test_equal_specs_give_equal_digests_however_they_were_made(tmp_path, more):
    spec = msgspec.structs.replace(SHORT, **more)
    assert spec == SHORT
    run = simulate(spec, path=tmp_path / "run.jsonl")
    assert run.footer.digest == simulate(SHORT).footer.digest
    assert Recording.load(tmp_path / "run.jsonl").footer == run.footer


def test_a_map_file_that_changes_gives_another_digest(tmp_path):
    path = tmp_path / "room.wkt"
    spec = RunSpec(environment=FileEnvironment(path=str(path)), seed=1)
    digests = []
    for width in (6, 7):
        path.write_text(f"POLYGON ((0 0, {width} 0, {width} 5, 0 5, 0 0))")
        digests.append(simulate(spec).footer.digest)
    assert digests[0] != digests[1]


def test_a_digest_can_be_computed_from_the_file(tmp_path):
    # As documented: the spec, the free space, the starts, then the line of every event.
    path = tmp_path / "run.jsonl"
    simulate(APARTMENT, path=path)
    recording = Recording.load(path)
    lines = path.read_bytes().splitlines(keepends=True)
    digest = hashlib.sha256()
    for part in (recording.header.spec, recording.header.free, recording.header.starts):
        digest.update(msgspec.json.encode(part) + b"\n")
    for line in lines[1:-1]:
        digest.update(line)
    assert digest.hexdigest() == recording.footer.digest
