"""Questions for entries of the map that get no answer."""

from types import SimpleNamespace

import numpy as np
import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.explorer import Receive, RobotSelf, Send, TimedOut
from multisrt.robots.knowledge import Entries
from multisrt.robots.listening import Listener

HAS_MORE = ((1, 3, 0),)


class Quiet(Listener):
    """A robot that learns nothing."""

    ends_pauses_on_time = True

    def _merge(self, entries):
        return ()

    def _take_message(self, message):
        yield from self._ask_for_missing(message.sender, message.have)


@pytest.fixture
def listener():
    me = RobotSelf(
        robot=0,
        start=Configuration(0.0, 0.0, 0.0),
        footprint=Footprint.disc(0.25),
        kinematics=Differential(),
        range_m=4.0,
        rng=np.random.default_rng(0),
        team=3,
    )
    return Quiet(SimpleNamespace(time_s=0.0), me, Entries(), ask_period_s=2.0)


def asked_by(steps):
    """Return whom a robot asks; nobody answers, and pauses end on time."""
    asked, time_s = [], 0.0
    try:
        action = next(steps)
        while True:
            outcome = None
            if isinstance(action, Send):
                asked.append((time_s, action.to))
            else:
                assert isinstance(action, Receive)
                assert action.timeout_s is not None
                time_s += action.timeout_s
                outcome = TimedOut(time_s=time_s)
            action = steps.send(outcome)
    except StopIteration as end:
        return asked, end.value


def test_what_was_heard_of_during_a_question_is_asked_for_when_it_gets_no_answer(listener):
    assert asked_by(listener._ask_for_missing(1, HAS_MORE)) == ([(0.0, 1)], True)
    assert asked_by(listener._ask_for_missing(2, HAS_MORE)) == ([], False)
    assert asked_by(listener.ask_again()) == ([(2.0, 2)], True)
    assert asked_by(listener.ask_again()) == ([], False)


def test_a_robot_that_has_asked_nothing_rests_at_once(listener):
    assert asked_by(listener.ask_again()) == ([], False)
