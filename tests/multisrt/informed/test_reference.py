"""Reference times: what they are, and the cache that keeps them."""

import pytest
from shapely import box

from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.informed import reference
from multisrt.informed.reference import (
    Reference,
    informed_reference,
    informed_run,
    keep_reference,
    regret,
)
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec

DRIVEN: dict[str, object] = {}
HALL = Environment("hall", box(0.0, 0.0, 12.0, 3.0))


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(reference, "_folder", lambda: tmp_path / "informed")
    return tmp_path / "informed"


@pytest.fixture
def plans(monkeypatch):
    """How often a plan was driven; equal plans are made once for all tests."""
    made = []

    def driven(*given):
        made.append(given)
        if str(given) not in DRIVEN:
            DRIVEN[str(given)] = real(*given)
        return DRIVEN[str(given)]

    real = reference._driven
    monkeypatch.setattr(reference, "_driven", driven)
    return made


def spec(strategy="minpos", x=1.0, **more):
    return RunSpec(
        environment=inline(HALL),
        strategy=strategy,
        robots=(RobotSpec(start=(x, 1.5, 0.0)),),
        **more,
    )


def test_a_reference_is_planned_once(plans):
    first = informed_reference(spec(), HALL)
    # 12 m long, seen up to 4 m: 4 to 8 m to go.
    assert 6.0 < first.makespan_s < 16.0
    assert first.time_to_99_s == first.makespan_s
    assert informed_reference(spec("closest", seed=3), HALL) == first
    assert len(plans) == 1
    assert informed_reference(spec(x=11.0), HALL) != first
    assert informed_reference(spec(), HALL, home=True).makespan_s > 1.8 * first.makespan_s
    assert len(plans) == 3


@pytest.mark.parametrize("content", [b"", b"{}", b"not JSON", b'{"makespan_s": "long"}'])
def test_a_broken_file_is_made_anew(plans, folder, content):
    first = informed_reference(spec(), HALL)
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    file.write_bytes(content)
    assert informed_reference(spec(), HALL) == first
    assert len(plans) == 2
    assert file.read_bytes() == whole


def test_a_folder_that_cannot_be_written_costs_only_time(plans, folder):
    folder.parent.mkdir(exist_ok=True)
    folder.write_text("a file where the folder should be")
    first = informed_reference(spec(), HALL)
    assert informed_reference(spec(), HALL) == first
    assert len(plans) == 2


def test_the_folder_is_bounded(monkeypatch, folder):
    monkeypatch.setattr(reference, "MAX_FILES", 2)
    some = Reference(
        time_to_90_s=1.0,
        time_to_95_s=2.0,
        time_to_99_s=3.0,
        makespan_s=4.0,
        distance_m=1.0,
        coverage=0.99,
    )
    for x in (1.0, 2.0, 3.0, 4.0):
        keep_reference(informed_run(spec(x=x), HALL), HALL, some)
    assert len(list(folder.iterdir())) == 2


def test_regret_compares_with_a_plan_that_drives_home_if_the_run_did():
    explored = simulate(spec("srt-radial"), HALL)
    metrics = measure(explored, HALL)
    found = regret(explored, metrics, HALL)
    there = informed_reference(spec(), HALL)
    back = informed_reference(spec(), HALL, home=True)
    assert metrics.time_to_99_s is not None
    assert there.time_to_99_s is not None
    assert found.makespan is not None
    assert found.time_to_99 == metrics.time_to_99_s / there.time_to_99_s
    assert found.makespan == metrics.makespan_s / back.makespan_s
    assert found.makespan > 1.0


def test_what_is_seen_at_once_has_no_multiple():
    room = Environment("room", box(0.0, 0.0, 3.0, 3.0))
    run = RunSpec(
        environment=inline(room), strategy="minpos", robots=(RobotSpec(start=(1.5, 1.5, 0.0)),)
    )
    recording = simulate(run, room)
    assert regret(recording, measure(recording, room), room).time_to_99 is None
