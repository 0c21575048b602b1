"""Numbers of numpy in what explorers yield: taken as builtin numbers, or refused in words."""

# Values of wrong types are what is tested here.
# mypy: disable-error-code="arg-type, dict-item"

import math
import struct
from typing import Any, ClassVar

import msgspec
import numpy as np
import pytest

from multisrt.events import (
    AnyEvent,
    ArcClosed,
    Decision,
    Died,
    Ended,
    Event,
    GoalChosen,
    Learned,
    MapComplete,
    Motion,
    NodeAdded,
    Organized,
    Sensed,
    Supports,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.recording import Recording
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.explorer import Done, Look, Move, Note, Receive, Send, Sense, TimedOut
from multisrt.robots.messages import Message
from multisrt.simulation import plain
from multisrt.spec import RobotSpec

END = Done(complete=True, reason="enough")
NUMBERS = [np.float64, np.float32, np.float16, np.longdouble, np.int64, np.uint8, np.array, int]
NODE = NodeAdded(
    time_s=1.0,
    robot=0,
    serial=2,
    parent=(0, 1),
    configuration=(1.0, 2.0, 0.0),
    stage="draw",
    boundary=((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)),
    tags="012",
)


class Word(Message, frozen=True, kw_only=True):
    kind: ClassVar[str] = "word"
    content: Any


def noted(act, event):
    """Record one event after some nodes that it may name, and return it as it was recorded."""
    before = [
        Note(msgspec.structs.replace(NODE, serial=serial, parent=None)) for serial in (0, 1, 3, 4)
    ]
    other = msgspec.structs.replace(NODE, time_s=0.0, robot=1, serial=0, parent=None)
    recording, _ = act(
        (Receive(timeout_s=1.0), *before, Note(event), END),
        (Note(other), END),
        robots=[RobotSpec(start=(1.0, 1.0)), RobotSpec(start=(5.0, 1.0))],
    )
    return [recorded for recorded in recording.events if recorded.robot == 0][len(before)]


def assert_plain(value: Any) -> None:
    if isinstance(value, msgspec.Struct):
        value = msgspec.structs.asdict(value)
    if isinstance(value, dict):
        value = (*value, *value.values())
    if isinstance(value, tuple):
        for part in value:
            assert_plain(part)
    else:
        assert type(value) in (float, int, bool, str, type(None))


def reloaded(recording: Recording, folder: Any) -> Recording:
    recording.save(folder / "recording.jsonl")
    return Recording.load(folder / "recording.jsonl")


@pytest.mark.parametrize("number", NUMBERS)
def test_motions_take_numbers_of_numpy(drive, straight, number, tmp_path):
    plain, _ = drive(straight(1.0, 1.0, 3.0, 1.0, guard_m=1.0), END)
    waypoints = (
        Waypoint(number(0), number(1), number(1), number(0)),
        Waypoint(number(4), number(3), number(1), number(0)),
    )
    recording, explorer = drive(
        Move(trajectory=Trajectory(waypoints), guard_m=number(1), listen=np.bool_(False)), END
    )
    assert recording.footer.digest == plain.footer.digest
    assert_plain(recording.events[0])
    assert_plain(explorer.told[0].configuration)
    assert reloaded(recording, tmp_path).events == recording.events


def test_motions_take_rows_of_an_array(drive, straight):
    plain, _ = drive(straight(1.0, 1.0, 3.0, 1.0), END)
    rows = np.array([[0.0, 1.0, 1.0, 0.0], [4.0, 3.0, 1.0, 0.0]])
    recording, _ = drive(Move(trajectory=Trajectory([Waypoint(*row) for row in rows])), END)
    assert recording.footer.digest == plain.footer.digest


@pytest.mark.parametrize("number", NUMBERS)
def test_timeouts_take_numbers_of_numpy(drive, number):
    _, explorer = drive(Receive(number(2)), END)
    assert explorer.told[0].time_s == 2.0
    assert type(explorer.told[0].time_s) is float


def test_an_infinite_timeout_is_none(play):
    recording, _ = play([Receive(math.inf), END], starts=[(1.0, 1.0)])
    assert recording.footer.reason == "robot 0 waits for a message that never comes"


@pytest.mark.parametrize("to", [np.int64(1), np.uint8(1), np.array(1), 1])
def test_messages_take_numbers_of_numpy(play, to):
    content = {"x": np.float32(1.5), "n": np.int64(3), "on": np.bool_(True), "s": np.str_("a")}
    message = Word(sender=np.int64(0), content=content)
    plain = Word(sender=0, content={"x": 1.5, "n": 3, "on": True, "s": "a"})
    assert message.size_bytes == plain.size_bytes
    recording, (_, told) = play([Send(message, to=to), END], [Receive(1.0), END])
    assert told[0].messages == (message,)
    assert recording.events[0].reached == (1,)


def test_done_takes_arrays_of_numpy(drive, tmp_path):
    frontier = np.array([[0.0, 1.0, 2.0, 3.0]], dtype=np.float32)
    recording, _ = drive(
        Done(
            complete=np.bool_(True),
            reason=np.str_("enough"),
            frontier=frontier,
            on_call=np.bool_(False),
        )
    )
    (end,) = recording.events
    assert (end.complete, end.frontier) == (True, ((0.0, 1.0, 2.0, 3.0),))
    assert_plain(end)
    assert reloaded(recording, tmp_path).events == recording.events


@pytest.mark.parametrize(
    ("changes", "plain"),
    [
        ({"time_s": np.float64(1.0)}, {}),
        ({"time_s": 1, "robot": np.int32(0), "serial": np.array(2)}, {}),
        ({"parent": np.array([0, 1]), "configuration": np.array([1, 2, 0])}, {}),
        ({"configuration": [np.float32(1), np.longdouble(2), 0]}, {}),
        ({"boundary": np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], np.float32)}, {}),
        ({"boundary": [np.array([0, 0]), (np.int8(1), 0), [1.0, np.float16(1)]]}, {}),
        ({"stage": np.str_("scan"), "tags": np.str_("000")}, {"stage": "scan", "tags": "000"}),
    ],
)
def test_nodes_take_numbers_and_arrays_of_numpy(act, changes, plain):
    event = noted(act, msgspec.structs.replace(NODE, **changes))
    assert event == msgspec.structs.replace(NODE, **plain)
    assert_plain(event)


f, i, b = np.float32, np.int64, np.bool_


@pytest.mark.parametrize(
    "event",
    [
        Decision(time_s=f(1), robot=i(0), node=(i(0), i(1)), frontier_m=f(2), choice="draw",
                 target=np.array([1.0, 2.0]), draws=i(3), refused={"no room": i(2)},
                 candidates=((f(1), f(2), "no room"),), gpr=np.array([0, 1]), ger=(i(0),),
                 arcs=np.ones((1, 5))),
        GoalChosen(time_s=f(1), robot=i(0), rule="minpos", because="start", goal=(f(1), f(2)),
                   cost_m=f(3), frontiers=np.ones((2, 2)), robots=np.arange(2),
                   costs=((f(1), None),), ranks=((i(1), None),), rounds=((i(0), i(1), f(2), f(1)),),
                   bids=((None, f(2)),), phi_m=np.ones(2), scores=np.ones((1, 6))),
        Organized(time_s=f(1), robot=i(0), feasible=(i(0),), unfeasible=np.array([1]),
                  before={i(0): (f(1), f(2))}, after={i(0): np.ones(2)}, orders={i(0): "keep"},
                  conflicts=np.array([[0, 1]]), deadlock=b(True)),
        Supports(time_s=f(1), robot=i(0), tree=i(1), open_frontier_m={i(1): f(2)},
                 active_robots={i(1): i(0)}, candidates=np.array([1])),
        Learned(time_s=f(1), robot=i(0), nodes=np.array([[1, 0]])),
        ArcClosed(time_s=f(1), robot=i(0), node=(i(0), i(1)), reason="too narrow",
                  arc=np.ones((2, 4))),
        MapComplete(time_s=f(1), robot=i(0)),
    ],
    ids=lambda event: type(event).__name__,
)  # fmt: skip
def test_events_take_numbers_of_numpy(act, event):
    recorded = noted(act, event)
    assert type(recorded) is type(event)
    assert_plain(recorded)
    # Every field holds what it was given.
    plain = msgspec.convert(_builtins(event), AnyEvent)
    assert recorded == plain


def test_fields_without_a_value_pass_where_a_number_looks_infinite(act):
    # Its bytes are looked at again, as four of them are those with which an infinite one begins.
    (x,) = struct.unpack(">d", b"\x40\xcb\x7f\xf1\0\0\0\0")
    event = Decision(time_s=1.0, robot=0, node=(0, 1), frontier_m=2.0, choice="draw", target=(x, x))
    assert event.arcs is msgspec.UNSET
    assert noted(act, event) == event


def _builtins(value: Any) -> Any:
    match value:
        case msgspec.Struct():
            tag = value.__struct_config__.tag
            fields = msgspec.structs.asdict(value).items()
            return {"event": tag} | {name: _builtins(part) for name, part in fields}
        case np.ndarray():
            return value.tolist()
        case dict():
            return {_builtins(key): _builtins(part) for key, part in value.items()}
        case tuple():
            return [_builtins(part) for part in value]
        case np.generic():
            return value.item()
    return value


NAN, INF = float("nan"), float("inf")
STRAIGHT = Waypoint(0.0, 1.0, 1.0, 0.0), Waypoint(4.0, 3.0, 1.0, 0.0)
WAY = Trajectory(STRAIGHT)


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (Receive(NAN), r"timeout_s of its Receive is nan, a float; give a finite number or inf"),
        (Receive("2"), r"timeout_s of its Receive is '2', a str; give a number: float\(x\)"),
        (Receive(np.array([1.0])), r"Receive is array\(\[1\.\]\), a ndarray; give a number"),
        (Receive(2j), r"Receive is 2j, a complex"),
        (Send(Word(sender=0, content=1), to=1.0), r"to of its Send is 1\.0, a float; .*int\(x\)"),
        (Send(Word(sender=0, content=1), to=np.float64(1)), r"to of its Send is .*, a float64"),
        (Send(Word), r"which is no message"),
        (Send(Word(sender=0, content=(1, 2j))), r"Word\.content\[1\] is 2j, a complex"),
        (Send(Word(sender=0, content={"n": 2**70})), r"Word\.content\['n'\] is 118.*, an int"),
        (Note(MapComplete), r"it put <class .*MapComplete'> on record .*; give Note an instance"),
        (Note(None), r"it put None on record"),
        (Note(MapComplete(time_s=NAN, robot=0)), r"MapComplete\.time_s .* is nan, a float .*;"),
        (Note(MapComplete(time_s=np.float32(INF), robot=0)), r"MapComplete\.time_s .*, a float32"),
        (Note(MapComplete(time_s="now", robot=0)), r"time_s: Expected a number, got text"),
        (Note(MapComplete(time_s=0.0, robot=0.5)), r"robot: Expected a whole number, got"),
        (Note(MapComplete(time_s=0.0, robot=np.int64(1))), r"event of robot 1 on record .*; .*=0"),
        (Note(MapComplete(time_s=2j, robot=0)), r"MapComplete\.time_s .* is 2j, a complex"),
        (Note(MapComplete(time_s=0.0, robot=2**70)), r"MapComplete\.robot .* is 118.*, an int"),
        (Note(msgspec.structs.replace(NODE, boundary=np.full((3, 2), NAN))),
         r"NodeAdded\.boundary\[0\]\[0\] of what it put on record is nan"),
        (Note(GoalChosen(time_s=0.0, robot=0, rule="", because="", goal=None, bids=((INF,),))),
         r"GoalChosen\.bids\[0\]\[0\] of what it put on record is inf, a float"),
        (Done(complete=1, reason="x"), r"complete of its Done is 1, an int; give True"),
        (Done(complete=True, reason="x", on_call=2), r"on_call of its Done is 2, an int"),
        (Done(complete=True, reason="x", frontier=((0.0, 1.0, NAN, 3.0),)),
         r"a coordinate of the frontier of its Done is nan, a float; give a finite"),
        (Done(complete=True, reason="x", frontier=np.ones((1, 3))),
             r"a segment of the frontier of its Done is array"),
        (Move(trajectory=STRAIGHT), r"trajectory of its Move is \(Waypoint.*, a tuple"),
        (Move(trajectory=Trajectory(())), r"its trajectory has no waypoint"),
        (Move(trajectory=Trajectory((STRAIGHT[0], Waypoint(NAN, 1.0, 1.0, 0.0)))),
         r"waypoint 1 of its trajectory is nan, a float"),
        (Move(trajectory=Trajectory((Waypoint(0.0, "1", 1.0, 0.0),))), r"trajectory is '1', a str"),
        (Move(trajectory=Trajectory((np.ones(3),))), r"waypoint 0 of its trajectory is array"),
        (Move(trajectory=WAY, guard_m=np.float32(INF)), r"guard_m of its Move is inf, a float"),
        (Move(trajectory=WAY, listen=1), r"listen of its Move is 1, an int; give True or False"),
        (Move(trajectory=WAY, purpose="fun"), r"purpose of its Move is 'fun', a str; .*'explore'"),
        (Done(complete=True, reason=None), r"reason of its Done is None, a NoneType; say why"),
        (Done(complete=True, reason="x", frontier=3), r"frontier of its Done is 3, an int"),
        (Look, r"the class Look; yield an instance: Look\(\.\.\.\)"),
        (None, r"it yielded None, .*; yield Sense\(\), not yield alone"),
        ((x for x in "ab"), r"a generator; delegate .*: yield from <genexpr>\(\)"),
        (WAY, r"no action; yield Move\(trajectory=\.\.\.\) to follow it"),
        (Word(sender=0, content=1), r"no action; yield Send\(\.\.\.\) to send it"),
        (MapComplete(time_s=0.0, robot=0), r"no action; yield Note\(\.\.\.\) to put it"),
        (TimedOut(time_s=0.0), r"a TimedOut, which is an outcome; outcomes are"),
        ((Look(), Look()), r"it yielded 2 actions at once, in a tuple; yield them one by one"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused_in_words(play, action, said):
    with pytest.raises(ExplorerDefect, match=said) as caught:
        play([Sense(), action, END], [END])
    assert caught.value.where.startswith("the explorer of robot 0 ('script') at ")
    assert isinstance(caught.value, InvalidInputError)
    assert "\n" not in str(caught.value)


def test_events_of_no_kind_are_refused(drive):
    class Mine(Event, frozen=True, kw_only=True, tag="mine"):
        pass

    with pytest.raises(
        ExplorerDefect, match="it put a Mine on record, which explorers do not note"
    ):
        drive(Note(Mine(time_s=0.0, robot=0)), END)


@pytest.mark.parametrize(
    "event",
    [
        Sensed(time_s=0.0, robot=0, configuration=(3.0, 3.0, 0.0)),
        Motion(time_s=0.0, robot=0, waypoints=((0.0, 1.0, 1.0, 0.0),)),
        Died(time_s=0.0, robot=0, configuration=(1.0, 1.0, 0.0), doing="waiting"),
        Ended(time_s=0.0, robot=0, reason="", complete=True, frontier=()),
    ],
)
def test_what_robots_did_is_not_theirs_to_note(drive, event):
    with pytest.raises(ExplorerDefect, match="on record, which explorers do not note"):
        drive(Note(event), END)


def test_what_is_noted_has_the_present_time(drive):
    for time_s in (0.0, 2.0):
        with pytest.raises(ExplorerDefect, match=rf"MapComplete has time_s={time_s:g} at 1 s"):
            drive(Receive(timeout_s=1.0), Note(MapComplete(time_s=time_s, robot=0)), END)


def test_events_that_can_be_written_are_recorded_as_they_are(act):
    assert noted(act, NODE) == NODE
    assert plain.event(NODE, 0, 1.0, is_ours=True) is NODE


def test_whole_numbers_are_recorded_as_their_field_declares(act):
    chosen = GoalChosen(time_s=1.0, robot=0, rule="mine", because="start", goal=(2, 1))
    assert isinstance(noted(act, chosen).goal[0], float)


@pytest.mark.parametrize(
    ("waypoints", "said"),
    [
        (((0.0, 0.0), (2.0, 0.0), (1.0, 0.0)), "waypoint 2 of its trajectory is at 1 s, after 2 s"),
        (((1.0, 0.0), (2.0, 0.0)), "waypoint 0 of its trajectory is at 1 s, after 0 s"),
        (((0.0, 0.0), (1.0, 15.0)), "a leg of a motion turns by more than"),
    ],
)
def test_trajectories_that_no_recording_holds_are_refused(waypoints, said):
    wrong = Trajectory(tuple(Waypoint(at_s, 1.0, 1.0, heading) for at_s, heading in waypoints))
    with pytest.raises(ExplorerDefect, match=said):
        plain.motion(Move(trajectory=wrong), 0)


def test_lists_in_place_of_tuples_are_recorded(act):
    chosen = GoalChosen(
        time_s=1.0,
        robot=0,
        rule="mine",
        because="start",
        goal=None,
        frontiers=[[1.0, 2.0]],
    )
    learned = Learned(time_s=1.0, robot=0, nodes=[(0, 0)])
    for event in (chosen, learned):
        assert noted(act, event) is not None
