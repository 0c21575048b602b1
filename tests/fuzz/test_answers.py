"""What explorers of strangers yield: every strange value in every place of every action."""

import json

import pytest

from benchmarks.fuzz.judging import judge
from benchmarks.fuzz.scripts import KINDS, MAKERS
from benchmarks.fuzz.target import Input
from benchmarks.fuzz.targets import TARGETS


def make(kind, **fields):
    return {"make": kind, **fields}


def move(**fields):
    return make("Move", **{"trajectory": make("way", places=[[0.1, 0.0]])} | fields)


def leg(waypoints):
    return move(trajectory=make("Trajectory", waypoints=waypoints))


def place(x):
    return make("Waypoint", time_s=0.0, x=x, y=make("y"), heading=make("heading"))


def words(**fields):
    return make("Words", **{"sender": make("number")} | fields)


def note(kind, **fields):
    return make("Note", event=make(kind, **fields))


def decided(**fields):
    return note("Decided", **{"text": "here", "options": [[0, 0]]} | fields)


def chosen(**fields):
    near = {"rule": "mine", "because": "near", "goal": [1.0, 1.0], "frontiers": [[1.0, 1.0]]}
    return note("GoalChosen", **near | {"robots": [0]} | fields)


def node(**fields):
    corners = [make("near", dx=dx, dy=dy) for dx, dy in ((0.5, 0.0), (-0.5, 0.5), (-0.5, -0.5))]
    known = {"serial": 0, "parent": None, "configuration": make("here"), "stage": "root"}
    return note("NodeAdded", **known | {"boundary": corners, "tags": "111"} | fields)


def done(**fields):
    return make("Done", **{"complete": False, "reason": "it is over"} | fields)


PLACES = {
    "yield": lambda value: value,
    "timeout_s": lambda value: make("Receive", timeout_s=value),
    "trajectory": lambda value: move(trajectory=value),
    "waypoints": leg,
    "waypoint": lambda value: leg([value]),
    "x": lambda value: leg([place(value)]),
    "time": lambda value: move(trajectory=make("onward", time_s=value, dx=0.1, dy=0, turn=0)),
    "guard_m": lambda value: move(guard_m=value),
    "purpose": lambda value: move(purpose=value),
    "listen": lambda value: move(listen=value),
    "message": lambda value: make("Send", message=value),
    "to": lambda value: make("Send", message=words(), to=value),
    "content": lambda value: make("Send", message=words(content=value)),
    "deep content": lambda value: make("Send", message=words(content=[[value]])),
    "sender": lambda value: make("Send", message=words(sender=value)),
    "event": lambda value: make("Note", event=value),
    "text": lambda value: decided(text=value),
    "goal": lambda value: decided(goal=value),
    "options": lambda value: decided(options=value),
    "values": lambda value: decided(values={"a": [value]}),
    "time_s": lambda value: note("MapComplete", time_s=value),
    "robot": lambda value: note("MapComplete", robot=value),
    "nodes": lambda value: note("Learned", nodes=value),
    "boundary": lambda value: node(boundary=value),
    "tags": lambda value: node(tags=value),
    "serial": lambda value: node(serial=value),
    "rule": lambda value: chosen(rule=value),
    "costs": lambda value: chosen(costs=value),
    "complete": lambda value: done(complete=value),
    "reason": lambda value: done(reason=value),
    "frontier": lambda value: done(frontier=value),
    "segment": lambda value: done(frontier=[[0, 0, 1, value]]),
    "on_call": lambda value: done(on_call=value),
    "exception": lambda value: make("raise", error="ValueError", text=value),
}
VALUES = (
    *(make(name) for name in MAKERS if name != "many"),
    *(make(name, sender=make("number")) for name in ("Message", "Call", "Nameless", "Sleepless")),
    *(make(name) for name in KINDS),
    *(make("raise", error=name, text="a\nb") for name in ("StopIteration", "SystemExit")),
    *(make("array", of=of) for of in (["a"], [[1.0, 2.0], [3.0, 4.0]], 5.0)),
    *([make("deep")], [make("rude")], {"a": make("own list")}, make("list", of=[make("nan")])),
    *(None, True, -1, 0, 99, 1.5, -1e-9, 1e-300, 1e308, -1e308, 2**63, 2**64, 10**30),
    *("", "a\nb", "\x1b[2J", "\ud800", "x" * 9000),
    *([], [[]], {}, [0], [0, 0], [[0, 0]], [[0, 0], [1, 0], [1, 1]], [[0, "a"]], {"a": 1}),
    *([1e308, 1e308], [[1e308, 1e308]] * 3),
)


@pytest.mark.parametrize("name", PLACES)
def test_strange_answers_are_taken_or_refused(name, tmp_path):
    target = TARGETS["strategy"]
    for value in VALUES:
        script = {"first": [PLACES[name](value)], "again": [], "rounds": 0}
        one = Input(json.dumps(script).encode(), ".json", {})
        outcome = judge(target, one, tmp_path)
        assert outcome.verdict.is_right, (value, outcome)
