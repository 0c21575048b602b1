"""Collision of two bodies, against shapely, sampling and answers by hand."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from multisrt.geometry.bodies.collision_body import Body
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.geometry.bodies.meetings import bodies_collide, body_distance, first_meeting
from multisrt.geometry.bodies.motion import Motion
from multisrt.geometry.errors import InvalidInputError

PAIRS = [("disc", "disc"), ("disc", "bend"), ("box", "disc"), ("box", "wedge"), ("ell", "bend")]
MILLIMETRE = 1e-3


def meeting(*ends, turns=(None, None), arcs=(False, False), **options):
    """Return when two bodies first meet that move between configurations."""
    body_a, start_a, end_a, body_b, start_b, end_b = ends
    motion_a = Motion.between(start_a, end_a, turns[0], arc=arcs[0])
    motion_b = Motion.between(start_b, end_b, turns[1], arc=arcs[1])
    return first_meeting(body_a, motion_a, body_b, motion_b, **options)


@pytest.mark.parametrize("pair", PAIRS)
def test_two_bodies_agree_with_shapely(pair, moving):
    footprint_a, footprint_b = (moving.footprints[name] for name in pair)
    body_a, body_b = Body(footprint_a), Body(footprint_b)
    rng = np.random.default_rng(7)
    poses_a, poses_b = (
        moving.random_poses(rng, 1500, 3.0, 4.2),
        moving.random_poses(rng, 1500, 3.0, 4.2),
    )
    expected = moving.gaps(footprint_a, poses_a, footprint_b, poses_b)
    for pose_a, pose_b, gap in zip(poses_a, poses_b, expected, strict=True):
        assert bodies_collide(body_a, pose_a, body_b, pose_b) == (gap <= 0)
        assert bodies_collide(body_b, pose_b, body_a, pose_a) == (gap <= 0)
        distance = body_distance(body_a, pose_a, body_b, pose_b)
        assert distance == pytest.approx(max(gap, 0.0), abs=1e-9)
    assert 200 < (expected <= 0).sum() < 1300


def test_one_body_inside_the_other_collides():
    large, small = Footprint.box(4.0, 4.0), Footprint.box(0.1, 0.1)
    for big in (large, Footprint.disc(2.0)):
        for tiny in (small, Footprint.disc(0.05)):
            pose = (10.3, 9.8, 0.4)
            assert bodies_collide(Body(big), (10, 10, 0), Body(tiny), pose)
            assert bodies_collide(Body(tiny), pose, Body(big), (10, 10, 0))
            assert body_distance(Body(tiny), pose, Body(big), (10, 10, 0)) == 0.0


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-4, 4), st.floats(-5, 5), st.floats(-4, 4))
def test_distance_is_symmetric_and_independent_of_the_frame(moving, x, y, heading, shift, turn):
    body = Body(moving.footprints["ell"])  # one object, in two places
    distance = body_distance(body, (0, 0, 0), body, (x, y, heading))
    assert body_distance(body, (x, y, heading), body, (0, 0, 0)) == pytest.approx(distance)
    c, s = math.cos(turn), math.sin(turn)
    moved = (shift + c * x - s * y, s * x + c * y, heading + turn)
    assert body_distance(body, (shift, 0, turn), body, moved) == pytest.approx(distance, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("arcs", [(False, False), (True, False)])
def test_meetings_agree_with_sampling(pair, arcs, moving):
    footprint_a, footprint_b = (moving.footprints[name] for name in pair)
    body_a, body_b = Body(footprint_a), Body(footprint_b)
    rng = np.random.default_rng(8)
    fractions = np.linspace(0, 1, 2001)
    found: list[float | None] = []
    while len(found) < 30:
        start_a, start_b = moving.random_poses(rng, 2, 0, 2)
        turn_a, turn_b = rng.uniform(-4, 4, 2)
        end_a = np.array([*rng.uniform(0, 2, 2), start_a[2] + turn_a])
        end_b = np.array([*rng.uniform(0, 2, 2), start_b[2] + turn_b])
        turns = (turn_a, turn_b)
        contact = meeting(body_a, start_a, end_a, body_b, start_b, end_b, turns=turns, arcs=arcs)
        path_a, path_b = (moving.on_arc if arc else moving.on_line for arc in arcs)
        poses_a = path_a(start_a, turn_a, end_a, fractions)
        poses_b = path_b(start_b, turn_b, end_b, fractions)
        apart = moving.gaps(footprint_a, poses_a, footprint_b, poses_b)
        if apart[0] <= 0:
            assert contact == 0.0
            continue
        found.append(contact)
        if contact is None:
            # Less than half a millimetre of overlap may be missed.
            for i in np.flatnonzero(apart <= 0):
                core = footprint_a.placed(poses_a[i]).buffer(-MILLIMETRE)
                assert not core.intersects(footprint_b.placed(poses_b[i]))
        else:
            at = np.array([contact])
            there_a = path_a(start_a, turn_a, end_a, at)
            there_b = path_b(start_b, turn_b, end_b, at)
            assert moving.gaps(footprint_a, there_a, footprint_b, there_b)[0] == pytest.approx(
                0, abs=2e-6
            )
            assert (apart[fractions < contact - 1e-2] > 0).all()
    assert 3 < found.count(None) < 27


@pytest.mark.slow
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("arcs", [(False, False), (True, True)])
def test_coming_within_a_gap_agrees_with_sampling(pair, arcs, moving):
    footprint_a, footprint_b = (moving.footprints[name] for name in pair)
    body_a, body_b = Body(footprint_a), Body(footprint_b)
    rng = np.random.default_rng(9)
    fractions = np.linspace(0, 1, 2001)
    found: list[float | None] = []
    while len(found) < 25:
        gap = rng.choice([0.01, 0.3, 1.0])
        start_a, start_b = moving.random_poses(rng, 2, 0, 4)
        turn_a, turn_b = rng.uniform(-4, 4, 2)
        end_a = np.array([*rng.uniform(0, 4, 2), start_a[2] + turn_a])
        end_b = np.array([*rng.uniform(0, 4, 2), start_b[2] + turn_b])
        options = {"turns": (turn_a, turn_b), "arcs": arcs, "gap_m": gap}
        near = meeting(body_a, start_a, end_a, body_b, start_b, end_b, **options)
        path_a, path_b = (moving.on_arc if arc else moving.on_line for arc in arcs)

        def apart(at, path_a=path_a, path_b=path_b, a=(start_a, turn_a, end_a),
                  b=(start_b, turn_b, end_b)):  # fmt: skip
            return moving.gaps(footprint_a, path_a(*a, at), footprint_b, path_b(*b, at))

        if apart(np.array([0.0]))[0] <= gap:
            assert near == 0.0
            continue
        found.append(near)
        before = fractions[fractions < (2.0 if near is None else near)]
        assert (apart(before) > gap - MILLIMETRE / 2).all()
        if near is not None:
            assert gap < apart(np.array([near]))[0] < gap + 2e-6
    assert 3 < found.count(None) < 22


@given(
    st.tuples(*[st.floats(-5, 5)] * 8),
    st.floats(0.05, 1.0),
    st.floats(0.05, 1.0),
    st.sampled_from([0.0, 0.2, 2.0]),
)
def test_closed_form_for_discs_agrees_with_advancement(numbers, radius_a, radius_b, gap):
    # Discs on lines meet in closed form; on a nearly straight arc advancement is used.
    ax, ay, bx, by, to_ax, to_ay, to_bx, to_by = numbers
    body_a, body_b = Body(Footprint.disc(radius_a)), Body(Footprint.disc(radius_b))
    ends = (body_a, (ax, ay, 0), (to_ax, to_ay, 0), body_b, (bx, by, 0), (to_bx, to_by, 0))
    exact = meeting(*ends, gap_m=gap)
    bent = (body_a, (ax, ay, 0), (to_ax, to_ay, 1e-6), *ends[3:])
    followed = meeting(*bent, turns=(1e-6, None), arcs=(True, False), gap_m=gap, resolution_m=1e-5)
    reach = radius_a + radius_b + gap
    if exact is None:
        assert followed is None or followed > 1 - 1e-5 or _least(numbers) > reach - 1e-6
    else:
        at = np.array(numbers[:4]) + exact * (np.array(numbers[4:]) - np.array(numbers[:4]))
        distance = math.hypot(at[2] - at[0], at[3] - at[1])
        assert exact == 0.0 or reach < distance < reach + 2e-6
        grazes = _least(numbers) > reach - 1e-5
        assert grazes or followed == pytest.approx(exact, abs=1e-3)


def _least(numbers):
    line = shapely.LineString(
        [(numbers[2] - numbers[0], numbers[3] - numbers[1]),
         (numbers[6] - numbers[4], numbers[7] - numbers[5])]
    )  # fmt: skip
    return line.distance(shapely.Point(0, 0))


def test_discs_that_nearly_miss_are_reported_before_contact():
    disc = Body(Footprint.disc(0.5))
    for offset in (1.0, 1.0 - 1e-15, 1.0 - 1e-12, 1.0 - 1e-9):
        ends = (disc, (0, 0, 0), (10, 0, 0), disc, (5, offset, 0), (5, offset, 0))
        fraction = meeting(*ends)
        assert fraction is not None
        assert fraction == pytest.approx(0.5, abs=1e-4)
        assert math.hypot(5 - 10 * fraction, offset) > 1.0
    ends = (disc, (0, 0, 0), (10, 0, 0), disc, (5, 1 + 1e-9, 0), (5, 1 + 1e-9, 0))
    assert meeting(*ends) is None
    assert meeting(*ends, gap_m=1e-8) is not None
    assert meeting(*ends, gap_m=5.0) == 0.0


def test_a_gap_is_a_finite_length():
    disc, at = Body(Footprint.disc(0.5)), (0, 0, 0)
    for gap in (-0.1, math.nan, math.inf):
        with pytest.raises(InvalidInputError, match="a gap of"):
            meeting(disc, at, at, disc, (5, 0, 0), at, gap_m=gap)


def test_bodies_that_keep_pace_never_meet():
    body = Body(Footprint.box(1.0, 1.0))
    side_by_side = meeting(body, (0, 0, 0), (50, 0, 0), body, (0, 1.001, 0), (50, 1.001, 0))
    assert side_by_side is None
    head_on = meeting(body, (0, 0, 0), (10, 0, 0), body, (10, 0, 0), (0, 0, 0))
    assert head_on == pytest.approx(0.45, abs=1e-6)
    # They swap places on crossing lines: the ends are apart, the middle is not.
    crossing = meeting(body, (0, 0, 0), (9, 9, 0), body, (0, 9, 0), (9, 0, 0))
    assert crossing == pytest.approx(4.0 / 9.0, abs=1e-6)
    waiting = meeting(body, (0, 0, 0), (0, 0, 0), body, (3, 0, 0), (3, 0, 0))
    assert waiting is None


def test_touching_is_a_collision():
    disc = Body(Footprint.disc(0.5))
    assert bodies_collide(disc, (0, 0, 0), disc, (1, 0, 0))
    assert not bodies_collide(disc, (0, 0, 0), disc, (1 + 1e-9, 0, 0))


@pytest.mark.parametrize(
    "bad", [(math.nan, 0, 0), (0, math.inf, 0), (0, 0, math.nan), (1, 2), None]
)
def test_configurations_that_are_not_numbers_are_refused(bad, moving):
    body, good = Body(moving.footprints["ell"]), (1.0, 1.0, 0.0)
    queries = [
        lambda: bodies_collide(body, good, body, bad),
        lambda: body_distance(body, bad, body, good),
        lambda: Motion.between(bad, good),
        lambda: Motion.between(good, bad),
    ]
    for query in queries:
        with pytest.raises(InvalidInputError, match="configuration"):
            query()
