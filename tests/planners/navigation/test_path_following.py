import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely.ops import substring

from multisrt.environments.catalog import environment
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.regions.edge_index import EdgeIndex
from multisrt.geometry.regions.safe_region import local_safe_region
from multisrt.geometry.regions.scan import take_scan
from multisrt.planners.motion.body import PlanningBody
from multisrt.planners.motion.kinematics import Car, Differential, Holonomic, Kinematics
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory
from multisrt.planners.navigation.path_following import MIN_MOTION_M, ahead, follow

DISC = PlanningBody(Footprint.disc(0.25), 0.02)
BOX = PlanningBody(Footprint.box(0.6, 0.4), 0.02)
DRIVE = Differential(speed_m_s=0.5, turn_rate_rad_s=1.0)


# An L: 4 m to the right, then 4 m up, 1 m wide.
ELL = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (3.0, 4.0), (3.0, 1.0), (0.0, 1.0)])
ROUND_THE_CORNER = np.array([[0.5, 0.5], [2.0, 0.5], [3.5, 0.5], [3.5, 6.0]])


def followed(
    body: PlanningBody,
    kinematics: Kinematics,
    at: Configuration,
    path: np.ndarray,
    limit_m: float = math.inf,
    *,
    saves_turns: bool = False,
) -> Trajectory:
    """Return the motion of a body along a path in the L that it can follow."""
    motion = follow(body, kinematics, ELL, at, path, limit_m=limit_m, saves_turns=saves_turns)
    assert motion is not None
    return motion


def test_a_way_back_is_driven_backwards_to_save_turns():
    at = Configuration(3.5, 0.5, 0.0)
    back = np.array([[3.5, 0.5], [0.5, 0.5]])
    turned = followed(DISC, DRIVE, at, back)
    reversed_ = followed(DISC, DRIVE, at, back, saves_turns=True)
    assert turned.end == pytest.approx((0.5, 0.5, math.pi))
    assert reversed_.end == pytest.approx((0.5, 0.5, 0.0))
    saved_s = turned.duration_s - reversed_.duration_s
    assert saved_s == pytest.approx(math.pi / DRIVE.turn_rate_rad_s)


PATH = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]])


@pytest.mark.parametrize(
    ("at", "left"),
    [
        ((0.0, 0.0), [(0, 0), (4, 0), (4, 3)]),
        ((-1.0, 0.5), [(0, 0), (4, 0), (4, 3)]),
        ((1.5, 0.2), [(1.5, 0), (4, 0), (4, 3)]),
        ((4.0, 0.0), [(4, 0), (4, 3)]),
        ((3.5, 1.0), [(4, 1), (4, 3)]),
        # Equally near to both legs: the later one counts.
        ((3.0, 1.0), [(4, 1), (4, 3)]),
        ((5.0, 9.0), [(4, 3)]),
    ],
)
def test_rest_of_a_path_begins_beside_the_robot(at, left):
    assert ahead(PATH, Configuration(*at)).tolist() == [list(map(float, place)) for place in left]


def test_rest_of_a_path_has_no_repeated_corners():
    twice = np.repeat(PATH, 2, axis=0)
    assert ahead(twice, Configuration(1.0, 0.0)).tolist() == [[1, 0], [4, 0], [4, 3]]
    assert ahead(np.zeros((3, 2)), Configuration(1.0, 0.0)).tolist() == [[0, 0]]


places = st.tuples(*2 * (st.floats(-5, 5).map(lambda v: round(v, 6)),))


@given(st.lists(places, min_size=2, max_size=8), places)
def test_rest_of_a_path_begins_at_the_nearest_point(path, at):
    left = ahead(np.array(path), Configuration(*at))
    nearest = shapely.LineString(path).distance(shapely.Point(at))
    assert math.dist(left[0], at) == pytest.approx(nearest, abs=1e-8)
    assert left[-1] == pytest.approx(path[-1], abs=1e-8)
    assert shapely.LineString(path).distance(shapely.Point(left[0])) < 1e-8


def test_the_last_leg_is_shortened_to_fit():
    motion = followed(DISC, DRIVE, Configuration(0.5, 0.5, 0.0), ROUND_THE_CORNER)
    # The wall is at y = 4; radius and margin are 0.27 m.
    assert motion.end == pytest.approx((3.5, 3.73, math.pi / 2))
    assert motion.length_m == pytest.approx(3.0 + 3.23)
    assert motion.duration_s == pytest.approx(6.23 / 0.5 + math.pi / 2)


def test_a_holonomic_body_keeps_its_heading():
    motion = followed(BOX, Holonomic(), Configuration(0.5, 0.5, 0.0), ROUND_THE_CORNER)
    assert motion.end == pytest.approx((3.5, 3.78, 0.0))


def test_a_path_that_fits_is_driven_to_its_end():
    motion = followed(DISC, DRIVE, Configuration(0.5, 0.5, 0.0), ROUND_THE_CORNER[:3])
    assert motion.end[:2] == (3.5, 0.5)
    # Also if hardly any of the path remains.
    motion = followed(DISC, DRIVE, Configuration(3.495, 0.5, 0.0), ROUND_THE_CORNER[2:3])
    assert motion.end[:2] == (3.5, 0.5)


def test_limit_bounds_the_length_of_the_motion():
    at = Configuration(0.5, 0.5, 0.0)
    motion = followed(DISC, DRIVE, at, ROUND_THE_CORNER, limit_m=3.6)
    assert motion.end == pytest.approx((3.5, 1.1, math.pi / 2))
    motion = followed(DISC, DRIVE, at, ROUND_THE_CORNER, limit_m=1.0)
    assert motion.end == pytest.approx((1.5, 0.5, 0.0))


@pytest.mark.parametrize("until_s", [0.3, 2.0, 3.0, 6.5, 9.0, 60.0])
@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_a_motion_up_to_a_time_begins_as_the_whole_one(until_s, heading):
    at = Configuration(0.5, 0.5, heading)
    whole = followed(DISC, DRIVE, at, ROUND_THE_CORNER)
    part = follow(DISC, DRIVE, ELL, at, ROUND_THE_CORNER, until_s=until_s)
    assert part is not None
    assert part.until(until_s) == whole.until(until_s)
    assert part.waypoints == whole.waypoints[: len(part.waypoints)]
    # Its last leg is a turn and a drive.
    assert (part == whole) == (until_s > whole.waypoints[-3].time_s)


def test_a_robot_beside_its_path_goes_to_the_next_corner():
    at = Configuration(0.5, 0.6, 0.0)
    motion = followed(DISC, Holonomic(), at, ROUND_THE_CORNER)
    assert motion.waypoints[1][1:3] == (2.0, 0.5)
    # Not if that would cut the corner: here the robot is in the L's arm, its path below.
    motion = followed(DISC, Holonomic(), Configuration(3.5, 1.5, 0.0), ROUND_THE_CORNER[[2, 1]])
    assert motion.waypoints[1][1:3] == (3.5, 0.5)
    assert motion.end[:2] == (2.0, 0.5)


def test_motions_that_are_too_short_are_none():
    end = Configuration(3.5, 3.73, math.pi / 2)
    up = np.array([[3.5, 3.73], [3.5, 6.0]])
    assert follow(DISC, DRIVE, ELL, end, up) is None
    assert follow(DISC, DRIVE, ELL, Configuration(3.5, 3.725, 1.0), up) is None
    assert follow(DISC, DRIVE, ELL, Configuration(3.5, 3.7, 1.0), up) is not None
    assert follow(DISC, DRIVE, ELL, end, up[:1]) is None


def test_cars_are_rejected():
    with pytest.raises(InvalidInputError, match="car_trajectory"):
        follow(DISC, Car(), ELL, Configuration(0.5, 0.5), ROUND_THE_CORNER)


@pytest.mark.parametrize("path", [np.empty((0, 2)), np.zeros(4), np.array([[0.0, math.nan]])])
def test_invalid_paths_are_rejected(path):
    with pytest.raises(InvalidInputError, match="path"):
        ahead(path, Configuration(0.0, 0.0))


WORLDS = ("office", "clutter", "garden", "maze")
RANGE_M = 4.0


@cache
def scenes(name: str) -> list[tuple[np.ndarray, tuple[float, float]]]:
    """Regions in a world, and the places of their scans, at which the body fits."""
    world = environment(name, seed=1)
    index = EdgeIndex(world.edges, RANGE_M / 3.0)
    room = world.free.buffer(-0.4)
    shapely.prepare(room)
    rng = np.random.default_rng(5)
    x0, y0, x1, y1 = world.bounds
    spots = rng.uniform((x0, y0), (x1, y1), (4000, 2))
    found = []
    for x, y in spots[shapely.contains_xy(room, spots)][:12].tolist():
        scan = take_scan(index, Configuration(x, y), 0.0, RANGE_M)
        for shape in ("radial", "star"):
            found.append((local_safe_region(scan, shape).boundary, (x, y)))
    return found


offsets = st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), min_size=1, max_size=5)


@given(
    st.sampled_from(WORLDS),
    st.integers(0, 23),
    st.sampled_from([DISC, BOX]),
    st.sampled_from([DRIVE, Holonomic()]),
    st.floats(-3.14, 3.14),
    offsets,
    st.one_of(st.just(math.inf), st.floats(0.2, 4.0)),
)
def test_motions_follow_the_path_inside_the_region(
    name, number, body, kinematics, heading, steps, limit
):
    boundary, spot = scenes(name)[number]
    x, y = spot
    at = Configuration(x, y, heading)
    path = np.vstack([[spot], np.array(spot) + np.cumsum(steps, axis=0)])
    motion = follow(body, kinematics, boundary, at, path, limit_m=limit)
    region = shapely.Polygon(boundary)
    line = shapely.LineString(path)
    length = 0.0
    if motion is not None:
        length = motion.length_m
        assert motion.start == pytest.approx(at)
        assert length >= MIN_MOTION_M or motion.end[:2] == pytest.approx(path[-1])
        assert length <= limit + 1e-9
        assert all(a.time_s <= b.time_s for a, b in pairwise(motion.waypoints))
        # The motion follows the path; a first corner close by may be cut.
        along = shapely.LineString(motion.points())
        assert along.hausdorff_distance(substring(line, 0.0, length)) < 2 * MIN_MOTION_M
        sweep = Sweep(body.footprint, motion)
        assert sweep.shape.buffer(sweep.pad_m - 0.004).within(region)
        if body.is_disc:
            assert sweep.shape.distance(region.exterior) >= body.outer_radius_m
    # For a disc the motion is the longest possible: there is no room a little farther on.
    if body.is_disc and line.length - length > MIN_MOTION_M and limit - length > MIN_MOTION_M:
        beyond = line.interpolate(length + 2.5 * MIN_MOTION_M)
        room = min(
            line.interpolate(length + share * MIN_MOTION_M).distance(region.exterior)
            for share in (0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 2.5)
        )
        assert room < body.ample_radius_m or not region.contains(beyond)


def test_a_robot_beside_its_path_that_saves_turns_joins_it_ahead():
    # In a hall whose far end is not known yet: the second corner is out of sight.
    hall = np.array([(0.0, 0.0), (6.0, 0.0), (6.0, 3.0), (0.0, 3.0)])
    at, path = Configuration(1.0, 1.0, 0.0), np.array([[1.0, 1.6], [9.0, 1.6]])
    motions = {
        saves: follow(DISC, DRIVE, hall, at, path, saves_turns=saves) for saves in (False, True)
    }
    first = {saves: motion.waypoints[1:] for saves, motion in motions.items() if motion is not None}
    # To the foot it is a quarter turn and 0.6 m; it is 3 m ahead otherwise.
    assert max(waypoint.x for waypoint in first[False][:2]) == pytest.approx(1.0)
    assert first[True][-1].x == pytest.approx(first[False][-1].x, abs=0.1)
    plain, saving = motions[False], motions[True]
    assert plain is not None
    assert saving is not None
    assert saving.duration_s < plain.duration_s - 2.0
    assert min(waypoint.x for waypoint in first[True]) > 1.0
