"""Frontier bidding as a whole: runs end well, rules decide as they are written, options hold."""

import dataclasses
import itertools
import math
from functools import partial

import numpy as np
import pytest
import shapely

from multisrt.analysis.metrics import measure
from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.events import Collision, Ended, GoalChosen, MapComplete, Motion, NodeAdded
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.grids.grid_path import shortest_path
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.assignment.greedy import greedy
from multisrt.planners.assignment.minpos import minpos
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots import registry
from multisrt.robots.explorer import Done, Note, Receive, Received, RobotSelf, Send, Sighting
from multisrt.robots.frontier.explore import FrontierExplorer
from multisrt.robots.frontier.messages import (
    GiveWayMessage,
    ReportMessage,
    RobotReport,
    StopMessage,
)
from multisrt.robots.frontier.options import FrontierOptions, SelfBiddingOptions
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.frontier.rules import (
    Bids,
    bid_table,
    choose_closest,
    choose_greedy,
    choose_minpos,
)
from multisrt.robots.frontier.self_bidding import (
    choose_by_self_bidding,
    path_gaps,
    tell_who_may_stop,
)
from multisrt.robots.registry import strategy
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import inline
from multisrt.spec import CatalogEnvironment, DriveSpec, RadioSpec, RobotSpec, RunSpec, StopRule

FAMILY = ["closest", "greedy", "minpos", "utility", "self-bidding", "rules"]

WALL = shapely.union_all([shapely.box(5, 0, 5.2, 1.5), shapely.box(5, 2.7, 5.2, 5)])
TWO_ROOMS = Environment(
    "two rooms",
    shapely.box(0, 0, 10, 5).difference(WALL),
    starts=[(1, 1), (1, 2.5), (1, 4)],
)
PILLARS = shapely.union_all(
    [shapely.box(x, y, x + 1, y + 1) for x, y in ((6, 3), (13, 8), (18, 4))]
)
PLAZA = Environment("plaza", shapely.box(0, 0, 26, 14).difference(PILLARS))


def simulated(name, robots=1, *, world=TWO_ROOMS, options=None, robot=None, **spec):
    return simulate(
        RunSpec(
            environment=inline(world),
            strategy=name,
            options=options or {},
            robots=(robot or RobotSpec(),) * robots,
            stop=StopRule(max_time_s=600.0),
            **spec,
        ),
        world,
    )


def events(recording, kind, robot=None):
    return [e for e in recording.events if isinstance(e, kind) and robot in (None, e.robot)]


def edges_of(world):
    rings = shapely.get_rings(shapely.get_parts(world.free))
    corners = [shapely.get_coordinates(ring) for ring in rings]
    return EdgeIndex(np.vstack([np.hstack([c[:-1], c[1:]]) for c in corners]), 1.5)


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


def robot_at(places, mates=(), options=None):
    """A robot at the first of some places from all of which it has seen the plaza."""
    me = self_at(*places[0], team=1 + len(mates))
    robot = FrontierRobot(me, options or FrontierOptions())
    paint(robot, places)
    for number, place in enumerate(mates, start=1):
        robot.team.mates.take(report_of(number, place))
    return robot


def paint(robot, places):
    """Show a robot what is seen of the plaza from some places."""
    index = edges_of(PLAZA)
    for x, y in places:
        scan = take_scan(index, Configuration(x, y), 0.0, 4.0)
        robot.raster.add(local_safe_region(scan, "radial"))


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


def acts_of(steps):
    """Everything that was done, and what came out in the end."""
    acts = []
    try:
        while True:
            acts.append(steps.send(None))
    except StopIteration as end:
        return acts, end.value


# Whole runs ------------------------------------------------------------------------------------


@pytest.mark.parametrize("robots", [1, 3])
@pytest.mark.parametrize("name", FAMILY)
def test_a_team_completes_two_rooms(name, robots):
    run = simulated(name, robots, seed=3)
    assert run.footer.outcome == "complete"
    assert measure(run, TWO_ROOMS).coverage > 0.98
    assert not events(run, Collision)
    assert sorted(e.robot for e in events(run, MapComplete)) == [*range(robots)]
    assert simulated(name, robots, seed=3).footer == run.footer


@pytest.mark.parametrize("name", ["closest", "greedy", "minpos"])
def test_robots_that_hear_nothing_explore_each_for_itself(name):
    run = simulated(name, 2, radio=RadioSpec(range_m=0.0), seed=1)
    assert run.footer.outcome == "complete"
    for robot in range(2):
        regions = [shapely.Polygon(e.boundary) for e in events(run, NodeAdded, robot)]
        assert shapely.union_all(regions).area > 0.98 * TWO_ROOMS.free.area


@pytest.mark.parametrize("name", FAMILY)
def test_every_drive_has_a_goal_that_was_chosen_for_a_reason(name):
    run = simulated(name, 2, seed=5)
    for robot in range(2):
        chosen = events(run, GoalChosen, robot)
        assert chosen[0].because == "start"
        assert all(e.because != "start" for e in chosen[1:])
        assert chosen[0].time_s <= events(run, Motion, robot)[0].time_s
        assert {e.rule for e in chosen} <= {name, "random", "closest"}
        # A robot that is done has looked for a goal and found none.
        assert chosen[-1].goal is None


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
    """A robot that knows part of the plaza, and up to three mates in it."""
    places = places_drawn(seed, 3 + seed % 5)
    return partial(robot_at, places, places[1 : 1 + seed % 4])


def only_choice(rule, robot):
    (act,), goal = acts_of(rule(robot, Event.START))
    assert isinstance(act, Note)
    assert act.event.goal == goal.place
    assert act.event.frontiers == tuple(map(tuple, robot.targets().tolist()))
    return act.event, goal


def worked_out(event):
    """The costs on record, with the places where they stand."""
    return [
        (i, j, cost)
        for i, row in enumerate(event.costs)
        for j, cost in enumerate(row)
        if cost is not None
    ]


@pytest.mark.parametrize("seed", range(6))
def test_closest_takes_the_nearest_of_all_targets(seed):
    make = situation(seed)
    table = bid_table(make())
    assert len(table.targets) > 1
    event, goal = only_choice(choose_closest, make())
    assert goal.place == tuple(table.targets[np.argmin(table.costs[table.row])])
    assert goal.cost_m == pytest.approx(table.costs[table.row].min(), abs=0.15)
    assert event.rule == "closest"


@pytest.mark.parametrize("seed", range(12))
def test_greedy_decides_as_on_the_full_table(seed):
    make = situation(seed)
    table = bid_table(make())
    given = greedy(table.costs)
    event, goal = only_choice(choose_greedy, make())
    assert event.robots == table.robots == tuple(range(1 + seed % 4))
    assert goal.place == tuple(table.targets[given.assignment[table.row]])
    # The rounds are those of the full assignment, up to the robot's own.
    order = [(table.robots[i], j) for i, j, *_ in given.rounds]
    own = [i for i, _ in order].index(0)
    assert [(i, j) for i, j, *_ in event.rounds] == order[: own + 1]
    for i, j, cost in worked_out(event):
        assert cost == table.costs[i, j]


def test_minpos_decides_as_on_the_full_table():
    compared, left_to_others = 0, 0
    for seed in range(60):
        make = situation(seed)
        table = bid_table(make())
        columns = np.sort(table.costs, axis=0)
        # A wave from a target and one to it differ by their rounding: near ties may go otherwise.
        if len(columns) > 1 and np.diff(columns, axis=0).min() < 0.2:
            continue
        given = minpos(table.costs, table.row)
        event, goal = only_choice(choose_minpos, make())
        assert event.robots == table.robots
        assert goal.place == tuple(table.targets[given.choice])
        compared += 1
        left_to_others += given.choice != np.argmin(table.costs[table.row])
    assert compared >= 20
    assert left_to_others >= 2


def test_bids_find_the_nearest_of_those_that_are_left():
    make = situation(7)
    table, bids = bid_table(make()), Bids(make())
    for row in range(len(table.robots)):
        left = bids.all_targets()
        for target in np.argsort(table.costs[row], kind="stable"):
            assert bids.nearest(row, left) == (table.costs[row, target], target)
            left = left[left != target]
        assert bids.nearest(row, left) is None
    assert bids.table().costs.tolist() == table.costs.tolist()


def team_at(places, members):
    """Robots that know the same: what was seen from some places, and where they all are."""
    team = []
    for number, place in enumerate(members):
        robot = FrontierRobot(self_at(*place, number=number, team=len(members)), FrontierOptions())
        paint(robot, places)
        for mate, other in enumerate(members):
            if mate != number:
                robot.team.mates.take(report_of(mate, other))
        team.append(robot)
    return team


@pytest.mark.parametrize("seed", range(6))
def test_robots_that_know_the_same_agree_who_is_nearer_to_what(seed):
    places = places_drawn(seed, 6)
    # The last one stands where the second does.
    members = [*places[: 2 + seed % 3], places[1]]
    ranks = []
    for robot in team_at(places, members):
        bids = Bids(robot)
        own = [(target, len(list(bids.nearer_robots(target)))) for target in bids.nearest_first()]
        ranks.append([rank for _, rank in sorted(own)])
        assert len(own) == len(bids.targets) > 1
    for column in zip(*ranks, strict=True):
        assert sorted(column) == [*range(len(members))]


def test_robots_at_one_place_spread_by_minpos():
    places = places_drawn(2, 6)
    chosen = [only_choice(choose_minpos, r)[0] for r in team_at(places, [places[0]] * 3)]
    assert len(chosen[0].frontiers) == 2
    assert [event.goal for event in chosen].count(chosen[0].goal) == 2
    assert chosen[0].goal == chosen[2].goal != chosen[1].goal


def test_minpos_has_on_record_who_is_known_to_be_nearer():
    places = places_drawn(1, 5)
    events = [only_choice(choose_minpos, r)[0] for r in team_at(places, places[:3])]
    for number, event in enumerate(events):
        choice = event.frontiers.index(event.goal)
        ranks = np.array(event.ranks)
        assert ranks.shape == (3, len(event.frontiers))
        worked = [j for j, cost in enumerate(event.costs[number]) if cost is not None]
        assert ranks[number, choice] == ranks[number, worked].min()


def test_idle_and_long_silent_mates_are_not_reckoned_with():
    places = places_drawn(3, 4)
    robot = robot_at(places, places[1:3])
    assert bid_table(robot).robots == (0, 1, 2)
    robot.course.time_s = robot.options.forget_after_s + 1.0
    robot.team.mates.heard_s[2] = robot.time_s
    assert bid_table(robot).robots == (0, 2)


# Stop signals ----------------------------------------------------------------------------------


def test_those_are_told_to_stop_whose_goal_is_explored():
    robot = robot_at([(3, 7), (6, 7)], [(10, 10)])
    (edge, *_) = robot.targets().tolist()
    for goal, told in ((None, False), (tuple(edge), False), ((25.0, 1.0), False), ((4, 7), True)):
        robot.team.mates.reports[1] = report_of(1, (10, 10), goal)
        acts, _ = acts_of(tell_who_may_stop(robot))
        assert acts == ([Send(StopMessage(sender=0, goal=goal), 1)] if told else [])
    assert acts_of(tell_who_may_stop(robot))[0] == []  # once is enough


def test_a_stop_signal_counts_for_the_goal_that_a_robot_has():
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


class Stopper:
    """Tells the other robot to stop once it has said where it goes."""

    def run(self):
        while True:
            outcome = yield Receive(None)
            assert isinstance(outcome, Received)
            for message in outcome.messages:
                goal = message.reports[0].goal if isinstance(message, ReportMessage) else None
                if goal is not None:
                    yield Receive(0.3)
                    yield Send(StopMessage(sender=1, goal=goal), 0)
                    yield Done(complete=True, reason="enough")
                    return


def test_a_robot_that_is_told_to_stop_chooses_again(monkeypatch):
    own = strategy("self-bidding")

    def explorer(me, options):
        return own.explorer(me, options) if me.robot == 0 else Stopper()

    monkeypatch.setitem(registry._registry(), own.name, dataclasses.replace(own, explorer=explorer))
    run = simulated("self-bidding", 2, seed=1)
    stopped = [e for e in events(run, GoalChosen, 0) if e.because == "stop signal"]
    assert len(stopped) == 1
    assert run.footer.outcome == "complete"


class Nagger:
    """Stands in a corridor and insists that the other robot gives way, for a long time."""

    LONG_S = 400.0

    def run(self):
        nag = GiveWayMessage(sender=1, path=((4.0, 0.35), (0.5, 0.35)), radius_m=0.25, firm=True)
        now_s = 0.0
        while now_s < self.LONG_S:
            yield Send(nag, 0)
            again_s = now_s + 1.0
            while now_s < again_s:
                now_s = (yield Receive(again_s - now_s)).time_s
        yield Done(complete=True, reason="enough")


@pytest.mark.parametrize("name", FAMILY)
def test_a_robot_that_can_neither_pass_nor_give_way_is_done_at_last(name, monkeypatch):
    own = strategy(name)

    def explorer(me, options):
        return own.explorer(me, options) if me.robot == 0 else Nagger()

    monkeypatch.setitem(registry._registry(), own.name, dataclasses.replace(own, explorer=explorer))
    corridor = Environment("corridor", shapely.box(0, 0, 12, 0.7), starts=[(1, 0.35), (4, 0.35)])
    robots = tuple(RobotSpec(start=start) for start in corridor.starts)
    run = simulate(RunSpec(environment=inline(corridor), strategy=name, robots=robots), corridor)
    boxed_in = [e for e in events(run, Ended, 0) if e.time_s < Nagger.LONG_S]
    assert [(e.complete, e.reason) for e in boxed_in] == [
        (False, "boxed in by robots 1, which do not give way")
    ]
    assert run.footer.outcome == "stalled"


# Options ---------------------------------------------------------------------------------------


def ends_of(run, chosen):
    """Where the robot was when it chose, for every choice."""
    for event in chosen:
        before = [m for m in events(run, Motion, event.robot) if m.time_s < event.time_s]
        yield before[-1].waypoints[-1][1:3] if before else run.starts[event.robot][:2]


@pytest.mark.parametrize("name", FAMILY)
def test_scans_at_targets_only_make_nodes_at_targets_only(name):
    run = simulated(name, options={"sense": "targets", "reached": "cell"}, seed=2)
    assert run.footer.outcome == "complete"
    assert measure(run, TWO_ROOMS).coverage > 0.98
    goals = [e.goal for e in events(run, GoalChosen) if e.goal is not None]
    root, *nodes = events(run, NodeAdded)
    assert root.stage == "root"
    assert nodes
    # By its rules a robot goes to where its goal is seen from, which is not on record.
    for node in nodes if name != "rules" else ():
        assert min(math.dist(node.configuration[:2], goal) for goal in goals) < 0.02
    assert len(nodes) <= len(goals)
    moving = simulated(name, options={"reached": "cell"}, seed=2)
    assert len(events(moving, NodeAdded)) > len(nodes) + 1


@pytest.mark.parametrize("reached", ["cell", "sight"])
def test_a_goal_is_reached_at_its_cell_or_in_sight(reached):
    # Without scans on the way only arrival ends a drive.
    run = simulated(
        "closest", options={"sense": "targets", "reached": reached, "replan": "target"}, seed=2
    )
    assert run.footer.outcome == "complete"
    chosen = events(run, GoalChosen)
    gaps = [
        math.dist(place, before.goal)
        for before, event, place in zip(
            chosen[:-1], chosen[1:], [*ends_of(run, chosen[1:])], strict=True
        )
        if event.because == "reached"
    ]
    assert gaps
    if reached == "cell":
        assert max(gaps) < 0.02
    else:
        assert max(gaps) > 0.5
        assert max(gaps) <= 2.0 + 1e-9


@pytest.mark.parametrize(("replan", "chosen_anew"), [("news", True), ("target", False)])
def test_goals_are_chosen_anew_on_news_only_if_wanted(replan, chosen_anew):
    run = simulated("minpos", 3, options={"replan": replan}, seed=1)
    assert any(e.because == "news" for e in events(run, GoalChosen)) is chosen_anew


@pytest.mark.parametrize("name", FAMILY)
def test_cells_wider_than_the_body_are_refused(name):
    options = {"cell_m": 0.51, "search_cell_m": 1.0} if name == "rules" else {"cell_m": 0.51}
    with pytest.raises(InvalidInputError, match=r"cell_m is 0\.51.*choose at most 0\.5$") as caught:
        simulated(name, options=options)
    assert "\n" not in str(caught.value)


def test_a_body_that_is_no_disc_keeps_room_to_turn():
    # Through some gaps among the stones its narrow side would fit, but it could not turn there.
    spec = RunSpec(
        environment=CatalogEnvironment(name="clutter"),
        strategy="utility",
        robots=(RobotSpec(footprint="box:0.6x0.4"),),
        seed=877,
    )
    recording = simulate(spec)
    assert recording.footer.outcome == "complete"
    assert measure(recording, environment("clutter")).coverage > 0.99


def test_holonomic_bodies_are_not_refused():
    run = simulated("self-bidding", 2, robot=RobotSpec(drive=DriveSpec(kind="holonomic")))
    assert run.footer.outcome == "complete"


@pytest.mark.parametrize("name", ["utility", "self-bidding", "rules"])
def test_robots_that_decide_together_have_to_hear_one_another(name):
    with pytest.raises(InvalidInputError, match="the radio range is 0"):
        simulated(name, 2, radio=RadioSpec(range_m=0.0))


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("closest", {"cel_m": 0.1}, "closest has no option 'cel_m'"),
        ("minpos", {"beta": 1.0}, "minpos has no option 'beta'"),
        ("utility", {"beta": -1.0}, "beta is -1.0; it must be 0 or more"),
        ("self-bidding", {"phi_step": 0.0}, "phi_step is 0.0; it must be positive"),
        ("greedy", {"sense": "never"}, "sense='never' of greedy"),
        ("rules", {"patience": 0}, "patience is 0; it must be at least 1"),
    ],
)
def test_options_that_make_no_sense_are_refused(name, options, message):
    with pytest.raises(InvalidInputError, match=message):
        simulated(name, options=options)


@pytest.mark.parametrize("name", ["closest", "greedy", "minpos", "utility"])
def test_all_that_bid_can_drive_by_the_diagram(name):
    paths, diagram = (
        simulated(name, 2, world=PLAZA, options={"drive": drive}, seed=1)
        for drive in ("path", "nearness-diagram")
    )
    for recording in (paths, diagram):
        assert recording.footer.outcome == "complete"
        assert not events(recording, Collision)
    # It drives in arcs, and slows down near walls.
    assert diagram.footer.time_s > paths.footer.time_s
    assert len(events(diagram, Motion)) > len(events(paths, Motion))


@pytest.mark.parametrize("seed", range(4))
def test_ways_lead_as_far_from_others_goals_as_dense_points_say(seed):
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
        ((9.425, 7.0), 2, 4, "pocket"),
        ((10.5, 7.35), 7, 4, "west"),
        ((10.5, 7.35), 7, 16, "nowhere"),
        (None, 2, 4, "own cell"),
    ],
    ids=[
        "a way leads away from the body",
        "the way on would come nearer",
        "to the pocket it would come nearer",
        "there is but the pocket, past the body",
        "no body",
    ],
)
def test_ways_begin_where_they_lead_on_and_no_body_stops_the_robot(body, pocket, west, begins_in):
    # Around the robot nothing is passable but one cell, from which no way leads, and what lies
    # to the west.
    robot = robot_at([(10.0, 7.0)])
    raster, cell = robot.raster, robot.raster.cell_of(10.0, 7.0)
    scan = take_scan(edges_of(PLAZA), Configuration(10.0, 7.0), 0.0, 4.0)
    robot.map.view(scan)
    expected = {
        "west": (cell[0], cell[1] - 5),
        "pocket": (cell[0] + pocket, cell[1]),
        "own cell": cell,
        "nowhere": None,
    }
    if body is not None:
        seen = Sighting(
            robot=1, configuration=Configuration(*body, 0.0), footprint=Footprint.parse("disc:0.25")
        )
        robot.bodies.add(seen)
        row, column = cell[0] - raster.row, cell[1] - raster.column
        raster.passable[row - 12 : row + 13, column - west : column + 13] = False
        raster.passable[row + pocket, column] = True
    with robot.around_bodies():
        assert robot.ways.first_cell() == expected[begins_in]


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
    scan = take_scan(edges_of(PLAZA), robot.at, 0.0, 4.0)
    robot.map.view(scan)
    goal = robot.goal_at(robot.own_field(), *place)
    assert robot.sees_at_half_range(goal) == seen


def test_a_goal_at_which_nothing_was_learnt_from_afar_is_gone_to():
    robot = robot_at([(5.0, 4.2)], options=FrontierOptions(reached="sight"))
    scan = take_scan(edges_of(PLAZA), robot.at, 0.0, 4.0)
    robot.map.view(scan)
    field = robot.own_field()
    costs = field.distance(robot.indices_of(robot.targets()))
    x, y = robot.targets()[int(np.argmin(costs))].tolist()
    goal = robot.goal_at(field, x, y)
    # Half way there it is in sight, and still a frontier.
    half_way = goal.path[0] + 0.7 * (goal.path[-1] - goal.path[0])
    robot.course.at = Configuration(*half_way.tolist(), 0.0)
    assert robot.sees_at_half_range(goal)
    robot.frontiers.note_reached(goal.place, robot.at[:2])
    assert not robot.sees_at_half_range(goal)
    assert any((place == goal.place).all() for place in robot.targets())
