"""Runs as tables."""

from itertools import pairwise

import msgspec
import pytest
import shapely

from multisrt.analysis.run_tables import coverage_curve, events, trajectories
from multisrt.environments.environment import Environment
from multisrt.events import Motion
from multisrt.finished_run import Run
from multisrt.run import explore

ROOM = Environment("room", shapely.box(0, 0, 12, 5))


@pytest.fixture(scope="module")
def run() -> Run:
    return explore(ROOM, robots=2, starts=[(1.0, 1.0), (1.0, 3.0)], range_m=4.0, seed=1)


def rows(columns):
    values = zip(*(column.values for column in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in values]


def test_trajectories_begin_at_starts_and_hold_every_waypoint(run):
    own = rows(trajectories(run.recording))
    first = {row["robot"]: row for row in reversed(own)}
    assert (first[1]["x_m"], first[1]["y_m"], first[1]["time_s"]) == (1.0, 3.0, 0.0)
    assert (first[1]["motion"], first[1]["purpose"]) == (None, None)
    motions = [event for event in run.recording.of(Motion) if event.robot == 1]
    told = [row for row in own if row["robot"] == 1 and row["motion"] == len(motions) - 1]
    assert [(row["time_s"], row["x_m"], row["y_m"], row["heading_rad"]) for row in told] == list(
        motions[-1].waypoints
    )
    assert own == sorted(own, key=lambda row: (row["robot"], row["time_s"]))
    assert len(own) == 2 + sum(len(event.waypoints) for event in run.recording.of(Motion))


def test_the_coverage_curve_agrees_with_the_metrics(run):
    curve = rows(coverage_curve(run.recording, run.environment))
    assert curve[0]["time_s"] == 0.0
    assert curve[-1]["time_s"] == run.recording.footer.time_s
    assert curve[-1]["coverage"] == run.metrics.coverage
    assert curve[-1]["seen_area_m2"] == pytest.approx(run.metrics.seen_area_m2)
    times = [row["time_s"] for row in curve]
    assert all(a < b for a, b in pairwise(times))
    reached = next(row["time_s"] for row in curve if row["coverage"] >= 0.9 - 1e-9)
    assert reached == run.metrics.time_to_90_s


def test_events_lose_nothing(run):
    own = rows(events(run.recording))
    assert len(own) == len(run.recording.events)
    for row, event in zip(own, run.recording.events, strict=True):
        told = msgspec.json.decode(msgspec.json.encode(event))
        kind, place = told.pop("event"), told.pop("configuration", (None, None, None))
        assert (row["event"], row["time_s"], row["robot"]) == (
            kind,
            told.pop("time_s"),
            told.pop("robot"),
        )
        assert (row["x_m"], row["y_m"], row["heading_rad"]) == tuple(place)
        fields = msgspec.json.decode(row["fields"])
        assert fields == told
