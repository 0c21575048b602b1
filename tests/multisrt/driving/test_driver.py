"""Explorers outside the simulation, with bodies that are written down step by step."""

import math
from typing import ClassVar

import numpy as np
import pytest

import multisrt as ms
from multisrt.driving import Arrived, Body, Driver, decode, encode, scan_of_polygon
from multisrt.events import Blocked, Ended, MapComplete, Motion, Sensed, Sent
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.planners.motion.kinematics import Differential
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.robots.defects import ExplorerDefect
from multisrt.robots.explorer import (
    Done,
    Look,
    Move,
    Moved,
    Note,
    Receive,
    Received,
    RobotSelf,
    Send,
    Sense,
    Sighting,
    Stop,
    TimedOut,
)
from multisrt.robots.messages import Message
from multisrt.robots.strategy import NoOptions, Strategy

HERE = Configuration(1.0, 1.0, 0.0)
THERE = Configuration(3.0, 1.0, 0.0)
DISC = ms.Footprint.disc(0.25)
ROOM = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)]
END = Done(complete=True, reason="enough")
WAY = Trajectory((Waypoint(0.0, 1.0, 1.0, 0.0), Waypoint(4.0, 3.0, 1.0, 0.0)))


class Word(Message, frozen=True, kw_only=True):
    kind: ClassVar[str] = "driver's word"
    text: str = ""


class Call(Word, frozen=True, kw_only=True):
    @property
    def wakes(self) -> bool:
        return True


def self_of(robot: int = 0, team: int = 1) -> RobotSelf:
    return RobotSelf(
        robot=robot,
        start=HERE,
        footprint=DISC,
        kinematics=Differential(),
        range_m=9.0,
        rng=np.random.default_rng(0),
        team=team,
    )


class Script:
    """Yields actions, and keeps their outcomes; what it knows is passed by."""

    def __init__(self, *actions):
        self.actions = actions
        self.told = []

    @property
    def strategy(self):
        """The strategy that this explorer follows."""

        def begin_script(me, options):
            self.me = me
            return self

        return Strategy(name="script", summary="", options=NoOptions, explorer=begin_script)

    def run(self):
        for action in self.actions:
            self.told.append((yield action))


def sense():
    return scan_of_polygon(ROOM, HERE, time_s=0.5, range_m=9.0)


def arrive(move):
    return Moved(configuration=THERE, time_s=5.0)


def begin(move):
    return None


class Telling:
    """A `receive` that gives answers in turn, and keeps the times that it was asked for."""

    def __init__(self, *answers):
        self.left = list(answers)
        self.asked: list[float] = []

    def __call__(self, until_s):
        self.asked.append(until_s)
        return self.left.pop(0)


def test_three_callables_drive_a_robot():
    sent: list[tuple] = []
    noted: list[object] = []
    note = MapComplete(time_s=5.0, robot=0)
    script = Script(Sense(), Move(trajectory=WAY), Send(Word(sender=0), to=1), Note(note), END)
    driver = ms.drive(
        script.strategy,
        self_of(),
        sense=sense,
        move=arrive,
        send=lambda *letter: sent.append(letter),
        note=noted.append,
    )
    scan, moved, *rest = script.told
    assert scan.time_s == 0.5
    assert (moved.configuration, moved.time_s) == (THERE, 5.0)
    assert rest == [None, None]
    assert [(decode(data), to) for data, to in sent] == [(Word(sender=0), 1)]
    assert noted == [note]
    assert [type(event) for event in driver.events] == [Sensed, Motion, Sent, MapComplete, Ended]
    assert driver.end == driver.events[-1]
    assert (driver.is_done, driver.time_s) == (True, 5.0)


def test_a_motion_that_was_blocked_is_told_and_recorded():
    seen = Sighting(robot=1, configuration=Configuration(2.6, 1.0), footprint=DISC)
    stopped = Moved(configuration=Configuration(2.0, 1.0), time_s=3.0, blocked_by=seen)
    script = Script(Move(trajectory=WAY), END)
    driver = ms.drive(script.strategy, self_of(team=2), sense=sense, move=lambda move: stopped)
    assert script.told == [stopped]
    motion, blocked, _ = driver.events
    assert isinstance(motion, Motion)
    assert motion.waypoints == ((0.0, 1.0, 1.0, 0.0), (3.0, 2.0, 1.0, 0.0))
    assert blocked == Blocked(time_s=3.0, robot=0, by=1, configuration=(2.0, 1.0, 0.0))


def test_a_robot_that_sees_nobody_needs_no_look():
    script = Script(Look(), END)
    ms.drive(script.strategy, self_of(), sense=sense, move=arrive)
    assert script.told == [()]


def test_messages_wait_while_a_robot_moves_and_does_not_listen():
    letter = Arrived(data=(encode(Call(sender=1)),), time_s=2.0)
    moved = Moved(configuration=THERE, time_s=4.0)
    receive = Telling(letter, moved)
    script = Script(Move(trajectory=WAY), Receive(0.0), END)
    ms.drive(script.strategy, self_of(team=2), sense=sense, move=begin, receive=receive)
    assert script.told == [moved, Received((Call(sender=1),), 4.0)]
    assert receive.asked == [math.inf, math.inf]


def test_a_message_that_wakes_is_told_on_the_way():
    quiet, call = (
        Arrived(data=(encode(kind(sender=1)),), time_s=time_s)
        for kind, time_s in ((Word, 1.0), (Call, 2.0))
    )
    stopped = Moved(configuration=Configuration(2.0, 1.0), time_s=2.0)
    script = Script(Move(trajectory=WAY, listen=True), Stop(), END)
    driver = ms.drive(
        script.strategy,
        self_of(team=2),
        sense=sense,
        move=begin,
        receive=Telling(quiet, None, call),
        stop=lambda: stopped,
    )
    assert script.told == [Received((Word(sender=1), Call(sender=1)), 2.0), stopped]
    motion = driver.events[0]
    assert isinstance(motion, Motion)
    assert motion.waypoints[-1] == (2.0, 2.0, 1.0, 0.0)


def test_times_to_wait_are_told_by_the_clock():
    receive = Telling(TimedOut(2.5), TimedOut(4.5))
    script = Script(Sense(), Receive(2.0), Receive(2.0), END)
    ms.drive(script.strategy, self_of(), sense=sense, move=arrive, receive=receive)
    assert receive.asked == [2.5, 4.5]
    assert script.told[1:] == [TimedOut(2.5), TimedOut(4.5)]


def test_nothing_comes_at_once_where_nothing_is_received():
    script = Script(Sense(), Receive(0.0), END)
    ms.drive(script.strategy, self_of(), sense=sense, move=arrive)
    assert script.told[1] == TimedOut(0.5)


def test_a_robot_on_call_is_woken_by_a_message_until_its_time_is_over():
    on_call = Done(complete=True, reason="home", on_call=True)
    script = Script(on_call, Sense(), on_call)
    receive = Telling(Arrived(data=(encode(Word(sender=1)),), time_s=0.25), TimedOut(30.5))
    driver = ms.drive(
        script.strategy, self_of(team=2), sense=sense, move=arrive, receive=receive, on_call_s=30.0
    )
    assert receive.asked == [30.0, 30.5]
    assert [type(event) for event in driver.events] == [Ended, Sensed, Ended]
    assert driver.is_done


def test_a_loop_drives_a_team():
    inboxes: list[list[bytes]] = [[], []]

    def body(number):
        def receive(until_s):
            if inboxes[number]:
                return Arrived(data=(inboxes[number].pop(),), time_s=clock[0])
            return TimedOut(clock[0]) if clock[0] >= until_s else None

        def send(data, to):
            inboxes[1 - number].append(data)

        return Body(sense=sense, move=arrive, send=send, receive=receive)

    clock = [0.0]
    scripts = [
        Script(Receive(2.0), Send(Word(sender=0, text="go")), Receive(), END),
        Script(Receive(), Send(Word(sender=1, text="gone")), END),
    ]
    team = [Driver(script.strategy, self_of(k, 2), body(k)) for k, script in enumerate(scripts)]
    while not all(driver.is_done for driver in team):
        for driver in team:
            driver.poll()
        clock[0] += 0.5
    assert scripts[0].told[0] == TimedOut(2.0)
    assert scripts[1].told[0].messages[0].text == "go"
    assert scripts[0].told[2].messages[0].text == "gone"
    assert [driver.poll() for driver in team] == [False, False]


def test_a_driver_that_is_closed_lets_go_of_its_explorer():
    ended = []

    class Waits:
        def __init__(self, me, options):
            pass

        def run(self):
            try:
                yield Receive()
            finally:
                ended.append(True)

    body = Body(sense=sense, move=arrive, receive=lambda until_s: None)
    driver = Driver(Waits, self_of(), body)
    assert driver.poll()
    driver.close()
    assert ended == [True]


STILL = Moved(configuration=HERE, time_s=-3.0)


@pytest.mark.parametrize(
    ("action", "callables", "words"),
    [
        (Sense(), {"sense": lambda: 3}, "sense of robot 0 returned 3"),
        (Move(trajectory=WAY), {"move": lambda move: True}, "move of robot 0 returned True"),
        (Move(trajectory=WAY), {"move": begin}, "no receive that reports its end"),
        (Move(trajectory=WAY), {"move": lambda move: STILL}, "reports -3 s after 0 s"),
        (Send(Word(sender=0)), {}, "sends a message, but there is no send"),
        (Receive(2.0), {}, "waits, but there is no receive"),
        (Receive(2.0), {"receive": lambda until_s: TimedOut(1.0)}, "TimedOut at 2 s or later"),
        (Receive(2.0), {"receive": lambda until_s: "hello"}, "returned 'hello'"),
        (Receive(2.0), {"receive": lambda until_s: arrive(None)}, "only for a motion"),
        (Receive(2.0), {"receive": lambda u: Arrived(data=(b"?",), time_s=1.0)}, "no message"),
    ],
)
def test_a_body_that_answers_wrongly_is_refused(action, callables, words):
    with pytest.raises(InvalidInputError, match=words):
        ms.drive(
            Script(action, END).strategy,
            self_of(),
            **({"sense": sense, "move": arrive} | callables),
        )


@pytest.mark.parametrize(
    ("action", "words"),
    [
        ("north", "which is no action"),
        (Stop(), "Stop, but it stands"),
        (Note(MapComplete(time_s=7.0, robot=0)), "time_s=7 at 0 s"),
    ],
)
def test_an_explorer_with_a_defect_is_refused(action, words):
    with pytest.raises(ExplorerDefect, match=words):
        ms.drive(Script(action, END).strategy, self_of(), sense=sense, move=arrive)


def test_an_explorer_that_returns_is_refused():
    with pytest.raises(ExplorerDefect, match="without a last action Done"):
        ms.drive(Script().strategy, self_of(), sense=sense, move=arrive)


def test_a_strategy_that_sees_the_truth_drives_no_body():
    with pytest.raises(InvalidInputError, match="plans on the true map"):
        ms.drive("informed", self_of(), sense=sense, move=arrive)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ({"move": lambda _: Moved(configuration=None, time_s=1.0)}, "the configuration None"),  # type: ignore[arg-type]
        ({"move": lambda _: Moved(configuration=(math.nan, 2, 0), time_s=1.0)}, "three finite"),  # type: ignore[arg-type]
        ({"move": lambda _: Moved(configuration=WAY.end, time_s=None)}, "reports None s after"),  # type: ignore[arg-type]
        ({"look": lambda: None}, "look of robot 0 returned None"),
        ({"receive": lambda _: Arrived(data=b"abc", time_s=0.5)}, "a tuple of bytes as data"),  # type: ignore[arg-type]
        ({"receive": lambda _: Arrived(data=("abc",), time_s=0.5)}, "decoded from bytes"),  # type: ignore[arg-type]
        ({"receive": lambda _: TimedOut(None)}, "reports None s after"),  # type: ignore[arg-type]
    ],
)
def test_what_callables_return_is_checked(body, said):
    script = Script(Look(), Move(trajectory=WAY), Receive(timeout_s=1.0), END)
    with pytest.raises(InvalidInputError, match=said):
        ms.drive(script.strategy, self_of(), **{"sense": sense, "move": arrive} | body)


@pytest.mark.slow
def test_an_explorer_that_lets_no_time_pass_is_stopped():
    class Looks:
        def __init__(self, me):
            pass

        def run(self):
            while True:
                yield Look()

    with pytest.raises(ExplorerDefect, match="lets no time pass"):
        ms.drive(Looks, self_of(), sense=sense, move=arrive)  # type: ignore[arg-type]


def test_a_wrong_end_is_told_as_that_of_done():
    script = Script(Done(complete=True, reason=5))  # type: ignore[arg-type]
    with pytest.raises(ExplorerDefect, match="reason of its Done is 5"):
        ms.drive(script.strategy, self_of(), sense=sense, move=arrive)
