import re

import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import Blocked, Decided, Ended, Learned, Motion, NodeAdded, Sent
from multisrt.explain.custom import MAX_ROWS
from multisrt.explain.srt import explain, explain_all
from multisrt.geometry.configuration import Configuration
from multisrt.recording import Recorder, header_of
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec

OPTIONS = tuple((float(x), 2.0) for x in range(20))
PATHS = (None, *(19.0 - x for x in range(1, 20)))


def decision(time_s, text, **known):
    return Decided(time_s=time_s, robot=0, text=text, **known)


@pytest.fixture(scope="module")
def recording():
    hall = Environment("hall", shapely.box(0, 0, 20, 10))
    spec = RunSpec(environment=inline(hall), robots=(RobotSpec(),) * 2)
    recorder = Recorder(header_of(spec, hall, (Configuration(1, 1), Configuration(5, 1))))
    for robot in range(2):
        recorder.record(
            NodeAdded(
                time_s=0.0,
                robot=robot,
                serial=0,
                parent=None,
                configuration=(1.0 + 4.0 * robot, 1.0, 0.0),
                stage="root",
                boundary=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),
                tags="000",
            )
        )
    for event in (
        Learned(time_s=0.5, robot=0, nodes=((1, 0),)),
        decision(
            1.0,
            "the one that\n\n  is nearest\x1b[2J now",
            goal=OPTIONS[17],
            options=OPTIONS,
            values={"path (m)": PATHS, "a value with a long name": tuple(range(20))},
        ),
        Motion(time_s=1.0, robot=0, waypoints=((1.0, 1.0, 1.0, 0.0), (9.0, 5.0, 1.0, 0.0))),
        Sent(time_s=9.0, robot=0, kind="hello", size_bytes=9, reached=(1,)),
        Blocked(time_s=9.0, robot=0, by=1, configuration=(5.0, 1.0, 0.0)),
        decision(9.0, "nowhere"),
        Ended(time_s=10.0, robot=0, reason="enough", complete=False, frontier=()),
    ):
        recorder.record(event)
    return recorder.finish(12.0, "stalled", "")


def test_a_decision_is_told_in_its_own_words_and_numbers(recording):
    told = explain(recording, 0, 5.0)
    assert told.startswith("Robot 0 at 5.00 s: its last decision was at 1.00 s.\n")
    for line in (
        "at (1.00, 1.00), heading 0 degrees",
        "its map had 1 node that it had made",
        "it had learned 1 node of others: 1 of robot 1; last at 0.50 s",
        "the one that",
        "is nearest [2J now",
        "goal (17.00, 2.00), 16.03 m away in a straight line",
        "place path (m) a value with a long name",
        "(19.00, 2.00) 0.00 19.00",
        "* (17.00, 2.00) 2.00 17.00",
        "and 8 more options",
        "from 1.00 s on it drove 4.00 m in 8.00 s, to (5.00, 1.00)",
        "at 9.00 s it decided again",
        "it sent 1 message: 1 hello",
    ):
        assert line in [" ".join(shown.split()) for shown in told.splitlines()], line
    assert len(re.findall(r"^[ *]{4} *\(.*[\d-]$", told, re.MULTILINE)) == MAX_ROWS
    assert "\x1b" not in told


def test_a_decision_to_go_nowhere_is_told(recording):
    told = explain(recording, 0)
    assert "  nowhere\n  no goal\n" in told
    assert "10.00 s: it ended: enough" in told
    assert "protective stop at (5.00, 1.00), before the body of robot 1" in told


def test_all_decisions_have_a_line_each(recording):
    assert explain_all(recording, 0).splitlines() == [
        " time (s)  options  decision",
        "     1.00       20  to (17.00, 2.00): the one that is nearest [2J now",
        "     9.00        0  no goal: nowhere",
    ]
