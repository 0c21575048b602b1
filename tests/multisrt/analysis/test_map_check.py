import pytest
import shapely
from shapely import box

from multisrt.analysis.map_check import check_map
from multisrt.environments.environment import Environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import inline
from multisrt.spec import RobotSpec, RunSpec

BODY = Footprint.disc(0.25)
WALL = box(4, 0, 4.2, 1.8) | box(4, 2.2, 4.2, 4)
ROOMS = box(0, 0, 8.2, 4) - WALL


def test_a_hall_suits_a_body():
    check = check_map(Environment("hall", box(0, 0, 8, 4), starts=[(1, 1)]), BODY)
    assert check.problems == ()
    assert check.unreachable == ()
    assert check.reached_share == 1.0


def test_a_room_behind_a_narrow_door_is_out_of_reach():
    check = check_map(Environment("rooms", ROOMS, starts=[(6, 2)]), BODY)
    (room,) = check.unreachable
    # The room at the left, the door, and what the disc leaves of the door on its side.
    assert room.area == pytest.approx(16.08, abs=0.03)
    assert room.contains(shapely.Point(1, 1))
    assert check.reached_share == pytest.approx(1 - room.area / ROOMS.area)
    (door,) = check.blocking
    assert door.width_m == pytest.approx(0.4)
    (problem,) = check.problems
    assert "reaches 50.0 %" in problem


def test_a_body_as_wide_as_the_door_passes():
    check = check_map(Environment("rooms", ROOMS), Footprint.disc(0.2))
    assert check.unreachable == ()
    assert check.blocking == ()


@pytest.mark.parametrize(
    ("radius_m", "blocking", "tight"),
    [(0.14, 0, 0), (0.16, 0, 1), (0.2, 0, 1), (0.21, 1, 0)],
)
def test_passages_with_little_to_spare_are_tight(radius_m, blocking, tight):
    check = check_map(Environment("rooms", ROOMS), Footprint.disc(radius_m))
    assert (len(check.blocking), len(check.tight)) == (blocking, tight)


def test_a_box_is_checked_by_its_inscribed_disc():
    check = check_map(Environment("rooms", ROOMS), Footprint.parse("box:1x0.39"))
    assert check.reached_share == 1.0


def test_a_body_that_fits_nowhere_is_a_problem():
    check = check_map(Environment("hall", box(0, 0, 8, 4)), Footprint.disc(2.1))
    assert check.reached_share == 0.0
    assert "fits nowhere" in check.problems[0]
    assert "radius of 2 m" in check.problems[0]


def test_the_largest_disc_is_the_one_that_fits_anywhere():
    # A hall of 4 x 4 m, and half of the area in corridors of 0.4 m.
    corridors = [box(4, 0.5 * k, 14, 0.5 * k + 0.4) for k in range(8)]
    check = check_map(Environment("comb", shapely.union_all([box(0, 0, 4, 4), *corridors])), BODY)
    assert check.largest.radius_m == pytest.approx(0.2, abs=0.01)
    large = check_map(check.environment, Footprint.disc(2.5))
    assert large.largest == check.largest
    assert "the largest disc there has a radius of 2 m" in large.problems[0]


def test_starts_in_other_parts_or_beside_walls_are_problems():
    two = shapely.union_all([box(0, 0, 8, 4), box(9, 0, 9.5, 1)])
    world = Environment("two", two, starts=[(1, 1), (9.2, 0.5), (7.9, 2)])
    check = check_map(world, BODY)
    assert check.start_parts == (0, 1, 0)
    assert check.problems == (
        "the suggested start (9.2, 0.5) is in another part than the first",
        "at the suggested start (7.9, 2) the body disc:0.25 does not fit: "
        "the nearest wall is at 0.1 m, and it needs more than 0.25 m",
    )


@pytest.mark.parametrize("body", ["disc:0.25", "box:0.6x0.4"])
def test_a_start_at_which_no_run_begins_is_a_problem(body):
    # As far from the wall as the disc's radius, and less than half the length of the box.
    world = Environment("hall", box(0, 0, 8, 4), starts=[(4, 2), (0.25, 2)])
    (problem,) = check_map(world, Footprint.parse(body)).problems
    assert problem.startswith(
        f"at the suggested start (0.25, 2) the body {body} does not fit: the nearest wall is at "
        "0.25 m, and it needs "
    )
    robots = (RobotSpec(footprint=body),) * 2
    spec = RunSpec(environment=inline(world), robots=robots, starts="suggested")
    with pytest.raises(InvalidInputError, match=r"does not fit at \(0\.25, 2\), where the cle"):
        starts_of(spec, world)


def test_equal_problems_of_starts_are_one():
    hall = box(0, 0, 8, 4) | box(9, 0, 9.4, 4)
    near = [(0.1, 1), (0.2, 2), (0.1, 3), (7.95, 2)]
    world = Environment("hall", hall, starts=[(1, 1), *near, (9.1, 1), (9.1, 2)])
    assert check_map(world, BODY).problems == (
        "the suggested starts (9.1, 1) and (9.1, 2) are in another part than the first",
        "at the suggested starts (0.1, 1), (0.2, 2), (0.1, 3) and 1 more the body disc:0.25 does "
        "not fit: the nearest walls are at 0.05 to 0.2 m, and it needs more than 0.25 m",
    )


def test_equal_parts_are_a_problem_and_the_first_start_chooses():
    two = shapely.union_all([box(0, 0, 4, 4), box(5, 0, 10, 4)])
    check = check_map(Environment("two", two, starts=[(1, 1)]), BODY)
    assert check.main.area == 16.0
    assert "only 44.4 % of free space" in check.problems[0]


def test_paper_around_a_building_is_not_the_main_part():
    wall = box(1, 1, 9, 9) - box(2, 2, 8, 8)
    check = check_map(Environment.from_outline("plan", box(0, 0, 10, 10), [wall]), BODY)
    assert check.main.area == 36.0
    assert "the area around the walls is free, too" in check.problems[0]


def test_a_page_around_a_small_plan_is_no_matter_of_doors():
    wall = box(1, 1, 13, 13) - box(1.5, 1.5, 12.5, 12.5)
    check = check_map(Environment.from_outline("page", box(0, 0, 36, 30), [wall]), BODY)
    assert check.main.area == 36 * 30 - 144
    assert (
        ", which lies around others along the border of the map: if it is the page around a "
        "building, make it occupied, or explore with --start 7.00,7.00; else open doors"
    ) in check.problems[0]


@pytest.mark.parametrize("share", [0.0, -1.0, 1.1, float("nan")])
def test_shares_out_of_range_are_refused(share):
    with pytest.raises(InvalidInputError, match="share"):
        check_map(Environment("hall", box(0, 0, 8, 4)), BODY, share=share)


PAGE = Environment.from_outline(
    "page", box(0, 0, 36, 30), [box(1, 1, 13, 13) - box(1.5, 1.5, 12.5, 12.5)], starts=[(20, 20)]
)


def test_a_given_start_chooses_the_part():
    check = check_map(PAGE, BODY, starts=[Configuration(7, 7), Configuration(3, 3)])
    assert check.main.area == 121.0
    assert check.problems == ()  # that it has 12 % of free space was asked for
    assert (check.starts, check.start_parts) == (((7, 7), (3, 3)), (1, 1))
    assert check_map(PAGE, BODY).main.area == 36 * 30 - 144


def test_what_is_in_reach_is_so_from_a_given_start():
    check = check_map(Environment("rooms", ROOMS), BODY, starts=[Configuration(1, 2)])
    (room,) = check.unreachable
    assert room.contains(shapely.Point(6, 2))
    check = check_map(Environment("rooms", ROOMS), BODY, starts=[Configuration(6, 2)])
    (room,) = check.unreachable
    assert room.contains(shapely.Point(1, 2))


def test_given_starts_in_another_part_or_without_room_are_problems():
    check = check_map(
        PAGE, BODY, starts=[Configuration(7, 7), Configuration(20, 20), Configuration(1.6, 7)]
    )
    assert check.problems == (
        "the start (20, 20) is in another part than the first",
        "the body disc:0.25 does not fit at the start (1.6, 7) of 'page': the clearance there is "
        "0.1 m, and it needs more than 0.25 m; the nearest place where the body disc:0.25 fits is "
        "(1.76, 7), 0.16 m from there",
    )


def test_the_heading_of_a_given_start_counts():
    corridor = Environment("corridor", box(0, 0, 8, 1))
    along, across = Configuration(4, 0.5), Configuration(4, 0.5, 1.5708)
    body = Footprint.parse("box:1.6x0.6")
    assert check_map(corridor, body, starts=[along]).problems == ()
    (problem,) = check_map(corridor, body, starts=[across]).problems
    assert problem.startswith("the body box:1.6x0.6 does not fit at the start (4, 0.5)")


def test_a_given_start_in_a_wall_is_refused_with_the_nearest_place():
    with pytest.raises(ClearanceError, match=r"start \(1\.2, 7\) is not.*fits is \(0\.74, 7\)"):
        check_map(PAGE, BODY, starts=[Configuration(7, 7), Configuration(1.2, 7)])
    with pytest.raises(InvalidInputError, match="a start is finite"):
        check_map(PAGE, BODY, starts=[Configuration(float("nan"), 7)])
