"""The state machine of progress: every transition by hand, and its laws on random events."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.progress import Event, Progress, State

LIMITS = MultiSrtOptions(
    crowded_after=2, jammed_after=4, boxed_in_after=3, gives_up_after=7, max_rounds=2
)


def after(*events: Event) -> Progress:
    progress = Progress(LIMITS)
    for event in events:
        progress.note(event)
    return progress


@pytest.mark.parametrize(
    ("setbacks", "state"),
    [
        (0, State.CLEAR),
        (1, State.CLEAR),
        (2, State.CROWDED),
        (3, State.CROWDED),
        (4, State.JAMMED),
        (6, State.JAMMED),
        (7, State.BOXED_IN),
        (9, State.BOXED_IN),
    ],
)
def test_setbacks_lead_from_clear_to_jammed_and_to_giving_up(setbacks, state):
    assert after(*[Event.SETBACK] * setbacks).state is state


@pytest.mark.parametrize("setbacks", [0, 1, 2, 5])
@pytest.mark.parametrize("event", [Event.NEW_PLACE, Event.NEW_TASK])
def test_a_new_place_or_a_new_task_clears(setbacks, event):
    progress = after(*[Event.SETBACK] * setbacks, event)
    assert (progress.state, progress.setbacks) == (State.CLEAR, 0)


@pytest.mark.parametrize("setbacks", range(6))
def test_a_path_leads_back_to_where_the_robot_was(setbacks):
    before = [Event.SETBACK] * setbacks
    assert after(*before, Event.PATH).state is after(*before).state
    assert after(*before, Event.NO_PATH).state is State.STUCK
    assert after(*before, Event.NO_PATH, Event.PATH).state is after(*before).state
    assert after(*before, *[Event.NO_PATH] * 9, Event.PATH).state is after(*before).state


def test_no_room_at_the_start_boxes_in_at_once():
    assert after(Event.NEW_TASK, Event.NO_ROOM).state is State.BOXED_IN
    assert after(Event.NO_ROOM, Event.PATH).state is State.CLEAR


def test_no_path_in_a_row_boxes_in():
    assert after(*[Event.NO_PATH] * 3).state is State.STUCK
    assert after(*[Event.NO_PATH] * 4).state is State.BOXED_IN
    assert after(*[Event.NO_PATH] * 3, Event.PATH, *[Event.NO_PATH] * 3).state is State.STUCK


def test_no_path_keeps_a_robot_that_has_given_up_boxed_in():
    assert after(*[Event.SETBACK] * 7, Event.NO_PATH).state is State.BOXED_IN
    assert after(*[Event.SETBACK] * 7, Event.NO_PATH, Event.PATH).state is State.JAMMED


def test_a_robot_may_give_up_as_soon_as_it_is_jammed():
    limits = msgspec.structs.replace(LIMITS, gives_up_after=LIMITS.jammed_after)
    progress = Progress(limits)
    states = []
    for _ in range(limits.jammed_after):
        progress.note(Event.SETBACK)
        states.append(progress.state)
    assert states[-2:] == [State.CROWDED, State.BOXED_IN]


def test_setbacks_do_not_count_where_there_is_no_path():
    progress = after(Event.NO_PATH, Event.SETBACK, Event.SETBACK, Event.SETBACK, Event.PATH)
    assert (progress.state, progress.setbacks) == (State.CLEAR, 0)


def test_a_new_task_does_not_free_a_robot_that_is_boxed_in():
    boxed_in = [Event.NO_PATH] * 4
    assert after(*boxed_in, Event.NEW_TASK).is_boxed_in
    assert after(*boxed_in, Event.NEW_TASK, Event.NO_PATH).is_boxed_in
    assert not after(*boxed_in, Event.NEW_TASK, Event.PATH).is_boxed_in


def test_a_robot_is_hindered_while_crowded_or_jammed():
    hindered = {State.CROWDED, State.JAMMED}
    for events in ([], [Event.SETBACK] * 2, [Event.SETBACK] * 4, [Event.NO_PATH] * 4):
        progress = after(*events)
        assert progress.is_hindered == (progress.state in hindered)


@given(st.lists(st.sampled_from(Event), max_size=40))
def test_any_events_lead_to_a_state_that_its_limits_allow(events):
    progress = after(*events)
    in_a_row, has_room = 0, True
    for event in events:
        if event is Event.NO_ROOM:
            has_room = False
        elif event in (Event.PATH, Event.NEW_PLACE):
            has_room = True
        if event is Event.NO_PATH:
            in_a_row += 1
        elif event in (Event.PATH, Event.NEW_PLACE):
            in_a_row = 0
    if progress.state is State.BOXED_IN:
        gave_up = progress.setbacks == 0 or progress.setbacks >= LIMITS.gives_up_after
        assert in_a_row > LIMITS.boxed_in_after or gave_up or not has_room
    assert progress.state is not State.CROWDED or progress.setbacks >= LIMITS.crowded_after
    assert progress.state is not State.JAMMED or progress.setbacks >= LIMITS.jammed_after
    assert 1 <= progress.backoff <= 1 + LIMITS.jammed_after


def test_rounds_of_questions_are_counted_by_step():
    progress = Progress(LIMITS)
    assert [progress.has_asked_enough() for _ in range(4)] == [False, False, True, False]
    progress.begin_step()
    assert [progress.has_asked_enough() for _ in range(3)] == [False, False, True]


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ({"crowded_after": 0}, "crowded_after is 0; it must be at least 1"),
        ({"max_rounds": 0}, "max_rounds is 0; it must be at least 1"),
        ({"left_out_s": 0.0}, "left_out_s is 0.0; it must be positive"),
        ({"crowded_after": 5, "jammed_after": 4}, "jammed_after is 4; it must be at least crowded"),
        ({"gives_up_after": 11}, "gives_up_after is 11; it must be at least jammed_after"),
    ],
)
def test_limits_that_make_no_sense_are_refused(limits, said):
    with pytest.raises(InvalidInputError, match=said):
        MultiSrtOptions(**limits)
