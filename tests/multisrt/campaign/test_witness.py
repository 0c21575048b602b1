"""Messages and sightings, as seen between explorers and the simulation."""

import math
from types import SimpleNamespace
from typing import Any

import pytest
import shapely

from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.mission import judge
from multisrt.campaign.witness import Witness
from multisrt.campaign.witness.sightings import (
    EndOfMotion,
    Looked,
    bodies_in_sight,
    ends_of_motions,
)
from multisrt.environments.environment import Environment
from multisrt.events import Died, Motion, Sent
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.explorer import (
    Done,
    Look,
    Move,
    Moved,
    Receive,
    Received,
    Send,
    Sighting,
    TimedOut,
)
from multisrt.robots.messages import Message
from multisrt.simulation.setting_up import set_up
from multisrt.simulation.simulation import Simulation
from multisrt.spec import (
    BaseSpec,
    CatalogEnvironment,
    Death,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)
from tests.multisrt.campaign.tampering import written

STARTS = ((1.0, 1.5, 0.0), (2.0, 1.5, 0.0), (3.0, 1.5, 0.0))
END_S = 20.0


class Hello(Message, frozen=True):
    text: str = "hello"


class Alarm(Message, frozen=True):
    wakes = True


def witness_of(run):
    """Return the witness of a run that is played by hand."""
    setup: Any = SimpleNamespace(spec=run.recording.spec, explorers=())
    return Witness(setup)


class Played:
    """A run of three robots that is played by hand, and judged."""

    def __init__(self, *, faults=(), **radio):
        self.run = written(
            starts=STARTS, end_s=END_S, radio=RadioSpec(**radio), faults=tuple(faults)
        )
        self.witness = witness_of(self.run)

    def send(self, time_s, message, reached, to=None, lost=()):
        self.witness.overhear(message.sender, time_s, None, Send(message=message, to=to))
        self.base_sends(time_s, message, reached, lost, sender=message.sender)

    def base_sends(self, time_s, message, reached, lost=(), sender=3):
        self.witness.watch(
            Sent(
                time_s=time_s,
                robot=sender,
                kind=message.kind,
                size_bytes=1,
                reached=tuple(reached),
                lost=tuple(lost),
            )
        )

    def wait(self, robot, begin_s, end_s, *messages, timeout_s=None):
        outcome = Received(messages, end_s) if messages else TimedOut(end_s)
        self.witness.overhear(robot, begin_s, None, Receive(timeout_s=timeout_s))
        self.witness.overhear(robot, end_s, outcome, Done(complete=True, reason="heard"))

    def says(self):
        return [violation.says for violation in self.witness.violations(self.run)]


@pytest.mark.parametrize(
    ("begin_s", "end_s", "says"),
    [
        (0.0, 2.5, None),
        (0.0, 3.0, None),
        (7.0, 7.0, None),  # it had arrived before
        (0.0, 1.9, "the message of robot 0 at 1.00 s (hello) is received 0.900 s later by robot 1"),
        (0.0, 3.1, "the message of robot 0 at 1.00 s (hello) is received 2.100 s later by robot 1"),
        (7.0, 7.5, "the message of robot 0 at 1.00 s (hello) is received 6.500 s later by robot 1"),
    ],
)
def test_a_message_is_received_when_it_may_arrive(begin_s, end_s, says):
    played, hello = Played(latency_s=1.0, jitter_s=1.0), Hello(sender=0)
    played.send(1.0, hello, [1])
    played.wait(1, begin_s, end_s, hello)
    assert played.says() == ([] if says is None else [says])


def test_a_message_is_received_once_and_where_it_was_sent():
    first, again = Hello(sender=0), Hello(sender=0)
    played = Played()
    played.send(1.0, first, [1])
    played.send(1.0, again, [1])
    played.wait(1, 0.0, 1.0, first, again)
    assert played.says() == []
    played.wait(1, 2.0, 3.0, first)
    assert "robot 1 receives a message (hello) that was not sent to it" in played.says()[0]
    played = Played()
    played.send(1.0, first, [1])
    played.wait(2, 0.0, 1.0, first)
    assert "robot 2 receives a message (hello) that was not sent to it" in played.says()[0]


def test_a_message_for_one_reaches_no_other():
    played = Played()
    played.send(1.0, Hello(sender=0), [1], to=1)
    assert played.says() == []
    played.send(2.0, Hello(sender=0), [1], to=1, lost=[2])
    assert played.says() == ["a message (hello) for robot 1 reaches robot 2"]


def test_messages_that_have_arrived_are_received():
    old, new = Hello(sender=0), Hello(sender=2)
    played = Played(latency_s=1.0)
    played.send(1.0, old, [1])
    played.send(4.0, new, [1])
    played.wait(1, 3.0, 5.0, new)
    assert played.says() == ["the message of robot 0 at 1.00 s (hello) is not received by 5.000 s"]
    played = Played(latency_s=1.0)
    played.send(1.0, old, [1])
    played.wait(1, 3.0, 5.0, timeout_s=2.0)
    assert played.says() == ["the message of robot 0 at 1.00 s (hello) is not received by 5.000 s"]


@pytest.mark.parametrize(
    ("last", "says"),
    [
        (Receive(), ["the message of robot 0 at 1.00 s (hello) is never received"]),
        (
            Done(complete=True, reason="done", on_call=True),
            ["the message of robot 0 at 1.00 s (hello) is never received"],
        ),
        (Done(complete=True, reason="done"), []),
    ],
)
def test_a_robot_that_waits_at_the_end_has_received_all(last, says):
    played = Played(latency_s=1.0)
    played.witness.overhear(1, 0.5, None, last)
    played.send(1.0, Hello(sender=0), [1])
    assert played.says() == says


def test_the_dead_and_what_arrives_after_the_end_wait_for_nothing():
    played = Played(latency_s=1.0, faults=[Death(robot=1, time_s=1.5)])
    played.witness.overhear(1, 0.5, None, Receive())
    played.send(1.0, Hello(sender=0), [1])
    played.witness.watch(Died(time_s=1.5, robot=1, configuration=(0.0, 0.0, 0.0), doing="waiting"))
    played.witness.overhear(2, 0.5, None, Receive())
    played.send(END_S - 0.5, Hello(sender=0), [2])
    assert played.says() == []


@pytest.mark.parametrize(
    ("begin_s", "is_received", "may_be"),
    [
        (1.2, True, True),
        (1.2, False, False),
        (1.5, True, True),
        (1.5, False, True),  # it may have arrived as the silence began
        (1.8, True, False),
        (1.8, False, True),
        (5.0, False, False),
    ],
)
def test_what_arrives_in_a_silence_is_not_received(begin_s, is_received, may_be):
    silence = Silence(robot=1, time_s=2.0, duration_s=2.0)
    played = Played(latency_s=0.5, jitter_s=0.2, faults=[silence])
    hello = Hello(sender=0)
    played.send(begin_s, hello, [1])
    if is_received:
        played.wait(1, 0.0, begin_s + 0.6, hello)
    else:
        played.wait(1, 0.0, begin_s + 5.0, timeout_s=begin_s + 5.0)
    assert (played.says() == []) is may_be


def moving(played, robot, time_s, outcome=None):
    way = Trajectory((Waypoint(0.0, 1.0, 1.5, 0.0), Waypoint(9.0, 2.0, 1.5, 0.0)))
    played.witness.overhear(robot, time_s, outcome, Move(trajectory=way, listen=True))


def test_on_the_way_only_what_wakes_is_received_at_once():
    hello, alarm = Hello(sender=0), Alarm(sender=0)
    played = Played(latency_s=1.0)
    moving(played, 1, 0.0)
    played.send(1.0, hello, [1])
    played.send(4.0, alarm, [1])
    played.witness.overhear(1, 5.0, Received((hello, alarm), 5.0), Receive())
    assert played.says() == []
    played.send(6.0, Alarm(sender=0), [1])
    moved = Moved(configuration=Configuration(2.0, 1.5), time_s=9.0)
    played.witness.overhear(1, 9.0, moved, Receive(timeout_s=1.0))
    played.witness.overhear(1, 10.0, TimedOut(10.0), Receive())
    assert played.says() == ["the message of robot 0 at 6.00 s (alarm) is not received by 10.000 s"]


def test_who_is_woken_late_is_found():
    alarm = Alarm(sender=0)
    played = Played(latency_s=1.0)
    moving(played, 1, 0.0)
    played.send(1.0, alarm, [1])
    played.witness.overhear(1, 3.0, Received((alarm,), 3.0), Receive())
    assert played.says() == [
        "the message of robot 0 at 1.00 s (alarm) is received 2.000 s later by robot 1"
    ]


def test_messages_of_the_base_station_are_known_by_their_kind():
    hello = Hello(sender=3)
    played = Played(latency_s=1.0)
    played.base_sends(1.0, hello, [1])
    played.wait(1, 0.0, 2.0, hello)
    assert played.says() == []
    played.base_sends(5.0, hello, [1])
    played.wait(1, 4.0, 8.0, hello)
    says = "the message of the base station at 5.00 s (hello) is received 3.000 s later by robot 1"
    assert played.says() == [says]


def test_of_equal_messages_one_may_have_been_lost_in_a_silence():
    hello = Hello(sender=3)
    played = Played(jitter_s=2.0, faults=[Silence(robot=1, time_s=0.5, duration_s=0.5)])
    played.base_sends(0.0, hello, [1])  # arrives at 0.7 s, in the silence
    played.base_sends(1.2, hello, [1])  # arrives at 1.5 s
    played.wait(1, 0.0, 1.5, hello)
    played.wait(1, 1.5, 6.0, timeout_s=4.5)
    assert played.says() == []


def test_what_was_lost_in_a_silence_excuses_no_later_message():
    played = Played(faults=[Silence(robot=1, time_s=0.5, duration_s=1.0)])
    for k in range(200):  # messages that are gone leave their addresses to others
        played.send(1.0, Hello(sender=0), [1])
        played.send(2.0 + 0.01 * k, Hello(sender=0), [1])
    played.wait(1, 5.0, 6.0, timeout_s=1.0)
    assert "is not received by 6.000 s" in played.says()[0]


def test_silences_that_overlap_are_one():
    silences = [
        Silence(robot=1, time_s=0.0, duration_s=10.0),
        Silence(robot=1, time_s=5.0, duration_s=15.0),
    ]
    played, hello = Played(latency_s=1.0, jitter_s=4.0, faults=silences), Hello(sender=0)
    played.send(7.0, hello, [1])
    played.wait(1, 6.0, 9.0, hello)
    assert "is received 2.000 s later by robot 1" in played.says()[0]


@pytest.mark.parametrize(("delay_s", "finds"), [(1.0, True), (1.7, True), (None, False)])
def test_delays_differ_with_jitter(delay_s, finds):
    played = Played(latency_s=1.0, jitter_s=1.0)
    for n in range(5):
        begin_s, hello = 3.0 * n, Hello(sender=0)
        played.send(begin_s, hello, [1])
        took_s = 1.0 + 0.2 * n if delay_s is None else delay_s
        played.wait(1, begin_s, begin_s + took_s, hello)
    says = played.says()
    assert len(says) == finds
    assert all(text.startswith("the delays of 5 messages differ by ") for text in says)


@pytest.mark.parametrize(("end_s", "right"), [(3.0, True), (2.5, False), (3.5, False)])
def test_a_wait_in_vain_is_as_long_as_was_said(end_s, right):
    played = Played()
    played.wait(1, 1.0, end_s, timeout_s=2.0)
    says = f"robot 1 waits from 1.000 s to {end_s:.3f} s instead of 3.000 s"
    assert played.says() == ([] if right else [says])


WALLED = Environment(
    "walled", shapely.box(0.0, 0.0, 4.0, 3.0).difference(shapely.box(2.4, 0.0, 2.6, 2.5))
)


def seen(robot, x, y, heading=0.0):
    disc = Footprint.disc(0.25)
    return Sighting(robot=robot, configuration=Configuration(x, y, heading), footprint=disc)


def looked(run, *sightings, time_s=1.0):
    found = next(bodies_in_sight(run, [Looked(0, time_s, sightings)]), None)
    return None if found is None else found.says


@pytest.mark.parametrize(
    ("sightings", "says"),
    [
        ([seen(1, 2.0, 1.5)], None),
        ([seen(1, 2.0, 1.5, math.tau)], None),
        ([], "robot 0 does not see robot 1 which is in sight, at 1.00 s"),
        ([seen(1, 2.0, 1.6)], "robot 0 sees robot 1 where it is not, at 1.00 s"),
        ([seen(1, 2.0, 1.5, 0.1)], "robot 0 sees robot 1 where it is not, at 1.00 s"),
        (
            [seen(1, 2.0, 1.5), seen(2, 3.0, 1.5)],
            "robot 0 sees robot 2 through a wall, at 1.00 s",
        ),
    ],
)
def test_bodies_are_seen_where_they_are(sightings, says):
    run = written(starts=STARTS, environment=WALLED)
    assert looked(run, *sightings) == says


@pytest.mark.parametrize(
    ("range_m", "sees", "says"),
    [
        (0.8, True, None),
        (0.8, False, "robot 0 does not see robot 1 which is in sight, at 1.00 s"),
        (0.7, True, "robot 0 sees robot 1 0.750 m away, out of range, at 1.00 s"),
        (0.7, False, None),
    ],
)
def test_bodies_are_seen_within_range(range_m, sees, says):
    robots = (RobotSpec(range_finder=RangeFinderSpec(range_m=range_m)), RobotSpec())
    run = written(starts=STARTS[:2], robots=robots)
    assert looked(run, *([seen(1, 2.0, 1.5)] if sees else [])) == says


def test_bodies_that_move_are_where_they_are_then():
    way = ((0.0, 2.0, 1.5, 0.0), (2.0, 3.0, 1.5, 0.0))
    motion = Motion(time_s=0.0, robot=1, waypoints=way, purpose="explore")
    run = written([motion], starts=STARTS[:2])
    assert looked(run, seen(1, 2.5, 1.5)) is None
    assert looked(run, seen(1, 2.5, 1.5), time_s=0.5) == (
        "robot 0 sees robot 1 where it is not, at 0.50 s"
    )


def test_bodies_are_seen_as_they_are():
    run = written(starts=STARTS[:2], robots=(RobotSpec(), RobotSpec(footprint="disc:0.2")))
    assert looked(run, seen(1, 2.0, 1.5)) == "robot 0 sees robot 1 as another body, at 1.00 s"


def told(run, by, blocked_by=None, x=1.0, time_s=1.0):
    moved = Moved(
        configuration=Configuration(x, 1.5, 0.0),
        time_s=time_s,
        blocked_by=blocked_by,
    )
    found = next(ends_of_motions(run, [EndOfMotion(0, 1.0, moved, by)]), None)
    return "" if found is None else found.says.partition(" at 1.00 s ")[2]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"by": None}, None),
        ({"by": 1, "blocked_by": seen(1, 2.0, 1.5)}, None),
        ({"by": 1}, "by nobody, and not robot 1"),
        ({"by": None, "blocked_by": seen(1, 2.0, 1.5)}, "by robot 1, and not nobody"),
        ({"by": 1, "blocked_by": seen(2, 3.0, 1.5)}, "by robot 2, and not robot 1"),
        ({"by": 1, "blocked_by": seen(1, 2.1, 1.5)}, "by robot 1 where it is not"),
        ({"by": None, "x": 1.1}, "where it is not"),
        ({"by": None, "time_s": 0.9}, "at 0.900 s"),
    ],
)
def test_robots_are_told_how_their_motions_end(given, says):
    assert told(written(starts=STARTS), **given) == (says or "")


def test_looks_are_taken_from_what_explorers_are_sent():
    run = written(starts=STARTS[:2])
    witness = witness_of(run)
    witness.overhear(0, 1.0, None, Look())
    witness.overhear(0, 1.0, (seen(1, 3.9, 1.5),), Receive())
    (found,) = witness.violations(run)
    assert (found.invariant, found.robot, found.time_s) == ("bodies-in-sight", 0, 1.0)


@pytest.mark.parametrize("strategy", ["srt-radial", "minpos", "self-bidding"])
def test_runs_with_a_bad_radio_are_judged_and_hold(strategy, monkeypatch):
    world = CatalogEnvironment(name="rooms", parameters={"size_m": 12.0, "rooms_per_side": 2})
    spec = RunSpec(
        environment=world,
        strategy=strategy,
        robots=(RobotSpec(),) * 3,
        radio=RadioSpec(latency_s=0.3, jitter_s=0.8, loss=0.2),
        base=BaseSpec(x=2.0, y=2.0) if strategy == "minpos" else None,
        faults=(Silence(robot=1, time_s=5.0, duration_s=10.0),),
        stop=StopRule(max_time_s=60.0),
    )
    received: list[Message] = []
    looks: list[bool] = []
    taken = Witness.overhear

    def overhear(self, robot, now_s, outcome, action):
        received.extend(outcome.messages if isinstance(outcome, Received) else ())
        looks.append(isinstance(action, Look))
        taken(self, robot, now_s, outcome, action)

    monkeypatch.setattr(Witness, "overhear", overhear)
    verdict = judge(spec)
    assert verdict.violations == ()
    assert verdict.digest
    assert len(received) > 10
    assert any(looks) or strategy != "srt-radial"


def test_what_is_overheard_changes_nothing():
    spec = RunSpec(environment=CatalogEnvironment(name="open"), robots=(RobotSpec(),) * 2)
    setup = set_up(spec)
    witness = Witness(setup)
    simulation = Simulation(setup, watch=witness.watch, overhear=witness.overhear)
    while simulation.has_events():
        simulation.clock.step()
    recording = simulation.finish()
    plain = Simulation(set_up(spec))
    while plain.has_events():
        plain.clock.step()
    assert recording.footer == plain.finish().footer
    run = JudgedRun(recording=recording, environment=setup.environment)
    assert list(witness.violations(run)) == []
