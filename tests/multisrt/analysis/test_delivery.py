"""What a base station knows, by hand-made recordings in a hall of 10 x 10 m."""

import math

import msgspec
import pytest
import shapely

from multisrt.analysis.isolation import team_isolation
from multisrt.analysis.measuring import measure
from multisrt.analysis.radio_links import radio_links
from multisrt.analysis.run_tables import coverage_curve
from multisrt.events import BaseLearned, Learned, Sent
from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import measure_named
from multisrt.experiments.results import Result
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recorder, Recording
from multisrt.recording.lines import WITHOUT_BASE
from multisrt.spec import BaseSpec, RadioSpec
from tests.multisrt.experiments.results import metrics_of

TWO = ((1.0, 1.0, 0.0), (9.0, 9.0, 0.0))
LEFT, RIGHT = shapely.box(0, 0, 4, 10), shapely.box(4, 0, 10, 10)


@pytest.fixture
def at_base(recorded):
    """Build the recording of a team with a base station at (5, 5)."""

    def build(*events, base=(5.0, 5.0), **more) -> Recording:
        plain = recorded(*events, **more)
        spec = msgspec.structs.replace(plain.spec, base=BaseSpec(x=base[0], y=base[1]))
        recorder = Recorder(msgspec.structs.replace(plain.header, spec=spec))
        for event in plain.events:
            recorder.record(event)
        return recorder.finish(plain.footer.time_s, "complete", "")

    return build


def sent(time_s: float, robot: int, *reached: int) -> Sent:
    return Sent(time_s=time_s, robot=robot, kind="map", size_bytes=10, reached=reached)


def learned(time_s: float, robot: int, *nodes: tuple[int, int]) -> BaseLearned:
    return BaseLearned(time_s=time_s, robot=robot, nodes=nodes)


def test_measures_worked_out_on_paper(at_base, seen):
    # 40 m2 at 0 s, delivered at 10 s; 60 m2 at 20 s, delivered never; the run ends at 50 s.
    recording = at_base(
        seen(0.0, LEFT),
        sent(10.0, 0, 1),
        learned(10.0, 0, (0, 0)),
        seen(20.0, RIGHT, serial=1),
    )
    m = measure(recording)
    assert m.coverage == pytest.approx(1.0, abs=1e-6)
    assert m.delivered_coverage == pytest.approx(0.4, abs=1e-6)
    assert (m.delivered_90_s, m.delivered_95_s, m.delivered_99_s) == (None, None, None)
    assert m.delivery_delay_s == pytest.approx((40 * 10 + 60 * 30) / 100, abs=1e-4)
    # From 0 to 10 s, and from 20 s to the end.
    assert m.carrying_s == pytest.approx(40.0)
    columns = coverage_curve(recording, recording.environment())
    assert list(columns["time_s"].values) == [0.0, 10.0, 20.0, 50.0]
    assert list(columns["delivered"].values) == pytest.approx([0.0, 0.4, 0.4, 0.4], abs=1e-6)
    assert list(columns["coverage"].values) == pytest.approx([0.4, 0.4, 1.0, 1.0], abs=1e-6)


def test_what_the_base_knows_is_neither_known_to_one_nor_lost(at_base, recorded, seen, died):
    # 40 m2 are known to the robot alone for 10 s, 60 m2 from 20 s until it dies at 30 s.
    told = (
        seen(0.0, LEFT),
        sent(10.0, 0, 1),
        learned(10.0, 0, (0, 0)),
        seen(20.0, RIGHT, serial=1),
    )
    m = measure(at_base(*told))
    assert m.known_to_one_m2s == pytest.approx(40 * 10 + 60 * 30, abs=1e-2)
    assert m.known_to_one_by_robot_m2s == (m.known_to_one_m2s,)
    assert m.known_to_one_m2 == pytest.approx(60.0, abs=1e-3)
    m = measure(at_base(*told, died(30.0, 0)))
    assert m.known_to_one_m2s == pytest.approx(40 * 10 + 60 * 10, abs=1e-2)
    assert m.known_to_one_m2 == 0.0
    assert m.lost_area_m2 == pytest.approx(60.0, abs=1e-3)
    assert m.lost_area_by_robot_m2 == pytest.approx((60.0,), abs=1e-3)
    # Without a base station all of it is.
    m = measure(recorded(seen(0.0, LEFT), seen(20.0, RIGHT, serial=1), died(30.0, 0)))
    assert m.known_to_one_m2s == pytest.approx(40 * 30 + 60 * 10, abs=1e-2)
    assert m.lost_area_m2 == pytest.approx(100.0, abs=1e-3)


def test_what_is_delivered_at_once_was_never_known_to_one(at_base, seen):
    m = measure(at_base(seen(0.0, LEFT), sent(0.0, 0, 1), learned(0.0, 0, (0, 0))))
    assert m.known_to_one_m2s == 0.0


def test_all_is_delivered_in_the_end(at_base, seen):
    recording = at_base(
        seen(0.0, LEFT),
        seen(20.0, RIGHT, serial=1),
        sent(30.0, 0, 1),
        learned(30.0, 0, (0, 0), (0, 1)),
    )
    m = measure(recording)
    assert m.delivered_coverage == m.coverage
    assert (m.delivered_90_s, m.delivered_99_s) == (30.0, 30.0)
    assert m.delivery_delay_s == pytest.approx((40 * 30 + 60 * 10) / 100, abs=1e-4)
    assert m.carrying_s == pytest.approx(30.0)


def test_what_was_not_delivered_ages_up_to_the_horizon(at_base, seen):
    recording = at_base(seen(0.0, LEFT), sent(10.0, 0, 1), learned(10.0, 0, (0, 0)),
                        seen(20.0, RIGHT, serial=1))  # fmt: skip
    later = measure(recording, horizon_s=80.0)
    assert later.delivery_delay_s == pytest.approx((40 * 10 + 60 * 60) / 100, abs=1e-4)
    # Stored results are moved to the same horizon without measuring the run again.
    where = Condition(environment="hall", strategy="closest", robots=1)
    result = Result(key="k", condition=where, repetition=0, status="complete", reason="",
                    metrics=measure(recording))  # fmt: skip
    assert metrics_of(result.to_horizon(80.0)).delivery_delay_s == pytest.approx(
        later.delivery_delay_s
    )
    earlier = measure(recording, horizon_s=30.0)
    assert earlier.delivery_delay_s == pytest.approx((40 * 10 + 60 * 10) / 100, abs=1e-4)


def test_news_pass_through_another_robot(at_base, seen):
    # Robot 0 tells robot 1 at 5 s, which tells the base at 25 s; robot 0 dies at 15 s.
    recording = at_base(
        seen(0.0, LEFT),
        Learned(time_s=5.0, robot=1, nodes=((0, 0),)),
        sent(25.0, 1, 2),
        learned(25.0, 1, (0, 0)),
        starts=TWO,
    )
    m = measure(recording)
    assert m.delivered_coverage == pytest.approx(0.4, abs=1e-6)
    assert m.carrying_s == pytest.approx((25.0 + 20.0) / 2)


def test_a_dead_robot_carries_nothing_and_delivers_nothing(at_base, seen, died):
    m = measure(at_base(seen(0.0, LEFT), died(15.0, 0)))
    assert m.delivered_coverage == 0.0
    assert m.carrying_s == pytest.approx(15.0)
    assert m.delivery_delay_s == pytest.approx(50.0)


def test_what_no_message_brought_does_not_count(at_base, seen):
    told_before = at_base(sent(0.0, 0, 1), seen(5.0, LEFT), learned(10.0, 0, (0, 0)))
    assert measure(told_before).delivered_coverage == 0.0
    by_who_does_not_know = at_base(
        seen(5.0, LEFT), sent(10.0, 1, 2), learned(10.0, 1, (0, 0)), starts=TWO
    )
    assert measure(by_who_does_not_know).delivered_coverage == 0.0
    # Robots may learn of the base station.
    through = at_base(
        seen(0.0, LEFT), sent(5.0, 0, 2), learned(5.0, 0, (0, 0)), sent(9.0, 2, 1),
        Learned(time_s=9.0, robot=1, nodes=((0, 0),)), starts=TWO,
    )  # fmt: skip
    assert measure(through).known_to_one_m2 == pytest.approx(0.0, abs=1e-6)


def test_a_region_counts_as_far_as_it_was_seen(at_base, seen):
    # Scans of 3 m show a quarter of the node's region from the corner (1, 1).
    recording = at_base(
        seen(0.0, shapely.box(0, 0, 4, 4)), sent(1.0, 0, 1), learned(1.0, 0, (0, 0)), range_m=4.0
    )
    m = measure(recording)
    shown = shapely.Point(1, 1).buffer(4.0, quad_segs=512) & shapely.box(0, 0, 4, 4)
    expected = shown.area / m.explorable_area_m2
    assert shown.area < 16.0
    assert m.delivered_coverage == pytest.approx(expected, abs=1e-3)
    assert m.delivered_coverage == m.coverage


def test_without_a_base_there_are_no_such_measures(recorded, seen):
    recording = recorded(seen(0.0, LEFT))
    assert recording.header.format_version == WITHOUT_BASE
    m = measure(recording)
    names = [
        "delivered_coverage", "delivered_90_s", "delivered_95_s", "delivered_99_s",
        "delivery_delay_s", "carrying_s",
    ]  # fmt: skip
    assert [getattr(m, name) for name in names] == [None] * 6
    assert not [row for row in m.outline() if "base" in row[0]]
    where = Condition(environment="hall", strategy="closest", robots=1)
    result = Result(key="k", condition=where, repetition=0, status="complete", reason="", metrics=m)
    assert [measure_named(name).of(result) for name in names] == [None] * 6


def test_the_outline_tells_what_is_delivered(at_base, seen):
    m = measure(at_base(seen(0.0, LEFT), sent(1.0, 0, 1), learned(1.0, 0, (0, 0))))
    assert ("delivered to the base", "40.0 %") in m.outline()


def test_a_recording_with_a_base_is_read_again(at_base, seen, tmp_path):
    recording = at_base(seen(0.0, LEFT), sent(1.0, 1, 0), learned(1.0, 0, (0, 0)))
    recording.save(tmp_path / "a.jsonl")
    again = Recording.load(tmp_path / "a.jsonl")
    assert again.events == recording.events
    assert again.spec.base == BaseSpec(x=5.0, y=5.0)


@pytest.mark.parametrize(
    ("event", "flaw"),
    [
        (learned(1.0, 0, (0, 7)), "node 7 of robot 0 is nowhere in the recording"),
        (learned(1.0, 1, (0, 0)), "there is no robot 1"),
        (sent(1.0, 0, 2), "there is no robot 2"),
    ],
)
def test_a_wrong_event_of_a_base_is_refused(at_base, seen, tmp_path, event, flaw):
    at_base(seen(0.0, LEFT), event).save(tmp_path / "a.jsonl")
    with pytest.raises(InvalidInputError, match=flaw):
        Recording.load(tmp_path / "a.jsonl")


def test_a_base_learns_nothing_in_a_run_without_one(recorded, seen, tmp_path):
    recorded(seen(0.0, LEFT), learned(1.0, 0, (0, 0))).save(tmp_path / "a.jsonl")
    with pytest.raises(InvalidInputError, match="the run has none"):
        Recording.load(tmp_path / "a.jsonl")


# The base station as a relay ---------------------------------------------------------------------


@pytest.mark.parametrize(("multi_hop", "isolated_s"), [(True, 0.0), (False, 50.0)])
def test_a_base_relays_between_robots(at_base, multi_hop, isolated_s):
    # 8 m apart, and 4 m from the base each.
    starts = ((1.0, 5.0, 0.0), (9.0, 5.0, 0.0))
    radio = RadioSpec(range_m=5.0, multi_hop=multi_hop)
    recording = at_base(starts=starts, radio=radio)
    team = team_isolation(recording)
    assert (team.total_s, team.split_s) == (isolated_s, isolated_s)
    assert radio_links(recording) == {(0, 2): ((0.0, 50.0),), (1, 2): ((0.0, 50.0),)}


def test_a_robot_at_the_base_alone_is_isolated(at_base, moved):
    # Robot 1 leaves the base's range of 5 m at x = 10, 20 s after it set out.
    away = moved((10.0, 8.0, 5.0, 0.0), (30.0, 9.9, 5.0, 0.0), robot=1)
    radio = RadioSpec(range_m=4.0)
    recording = at_base(away, starts=((2.0, 5.0, 0.0), (8.0, 5.0, 0.0)), radio=radio)
    leaves_s = 10.0 + 20.0 * 1.0 / 1.9
    [*_, split] = (team_isolation(recording).total_s, team_isolation(recording).split_s)
    assert split == pytest.approx(50.0 - leaves_s, abs=1e-5)
    assert math.isclose(team_isolation(recording).robots[0].total_s, split, abs_tol=1e-5)
