import math
from collections.abc import Iterable
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.environments.layers import Layer, Layers
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import ClearanceError, InvalidInputError
from multisrt.simulation.random_streams import random_stream
from multisrt.simulation.rooms import nearest_room
from multisrt.simulation.starts import starts_of
from multisrt.simulation.worlds import inline
from multisrt.spec import BaseSpec, DriveSpec, RangeFinderSpec, RobotSpec, RunSpec

HALL = Environment("hall", shapely.box(0, 0, 12, 8))
PILLAR = Environment("pillar", HALL.free.difference(shapely.box(4, 2, 6, 4)))
FAR = RangeFinderSpec(range_m=8.0)
BODIES = ["disc:0.25", "disc:0.4", "box:0.6x0.4", "polygon:-0.2,-0.2 0.6,-0.2 0.1,0.5 -0.2,0.5"]


def starts(
    world: Environment, robots: Iterable[RobotSpec], **spec: Any
) -> tuple[Configuration, ...]:
    return starts_of(RunSpec(environment=inline(world), robots=tuple(robots), **spec), world)


def start_of(robot: RobotSpec, world: Environment, seed: int = 0) -> Configuration:
    return starts(world, [robot], seed=seed)[0]


def team(count: int, **robot: Any) -> list[RobotSpec]:
    return [RobotSpec(**robot)] * count


def rooms() -> Environment:
    """Two rooms of 5 m by 5 m, a door of 0.9 m between them at the top, and a closed one."""
    free = shapely.box(0, 0, 5, 5) | shapely.box(5.2, 0, 10.2, 5) | shapely.box(5, 4, 5.2, 4.9)
    return Environment("rooms", free | shapely.box(20, 0, 25, 5))


def shape(robot: RobotSpec, start: Configuration) -> shapely.Polygon:
    return Footprint.parse(robot.footprint).placed(start)


# One robot ----------------------------------------------------------------------------------


def test_a_given_start_is_taken():
    assert starts(HALL, [RobotSpec(start=(3, 2))]) == (Configuration(3, 2, 0),)
    assert starts(HALL, [RobotSpec(start=(3, 2, 1.5))]) == (Configuration(3, 2, 1.5),)


def test_one_robot_starts_where_the_world_suggests():
    world = Environment("hall", HALL.free, starts=[(2, 2), (6, 6)])
    assert starts(world, team(1)) == (Configuration(2, 2, 0),)


def test_a_suggested_start_without_room_is_passed_over():
    world = Environment("hall", HALL.free, starts=[(0.1, 4), (0.3, 0.2), (6, 6), (2, 2)])
    assert starts(world, team(1)) == (Configuration(6, 6, 0),)
    assert starts(world, team(1, footprint="disc:0.05")) == (Configuration(0.1, 4, 0),)
    first, _ = starts(world, team(2), starts="clustered")
    assert first == Configuration(6, 6, 0)
    with pytest.raises(ClearanceError, match=r"start \(0\.1, 4\) .* clearance there is 0\.1 m"):
        starts(world, team(1, footprint="disc:3"))


def test_a_single_robot_starts_at_random_where_it_has_room():
    (start,) = starts(HALL, team(1), seed=5)
    room = shapely.box(0.275, 0.275, 11.725, 7.725)
    # The first draw of its stream from the bounds of that room, which is a rectangle.
    x, y = random_stream(5, "starts", 0).uniform(room.bounds[:2], room.bounds[2:])
    assert start == pytest.approx((x, y, 0.0))
    assert starts(HALL, team(1), seed=6) != (start,)
    assert starts(HALL, team(1), seed=5, starts="clustered") == (start,)


def test_a_body_that_does_not_fit_at_its_start_is_refused():
    with pytest.raises(ClearanceError, match=r"clearance there is 0\.2 m.* more than 0\.25 m"):
        starts(HALL, [RobotSpec(start=(0.2, 4))])
    with pytest.raises(ClearanceError, match=r"needs 0\.2 to 0\.361 m, by its heading"):
        starts(HALL, [RobotSpec(start=(0.25, 4), footprint="box:0.6x0.4")])
    upright = RobotSpec(start=(0.25, 4, math.pi / 2), footprint="box:0.6x0.4")
    assert starts(HALL, [upright]) == (Configuration(0.25, 4, math.pi / 2),)
    with pytest.raises(ClearanceError, match="not in the free space"):
        starts(HALL, [RobotSpec(start=(-1, 4))])
    with pytest.raises(InvalidInputError, match="fits nowhere"):
        starts(HALL, team(1, footprint="disc:5", range_finder=FAR))


def test_a_start_inside_an_obstacle_is_refused():
    said = (
        r"\(4\.2, 3\).*'pillar'.*, 0\.2 m from free space; the nearest place where the body "
        r"disc:0\.25 fits is \(3\.74, 3\), 0\.46 m from there"
    )
    with pytest.raises(ClearanceError, match=said):
        start_of(RobotSpec(start=(4.2, 3.0)), PILLAR)


@settings(max_examples=60)
@given(
    x=st.floats(-3, 13),
    y=st.floats(-3, 9),
    body=st.sampled_from(["disc:0.25", "disc:1.37", "box:0.6x0.4", BODIES[3]]),
    turn=st.floats(0, 3),
)
def test_a_start_that_is_refused_has_a_place_near_by(x, y, body, turn):
    free = shapely.affinity.rotate(PILLAR.free, turn, use_radians=True)
    world, footprint = Environment("turned", free), Footprint.parse(body)
    place = nearest_room(world, footprint, x, y)
    assert place is not None
    assert start_of(RobotSpec(start=(*place, turn), footprint=body), world)[:2] == place
    radius = footprint.circumscribed_radius_m
    best = free.buffer(-radius, quad_segs=200).distance(shapely.Point(x, y))
    away = math.dist(place, (x, y))
    assert best - 0.01 <= away <= best + 0.05


def test_no_place_is_named_where_a_body_fits_nowhere():
    with pytest.raises(ClearanceError, match="disc:4 has room in every heading nowhere"):
        start_of(RobotSpec(start=(-1.0, 3.0), footprint="disc:4", range_finder=FAR), HALL)


def test_a_start_on_the_border_is_refused():
    with pytest.raises(ClearanceError, match=r"it is on its border; .* \(3\.74, 3\)"):
        start_of(RobotSpec(start=(4.0, 3.0)), PILLAR)


def test_a_start_outside_the_world_is_refused():
    with pytest.raises(ClearanceError, match=r"\(50, 3\)"):
        start_of(RobotSpec(start=(50.0, 3.0)), PILLAR)


def test_a_start_without_room_is_refused_with_its_clearance():
    with pytest.raises(ClearanceError, match=r"clearance there is 0\.1 m.*0\.25") as error:
        start_of(RobotSpec(start=(3.9, 3.0)), PILLAR)
    assert error.value.clearance_m == pytest.approx(0.1)


def test_a_start_at_exactly_the_radius_from_a_wall_is_refused():
    with pytest.raises(ClearanceError):
        start_of(RobotSpec(start=(0.25, 3.0)), HALL)
    assert start_of(RobotSpec(start=(0.2500001, 3.0)), HALL) == (0.2500001, 3.0, 0.0)


def test_whether_a_box_fits_depends_on_its_heading():
    corridor = Environment("corridor", shapely.box(0, 0, 10, 0.5))
    box = "box:0.6x0.4"
    assert start_of(RobotSpec(start=(5.0, 0.25), footprint=box), corridor) == (5.0, 0.25, 0.0)
    assert start_of(RobotSpec(start=(5.0, 0.25, math.pi), footprint=box), corridor)
    with pytest.raises(ClearanceError, match=r"0\.25 m.*0\.2 to 0\.361"):
        start_of(RobotSpec(start=(5.0, 0.25, math.pi / 2), footprint=box), corridor)


def test_a_body_that_fits_nowhere_is_refused():
    with pytest.raises(InvalidInputError, match=r"disc:4\.1 fits nowhere in 'hall'.*4\.1 m"):
        start_of(RobotSpec(footprint="disc:4.1", range_finder=FAR), HALL)


def test_a_body_that_fits_nowhere_is_told_that_walls_may_be_left_out():
    layers = Layers(
        layers=(Layer("0", "", 5), Layer("Columns", "obstacles", 1)),
        bounds_space=False,
        remedy="name layers walls to read them",
    )
    noname = Environment("noname", shapely.box(0, 0, 0.4, 0.4), layers=layers)
    said = (
        r"0\.25 m; no layer is read as walls or free space, and 0 \(5 shapes\) is left out: "
        "name layers walls to read them$"
    )
    with pytest.raises(InvalidInputError, match=said):
        start_of(RobotSpec(), noname)


def test_a_suggested_start_is_checked_like_a_given_one():
    suggested = Environment("hall", HALL.free, starts=[(3.0, 2.0), (1.0, 1.0)])
    assert start_of(RobotSpec(), suggested) == (3.0, 2.0, 0.0)
    with pytest.raises(ClearanceError):
        start_of(RobotSpec(footprint="disc:2.1"), suggested)


def test_a_random_start_depends_on_the_seed_and_has_room():
    starts = [start_of(RobotSpec(footprint="box:0.6x0.4"), PILLAR, seed) for seed in range(20)]
    assert starts == [
        start_of(RobotSpec(footprint="box:0.6x0.4"), PILLAR, seed) for seed in range(20)
    ]
    assert len(set(starts)) == 20
    assert all(PILLAR.clearance(x, y) > math.hypot(0.3, 0.2) for x, y, _ in starts)


def test_a_random_start_lies_in_the_largest_part():
    cells = Environment("cells", shapely.union(shapely.box(0, 0, 2, 2), shapely.box(3, 0, 9, 6)))
    assert all(start_of(RobotSpec(), cells, seed).x > 3.0 for seed in range(10))


@pytest.mark.parametrize("how", ["scattered", "clustered", "random"])
@pytest.mark.parametrize("robots", [1, 3])
def test_robots_start_inside_a_building_not_on_the_paper(how, robots):
    # 80 m2 of paper around a room of 49 m2.
    wall = shapely.box(1, 1, 9, 9) - shapely.box(1.5, 1.5, 8.5, 8.5)
    plan = Environment.from_outline("plan", shapely.box(0, 0, 12, 12), [wall])
    room = shapely.box(1.5, 1.5, 8.5, 8.5)
    for seed in range(3):
        placed = starts(plan, team(robots), starts=how, seed=seed)
        assert all(room.contains(shapely.Point(x, y)) for x, y, _ in placed)
    assert starts(plan, [RobotSpec(start=(10, 10))])[0][:2] == (10, 10)
    with pytest.raises(InvalidInputError, match=r"around which that of 80 m2 lies.* or its start"):
        starts(plan, team(robots, footprint="disc:3.6"), starts=how)


def test_a_page_that_may_be_a_hall_is_not_left_out():
    # The room has less than half of the area around it.
    wall = shapely.box(1, 1, 9, 9) - shapely.box(1.5, 1.5, 8.5, 8.5)
    page = Environment.from_outline("page", shapely.box(0, 0, 20, 20), [wall])
    placed = [start_of(RobotSpec(), page, seed) for seed in range(5)]
    assert all(page.component(x, y).area == 20 * 20 - 64 for x, y, _ in placed)


# Given starts of a team ---------------------------------------------------------------------


def test_starts_in_different_components_are_refused():
    robots = [RobotSpec(start=(1, 1)), RobotSpec(start=(9, 1)), RobotSpec(start=(22, 2))]
    assert len(starts(rooms(), robots[:2])) == 2
    with pytest.raises(InvalidInputError, match=r"robots 0 and 2 start .* no path"):
        starts(rooms(), robots)


def test_bodies_that_touch_are_refused():
    pair = [RobotSpec(start=(3, 3)), RobotSpec(start=(3.5, 3))]
    with pytest.raises(InvalidInputError, match=r"robots 0 and 1 .* 0\.5 m apart.* more than 0\.5"):
        starts(HALL, pair)
    assert starts(HALL, [pair[0], RobotSpec(start=(3.501, 3))])[1].x == 3.501
    # Two boxes of 0.6 m by 0.4 m, side by side and one behind the other.
    box: dict[str, Any] = {"footprint": "box:0.6x0.4"}
    beside = [RobotSpec(start=(3, 3), **box), RobotSpec(start=(3, 3.45), **box)]
    assert len(starts(HALL, beside)) == 2
    behind = [RobotSpec(start=(1, 1)), beside[0], RobotSpec(start=(3.45, 3), **box)]
    with pytest.raises(InvalidInputError, match=r"robots 1 and 2 .* need 0\.4 to 0\.721 m"):
        starts(HALL, behind)


# Teams without starts -----------------------------------------------------------------------


@pytest.mark.parametrize("how", ["scattered", "clustered", "random"])
def test_a_team_starts_around_given_robots_in_their_component(how):
    robots = [RobotSpec(), RobotSpec(start=(22, 2.5, 0.5)), RobotSpec(), RobotSpec()]
    found = starts(rooms(), robots, starts=how)
    assert found[1] == Configuration(22, 2.5, 0.5)
    assert all(20 < start.x < 25 for start in found)
    if how == "clustered":
        assert [start.heading for start in found] == [0.5] * 4
        assert all(found[k].distance(found[1]) == pytest.approx(0.75) for k in (0, 2, 3))


def test_a_team_takes_the_suggested_starts_at_which_it_has_room():
    # The second is too near the wall, the third too near the first, the fourth in another room.
    places = [(2.0, 2.5), (0.1, 2.5), (2.2, 2.5), (22.0, 2.5), (3.0, 2.5), (3.0, 4.0)]
    world = Environment("rooms", rooms().free, starts=places)
    found = starts(world, team(3), starts="suggested")
    assert [start[:2] for start in found] == [places[0], places[4], places[5]]
    beside = starts(world, [RobotSpec(start=(21, 2.5, 0.5)), RobotSpec()], starts="suggested")
    assert beside[1][:2] == places[3]
    with pytest.raises(InvalidInputError) as error:
        starts(world, team(4), starts="suggested")
    assert str(error.value) == (
        "'rooms' suggests 6 starts, with room for 3 of the 4 robots together: the body disc:0.25 "
        "does not fit at (0.1, 2.5), where the clearance is 0.1 m and it needs more than 0.25 m; "
        "(2.2, 2.5) is too near to another robot; (22, 2.5) is in another part of free space: "
        "choose smaller bodies or fewer robots, let the others stand around the first "
        "(--starts clustered), or place the others in another way (--start, --starts)"
    )
    few = [RobotSpec(start=(4, 1)), *team(4)]
    with pytest.raises(InvalidInputError, match="room for 3 of the 4 robots together"):
        starts(world, few, starts="suggested")
    with pytest.raises(InvalidInputError, match="'hall' suggests no starts: place robots in ano"):
        starts(HALL, team(1), starts="suggested")
    narrow = Environment("hall", HALL.free, starts=[(0.1, 4.0)])
    said = (
        "suggests 1 start, at which no robot has room: the body disc:0.25 does not fit at "
        r"\(0.1, 4\), where the clearance is 0.1 m and it needs more than 0.25 m: choose smaller "
        r"bodies, or place robots in another way \(--start, --starts\)$"
    )
    with pytest.raises(InvalidInputError, match=said):
        starts(narrow, team(1), starts="suggested")


def test_too_few_suggested_starts_are_told_with_the_starts_that_begin_there():
    world = Environment("hall", HALL.free, starts=[(3.0, 2.5)])
    said = (
        "suggests 1 start, with room for 1 of the 2 robots together: choose fewer robots, let the "
        r"others stand around the first \(--starts clustered\), or place the others"
    )
    with pytest.raises(InvalidInputError, match=said):
        starts(world, team(2), starts="suggested")
    assert starts(world, team(2), starts="clustered")[0] == (3.0, 2.5, 0.0)
    with pytest.raises(InvalidInputError, match="choose fewer robots, or place the others"):
        starts(world, [RobotSpec(start=(6, 2)), *team(2)], starts="suggested")


def test_of_many_unsuitable_starts_the_first_are_told():
    places = [(0.1, 1.0 + number) for number in range(5)]
    world = Environment("hall", HALL.free, starts=[(3.0, 2.5), *places])
    with pytest.raises(InvalidInputError, match=r"than 0\.25 m; and so for 2 more starts: choose"):
        starts(world, team(2), starts="suggested")


def test_a_cluster_is_as_dense_as_documented():
    # In the open: the middle, six around it, and twelve around these.
    world = Environment("hall", HALL.free, starts=[(6, 4)])
    found = starts(world, team(19), starts="clustered")
    away = np.sort([found[0].distance(start) for start in found])
    expected = [0] + [0.75] * 6 + [0.75 * math.sqrt(3)] * 6 + [1.5] * 6
    assert away == pytest.approx(expected, abs=1e-9)
    for a, b in combinations(found, 2):
        assert a.distance(b) > 0.75 - 1e-9
    assert found[0] == Configuration(6, 4, 0)


def test_a_cluster_goes_round_walls_not_through_them():
    # Behind the wall is nearer than the far end of the room, but not by any short path.
    world = Environment("rooms", rooms().free, starts=[(4.4, 0.6)])
    found = starts(world, team(30), starts="clustered")
    assert all(start.x < 5 for start in found)
    # Robots that do not fit into the first room are placed beyond the door in the second.
    many = starts(world, team(50), starts="clustered")
    behind = [start for start in many if start.x > 5]
    assert many[:30] == found
    assert len(behind) >= 5
    assert all(start.y > 1.5 for start in behind)


# At the base station --------------------------------------------------------------------------


def at_base(
    world: Environment, robots: Iterable[RobotSpec], x: float, y: float
) -> tuple[Configuration, ...]:
    return starts(world, robots, starts="base", base=BaseSpec(x=x, y=y))


def test_teams_stand_around_the_base_station():
    found = at_base(HALL, team(19), 6.0, 4.0)
    away = np.sort([math.dist(start[:2], (6.0, 4.0)) for start in found])
    expected = [0.0] + [0.75] * 6 + [0.75 * math.sqrt(3)] * 6 + [1.5] * 6
    assert away == pytest.approx(expected, abs=1e-9)
    assert len({start.heading for start in found}) == 1
    # A single robot stands there, and suggested starts do not matter.
    world = Environment("hall", HALL.free, starts=[(1, 1)])
    assert at_base(world, team(1), 6.0, 4.0)[0][:2] == (6.0, 4.0)
    # A closet has room for one.
    closet = Environment("closet", shapely.box(0, 0, 0.7, 0.7))
    assert at_base(closet, team(1), 0.35, 0.35)[0][:2] == (0.35, 0.35)


def test_at_a_wall_the_nearest_place_with_room_is_taken():
    (start,) = at_base(HALL, team(1), 6.0, 0.01)
    assert start[:2] == pytest.approx((6.0, 1.01 * 0.275))
    found = at_base(rooms(), team(5), 4.9, 0.6)
    assert all(start.x < 5 for start in found)


def test_the_nearest_place_behind_a_wall_is_not_taken():
    # The base station stands in a corridor that is too narrow for the body, beside a hall.
    narrow = shapely.union_all(
        [shapely.box(0, 0, 12, 0.5), shapely.box(0, 0.6, 10, 6), shapely.box(11, 0, 12, 6)]
    )
    world = Environment("corridor", narrow | shapely.box(10, 5, 11, 6))
    (start,) = at_base(world, team(1), 6.0, 0.25)
    assert start.x > 11
    with pytest.raises(InvalidInputError, match=r"no room in its sight, within 10 m: .* 0\.33 m"):
        at_base(world, team(1, footprint="disc:0.3"), 1.0, 0.25)


def test_given_starts_stay_and_the_others_stand_at_the_base():
    given = RobotSpec(start=(1.0, 7.0), footprint="disc:0.6")
    found = at_base(HALL, [given, *team(2)], 6.0, 4.0)
    assert found[0] == Configuration(1.0, 7.0, 0.0)
    assert [math.dist(start[:2], (6.0, 4.0)) for start in found[1:]] == pytest.approx([0.0, 0.75])
    # A robot that stands where the base station is keeps its place, too.
    found = at_base(HALL, [RobotSpec(start=(6.0, 4.0)), *team(2)], 6.0, 4.0)
    assert all(found[0].distance(start) == pytest.approx(0.75) for start in found[1:])


def test_starts_at_the_base_station_are_refused_for_a_reason():
    with pytest.raises(InvalidInputError, match="starts='base' needs a base station"):
        starts(HALL, team(2), starts="base")
    with pytest.raises(ClearanceError, match=r"the base station .* is not in the free space"):
        at_base(HALL, team(2), 12.5, 4.0)
    with pytest.raises(InvalidInputError, match="largest body that starts at the base station"):
        at_base(HALL, team(2, footprint="disc:5", range_finder=FAR), 6.0, 4.0)
    with pytest.raises(InvalidInputError, match="which no path through free space connects"):
        at_base(rooms(), [RobotSpec(start=(22.0, 2.0)), *team(1)], 2.0, 2.0)


def test_scattered_robots_spread_out():
    found = starts(HALL, team(4), seed=1)
    nearest = min(a.distance(b) for a, b in combinations(found, 2))
    assert nearest > 4.0  # in a hall of 12 m by 8 m
    assert len({start.heading for start in found}) == 4


def test_random_robots_start_uniformly_where_they_have_room():
    # The first robot takes a corner of a narrow hall of 9.45 m where bodies fit: the others start
    # in either half alike, beyond 0.75 m.
    hall = Environment("hall", shapely.box(0, 0, 10, 0.6))
    first = RobotSpec(start=(0.275, 0.3))
    xs = np.array(
        [starts(hall, [first, RobotSpec()], starts="random", seed=k)[1].x for k in range(400)]
    )
    low, high = 0.275 + 0.75, 9.725
    assert low <= xs.min() < 1.1
    assert 9.6 < xs.max() <= high
    # Uniform to within 4 standard errors of the mean.
    assert abs(xs.mean() - 0.5 * (low + high)) < 4.0 * (high - low) / math.sqrt(12.0 * 400)
    # One that is scattered is far away.
    assert starts(hall, [first, RobotSpec()], starts="scattered", seed=1)[1].x > 8.0


@pytest.mark.parametrize(("how", "least"), [("scattered", 10), ("clustered", 14), ("random", 10)])
def test_a_team_that_does_not_fit_is_refused(how, least):
    # Lattices of 0.75 m hold about 20 robots here.
    tight = Environment("cell", shapely.box(0, 0, 3.4, 3.4))
    with pytest.raises(InvalidInputError, match=r"of the 40 robots, \d+ fit .* fewer") as refused:
        starts(tight, team(40), starts=how)
    fitting = int(str(refused.value).split("robots, ")[1].split()[0])
    assert least <= fitting <= 25
    assert len(starts(tight, team(fitting), starts=how)) == fitting


def test_scattered_robots_find_the_last_free_corner():
    # The given robots leave room for one more in the hall, which random draws seldom find.
    tight = Environment("cell", shapely.box(0, 0, 12, 12))
    given_robots = [
        RobotSpec(start=(0.6 + 1.15 * i, 0.6 + 1.15 * j), footprint="disc:0.5")
        for i in range(10)
        for j in range(10)
        if (i, j) != (7, 3)
    ]
    found = starts(tight, [*given_robots, RobotSpec(footprint="disc:0.25")])
    assert found[-1].distance(Configuration(0.6 + 1.15 * 7, 0.6 + 1.15 * 3)) < 0.3


@pytest.mark.parametrize("how", ["scattered", "clustered", "random"])
def test_the_same_seed_gives_the_same_starts(how):
    world = environment("office")
    found = starts(world, team(10), starts=how, seed=3)
    assert starts(world, team(10), starts=how, seed=3) == found
    if how != "clustered":
        assert starts(world, team(10), starts=how, seed=4) != found
        # Robots with higher numbers change nothing for those before.
        assert starts(world, team(12), starts=how, seed=3)[:10] == found


@pytest.mark.slow
@settings(max_examples=25)
@given(
    st.integers(0, 10**6),
    st.lists(st.sampled_from(BODIES), min_size=2, max_size=7),
    st.sampled_from(["office", "rooms", "cave"]),
)
def test_teams_fit_and_keep_apart(seed, bodies, name):
    world = environment(name)
    robots = [RobotSpec(footprint=body) for body in bodies]
    spread = {}
    for how in ("scattered", "clustered", "random"):
        found = starts(world, robots, starts=how, seed=seed)
        shapes = [shape(robot, start) for robot, start in zip(robots, found, strict=True)]
        assert all(shapely.contains_properly(world.free, body) for body in shapes)
        component = world.component(*found[0][:2])
        assert all(component.contains(shapely.Point(start[:2])) for start in found)
        for a, b in combinations(range(len(robots)), 2):
            assert shapes[a].distance(shapes[b]) > 0.24
        spread[how] = min(a.distance(b) for a, b in combinations(found, 2))
    assert spread["scattered"] > spread["clustered"]


# Cars ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["reeds-shepp", "dubins"])
def test_a_car_needs_room_to_turn(kind):
    # In a corridor of 3 m, where a body of 0.4 m width needs 0.2 m at the side.
    corridor = Environment("corridor", shapely.box(0, 0, 30, 3))
    robot: dict[str, Any] = {"start": (2, 1.5), "footprint": "box:0.6x0.4"}

    def drive(radius):
        return DriveSpec(kind=kind, turning_radius_m=radius)

    assert len(starts(corridor, [RobotSpec(drive=drive(1.29), **robot)])) == 1
    with pytest.raises(InvalidInputError, match=r"robot 1 .* radius of 1\.4 m.* about 1\.30 m"):
        starts(
            corridor,
            [
                RobotSpec(start=(8, 1.5)),
                RobotSpec(drive=drive(1.4), **robot),
            ],
        )


def test_only_the_component_of_a_car_counts():
    world = Environment("two", shapely.box(0, 0, 3, 3) | shapely.box(10, 0, 30, 20))
    car = DriveSpec(kind="dubins", turning_radius_m=2.0)
    assert len(starts(world, [RobotSpec(start=(20, 10), drive=car)])) == 1
    with pytest.raises(InvalidInputError, match="turning circle fits nowhere"):
        starts(world, [RobotSpec(start=(1.5, 1.5), drive=car)])
