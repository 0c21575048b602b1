"""The state machine: which event leads where, and how often a robot tries in vain."""

import pytest

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.occupancy import Occupancy
from multisrt.robots.frontier.bodies import MOVED_M
from multisrt.robots.frontier.course import Course
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.progress import TRANSITIONS, Event, Progress, State


def progress_with(**options):
    """A robot that stands at the origin, and knows nothing."""
    course = Course(Configuration(0.0, 0.0, 0.0), 0.0)
    return Progress(FrontierOptions(**options), course, Occupancy(0.1, 0.25)), course


def learn(progress):
    progress._raster._changes.revision += 1


def test_every_state_can_be_left_and_reached():
    assert TRANSITIONS.keys() == {*State}
    reached, found = {State.CHOOSING}, [State.CHOOSING]
    for state in found:
        following = {*TRANSITIONS[state].values()} - reached
        reached |= following
        found += following
    assert reached == {*State}
    for state in State:
        # From everywhere a robot comes to choose again.
        steps, now = 0, {state}
        while State.CHOOSING not in now:
            now = {after for one in now for after in TRANSITIONS[one].values()}
            steps += 1
            assert steps < len(State)


def test_an_event_leads_to_the_next_state():
    progress, _ = progress_with()
    for event, state in (
        (Event.GOAL, State.DRIVING),
        (Event.MET, State.MEETING),
        (Event.DETOUR, State.DRIVING),
        (Event.ASKED, State.YIELDING),
        (Event.GAVE_WAY, State.CHOOSING),
        (Event.BARRED, State.WAITING),
        (Event.BLOCKED, State.CHOOSING),
        (Event.EXPLORED, State.COMPLETE),
        (Event.CALLED_ON, State.CHOOSING),
    ):
        progress.advance(event)
        assert (progress.state, progress.because) == (state, event)


def test_an_event_that_cannot_end_a_state_is_refused():
    progress, _ = progress_with()
    with pytest.raises(InvalidInputError, match="'met' cannot end CHOOSING"):
        progress.advance(Event.MET)
    assert progress.state is State.CHOOSING


def test_jams_count_for_one_place_and_one_map():
    progress, course = progress_with(max_jams=3)
    for other in (1, 1, 2):
        assert not progress.is_jammed
        progress.note_jam(other)
    assert progress.is_jammed
    assert progress.standstill.jams == {1: 2, 2: 1}
    course.at = Configuration(0.5 * MOVED_M, 0.0, 0.0)
    assert progress.is_jammed
    learn(progress)
    assert not progress.is_jammed
    for _ in range(3):
        progress.note_jam(1)
    course.at = Configuration(2.0 * MOVED_M, 0.0, 0.0)
    assert not progress.is_jammed
    assert progress.standstill.jams == {}


def test_who_makes_room_instead_of_passing_is_jammed_wherever_it_moves():
    progress, course = progress_with(max_jams=3)
    for step in range(3):
        assert not progress.is_jammed
        course.at = Configuration(step * 2.0 * MOVED_M, 0.0, 0.0)
        progress.note_asked_instead(1)
    assert progress.is_jammed
    assert progress.jams == {1: 3}
    learn(progress)
    assert not progress.is_jammed
    progress.note_asked_instead(2)
    progress.note_jam(4)
    assert progress.jams == {2: 1, 4: 1}


def test_giving_way_is_counted_by_robot_wherever_it_moves_until_the_map_changes():
    progress, course = progress_with()
    assert [progress.note_giving_way(1) for _ in range(3)] == [0, 1, 2]
    course.at = Configuration(2.0 * MOVED_M, 0.0, 0.0)
    assert progress.note_giving_way(1) == 3
    assert progress.note_giving_way(2) == 0
    assert progress.jams == {}
    learn(progress)
    assert progress.note_giving_way(1) == 0


def test_a_detour_is_tried_anew_from_another_place_only():
    progress, course = progress_with()
    assert not progress.has_detoured
    progress.note_detour()
    learn(progress)
    assert progress.has_detoured
    course.at = Configuration(2.0 * MOVED_M, 0.0, 0.0)
    assert not progress.has_detoured
    course.at = Configuration(0.0, 0.0, 0.0)
    assert progress.has_detoured


def test_detours_from_several_places_are_remembered_until_the_map_changes():
    progress, course = progress_with()
    here, there = Configuration(0.0, 0.0, 0.0), Configuration(9.0, 0.0, 0.0)
    for at in (here, there):
        course.at = at
        assert not progress.has_detoured
        progress.note_detour()
    # Sent from one door to the other, it is not sent back.
    course.at = here
    assert progress.has_detoured
    learn(progress)
    assert not progress.has_detoured
    course.at = there
    assert progress.has_detoured


def test_waits_count_until_the_map_changes():
    progress, course = progress_with(max_waits=2)
    for _ in range(2):
        assert progress.may_wait
        progress.note_wait()
    assert not progress.may_wait
    course.at = Configuration(5.0, 0.0, 0.0)
    assert not progress.may_wait
    learn(progress)
    assert progress.may_wait


def test_a_goal_without_a_free_path_is_given_up_at_the_second_try_here_or_the_fourth_anywhere():
    progress, course = progress_with()
    far, near = (9.0, 9.0), (1.0, 1.0)
    assert not progress.note_no_path(near)
    assert progress.note_no_path(near)
    # Not the goal, but the place at which the robot stands, may be at fault.
    assert progress.note_no_path(far)
    given_up = []
    for x in range(1, 4):
        course.at = Configuration(float(x), 0.0, 0.0)
        given_up.append(progress.note_no_path(far))
    assert given_up == [False, False, True]


def test_many_goals_at_one_moment_are_hasty():
    progress, course = progress_with(max_instant_goals=2)

    def take_goal(duration_s):
        progress.advance(Event.GOAL)
        course.time_s += duration_s
        progress.advance(Event.NO_WAY)
        return progress.is_hasty

    assert [take_goal(0.0) for _ in range(4)] == [False, False, True, True]
    assert [take_goal(duration_s) for duration_s in (1.0, 0.0)] == [False, False]


def test_a_goal_ends_only_when_a_meeting_is_over():
    progress, course = progress_with(max_instant_goals=1)
    for _ in range(3):
        progress.advance(Event.GOAL)
        progress.advance(Event.MET)
        course.time_s += 2.0
        progress.advance(Event.BLOCKED)
        assert not progress.is_hasty
