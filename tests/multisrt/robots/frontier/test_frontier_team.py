"""Decisions of one robot: rules choose as they are written, and paths begin where they can."""

import itertools
import math
from functools import partial

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.environments.environment import Environment
from multisrt.events import GoalChosen
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.assignment.costs import DenseCosts
from multisrt.planners.assignment.greedy import greedy
from multisrt.planners.assignment.minpos import minpos
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.explorer import Note, RobotSelf, Send, Sighting
from multisrt.robots.frontier.assignments import Assignments
from multisrt.robots.frontier.driving import reason_to_end
from multisrt.robots.frontier.explore import FrontierExplorer
from multisrt.robots.frontier.messages import (
    AssignmentMessage,
    GiveWayMessage,
    ReportMessage,
    RobotReport,
    StopMessage,
)
from multisrt.robots.frontier.options import (
    BiddingOptions,
    FrontierOptions,
    SelfBiddingOptions,
    UtilityOptions,
)
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.self_bidding import (
    choose_by_self_bidding,
    path_gaps,
    send_last_stop_signal,
    send_stop_signals,
)
from multisrt.robots.frontier.utility import answer_requests, follow_assignment
from multisrt.robots.frontier.wavefront_costs import WavefrontCosts, full_table
from multisrt.robots.frontier.wavefront_rules import choose_closest, choose_greedy, choose_minpos

PILLARS = shapely.union_all(
    [shapely.box(x, y, x + 1, y + 1) for x, y in ((6, 3), (13, 8), (18, 4))]
)
PLAZA = Environment("plaza", shapely.box(0, 0, 26, 14).difference(PILLARS))


def self_at(x, y, *, number=0, team=1):
    return RobotSelf(
        robot=number,
        start=Configuration(x, y, 0.0),
        footprint=Footprint.parse("disc:0.25"),
        kinematics=Differential(speed_m_s=0.5, turn_rate_rad_s=math.pi / 2),
        range_m=4.0,
        rng=np.random.default_rng(1),
        team=team,
    )


def robot_at(places, teammates=(), options=None):
    """A robot at the first of some places from all of which it has seen the plaza."""
    me = self_at(*places[0], team=1 + len(teammates))
    robot = FrontierRobot(me, options or FrontierOptions())
    paint(robot, places)
    for number, place in enumerate(teammates, start=1):
        robot.team.teammates.take(report_of(number, place))
    return robot


def scan_from(x, y):
    return take_scan(EdgeIndex(PLAZA.edges, 1.5), Configuration(x, y), 0.0, 4.0)


def paint(robot, places):
    """Show a robot what is seen of the plaza from some places."""
    for x, y in places:
        robot.raster.add(local_safe_region(scan_from(x, y), "radial"))


def report_of(number, place, goal=None):
    return RobotReport(
        robot=number,
        said=1,
        time_s=0.0,
        phase="driving",
        place=(*place, 0.0),
        goal=goal,
        remaining_m=0.0,
        path=(),
        footprint="disc:0.25",
        have=(),
    )


# Decisions -------------------------------------------------------------------------------------


def places_drawn(seed, count):
    rng = np.random.default_rng(seed)
    places = rng.uniform((1.0, 1.0), (25.0, 13.0), (40, 2))
    clear = shapely.distance(shapely.points(places), PILLARS) > 0.4
    first, *rest = places[clear].tolist()
    # Only what hangs together can be reached.
    near = [first]
    for place in rest:
        if len(near) < count and min(math.dist(place, p) for p in near) < 5.0:
            near.append(place)
    return [tuple(p) for p in near]


def situation(seed):
    """A robot that knows part of the plaza, and up to three teammates in it."""
    places = places_drawn(seed, 3 + seed % 5)
    return partial(robot_at, places, places[1 : 1 + seed % 4])


@pytest.fixture
def only_choice(acts_of):
    def run(rule, robot):
        (act,), goal = acts_of(rule(robot, because=Event.START))
        assert isinstance(act, Note)
        assert isinstance(act.event, GoalChosen)
        assert act.event.goal == goal.place
        assert act.event.frontiers == tuple(map(tuple, robot.targets().tolist()))
        return act.event, goal

    return run


def worked_out(event):
    """The costs on record, with the places where they stand."""
    return [
        (i, j, cost)
        for i, row in enumerate(event.costs)
        for j, cost in enumerate(row)
        if cost is not None
    ]


@pytest.mark.parametrize("seed", range(6))
def test_closest_takes_the_nearest_of_all_targets(only_choice, seed):
    make = situation(seed)
    table = full_table(make())
    assert len(table.targets) > 1
    event, goal = only_choice(choose_closest, make())
    assert goal.place == tuple(table.targets[np.argmin(table.costs[table.row])])
    assert goal.cost_m == pytest.approx(table.costs[table.row].min(), abs=0.15)
    assert event.rule == "closest"


@pytest.mark.parametrize("seed", range(12))
def test_greedy_decides_as_on_the_full_table(only_choice, seed):
    make = situation(seed)
    table = full_table(make())
    given = greedy(DenseCosts(table.costs))
    event, goal = only_choice(choose_greedy, make())
    assert event.robots == table.robots == tuple(range(1 + seed % 4))
    assert goal.place == tuple(table.targets[given.assignment[table.row]])
    # The rounds are those of the full assignment, up to the robot's own.
    order = [(table.robots[i], j) for i, j, *_ in given.rounds]
    own = [i for i, _ in order].index(0)
    assert [(i, j) for i, j, *_ in event.rounds] == order[: own + 1]
    for i, j, cost in worked_out(event):
        assert cost == table.costs[i, j]


def test_minpos_decides_as_on_the_full_table(only_choice):
    compared, left_to_others = 0, 0
    for seed in range(60):
        make = situation(seed)
        table = full_table(make())
        columns = np.sort(table.costs, axis=0)
        # A wave from a target and one to it differ by their rounding: near ties may go otherwise.
        if len(columns) > 1 and np.diff(columns, axis=0).min() < 0.2:
            continue
        given = minpos(DenseCosts(table.costs), table.row)
        event, goal = only_choice(choose_minpos, make())
        assert event.robots == table.robots
        assert goal.place == tuple(table.targets[given.choice])
        compared += 1
        left_to_others += given.choice != np.argmin(table.costs[table.row])
    assert compared >= 20
    assert left_to_others >= 2


def test_lazy_costs_find_the_nearest_of_the_remaining():
    make = situation(7)
    table, lazy = full_table(make()), WavefrontCosts(make())
    for row in range(len(table.robots)):
        left = np.arange(len(table.targets))
        for target in np.argsort(table.costs[row], kind="stable"):
            assert lazy.nearest(row, left) == (table.costs[row, target], target)
            left = left[left != target]
        assert lazy.nearest(row, left) is None
    assert lazy.table().costs.tolist() == table.costs.tolist()


def team_at(places, members):
    """Robots that know the same: what was seen from some places, and where they all are."""
    team = []
    for number, place in enumerate(members):
        robot = FrontierRobot(self_at(*place, number=number, team=len(members)), FrontierOptions())
        paint(robot, places)
        for teammate, other in enumerate(members):
            if teammate != number:
                robot.team.teammates.take(report_of(teammate, other))
        team.append(robot)
    return team


@pytest.mark.parametrize("seed", range(6))
def test_robots_with_the_same_map_agree_on_positions(seed):
    places = places_drawn(seed, 6)
    # The last one stands where the second does.
    members = [*places[: 2 + seed % 3], places[1]]
    ranks = []
    for robot in team_at(places, members):
        lazy = WavefrontCosts(robot)
        targets = range(len(lazy.targets))
        for target in targets:
            assert lazy.nearest(lazy.row, np.array([target])) is not None
        ranks.append([len(list(lazy.robots_ahead(lazy.row, target))) for target in targets])
        assert len(targets) > 1
    for column in zip(*ranks, strict=True):
        assert sorted(column) == [*range(len(members))]


def test_robots_at_one_place_spread_by_minpos(only_choice):
    places = places_drawn(2, 6)
    chosen = [only_choice(choose_minpos, r)[0] for r in team_at(places, [places[0]] * 3)]
    assert len(chosen[0].frontiers) == 2
    assert [event.goal for event in chosen].count(chosen[0].goal) == 2
    assert chosen[0].goal == chosen[2].goal != chosen[1].goal


def test_minpos_records_the_positions_that_it_counted(only_choice):
    places = places_drawn(1, 5)
    events = [only_choice(choose_minpos, r)[0] for r in team_at(places, places[:3])]
    for number, event in enumerate(events):
        choice = event.frontiers.index(event.goal)
        ranks = np.array(event.ranks)
        assert ranks.shape == (3, len(event.frontiers))
        worked = [j for j, cost in enumerate(event.costs[number]) if cost is not None]
        assert ranks[number, choice] == ranks[number, worked].min()


def test_idle_and_long_silent_teammates_do_not_count():
    places = places_drawn(3, 4)
    robot = robot_at(places, places[1:3])
    assert full_table(robot).robots == (0, 1, 2)
    robot.course.time_s = robot.options.lost_after_s + 1.0
    robot.team.teammates.heard_s[2] = robot.course.time_s
    assert full_table(robot).robots == (0, 2)


# Stop signals ----------------------------------------------------------------------------------


def test_robots_whose_goal_is_explored_get_a_stop_signal(acts_of):
    robot = robot_at([(3, 7), (6, 7)], [(10, 10)], SelfBiddingOptions())
    (edge, *_) = robot.targets().tolist()
    for goal in (None, tuple(edge), (25.0, 1.0)):
        robot.team.teammates.reports[1] = report_of(1, (10, 10), goal)
        assert acts_of(send_stop_signals(robot))[0] == []
    robot.team.teammates.reports[1] = report_of(1, (10, 10), (4.0, 7.0))
    acts, _ = acts_of(send_stop_signals(robot))
    assert acts == [Send(StopMessage(sender=0, goal=(4.0, 7.0)), 1)]
    assert acts_of(send_stop_signals(robot))[0] == []  # once is enough


def test_the_robot_that_explored_a_goal_sends_the_signal(acts_of):
    robot = robot_at([(3, 7)], [(3, 12)], SelfBiddingOptions())
    robot.team.teammates.reports[1] = report_of(1, (3, 12), tuple(robot.targets()[0].tolist()))
    (x, y) = goal = robot.team.teammates.reports[1].goal
    assert acts_of(send_stop_signals(robot))[0] == []
    paint(robot, [(x, y)])
    assert not robot.is_frontier(*goal)
    for seen_from, signals in (((23.0, 12.0), 0), ((3.0, 7.0), 1)):
        robot.team.stops.settled.clear()
        robot.map.view(scan_from(*seen_from))
        assert len(acts_of(send_stop_signals(robot))[0]) == signals


def test_without_stop_signals_none_is_sent(acts_of):
    robot = robot_at([(3, 7), (6, 7)], [(10, 10)], SelfBiddingOptions(stop_signals=False))
    robot.team.teammates.reports[1] = report_of(1, (10, 10), (4.0, 7.0))
    assert acts_of(send_stop_signals(robot))[0] == []
    assert acts_of(send_last_stop_signal(robot))[0] == []


def test_a_robot_that_has_explored_all_tells_the_others_once(acts_of):
    robot = robot_at([(3, 7)], [(10, 10)], SelfBiddingOptions())
    (told,), _ = acts_of(send_last_stop_signal(robot))
    assert told == Send(StopMessage(sender=0))
    robot.course.time_s = 5.0
    assert acts_of(send_last_stop_signal(robot))[0] == []
    robot.course.set_out_s = 6.0
    robot.course.time_s = 7.0
    assert len(acts_of(send_last_stop_signal(robot))[0]) == 1
    # It ends the drive of a robot to whatever goal.
    other = robot_at([(3, 7)], [(10, 10)], SelfBiddingOptions())
    acts_of(other.team._take_message(told.message))
    assert not other.team.requests.stop
    other.set_goal(other.goal_at(other.own_field(), *other.targets()[0].tolist()))
    acts_of(other.team._take_message(told.message))
    assert other.team.requests.stop


def test_with_arrival_a_drive_goes_on_to_a_goal_that_is_no_frontier():
    ends = {}
    for replan in ("target", "arrival"):
        robot = robot_at([(3, 7)], options=BiddingOptions(replan=replan))
        goal = robot.goal_at(robot.own_field(), *robot.targets()[0].tolist())
        robot.set_goal(goal)
        assert reason_to_end(robot, goal, to_see=True) is None
        paint(robot, [goal.place])
        ends[replan] = reason_to_end(robot, goal, to_see=True)
    assert ends == {"target": Event.NOTHING_LEFT, "arrival": None}


def test_a_stop_signal_counts_for_the_present_goal_only(acts_of):
    explorer = FrontierExplorer(self_at(1, 1, team=2), SelfBiddingOptions(), choose_by_self_bidding)
    mapped = robot_at([(3, 7)], [(10, 10)], SelfBiddingOptions())
    goal = mapped.goal_at(mapped.own_field(), *mapped.targets()[0].tolist())
    explorer.robot = mapped
    mapped.set_goal(goal)
    acts_of(mapped.team._take_message(StopMessage(sender=1, goal=(1.0, 1.0))))
    assert not mapped.team.requests.any_pending
    acts_of(mapped.team._take_message(StopMessage(sender=1, goal=goal.place)))
    assert mapped.team.requests.any_pending
    assert explorer.request() is Event.STOP_SIGNAL
    assert not mapped.team.requests.any_pending


# Answers -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "told"), [(SelfBiddingOptions(), [0, 1, 2]), (BiddingOptions(), [0])]
)
def test_who_is_asked_passes_on_what_it_knows_by_self_bidding_alone(acts_of, options, told):
    robot = robot_at([(3, 7), (6, 9)], [(8, 10), (20, 3)], options)
    asked = ReportMessage(sender=1, reports=(report_of(1, (8, 10), (9.0, 9.0)),), asks=True)
    (answer,) = [
        act
        for act in acts_of(robot.team._take_message(asked))[0]
        if isinstance(act.message, ReportMessage)
    ]
    assert answer.to == 1
    assert [report.robot for report in answer.message.reports] == told
    unasked = acts_of(robot.team.report())[0]
    assert [report.robot for report in unasked[0].message.reports] == [0]


# Leaders ---------------------------------------------------------------------------------------


def asking(number, place, *, time_s=0.0):
    report = msgspec.structs.replace(
        report_of(number, place), phase="choosing", said=2, time_s=time_s
    )
    return ReportMessage(sender=number, reports=(report,), wants_goal=True)


def test_a_leader_answers_at_once_and_keeps_its_own_goal(acts_of):
    robot = robot_at([(3, 7), (6, 9), (9, 11)], [(8, 10)], UtilityOptions())
    answer_requests(robot)
    goal = robot.goal_at(robot.own_field(), *robot.targets()[0].tolist())
    robot.set_goal(goal)
    acts, _ = acts_of(robot.team._take_message(asking(1, (8, 10))))
    (given,) = [act for act in acts if isinstance(act.message, AssignmentMessage)]
    assert given.to == 1
    assert given.message.goal in {tuple(t) for t in robot.targets().tolist()}
    assert math.dist(given.message.goal, goal.place) > 1.0
    assert robot.goal is goal
    assert not robot.team.requests.any_pending


def test_a_goal_that_another_has_is_worth_less(acts_of):
    # Robot 1 stands at the edge that it would get if nobody went there.
    robot = robot_at([(3, 7), (6, 9), (9, 11)], [(8, 10), (7, 10)], UtilityOptions())
    answer_requests(robot)

    def goal_given():
        acts, _ = acts_of(robot.team._take_message(asking(1, (8, 10))))
        (given,) = [act.message for act in acts if isinstance(act.message, AssignmentMessage)]
        return given

    # Robot 2 has a goal: it does not ask.
    robot.team.teammates.reports[2] = report_of(2, (7, 10), (1.0, 1.0))
    first = goal_given()
    robot.team.teammates.reports[2] = report_of(2, (7, 10), first.goal)
    second = goal_given()
    assert second.goal != first.goal or second.utility == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_a_robot_goes_where_its_leader_says_at_the_cost_of_its_own_field(seed, only_choice):
    robot = situation(seed)()
    own = full_table(robot).costs[0]
    target = int(np.argsort(own)[np.isfinite(own).sum() // 2])
    goal = tuple((robot.targets()[target] + 0.05).tolist())
    assignment = AssignmentMessage(sender=9, goal=goal, utility=0.5, share=0.2)
    event, _ = only_choice(partial(follow_assignment, assignment=assignment), robot)
    assert event.goal == tuple(robot.targets()[target].tolist())
    assert event.rounds == ((0, target, 0.5, 0.2),)
    found = {j: cost for _, j, cost in worked_out(event)}
    assert found[target] == own[target]
    assert all(own[j] == cost for j, cost in found.items())
    assert set(found) <= {target, int(np.argmin(own))}


@pytest.mark.parametrize("place", [None, (500.0, 500.0)])
def test_a_robot_without_an_assigned_goal_nearby_goes_to_the_nearest(place, only_choice):
    robot = situation(2)()
    own = full_table(robot).costs[0]
    assignment = AssignmentMessage(sender=9, goal=place)
    event, _ = only_choice(partial(follow_assignment, assignment=assignment), robot)
    assert event.goal == tuple(robot.targets()[int(np.argmin(own))].tolist())
    assert event.rounds == ()


def test_robots_that_need_a_goal_at_once_get_theirs_together(acts_of):
    robot = robot_at([(3, 7), (6, 9), (9, 11)], [(8, 10), (8, 9)], UtilityOptions())
    answer_requests(robot)
    acts_of(robot.team._take_message(asking(2, (8, 9))))
    robot.team.assignments = Assignments(0, 0.5)
    (first, second) = (
        act.message
        for number, place in ((1, (8, 10)), (2, (8, 9)))
        for act in acts_of(robot.team._take_message(asking(number, place)))[0]
        if isinstance(act.message, AssignmentMessage)
    )
    assert first.goal != second.goal
    assert max(first.utility, second.utility) == 1.0


# Requests --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("asked_s", "firm", "yields"),
    [(None, False, True), (99.9, False, False), (99.9, True, True), (90.0, False, True)],
    ids=["did not ask", "both asked", "the other is cornered", "asked long ago"],
)
def test_of_two_that_both_ask_the_lower_number_goes_first(acts_of, asked_s, firm, yields):
    robot = robot_at([(5.0, 4.2)], [(6.0, 4.2)])
    robot.course.time_s = 100.0
    if asked_s is not None:
        robot.team.asked_s[1] = asked_s
    asked = GiveWayMessage(sender=1, path=((6.0, 4.2), (5.0, 4.2)), radius_m=0.25, firm=firm)
    acts, _ = acts_of(robot.team._take_message(asked))
    assert (robot.team.requests.give_way is asked) == yields
    # Either way the other hears that it was understood.
    assert [(type(act.message), act.to) for act in acts] == [(ReportMessage, 1)]


# Paths and goals -----------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_path_gaps_agree_with_dense_sampling(seed):
    places = places_drawn(seed, 6)
    robot = robot_at(places)
    field = robot.own_field()
    indices = robot.indices_of(robot.targets())
    others = np.array(places[1:3])

    def dense(path):
        along = [
            a + (b - a) * t for a, b in itertools.pairwise(path) for t in np.linspace(0, 1, 200)
        ]
        return max(min(math.dist(point, other) for other in others) for point in along)

    exact = np.array([dense(shortest_path(field, index)) for index in indices])
    step_m = 0.02
    for least_m in (1.0, 4.0, 9.0):
        gaps = path_gaps(field, indices, others, step_m, least_m)
        close = exact > least_m
        assert np.allclose(gaps[close], exact[close], atol=step_m)
        assert (gaps[~close] <= least_m + step_m).all()
    assert (exact > 1.0).any()
    assert (path_gaps(field, indices, others, step_m, math.inf) == 0.0).all()


@pytest.mark.parametrize(
    ("body", "pocket", "west", "begins_in"),
    [
        ((10.575, 7.0), 2, 4, "west"),
        ((9.44, 6.85), 2, 4, "pocket"),
        ((10.5, 7.35), 7, 4, "west"),
        ((10.5, 7.35), 7, 16, "nowhere"),
        ((10.5, 7.35), 0, 4, "own cell"),
        (None, 0, 4, "west"),
        (None, 0, 16, "own cell"),
        (None, None, 4, "own cell"),
    ],
    ids=[
        "a way leads away from the body",
        "the way on would come nearer",
        "to the pocket it would come nearer",
        "there is but the pocket, past the body",
        "the body may give way",
        "no path leads from the own cell",
        "no path leads from anywhere",
        "all is passable",
    ],
)
def test_paths_begin_where_no_body_stops_the_robot(body, pocket, west, begins_in):
    # Around the robot nothing is passable but one cell, from which no path leads, and what lies
    # to the west.
    robot = robot_at([(10.0, 7.0)])
    raster, cell = robot.raster, robot.raster.cell_of(10.0, 7.0)
    scan = take_scan(EdgeIndex(PLAZA.edges, 1.5), Configuration(10.0, 7.0), 0.0, 4.0)
    robot.map.view(scan)
    expected = {
        "west": (cell[0], cell[1] - 5),
        "pocket": (cell[0] + (pocket or 0), cell[1]),
        "own cell": cell,
        "nowhere": None,
    }
    if body is not None:
        seen = Sighting(
            robot=1, configuration=Configuration(*body), footprint=Footprint.parse("disc:0.25")
        )
        robot.bodies.add(seen)
    if pocket is not None:
        row, column = cell[0] - raster.row, cell[1] - raster.column
        raster.passable[row - 12 : row + 13, column - west : column + 13] = False
        raster.passable[row + pocket, column] = True
    with robot.around_bodies():
        assert robot.path_finder.first_cell() == expected[begins_in]


def test_frontiers_out_of_reach_count_once_parts_have_joined():
    """Though the frontier itself has not changed since."""
    corridor = Environment("corridor", shapely.box(0, 0, 40, 4))
    robot = FrontierRobot(self_at(10.0, 2.0), FrontierOptions())

    def see_from(x):
        scan = take_scan(EdgeIndex(corridor.edges, 1.5), Configuration(x, 2.0), 0.0, 4.0)
        robot.raster.add(local_safe_region(scan, "radial"))

    def ends():
        table = full_table(robot)
        assert np.isfinite(table.costs[table.row]).all()
        return sorted(round(x) for x, _ in table.targets.tolist())

    see_from(10.0)
    see_from(24.0)
    assert ends() == [6, 14]
    see_from(17.0)
    assert ends() == [6, 28]


def test_a_field_round_one_body_is_not_taken_for_that_round_two():
    robot = robot_at([(4.0, 7.0)])
    body = Sighting(
        robot=1, configuration=Configuration(5.0, 7.0), footprint=self_at(0, 0).footprint
    )
    places = np.array([[6.5, 7.0]])

    def length():
        return float(robot.own_field().distance(robot.indices_of(places))[0])

    for _ in range(2):
        free = length()
        with robot.around_bodies([body]):
            around = length()
            with robot.around_bodies():
                assert length() == around
        assert around > free + 0.05
        assert length() == free


def test_where_no_path_from_its_place_is_free_a_robot_sets_out_from_the_middle_of_its_cell():
    robot = robot_at([(5.03, 4.24)])
    middle = robot.raster.centre_of(*robot.raster.cell_of(*robot.at[:2]))
    assert middle != robot.at[:2]
    begins = []
    for _ in range(3):
        begins.append(tuple(robot.own_field().sources[0].tolist()))
        robot.course.note_no_path()
    assert begins == [robot.at[:2], middle, robot.at[:2]]
    # Elsewhere its paths begin where it stands again.
    robot.course.note_no_path()
    robot.course.at = Configuration(5.03, 5.24, 0.0)
    assert tuple(robot.own_field().sources[0].tolist()) == robot.at[:2]


@pytest.mark.parametrize(
    ("reached", "place", "seen"),
    [
        ("sight", (5.0, 5.3), True),
        ("sight", (5.0, 6.3), False),
        ("sight", (7.0, 4.5), False),
        ("cell", (5.0, 5.3), False),
    ],
    ids=["near and in sight", "beyond half the range", "behind a pillar", "not asked for"],
)
def test_a_goal_is_reached_in_sight_within_half_the_range(reached, place, seen):
    robot = robot_at([(5.0, 4.2), (7.0, 6.0)], options=FrontierOptions(reached=reached))
    # Its range is 4 m; the pillar stands at x from 6 to 7 and y from 3 to 4.
    assert robot.me.range_m == 4.0
    robot.course.at = Configuration(6.5, 2.7, 0.0) if place == (7.0, 4.5) else robot.at
    is_near = math.dist(robot.at[:2], place) <= 2.0
    assert is_near == (place != (5.0, 6.3))
    scan = take_scan(EdgeIndex(PLAZA.edges, 1.5), robot.at, 0.0, 4.0)
    robot.map.view(scan)
    goal = robot.goal_at(robot.own_field(), *place)
    assert robot.sees_at_half_range(goal) == seen


def test_a_goal_seen_from_afar_in_vain_must_be_reached():
    robot = robot_at([(5.0, 4.2)], options=FrontierOptions(reached="sight"))
    scan = take_scan(EdgeIndex(PLAZA.edges, 1.5), robot.at, 0.0, 4.0)
    robot.map.view(scan)
    field = robot.own_field()
    costs = field.distance(robot.indices_of(robot.targets()))
    x, y = robot.targets()[int(np.argmin(costs))].tolist()
    goal = robot.goal_at(field, x, y)
    # Half way there it is in sight, and still a frontier.
    half_way = goal.path[0] + 0.7 * (goal.path[-1] - goal.path[0])
    robot.course.at = Configuration(*half_way.tolist())
    assert robot.sees_at_half_range(goal)
    robot.frontiers.note_reached(goal.place, robot.at[:2])
    assert not robot.sees_at_half_range(goal)
    assert any((place == goal.place).all() for place in robot.targets())
