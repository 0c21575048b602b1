"""Runs that are odd: of no length, still going on, too long, contradictory; and full disks."""

import subprocess
import sys

import msgspec
import pytest

import multisrt as ms
from multisrt.events import Motion
from multisrt.exporting import ExportOptions, export_run
from tests.multisrt.exporting.conftest import read_with_mcap

SMALL_DISK = """
import resource, sys
from multisrt import InvalidInputError, Recording
from multisrt.exporting import export_run

recording = Recording.load(sys.argv[1])
limit = int(sys.argv[3])
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
try:
    export_run(recording, sys.argv[2])
except InvalidInputError as error:
    print(error)
"""


@pytest.fixture(scope="module")
def short() -> ms.Run:
    return ms.explore("open", seed=1, max_time_s=3.0)


def changed(recording, events=None, **footer):
    return ms.Recording(
        header=recording.header,
        events=recording.events if events is None else events,
        footer=msgspec.structs.replace(recording.footer, **footer),
    )


@pytest.mark.parametrize("suffix", [".mcap", ".rrd"])
def test_a_run_of_no_length_can_be_exported(tmp_path, suffix):
    run = ms.explore("open", seed=1, max_time_s=1e-9)
    run.export(tmp_path / f"x{suffix}")
    assert (tmp_path / f"x{suffix}").stat().st_size > 1000


def test_a_run_that_is_going_on_can_be_exported(tmp_path):
    stepper = ms.Stepper("open", seed=1)
    for step in stepper:
        if step.time_s > 3.0:
            break
    ms.Run(stepper.recording).export(tmp_path / "x.mcap")
    poses = read_with_mcap(tmp_path / "x.mcap")["/robot_0/pose"]
    assert poses[-1][0] == round(stepper.recording.footer.time_s * 1e9)


@pytest.mark.parametrize(
    ("time_s", "options", "said"),
    [
        (3e9, {}, r"the run lasts 3e\+09 s; at most 2e\+09 s can be exported"),
        (1e9, {}, "10 poses a second over 1e\\+09 s for 1 robots .* choose a lower rate"),
        (1e9, {"rate_hz": 0.01, "map_interval_s": 0.01}, "choose a longer interval"),
    ],
)
def test_runs_that_are_too_long_are_refused(short, tmp_path, time_s, options, said):
    recording = changed(short.recording, time_s=time_s)
    with pytest.raises(ms.InvalidInputError, match=said):
        export_run(recording, tmp_path / "x.mcap", options=ExportOptions(**options))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("time_s", [-5.0, 3.5, 1e300])
def test_waypoints_outside_the_run_are_refused(short, tmp_path, time_s):
    motion = short.recording.of(Motion)[0]
    first, *others = motion.waypoints
    waypoints = (first, *others[:-1], (time_s, *others[-1][1:]))
    recording = changed(short.recording, (msgspec.structs.replace(motion, waypoints=waypoints),))
    with pytest.raises(ms.InvalidInputError, match="robot 0 at 0 s has a waypoint at"):
        export_run(recording, tmp_path / "x.mcap")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suffix", "limit"), [(".mcap", 20_000), (".rrd", 20_000), (".rrd", 60_000)]
)
def test_nothing_is_left_on_a_full_disk(short, tmp_path, suffix, limit):
    short.save_recording(tmp_path / "recording.jsonl")
    path = tmp_path / f"x{suffix}"
    words = [
        sys.executable,
        "-c",
        SMALL_DISK,
        str(tmp_path / "recording.jsonl"),
        str(path),
        str(limit),
    ]
    found = subprocess.run(words, capture_output=True, text=True, timeout=300)
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith(f"cannot write {path}: ")
    assert [one.name for one in tmp_path.iterdir()] == ["recording.jsonl"]
