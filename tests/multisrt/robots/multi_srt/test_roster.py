"""What a robot knows of the others: who answers, who is lost, who is left out for a while."""

import pytest

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.body import PlanningBody
from multisrt.robots.explorer import RadioSelf, Sighting
from multisrt.robots.multi_srt.obstacles import Obstacles
from multisrt.robots.multi_srt.options import MultiSrtOptions
from multisrt.robots.multi_srt.roster import Roster
from multisrt.robots.multi_srt.whereabouts import Whereabouts


@pytest.fixture
def roster_of(robot_self):
    def build(radio=None, **options):
        me = robot_self(radio=radio or RadioSelf())
        at = Whereabouts(q_act=me.start, time_s=0.0)
        obstacles = Obstacles(PlanningBody(me.footprint, 0.02), 0.1)
        return Roster(me, MultiSrtOptions(**options), at, obstacles), at, obstacles

    return build


def seen_at(number: int, x: float, y: float) -> Sighting:
    there = Configuration(x, y, 0.0)
    return Sighting(robot=number, configuration=there, footprint=Footprint.disc(0.25))


@pytest.mark.parametrize(
    ("loss", "options", "patience"),
    [
        (0.0, {}, 1),
        # A question or its answer is lost with probability 0.19: 0.19 ** 6 < 1e-4 < 0.19 ** 5.
        (0.1, {}, 6),
        (0.1, {"silence_timeout_s": 2.0}, 4),
        (0.1, {"silence_timeout_s": 2.0, "ask_period_s": 3.0}, 1),
    ],
)
def test_patience_follows_from_loss_or_from_the_timeout(roster_of, loss, options, patience):
    roster, *_ = roster_of(RadioSelf(loss=loss, reaches_all=False), **options)
    assert roster.patience == patience


def test_a_robot_is_lost_when_it_never_answers(roster_of, robot_state):
    roster, *_ = roster_of(RadioSelf(loss=0.1, reaches_all=False))
    roster.take(robot_state(1), sender=1)
    asked = [roster.is_lost_when_asked(1) for _ in range(roster.patience + 1)]
    assert asked == [False] * roster.patience + [True]
    assert roster.is_out(1)
    assert not roster.answers(1)
    roster.hear_from(1)
    assert roster.answers(1)
    assert not roster.is_lost_when_asked(1)


def test_a_robot_is_left_out_only_until_its_time(roster_of, robot_state):
    roster, at, _ = roster_of()
    roster.take(robot_state(1), sender=1)
    roster.left_out_until_s[1] = 30.0
    for time_s, out in ((0.0, True), (29.9, True), (30.0, False)):
        at.time_s = time_s
        assert roster.is_out(1) == out
        assert (1 in roster.present()) != out
        assert roster.responds(1) != out
    assert roster.answers(1)
    assert not roster.responds(2)  # never heard from


def test_only_newer_states_are_kept(roster_of, robot_state):
    roster, *_ = roster_of()
    roster.take(robot_state(1, said=5, step=2), sender=1)
    roster.take(robot_state(1, said=4, step=1), sender=2)
    assert roster.states[1].step == 2
    roster.take(robot_state(0, said=9), sender=2)
    assert 0 not in roster.states


def test_hearsay_is_not_passed_on(roster_of, robot_state):
    roster, at, _ = roster_of()
    roster.take(robot_state(1), sender=1)
    roster.take(robot_state(2), sender=1)
    assert [state.robot for state in roster.vouched([1, 2])] == [1]
    at.time_s = 100.0
    assert roster.vouched([1, 2]) == ()


def test_bodies_that_are_heard_of_are_no_obstacles(roster_of, robot_state):
    roster, _, obstacles = roster_of()
    for phase, avoided in (("idle", True), ("moving", False)):
        obstacles.silent[1] = obstacles.avoided[1] = seen_at(1, 2.0, 0.0)
        roster.take(robot_state(1, phase=phase), sender=1)
        assert not obstacles.silent
        assert (1 in obstacles.avoided) == avoided


def test_news_is_a_standing_robot_seen_elsewhere(roster_of, robot_state):
    roster, *_ = roster_of()
    assert not roster.is_news(seen_at(1, 2.0, 0.0))
    roster.take(robot_state(1, [(2.0, 0.0)]), sender=1)
    assert not roster.is_news(seen_at(1, 2.0, 0.0))
    assert roster.is_news(seen_at(1, 2.0, 0.1))
    roster.take(robot_state(1, [(2.0, 0.0), (4.0, 0.0)], moving=True), sender=1)
    assert not roster.is_news(seen_at(1, 3.0, 0.0))
    roster.lost[1] = None
    assert not roster.is_news(seen_at(1, 9.0, 0.0))
