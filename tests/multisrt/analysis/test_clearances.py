"""Clearances to walls and distances between robots, by hand and by dense sampling."""

import cmath
import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.analysis import clearances
from multisrt.analysis.clearances import smallest_clearance, smallest_distance_between_robots
from multisrt.analysis.measuring import measure
from multisrt.environments.environment import Environment
from multisrt.events import Motion
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.recording import Recording

HALF = math.pi / 2.0

Pose = tuple[float, float, float]


@pytest.mark.parametrize(
    ("footprint", "start", "motions", "clearance"),
    [
        # A disc stands, drives along a wall and comes near to another at the end.
        ("disc:0.25", (1.0, 2.0), [], 0.75),
        ("disc:0.25", (3.0, 1.0), [((0, 3.0, 1.0, 0), (9, 6.0, 1.0, 0))], 0.75),
        ("disc:0.25", (3.0, 1.0), [((0, 3.0, 1.0, 0), (9, 9.5, 1.0, 0))], 0.25),
        # A box of 0.6 x 0.4 m along the wall and across it.
        ("box:0.6x0.4", (3.0, 0.5), [((0, 3.0, 0.5, 0), (9, 6.0, 0.5, 0))], 0.3),
        ("box:0.6x0.4", (3.0, 5.0), [((0, 3.0, 5.0, 0), (9, 9.0, 5.0, 0))], 0.7),
        # Turning, its corners come to hypot(0.3, 0.2) = 0.3606 m of the centre.
        (
            "box:0.6x0.4",
            (3.0, 0.5),
            [((0, 3.0, 0.5, 0), (1, 3.0, 0.5, math.pi))],
            0.5 - math.hypot(0.3, 0.2),
        ),
        # A half circle of 2 m about (5, 3), from its left end over its lowest point.
        ("disc:0.25", (3.0, 3.0), [((0, 3.0, 3.0, -HALF), (9, 7.0, 3.0, HALF))], 0.75),
        # A quarter of it: the hind corner swings out, 2.2 and 0.3 m from the circle's centre.
        (
            "box:0.6x0.4",
            (3.0, 3.0),
            [((0, 3.0, 3.0, -HALF), (9, 5.0, 1.0, 0.0))],
            1.0 - (math.hypot(2.2, 0.3) - 2.0),
        ),
        # Driven backwards and clockwise, with the corners of the box outermost.
        (
            "box:0.6x0.4",
            (3.0, 3.0),
            [((0, 3.0, 3.0, HALF), (9, 7.0, 3.0, 3 * HALF))],
            1.0 - (math.hypot(2.2, 0.3) - 2.0),
        ),
        # Not convex: an L whose long arm points out of the circle.
        (
            "polygon:-0.1,-0.1 0.1,-0.1 0.1,0.1 0.6,0.1 0.6,0.2 -0.1,0.2",
            (3.0, 3.0),
            [((0, 3.0, 3.0, math.pi), (9, 7.0, 3.0, 2 * math.pi))],
            1.0 - (math.hypot(2.6, 0.2) - 2.0),
        ),
    ],
)
def test_smallest_clearance(recorded, hall, moved, footprint, start, motions, clearance):
    recording = recorded(
        *(moved(*w) for w in motions), footprints=[footprint], starts=[(*start, 0.0)]
    )
    assert smallest_clearance(recording, hall) == pytest.approx(clearance, abs=1e-9)
    assert measure(recording, hall).min_clearance_m == pytest.approx(clearance, abs=1e-9)


def test_the_clearance_of_a_body_that_touched(recorded, hall, moved):
    into = moved((0, 1.0, 1.0, 0.0), (2, 1.0, 0.1, 0.0))
    assert smallest_clearance(recorded(into), hall) == pytest.approx(0.1 - 0.25)


def test_the_least_clearance_of_any_robot_counts(recorded, hall, moved):
    # The large one keeps off by 0.4 m, the box by 0.3 m, and the small one by 0.2 m.
    starts = [(1.9, 5.0, 0.0), (5.0, 0.5, 0.0), (9.0, 5.0, 0.0)]
    bodies = ["disc:1.5", "box:0.6x0.4", "disc:0.1"]

    def clearance(*motions: Motion) -> float:
        return smallest_clearance(recorded(*motions, starts=starts, footprints=bodies), hall)

    there = moved((0, 9.0, 5.0, 0.0), (2, 9.7, 5.0, 0.0), robot=2)
    assert clearance(there) == pytest.approx(0.2)
    assert clearance() == pytest.approx(0.3)
    # A body 1 m inside a wall counts more than one that touches it.
    into = moved((0, 1.9, 5.0, 0.0), (2, 0.5, 5.0, 0.0), robot=0)
    touching = moved((0, 9.0, 5.0, 0.0), (2, 10.0, 5.0, 0.0), robot=2)
    assert clearance(into, touching) == pytest.approx(-1.0)


@pytest.fixture(scope="module")
def approach(recorded) -> Callable[..., float]:
    """Measure the smallest distance between robots in a recording of their motions."""

    def measured(*motions: Motion, **more: Any) -> float:
        distance = smallest_distance_between_robots(recorded(*motions, **more))
        assert distance is not None
        return distance

    return measured


def test_the_distance_of_robots_that_stand(approach):
    starts = [(1.0, 1.0, 0.0), (4.0, 5.0, 0.0), (9.0, 9.0, 0.0)]
    assert approach(starts=starts) == pytest.approx(4.5)
    assert approach(starts=starts, end_s=0.0) == pytest.approx(4.5)


def test_the_distance_of_robots_that_pass_each_other(moved, approach):
    # Nearest at 4 s, between all waypoints: 1 m apart.
    there = moved((0, 1, 1, 0), (8, 9, 1, 0))
    back = moved((0, 9, 2, 0), (8, 1, 2, 0), robot=1)
    starts = [(1.0, 1.0, 0.0), (9.0, 2.0, 0.0)]
    assert approach(there, back, starts=starts) == pytest.approx(0.5, abs=1e-12)
    boxes = ["box:0.6x0.4", "box:0.6x0.4"]
    assert approach(there, back, starts=starts, footprints=boxes) == pytest.approx(0.6, abs=1e-6)


def test_paths_crossed_at_different_times_do_not_count(moved, approach):
    # Both come through (5, 5); the second when the first has stood at (9, 5) for a while.
    one = moved((0, 1, 5, 0), (8, 9, 5, 0))
    two = moved((20, 5, 1, 0), (28, 5, 9, 0), robot=1)
    starts = [(1.0, 5.0, 0.0), (5.0, 1.0, 0.0)]
    assert approach(one, two, starts=starts) == pytest.approx(4.0 - 0.5)
    # Before that, when the first came by the waiting second, they were 4 m apart as well.
    early = moved((4, 5, 1, 0), (12, 5, 9, 0), robot=1)
    assert approach(one, early, starts=starts) == pytest.approx(math.sqrt(8.0) - 0.5)


def test_bodies_that_touch_have_no_distance(moved, approach):
    into = moved((0, 1, 1, 0), (4, 5, 1, 0))
    assert approach(into, starts=[(1.0, 1.0, 0.0), (5.0, 1.0, 0.0)]) == 0.0


def test_the_distance_of_a_turning_box_and_on_an_arc(moved, approach):
    # Its corner points at the disc after 45 degrees or so, for a moment.
    turn = moved((0, 5, 5, 0), (4, 5, 5, math.pi))
    starts = [(5.0, 5.0, 0.0), (5.0, 6.0, 0.0)]
    corner = math.hypot(0.3, 0.2)
    bodies = ["box:0.6x0.4", "disc:0.25"]
    assert approach(turn, starts=starts, footprints=bodies) == pytest.approx(
        0.75 - corner, abs=2e-6
    )
    # The lowest point of the half circle is (5, 1); a disc stands 0.7 m below it.
    starts = [(3.0, 3.0, -HALF), (5.0, 0.3, 0.0)]
    arc = moved((0.0, 3.0, 3.0, -HALF), (9.0, 7.0, 3.0, HALF))
    assert approach(arc, starts=starts) == pytest.approx(0.2, abs=2e-6)


@st.composite
def stories(draw: st.DrawFn) -> tuple[list[Motion], list[Pose], list[str]]:
    """Motions, starts and bodies of two robots that drive, turn and follow arcs at random."""
    bodies = draw(
        st.lists(
            st.sampled_from(["disc:0.25", "box:0.6x0.4", "polygon:-0.2,-0.1 0.3,0 -0.2,0.1"]),
            min_size=2,
            max_size=2,
        )
    )
    places = st.floats(1.0, 9.0)
    motions: list[Motion] = []
    starts: list[Pose] = []
    for robot in range(2):
        time, x, y = draw(st.floats(0.0, 3.0)), draw(places), draw(places)
        heading = draw(st.floats(-3.0, 3.0))
        starts.append((x, y, heading))
        for _ in range(draw(st.integers(0, 3))):
            waypoints = [(time, x, y, heading)]
            for kind in draw(st.lists(st.sampled_from(["drive", "turn", "arc"]), max_size=3)):
                time += draw(st.floats(0.5, 6.0))
                if kind != "turn":
                    x, y = draw(places), draw(places)
                if kind != "drive":
                    heading += draw(st.floats(-3.0, 3.0))
                waypoints.append((time, x, y, heading))
            motions.append(Motion(time_s=waypoints[0][0], robot=robot, waypoints=tuple(waypoints)))
            time += draw(st.floats(0.0, 3.0))
    return motions, starts, bodies


def motions_in(recording: Recording) -> list[Motion]:
    return [event for event in recording.events if isinstance(event, Motion)]


def by_dense_sampling(recording: Recording, steps: int) -> float:
    """The distance at many moments, each leg followed by turning its velocity step by step."""
    times = np.linspace(0.0, recording.footer.time_s, steps)
    outlines = []
    for robot, spec in enumerate(recording.spec.robots):
        poses = np.tile(recording.header.starts[robot], (steps, 1))
        for motion in motions_in(recording):
            if motion.robot != robot:
                continue
            for a, b in itertools.pairwise(motion.waypoints):
                within = times >= a[0]
                share = np.clip((times[within] - a[0]) / (b[0] - a[0]), 0.0, 1.0)
                poses[within] = [on_leg(np.array(a[1:]), np.array(b[1:]), s) for s in share]
        body = Footprint.parse(spec.footprint)
        outlines.append([body.placed(pose) for pose in poses])
    return float(shapely.distance(*map(np.array, outlines)).min())


def on_leg(a: np.ndarray, b: np.ndarray, share: float) -> np.ndarray:
    """By the centre of rotation, which the method does not use."""
    turn = b[2] - a[2]
    if abs(turn) < 1e-6 or (a[:2] == b[:2]).all():
        return a + share * (b - a)
    start, end = complex(*a[:2]), complex(*b[:2])
    rotation = cmath.exp(1j * turn)
    centre = (end - rotation * start) / (1.0 - rotation)
    here = centre + cmath.exp(1j * turn * share) * (start - centre)
    return np.array([here.real, here.imag, a[2] + share * turn])


@pytest.mark.slow
@given(stories())
@settings(max_examples=25)
def test_the_smallest_distance_is_that_of_dense_sampling(recorded, story):
    motions, starts, bodies = story
    recording = recorded(*motions, starts=starts, footprints=bodies, end_s=70.0)
    found = smallest_distance_between_robots(recording)
    assert found is not None
    sampled = by_dense_sampling(recording, 1500)
    # Between two samples bodies come nearer by no more than their speeds allow.
    fastest = 2.0 * (fastest_point(recording)) * 70.0 / 1500
    # Discs are placed as polygons, whose sides lie up to 0.2 mm inside.
    rounding = 4e-4 if any(body.startswith("disc") for body in bodies) else 2e-6
    assert sampled - fastest - rounding <= found <= sampled + rounding


def fastest_point(recording: Recording) -> float:
    speeds = [0.0]
    for motion in motions_in(recording):
        for a, b in itertools.pairwise(motion.waypoints):
            turn = abs(b[3] - a[3])
            chord = math.dist(a[1:3], b[1:3])
            arc = chord if turn < 1e-6 else chord * turn / 2.0 / math.sin(turn / 2.0)
            speeds.append((arc + 0.4 * turn) / (b[0] - a[0]))
    return max(speeds)


@pytest.mark.parametrize("wall_y", [0.36, 0.3634])
def test_a_corner_that_passes_a_wall_between_two_degrees(recorded, moved, wall_y):
    # A box turns in place; its corner is lowest after 90 - atan(2 / 3) = 56.31 degrees, which no
    # step of whole degrees meets. Its diagonal is 0.36056 m.
    start = (5.0, wall_y, 0.0)
    turn = moved((0, *start), (1, 5.0, wall_y, 2.0))
    room = Environment("room", shapely.box(0, 0, 10, 10))
    recording = recorded(turn, footprints=["box:0.6x0.4"], starts=[start])
    expected = wall_y - math.hypot(0.3, 0.2)
    assert smallest_clearance(recording, room) == pytest.approx(max(0.0, expected), abs=1e-9)


def test_a_corner_of_a_wall_beside_a_box_that_turns(recorded, moved):
    # The corner (5, 1) of a pillar is 0.8 m below the centre of rotation, and the long side of
    # the box 0.3 m beside it: 0.8 cos(a) - 0.3 apart at the angle a.
    pillar = shapely.Polygon([(4.5, 0.5), (5.5, 0.5), (5.0, 1.0)])
    room = Environment("room", shapely.box(0, 0, 10, 10) - pillar)
    start = (5.0, 1.8, -0.1)
    turn = moved((0, *start), (1, 5.0, 1.8, 0.2))
    recording = recorded(turn, footprints=["box:1.4x0.6"], starts=[start])
    expected = 0.8 * math.cos(0.2) - 0.3
    assert smallest_clearance(recording, room) == pytest.approx(expected, abs=1e-9)


@pytest.mark.slow
@given(
    st.sampled_from(["disc:0.25", "box:0.6x0.4", "polygon:-0.2,-0.1 0.3,0 -0.2,0.1 -0.1,0"]),
    st.tuples(st.floats(2.0, 8.0), st.floats(2.0, 8.0), st.floats(-3.0, 3.0)),
    st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-3.1, 3.1)),
    st.lists(st.tuples(st.floats(1, 9), st.floats(1, 9), st.floats(0, 6)), max_size=5),
)
@settings(max_examples=60, deadline=None)
def test_the_clearance_is_that_of_dense_sampling(recorded, body, start, step, pillars):
    swept = shapely.LineString([start[:2], np.add(start, step)[:2]]).buffer(1.5)
    solid = [shapely.Point(x, y).buffer(0.3, 1) for x, y, _ in pillars]
    hall = Environment.from_outline(
        "hall", shapely.box(0, 0, 10, 10), [one for one in solid if not one.intersects(swept)]
    )
    end = tuple(np.add(start, step).tolist())
    motion = Motion(time_s=0.0, robot=0, waypoints=((0.0, *start), (1.0, *end)))
    recording = recorded(motion, footprints=[body], starts=[start])
    found = smallest_clearance(recording, hall)
    footprint, walls = Footprint.parse(body), hall.free.boundary
    samples = 400
    poses = [on_leg(np.array(start), np.array(end), s) for s in np.linspace(0, 1, samples)]
    if footprint.is_disc:
        sampled = min(walls.distance(shapely.Point(*pose[:2])) for pose in poses) - 0.25
    else:
        sampled = min(walls.distance(footprint.placed(pose.tolist())) for pose in poses)
    # Half a step between two samples, by the fastest point of the body.
    chord, turn = math.hypot(*step[:2]), abs(step[2])
    share = np.sinc(turn / (2.0 * math.pi))
    fastest = (chord / share + 0.4 * turn) / (samples - 1) / 2.0
    assert sampled - fastest - 1e-9 <= found <= sampled + 1e-9


def test_robots_at_rest_to_one_another_take_one_step(recorded, monkeypatch):
    # Two boxes circle (5, 5) by a right angle, opposite to each other, as one rigid body.
    motions = [
        Motion(time_s=0.0, robot=0, waypoints=((0.0, 7.0, 5.0, 0.0), (9.0, 5.0, 7.0, HALF))),
        Motion(time_s=0.0, robot=1, waypoints=((0.0, 3.0, 5.0, 0.0), (9.0, 5.0, 3.0, HALF))),
    ]
    recording = recorded(
        *motions,
        starts=[(7.0, 5.0, 0.0), (3.0, 5.0, 0.0)],
        footprints=["box:0.6x0.4", "box:0.6x0.4"],
        end_s=9.0,
    )
    asked = []
    measured = clearances._Pair.distances

    def counted(pair: Any, one: np.ndarray, two: np.ndarray) -> np.ndarray:
        asked.append(len(one))
        return measured(pair, one, two)

    monkeypatch.setattr(clearances._Pair, "distances", counted)
    assert smallest_distance_between_robots(recording) == pytest.approx(3.4, abs=1e-9)
    assert sum(asked) < 10
