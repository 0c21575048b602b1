"""Robots that go after a teammate out of touch: in a corridor, with answers worked out by hand."""

import math
import re
from typing import Any

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.events import Decided, Learned
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.explorer import RadioSelf, RobotSelf
from multisrt.robots.frontier.errand_steps import errand_now
from multisrt.robots.frontier.options import FrontierOptions
from multisrt.robots.frontier.pursuit import MAX_PURSUITS
from multisrt.robots.frontier.pursuit_options import PursuitOptions
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.registry import strategy
from multisrt.simulation.simulate import simulate
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    RadioSpec,
    RobotSpec,
    RunSpec,
    Silence,
    StopRule,
)

# A corridor of 80 m, of which a robot at x = 20 has seen the part from x = 0 to x = 40.
LINE = Environment("line", shapely.box(-20, 0, 60, 1.2))
# The same, of which the end at x = 1 was seen.
DEAD_END = Environment("dead end", shapely.box(1, 0, 60, 1.2))


def robot_at_20(world=LINE, **options):
    me = RobotSelf(
        robot=0,
        start=Configuration(20.0, 0.6, 0.0),
        footprint=Footprint.disc(0.25),
        kinematics=Differential(speed_m_s=0.5, turn_rate_rad_s=math.pi / 2),
        range_m=4.0,
        rng=np.random.default_rng(1),
        team=2,
        radio=RadioSelf(range_m=3.0, reaches_all=False),
    )
    robot = FrontierRobot(me, FrontierOptions(pursue=True, **options))
    index = EdgeIndex(world.edges, 1.5)
    for x in (20.0, *np.arange(4.0, 36.1, 0.5)):
        robot.map.add(take_scan(index, Configuration(x, 0.6, 0.0), x, 4.0))
    robot.course.time_s = 9.0
    return robot


def hear(robot, *, time_s=0.0, nodes=1, place=(22.0, 0.6), goal=(24.0, 0.6), phase="driving"):
    """Let the robot have heard from robot 1, which has the first of its nodes."""
    said = msgspec.structs.replace(
        robot.team.own_report(),
        robot=1,
        time_s=time_s,
        phase=phase,
        place=(*place, 0.0),
        goal=goal,
        path=() if goal is None else (place, goal),
        remaining_m=0.0 if goal is None else math.dist(place, goal),
        have=((0, nodes, 0),),
    )
    robot.team.teammates.take(said)


def pursued(robot) -> Any:
    """Return the errand of a robot that pursues."""
    return errand_now(robot)


def lengths_of(errand):
    return [float(found) for found in re.findall(r"([\d.]+) m", errand.why)]


def test_a_teammate_that_can_take_one_end_is_pursued_to_where_it_goes():
    robot = robot_at_20()
    hear(robot)
    errand = pursued(robot)
    assert errand.kind == "pursue"
    # It told a path of 2 m from x = 22: two cells. Robot 0 is at the first after 4 s and at the
    # second after 8 s, 13 s and 17 s after the report: both in step 3, of 6 s. By then it has
    # gone on from the first with most probability.
    assert errand.goal.place == pytest.approx((24.0, 0.6), abs=0.1)
    assert errand.waits_until_s(9.0) == errand.waits_until_s(17.0) == 18.0 + 12.0
    # Alone it drives 20 m to one end, and 40 m to the other. After a meeting in 9 s, or 4.5 m, it
    # is 24 m to the farther end.
    after, before = lengths_of(errand)
    assert (after, before) == (pytest.approx(28.5, abs=0.6), pytest.approx(60.0, abs=0.6))
    assert errand.what == "pursues a teammate"
    assert errand.purpose == "support"


def test_probabilities_that_add_up_to_one_but_for_rounding_are_taken():
    for leave in (0.1, 0.2, 0.3):
        assert PursuitOptions(pursue_stay=1.0 - leave, pursue_leave=leave).pursue_leave == leave


def test_a_share_can_be_asked_for_by_which_the_longest_route_gets_shorter():
    for gain, pursues in ((0.5, True), (0.55, False)):
        robot = robot_at_20(pursue_gain=gain)
        hear(robot)
        assert (errand_now(robot) is not None) is pursues


def test_one_frontier_is_not_shared():
    robot = robot_at_20(DEAD_END)
    hear(robot)
    assert errand_now(robot) is None


@pytest.mark.parametrize(
    "heard",
    [
        {"nodes": 66},  # it knows all that is there
        {"time_s": 6.0},  # it was heard 3 s ago
    ],
)
def test_who_knows_or_hears_is_not_pursued(heard):
    robot = robot_at_20()
    hear(robot, **heard)
    assert errand_now(robot) is None


def test_a_teammate_that_is_lost_is_not_pursued():
    robot = robot_at_20()
    hear(robot)
    robot.team.teammates.note_lost(1, 5.0)
    assert errand_now(robot) is None


def test_without_the_option_nobody_is_pursued():
    robot = robot_at_20()
    me, options = robot.me, FrontierOptions()
    assert FrontierRobot(me, options).pursuit is None


def test_a_teammate_that_stands_is_pursued_to_where_it_stands():
    robot = robot_at_20()
    hear(robot, place=(26.0, 0.6), goal=None, phase="idle")
    errand = pursued(robot)
    assert errand.goal.place == pytest.approx((26.0, 0.6), abs=0.1)


def test_a_pursuit_is_over_once_the_teammate_has_what_was_known():
    robot = robot_at_20()
    hear(robot)
    errand = pursued(robot)
    assert not errand.is_over()
    hear(robot, time_s=8.0, nodes=65)
    assert errand.is_over()
    robot.pursuit.note_end()
    robot.course.time_s = 60.0
    assert errand_now(robot) is None


def test_the_same_pursuit_goes_on_after_an_interruption():
    robot = robot_at_20()
    hear(robot)
    errand = pursued(robot)
    robot.course.arrive(Configuration(21.0, 0.6, 0.0), 11.0)
    again = pursued(robot)
    assert (again.why, again.until_s) == (errand.why, errand.until_s)
    # It goes to the place until a while after the time, and no longer.
    robot.course.time_s = 31.0
    assert errand_now(robot) is None


def test_a_pursuit_in_vain_is_not_repeated_until_the_teammate_is_heard():
    robot = robot_at_20()
    hear(robot)
    assert errand_now(robot) is not None
    robot.pursuit.note_end()
    robot.course.time_s = 60.0
    assert errand_now(robot) is None
    hear(robot, time_s=61.0)
    robot.course.time_s = 70.0
    assert errand_now(robot) is not None


def test_a_teammate_that_learns_nothing_is_pursued_a_few_times_only():
    robot = robot_at_20()
    pursued = 0
    for time_s in np.arange(20.0, 400.0, 20.0).tolist():
        hear(robot, time_s=time_s - 10.0)
        robot.course.time_s = time_s
        if errand_now(robot) is not None:
            pursued += 1
            robot.pursuit.note_end()
    assert pursued == MAX_PURSUITS


def test_what_a_teammate_finds_itself_is_not_learned_by_pursuits():
    robot = robot_at_20()
    pursued = 0
    for k, time_s in enumerate(np.arange(20.0, 400.0, 20.0).tolist()):
        hear(robot, time_s=time_s - 10.0)
        report = robot.team.teammates.reports[1]
        robot.team.teammates.take(msgspec.structs.replace(report, have=((0, 1, 0), (1, k, 0))))
        robot.course.time_s = time_s
        if errand_now(robot) is not None:
            pursued += 1
            robot.pursuit.note_end()
    assert pursued == MAX_PURSUITS


# Runs --------------------------------------------------------------------------------------------

OFFICE = CatalogEnvironment(name="office", parameters={"width_m": 20.0, "height_m": 14.0}, seed=1)


def run_with(rule="minpos", *, environment=OFFICE, seed=1, faults=(), robots=3, **options):
    return simulate(
        RunSpec(
            environment=environment,
            strategy=rule,
            options={"pursue": True} | options,
            robots=(RobotSpec(),) * robots,
            starts="clustered",
            radio=RadioSpec(range_m=4.0, walls="block"),
            seed=seed,
            faults=faults,
            stop=StopRule(max_time_s=1200.0),
        )
    )


def pursuits(recording):
    return [e for e in recording.of(Decided) if "pursues a teammate" in e.text]


def test_who_is_pursued_learns_what_the_other_knew():
    recording = run_with(environment=CatalogEnvironment(name="library"))
    assert recording.footer.outcome == "complete"
    begun = pursuits(recording)
    assert begun
    caught = 0
    for e in begun:
        teammate = int(e.text.split("robot ")[1].split(",")[0])
        within = [
            other
            for other in recording.of(Learned)
            if other.robot == teammate
            and e.time_s <= other.time_s <= e.time_s + 60.0
            and any(node[0] == e.robot for node in other.nodes)
        ]
        caught += len(within) > 0
    assert caught >= 1


RULES = ("closest", "greedy", "minpos", "utility", "self-bidding", "rules", "gain", "routes")


@pytest.mark.parametrize("seed", range(8))
def test_nobody_waits_for_the_dead_and_none_collides(seed):
    rule = RULES[seed]
    faults = (
        Death(robot=seed % 3, time_s=25.0 + 5.0 * seed),
        Silence(robot=(seed + 1) % 3, time_s=20.0, duration_s=30.0),
    )
    recording = run_with(rule, seed=seed, faults=faults)
    metrics = measure(recording)
    assert metrics.collisions == 0
    assert recording.footer.outcome in ("complete", "stalled")
    # A dead teammate is pursued once at most, by each robot that lives.
    after = [e for e in pursuits(recording) if e.time_s > faults[0].time_s]
    named = f"robot {seed % 3},"
    for robot in range(3):
        assert sum(e.robot == robot and named in e.text for e in after) <= 1


def test_the_same_run_is_the_same_to_the_byte():
    one, other = (run_with(seed=3).footer.digest for _ in range(2))
    assert one == other


# Misuse ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("robots", "radio", "match"),
    [
        (1, RadioSpec(range_m=4.0), "needs teammates to pursue, and there is one robot"),
        (2, RadioSpec(), "this radio reaches all: limit its range"),
    ],
)
def test_without_teammates_or_with_a_radio_that_reaches_all_it_is_refused(robots, radio, match):
    spec = RunSpec(
        environment=OFFICE,
        strategy="minpos",
        options={"pursue": True},
        robots=(RobotSpec(),) * robots,
        radio=radio,
    )
    with pytest.raises(InvalidInputError, match=match) as told:
        strategy("minpos").require_fit(spec)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    "wrong",
    [
        {"pursue_stay": 1.1},
        {"pursue_stay": 0.6, "pursue_leave": 0.5},
        {"pursue_step_s": 0.0},
        {"pursue_steps": 0},
        {"pursue_wait_s": math.inf},
        {"pursue_gain": 1.0},
    ],
)
def test_invalid_options_are_refused(wrong):
    with pytest.raises(InvalidInputError, match=re.escape(list(wrong)[-1])):
        FrontierOptions(**wrong)


def test_the_family_of_trees_has_no_such_option():
    spec = RunSpec(
        environment=OFFICE,
        strategy="srt-radial",
        options={"pursue": True},
        robots=(RobotSpec(),) * 2,
        radio=RadioSpec(range_m=12.0),
    )
    with pytest.raises(InvalidInputError, match="srt-radial has no option 'pursue'"):
        simulate(spec)
