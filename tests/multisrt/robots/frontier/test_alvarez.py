"""RULES: which cells are goals, how robots get there, and what they tell each other."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import multisrt as ms
from multisrt.environments.environment import Environment
from multisrt.events import GoalChosen, Sent
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.grid_search import reachable
from multisrt.planners.motion.kinematics import Differential
from multisrt.robots.explorer import Note, RobotSelf, Send, Sighting
from multisrt.robots.frontier.alvarez import Rules, agreed, as_party, facing
from multisrt.robots.frontier.alvarez_goals import (
    is_open,
    last_known,
    path_cost,
    path_to,
    search,
    take_survey,
)
from multisrt.robots.frontier.messages import InaccessibleMessage, SwapMessage
from multisrt.robots.frontier.options import RulesOptions
from multisrt.robots.frontier.progress import Event
from multisrt.robots.frontier.robot import FrontierRobot
from multisrt.robots.registry import strategy
from multisrt.simulation.worlds import inline
from multisrt.spec import (
    CatalogEnvironment,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

WALL = shapely.union_all([shapely.box(6, 0, 6.2, 2.5), shapely.box(6, 3.5, 6.2, 6)])
TWO_ROOMS = Environment("two rooms", shapely.box(0, 0, 12, 6).difference(WALL), starts=[(1, 1)])
HALL = Environment("hall", shapely.box(0, 0, 30, 10), starts=[(3, 5)])


def robot_in(world, x, y, heading=0.0, *, number=0, team=1, seen_from=(), **options):
    """A robot that has looked round from where it stands, and knows what was seen elsewhere."""
    at = Configuration(x, y, heading)
    me = RobotSelf(
        robot=number,
        start=at,
        footprint=Footprint.parse("disc:0.25"),
        kinematics=Differential(speed_m_s=0.5, turn_rate_rad_s=math.pi / 2),
        range_m=4.0,
        rng=np.random.default_rng(1),
        team=team,
    )
    robot = FrontierRobot(me, RulesOptions(**options))
    index = EdgeIndex(world.edges, 1.5)
    for place in (at, *(Configuration(*place) for place in seen_from)):
        robot.raster.add(local_safe_region(take_scan(index, place, 0.0, 4.0), "radial"))
    return robot


def report_of(robot, aim=None):
    """What a robot says of itself."""
    robot.team.cells.aim = aim
    robot.team.phase = "driving"
    return robot.team.own_report()


def tell(robot, *reports):
    for report in reports:
        robot.team.teammates.take(report)


# The map as cells ------------------------------------------------------------------------------


@pytest.mark.slow
def test_cells_of_the_search_are_the_same_for_all_robots():
    maps = [take_survey(robot_in(TWO_ROOMS, *at), (), ()) for at in ((1, 1), (10, 4.3))]
    for survey in maps:
        assert survey.centres / 0.5 % 1.0 == pytest.approx(np.full(survey.centres.shape, 0.5))


def test_cells_are_classified_by_the_raster_at_the_centre():
    robot = robot_in(TWO_ROOMS, 3, 3)
    survey = take_survey(robot, (), ())
    known = np.array([[robot.raster.is_known(x, y) for x, y in row] for row in survey.centres])
    assert (survey.unexplored == ~known).all()
    x, y = survey.centres.transpose(2, 0, 1)
    room = shapely.box(0, 0, 6, 6)
    inner, depth = (
        shapely.contains_xy(room, x, y),
        shapely.distance(shapely.points(x, y), room.exterior),
    )
    # So near to a wall the body cannot stand; the raster is right to a cell.
    assert survey.obstacle[known & inner & (depth < 0.2)].all()
    assert not survey.obstacle[known & inner & (depth > 0.4) & (x < 5.0)].any()


def test_the_map_extends_one_cell_beyond_what_was_seen():
    survey = take_survey(robot_in(HALL, 15, 5), (), ())
    x, y = survey.centres.transpose(2, 0, 1)
    # Seen is a disc of 4 m around (15, 5).
    assert (x.min(), x.max()) == (pytest.approx(10.75), pytest.approx(19.25))
    assert (y.min(), y.max()) == (pytest.approx(0.75), pytest.approx(9.25))
    assert survey.diagonal_m == pytest.approx(math.hypot(9.0, 9.0))


def test_inaccessible_cells_are_obstacles():
    robot = robot_in(HALL, 15, 5)
    before = take_survey(robot, (), ())
    assert before.unexplored[0, 0]
    after = take_survey(robot, (), [tuple(before.centres[0, 0])])
    assert after.obstacle[0, 0]
    assert after.unexplored.sum() == before.unexplored.sum() - 1


def test_cells_behind_a_wall_are_reached_through_the_door():
    robot = robot_in(TWO_ROOMS, 3, 3, seen_from=[(3, 1.2), (3, 4.8), (5, 1.2), (5, 4.8)])
    survey = take_survey(robot, (), ())
    assert survey.can_reach(robot.raster, (6.75, 3.25))
    path = path_to(robot, survey, (6.75, 5.75))
    assert path is not None
    x, y = path.edge
    assert 5.5 < x < 9.0
    assert 2.5 < y < 6.0
    # By A* around the end of the wall; seen from there, not less than the shortest line.
    assert path.cost_m >= math.dist((3, 3), (6.1, 3.5)) + math.dist((6.1, 3.5), (6.75, 5.75)) - 0.3
    # Entered in vain all along the door, nothing is left.
    tried = [(x, y) for x in np.arange(5.6, 10.1, 0.2) for y in np.arange(0.1, 6.0, 0.2)]
    closed = take_survey(robot, tried, ())
    assert path_to(robot, closed, (6.75, 5.75)) is None
    assert not closed.can_reach(robot.raster, (-0.25, 3.25))


def test_a_path_leads_to_every_unexplored_cell_in_reach_and_to_no_other():
    robot = robot_in(TWO_ROOMS, 3, 3, seen_from=[(3, 1.2), (5, 4.8)])
    survey = take_survey(robot, [(5.6, y) for y in np.arange(0.1, 6.0, 0.2)], ())
    in_reach = 0
    for x, y in survey.centres[survey.unexplored].tolist():
        leads = path_to(robot, survey, (x, y)) is not None
        assert leads == survey.can_reach(robot.raster, (x, y))
        in_reach += leads
    assert 0 < in_reach < survey.unexplored.sum()


def test_the_goal_is_at_the_edge_of_the_known_area():
    robot = robot_in(HALL, 15, 5)
    survey = take_survey(robot, (), ())
    path = path_to(robot, survey, (19.25, 5.25))
    assert path is not None
    assert math.dist(path.edge, (15, 5)) == pytest.approx(4.0, abs=0.2)
    assert robot.raster.is_known(*path.edge)
    assert is_open(robot.raster, path.edge)
    assert not is_open(robot.raster, (15.0, 5.0))
    assert path.cost_m == pytest.approx(math.dist((15, 5), (19.25, 5.25)), abs=0.15)
    assert path_to(robot, survey, (15.25, 5.25)) is None  # it has been seen


@pytest.mark.parametrize(
    ("known", "last"),
    [("110 010", 1), ("100 010", 0), ("100 110", 1), ("110 000", 0)],
    ids=["round one side", "round neither", "round the other", "unknown at once"],
)
def test_a_path_is_known_up_to_its_first_unknown_step(known, last):
    cells = np.array([[c == "1" for c in row] for row in known.split()])
    path = np.array([(0, 0), (1, 1), (1, 2)])
    assert last_known(cells, path) == last


@given(arrays(bool, (7, 7)), st.integers(0, 1000))
def test_the_known_part_of_a_path_cuts_no_corners(known, seed):
    rng = np.random.default_rng(seed)
    steps = rng.integers(-1, 2, (12, 2))
    path = np.clip(np.cumsum([(3, 3), *steps.tolist()], axis=0), 0, 6)
    assume(path[-1].tolist() != [3, 3])
    known[3, 3], known[tuple(path[-1])] = True, False
    last = last_known(known, path)
    reached = reachable(known, 3, 3)
    assert all(reached[tuple(cell)] for cell in path[: last + 1].tolist())
    after = tuple(path[last + 1].tolist())
    beside = [(path[last][0], after[1]), (after[0], path[last][1])]
    assert not known[after] or not any(known[cell] for cell in beside)


def test_the_cost_of_a_path_is_that_of_a_star():
    robot = robot_in(HALL, 15, 5)
    survey = take_survey(robot, (), ())
    assert path_cost(robot, survey, (15, 5), (19.25, 5.25)) == pytest.approx(4.35, abs=0.15)
    assert math.isinf(path_cost(robot, survey, (15, 5), (90, 5)))


# Choosing --------------------------------------------------------------------------------------


def test_a_ring_finds_a_share_of_all_cells():
    robot = robot_in(HALL, 15, 5)
    survey = take_survey(robot, (), ())
    cells, _ = search(robot, survey, np.empty((0, 2)))
    every, _ = search(robot, survey, np.empty((0, 2)), everywhere=True)
    assert math.ceil(0.05 * survey.unexplored.size) <= len(cells) < len(every)
    assert len(every) == survey.unexplored.sum()


@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, -math.pi / 2])
def test_in_an_open_hall_the_cell_ahead_is_the_best(acts_of, heading):
    robot = robot_in(HALL, 15, 5, heading, enough_share=1.0)
    acts, goal = acts_of(Rules().choose(robot, Event.START))
    note = acts[-1].event
    assert note.rule == "rules"
    bearing = math.atan2(goal.y - 5, goal.x - 15)
    assert abs(math.remainder(bearing - heading, math.tau)) < math.radians(20)
    assert note.scores == tuple(sorted(note.scores, key=lambda row: -row[2]))
    assert note.goal == robot.team.cells.aim == note.scores[0][:2]
    x, y, score, distance, turn, others = note.scores[0]
    diagonal = take_survey(robot, (), ()).diagonal_m
    assert distance == pytest.approx(45 * math.dist((15, 5), (x, y)) / diagonal)
    assert others == 0.0
    assert score == pytest.approx(70 - distance - turn)


def test_a_cell_far_from_anothers_goal_is_better(acts_of):
    me = robot_in(HALL, 15, 5, turn_weight=0.0, team=2)
    tell(me, report_of(robot_in(HALL, 15, 5, number=1, team=2), aim=(19.25, 5.25)))
    _, goal = acts_of(Rules().choose(me, Event.START))
    assert goal.x < 13


def test_a_robot_keeps_its_aim_until_it_is_explored(acts_of):
    robot = robot_in(HALL, 15, 5, 0.0)
    robot.team.cells.aim = (10.75, 5.25)
    rules = Rules()
    acts_of(rules.choose(robot, Event.NOTHING_LEFT))
    assert robot.team.cells.aim == (10.75, 5.25)
    acts_of(rules.choose(robot, Event.BLOCKED))
    assert robot.team.cells.aim[0] > 15


def test_there_is_no_goal_when_all_is_explored(acts_of):
    small = Environment("small", shapely.box(0, 0, 3, 3))
    robot = robot_in(small, 1.5, 1.5)
    acts, goal = acts_of(Rules().choose(robot, Event.START))
    assert goal is None
    assert robot.team.cells.aim is None
    assert isinstance(acts[-1], Note)
    assert isinstance(acts[-1].event, GoalChosen)
    assert acts[-1].event.goal is None


def test_after_some_failures_a_robot_goes_to_a_random_place(acts_of):
    robot = robot_in(HALL, 15, 5, random_goal_after=3)
    rules = Rules()
    picked = []
    for because in (Event.START, Event.BLOCKED, Event.NO_WAY, Event.BLOCKED):
        acts, goal = acts_of(rules.choose(robot, because))
        picked.append(acts[-1].event.rule)
    assert picked == ["rules", "rules", "rules", "random"]
    assert rules.wanders
    assert robot.raster.is_known(*goal.place)
    assert acts_of(rules.choose(robot, Event.REACHED))[0][-1].event.rule == "rules"


def test_a_place_reached_in_vain_is_reported_and_given_up(acts_of):
    robot = robot_in(HALL, 15, 5, team=2)
    rules = Rules()
    _, first = acts_of(rules.choose(robot, Event.START))
    acts, second = acts_of(rules.choose(robot, Event.REACHED))
    assert math.dist(first.place, second.place) > 0.25
    told = [act.message for act in acts if isinstance(act, Send)]
    (message,) = told
    assert isinstance(message, InaccessibleMessage)
    assert message.tried == (first.place,)
    teammate = robot_in(HALL, 15, 5, number=1, team=2)
    acts_of(teammate.team._take_message(message))
    assert list(teammate.team.cells.tried) == [first.place]


def test_a_place_to_which_this_robot_finds_no_way_is_left_to_the_others(acts_of):
    robot = robot_in(HALL, 15, 5, team=2)
    rules = Rules()
    told = []
    for because in (Event.START, Event.NO_WAY, Event.NO_WAY):
        acts, goal = acts_of(rules.choose(robot, because))
        told += [act.message for act in acts if isinstance(act, Send)]
    (given_up,) = robot.team.cells.tried
    assert goal.place != given_up
    # It says which cells it cannot reach; these are obstacles once all have said so.
    assert told
    for message in told:
        assert isinstance(message, InaccessibleMessage)
        assert message.tried == ()


def test_a_cell_that_no_robot_can_reach_is_an_obstacle(acts_of):
    robot = robot_in(HALL, 15, 5, team=3)
    others = [robot_in(HALL, 14 + k, 4, number=k, team=3) for k in (1, 2)]
    tell(robot, *(report_of(other) for other in others))
    cell = (10.75, 0.75)
    robot.team.cells.inaccessible[cell] = {0: None}
    for other in others:
        assert agreed(robot) == []
        said = InaccessibleMessage(
            sender=other.me.robot, cells=(cell,), tried=(), radius_m=other.body.outer_radius_m
        )
        acts_of(robot.team._take_message(said))
    assert agreed(robot) == [cell]


# Swaps -----------------------------------------------------------------------------------------


def crossed(exchange=True):
    """Two robots in a hall, each bound for a cell beyond the other."""
    left = robot_in(HALL, 10, 5, team=2, seen_from=[(14, 5)], exchange=exchange)
    right = robot_in(HALL, 14, 5, number=1, team=2, seen_from=[(10, 5)])
    near_left, near_right = (5.75, 5.25), (18.25, 5.25)
    tell(left, report_of(right, aim=near_left))
    left.team.cells.aim = near_right
    return left, right, near_left, near_right


def test_robots_with_crossed_goals_swap_them(acts_of):
    left, right, near_left, near_right = crossed()
    acts, done = acts_of(Rules().swaps(left))
    assert done
    assert left.team.cells.aim == near_left
    assert [act.message for act in acts] == [
        SwapMessage(sender=0, taken=near_left, given=near_right)
    ]
    acts_of(right.team._take_message(acts[0].message))
    assert right.team.cells.aim == near_right
    # Who has another goal by now keeps it.
    acts_of(right.team._take_message(acts[0].message))
    assert right.team.cells.aim == near_right


def test_a_swap_is_not_taken_back(acts_of):
    left, right, _, near_right = crossed()
    rules = Rules()
    acts_of(rules.swaps(left))
    tell(left, report_of(right, aim=near_right))
    assert acts_of(rules.swaps(left)) == ([], False)


def test_without_exchange_goals_stay(acts_of):
    left, *_ = crossed(exchange=False)
    assert acts_of(Rules().swaps(left)) == ([], False)


@pytest.mark.parametrize(("when", "swaps"), [("shorter", False), ("nearer", True)])
def test_a_swap_at_the_other_robots_expense_is_an_option(when, swaps, acts_of):
    # The left robot has 4.25 m to its own goal, and 3.25 m to that of the right one, which has
    # 4.75 m to it and would get a path of 12.25 m in return.
    left = robot_in(HALL, 10, 5, team=2, seen_from=[(14, 5), (18, 5)], exchange_when=when)
    right = robot_in(HALL, 18, 5, number=1, team=2)
    tell(left, report_of(right, aim=(13.25, 5.25)))
    left.team.cells.aim = (5.75, 5.25)
    assert acts_of(Rules().swaps(left))[1] is swaps


# The right of way ------------------------------------------------------------------------------


def test_a_robot_faces_along_its_path():
    at = Configuration(1.0, 1.0, 0.3)
    assert facing(at, np.array([[1.0, 1.0], [1.0, 4.0]])).heading == pytest.approx(math.pi / 2)
    assert facing(at, np.array([[1.0, 1.0]])) == at


def test_a_teammate_that_was_not_heard_of_is_inactive():
    robot = robot_in(HALL, 15, 5, team=2)
    teammate = robot_in(HALL, 17, 5, number=1, team=2)
    sighting = Sighting(robot=1, configuration=teammate.at, footprint=teammate.me.footprint)
    assert as_party(robot, sighting).inactive
    tell(robot, report_of(teammate, aim=(20.25, 5.25)))
    assert not as_party(robot, sighting).inactive


# Whole runs ------------------------------------------------------------------------------------


@pytest.mark.parametrize("robots", [1, 3])
def test_a_team_completes_two_rooms(robots):
    run = ms.explore(TWO_ROOMS, strategy="rules", robots=robots, seed=2)
    assert run.metrics.outcome == "complete"
    assert run.metrics.coverage > 0.995
    assert run.metrics.collisions == 0
    chosen = [e for e in run.recording.events if isinstance(e, GoalChosen)]
    assert {e.rule for e in chosen} <= {"rules", "closest", "random"}
    assert any(len(e.scores) == 10 for e in chosen)
    again = ms.explore(TWO_ROOMS, strategy="rules", robots=robots, seed=2)
    assert again.recording.footer == run.recording.footer


def test_other_strategies_say_nothing_of_aims():
    run = ms.explore(TWO_ROOMS, strategy="minpos", robots=2, seed=1)
    kinds = {e.kind for e in run.recording.events if isinstance(e, Sent)}
    assert not kinds & {"swap", "inaccessible"}


def test_a_robot_that_sees_nothing_searches_from_the_nearest_cell():
    # Robot 1 sees hardly farther than its body reaches, and the centres of coarse cells are farther
    # away: it knows only what robot 0 tells it, and stands outside of its map.
    blind = RobotSpec(
        start=(6.93, 7.04), footprint="disc:0.11", range_finder=RangeFinderSpec(range_m=0.12)
    )
    spec = RunSpec(
        environment=CatalogEnvironment(name="open", parameters={"size_m": 8.0}),
        strategy="rules",
        options={"cell_m": 0.22},
        robots=(RobotSpec(start=(1.0, 1.0)), blind),
        stop=StopRule(max_time_s=3.0),
    )
    assert any(chosen.robot == 1 for chosen in ms.simulate(spec).of(GoalChosen))


@pytest.mark.parametrize("name", ["rules", "utility", "self-bidding"])
def test_a_team_that_hears_nothing_is_refused(name):
    def spec(robots, reach):
        return RunSpec(
            environment=inline(TWO_ROOMS),
            strategy=name,
            robots=(RobotSpec(),) * robots,
            radio=RadioSpec(range_m=reach),
        )

    with pytest.raises(InvalidInputError, match=r"hear one another, and the radio range is 0"):
        strategy(name).require_fit(spec(2, 0.0))
    strategy(name).require_fit(spec(1, 0.0))
    strategy(name).require_fit(spec(2, 5.0))


@pytest.mark.parametrize(
    "wrong",
    [
        {"search_cell_m": 0.05},
        {"enough_share": 0.0},
        {"enough_share": 1.1},
        {"others_weight": -1.0},
        {"conflict_radius_m": math.inf},
        {"random_goal_after": 0},
    ],
)
def test_invalid_parameters_are_refused(wrong):
    with pytest.raises(InvalidInputError, match=next(iter(wrong))):
        RulesOptions(**wrong)
