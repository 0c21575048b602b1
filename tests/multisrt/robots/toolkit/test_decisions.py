import math
from typing import Any

import msgspec
import numpy as np
import pytest

import multisrt as ms
from multisrt.events import (
    MAX_NAME_LENGTH,
    MAX_OPTIONS,
    MAX_TEXT_LENGTH,
    MAX_VALUES,
    AnyEvent,
    Decided,
)
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.explorer import Done, Note, Sense
from multisrt.robots.registry import registered
from multisrt.robots.toolkit import decided


def decision(**changes) -> Decided:
    known: dict[str, Any] = {"time_s": 0.0, "robot": 0, "text": "so"}
    return Decided(**known | changes)


def test_arrays_of_any_kind_are_taken(robot):
    note = decided(
        robot(),
        np.float32(1.5),
        "why not",
        np.array([1.0, 2.0, 0.3]),
        [(1, 2), np.array([3.0, 4.0])],
        path_m=np.array([1.0, math.inf], np.float32),
        gain=[None, 2],
    )
    assert note == Note(
        decision(
            time_s=1.5,
            text="why not",
            goal=(1.0, 2.0),
            options=((1.0, 2.0), (3.0, 4.0)),
            values={"path_m": (1.0, None), "gain": (None, 2.0)},
        )
    )
    again = msgspec.json.decode(msgspec.json.encode(note.event), type=AnyEvent)
    assert again == note.event


def test_of_many_options_the_best_and_the_goal_are_kept(robot):
    places = np.column_stack([np.arange(300.0), np.zeros(300)])
    costs = np.abs(places[:, 0] - 150.0)
    costs[151] = math.inf
    event = decided(robot(), 0.0, "far away", places[299], places, cost=costs).event
    assert isinstance(event, Decided)
    assert len(event.options) == MAX_OPTIONS
    assert event.options[-1] == (299.0, 0.0)
    kept = [x for x, _ in event.options[:-1]]
    assert kept == sorted(kept)
    assert 151.0 not in kept
    assert max(abs(x - 150.0) for x in kept) <= 50.0


@pytest.mark.parametrize(
    ("call", "told"),
    [
        ({"goal": [(1.0, 2.0), (3.0, 4.0)]}, "goal has 2 places"),
        ({"options": "everywhere"}, "options is 'everywhere'"),
        ({"options": [(1.0, 2.0)], "cost": [1.0, 2.0]}, "for each of 1 options"),
        ({"options": [(1.0, 2.0)], "cost": "much"}, "cost is 'much'"),
    ],
)
def test_what_cannot_be_recorded_is_told(robot, call, told):
    with pytest.raises(InvalidInputError) as error:
        decided(robot(), 0.0, "so", **call)
    assert told in str(error.value)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (
            {"text": "x" * (MAX_TEXT_LENGTH + 1)},
            f"{MAX_TEXT_LENGTH + 1} characters of text; give at most",
        ),
        ({"text": 5}, "is 5; give words"),
        ({"options": ((0.0, 0.0),) * (MAX_OPTIONS + 1)}, f"{MAX_OPTIONS + 1} options"),
        ({"values": {str(k): () for k in range(MAX_VALUES + 1)}}, "11 kinds of values"),
        ({"values": {"x" * (MAX_NAME_LENGTH + 1): ()}}, "41 characters in the name"),
        ({"options": ((0.0, 0.0),), "values": {"a": ()}}, "0 values 'a' for 1 options"),
    ],
)
def test_a_decision_is_bounded_when_made_and_when_read(changes, told):
    with pytest.raises(InvalidInputError) as error:
        decision(**changes)
    assert told in str(error.value)
    line = {"event": "decided", "time_s": 0, "robot": 0, "text": "so"} | changes
    if isinstance(line["text"], str):
        with pytest.raises(msgspec.ValidationError) as unread:
            msgspec.json.decode(msgspec.json.encode(line), type=AnyEvent)
        assert told in str(unread.value)


class Deliberate:
    """Looks, decides twice, and stays."""

    def __init__(self, me):
        self.me = me

    def run(self):
        scan = yield Sense()
        corners = scan.boundary[:2]
        yield decided(self.me, scan.time_s, "first", corners[0], corners, far=np.array([1.0, 2.0]))
        yield Note(decision(text="by hand", options=corners, values={"a": [1.0, 2.0]}))
        yield Done(complete=False, reason="has decided")


def test_decisions_are_recorded_read_and_counted(tmp_path):
    class NoOptions(msgspec.Struct, frozen=True):
        pass

    strategy = ms.Strategy(
        name="deliberate",
        summary="Decides",
        options=NoOptions,
        explorer=lambda me, options: Deliberate(me),
    )
    with registered(strategy):
        run = ms.explore("open", strategy="deliberate")
    run.recording.save(tmp_path / "recording.jsonl")
    again = ms.Recording.load(tmp_path / "recording.jsonl")
    first, second = again.of(Decided)
    assert (first.text, second.text) == ("first", "by hand")
    assert first.goal == first.options[0]
    assert second.values == {"a": (1.0, 2.0)}
    assert run.metrics.decisions == 2
    told = run.why(robot=0)
    assert "by hand" in told
