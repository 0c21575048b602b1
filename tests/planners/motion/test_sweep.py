import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.bodies.footprint import Footprint
from multisrt.planners.motion.sweep import Sweep
from multisrt.planners.motion.trajectory import Trajectory, Waypoint

DISC = Footprint.disc(0.25)
BOX = Footprint.box(0.6, 0.4)
ELL = Footprint.polygon(
    [(-0.3, -0.3), (0.5, -0.3), (0.5, 0.0), (0.1, 0.0), (0.1, 0.4), (-0.3, 0.4)]
)


def standing(x: float, y: float, heading: float = 0.0) -> Trajectory:
    return Trajectory((Waypoint(0.0, x, y, heading),))


def bounds_of(sweep: Sweep) -> tuple[float, float, float, float]:
    x0, y0, x1, y1 = sweep.shape.bounds
    return x0 - sweep.pad_m, y0 - sweep.pad_m, x1 + sweep.pad_m, y1 + sweep.pad_m


def test_distance_of_discs_at_rest():
    a, b = Sweep(DISC, standing(0.0, 0.0)), Sweep(DISC, standing(3.0, 4.0))
    assert a.distance_to(b) == pytest.approx(4.5)
    assert bounds_of(a) == (-0.25, -0.25, 0.25, 0.25)
    assert a.distance_to(a) == 0.0


def test_bounds_of_a_box_at_rest():
    box = Sweep(BOX, standing(1.0, 2.0, math.pi / 2))
    assert box.pad_m == 0.0
    assert bounds_of(box) == pytest.approx((0.8, 1.7, 1.2, 2.3))


@pytest.mark.parametrize("footprint", [BOX, ELL])
def test_sweeps_of_straight_motions_are_exact(footprint):
    moved = Trajectory((Waypoint(0.0, 0.0, 0.0, 0.3), Waypoint(1.0, 2.0, 1.0, 0.3)))
    sweep = Sweep(footprint, moved)
    assert sweep.pad_m == 0.0
    expected = footprint.swept((0.0, 0.0, 0.3), (2.0, 1.0, 0.3))
    assert sweep.shape.buffer(0).symmetric_difference(expected).area < 1e-12


def test_a_disc_that_turns_in_place_sweeps_itself():
    turn = Trajectory((Waypoint(0.0, 1.0, 1.0, 0.0), Waypoint(1.0, 1.0, 1.0, 3.0)))
    assert bounds_of(Sweep(DISC, turn)) == (0.75, 0.75, 1.25, 1.25)


@pytest.mark.parametrize("step", [5e-324, 1e-195, 1e-160, 1e-12])
def test_a_disc_that_hardly_moves_sweeps_itself(step):
    moved = Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(1.0, 0.0, step, 0.0)))
    assert Sweep(DISC, moved).distance_to(Sweep(DISC, standing(3.0, 4.0))) == pytest.approx(4.5)
    assert Sweep(DISC, moved).distance_to(Sweep(DISC, standing(0.0, 0.0))) == 0.0


def test_a_box_that_turns_round_sweeps_its_circle():
    turn = Trajectory((Waypoint(0.0, 0.0, 0.0, 0.0), Waypoint(1.0, 0.0, 0.0, 2.0 * math.pi)))
    sweep = Sweep(BOX, turn)
    radius = math.hypot(0.3, 0.2)
    far = Sweep(DISC, standing(2.0, 0.0))
    assert sweep.distance_to(far) == pytest.approx(1.75 - radius, abs=0.005)


def test_a_box_on_an_arc_sweeps_up_to_its_outer_corners():
    # A quarter circle of 1 m about the origin: they are hypot(1.2, 0.3) away from it.
    moved = Trajectory((Waypoint(0, 1.0, 0.0, math.pi / 2), Waypoint(1, 0.0, 1.0, math.pi)))
    far = Sweep(DISC, standing(2.0, 2.0))
    gap = 2.0 * math.sqrt(2.0) - 0.25 - math.hypot(1.2, 0.3)
    assert gap - 0.005 <= Sweep(BOX, moved).distance_to(far) <= gap
    inside = Sweep(Footprint.disc(0.1), standing(0.0, 0.0))
    assert 0.695 <= Sweep(BOX, moved).distance_to(inside) <= 0.7


def rounded(low: float, high: float) -> st.SearchStrategy[float]:
    # GEOS, the oracle, divides by zero in unions of corners that lie 1e-295 m apart.
    return st.floats(low, high).map(lambda value: round(value, 9))


coordinate, angle = rounded(-3.0, 3.0), rounded(-3.1, 3.1)
legs = st.lists(st.tuples(coordinate, coordinate, st.one_of(st.just(0.0), angle)), max_size=2)


@st.composite
def motions(draw):
    x, y, heading = draw(coordinate), draw(coordinate), draw(angle)
    waypoints = [Waypoint(0.0, x, y, heading)]
    for dx, dy, turn in draw(legs):
        last = waypoints[-1]
        waypoints.append(Waypoint(last.time_s + 1.0, x + dx, y + dy, last.heading + turn))
    return Trajectory(tuple(waypoints))


def covered(footprint: Footprint, moved: Trajectory) -> shapely.Geometry:
    times = np.linspace(0.0, moved.duration_s, 150 if moved.duration_s else 1)
    return shapely.union_all([footprint.placed(moved.at(time)) for time in times])


footprints = st.sampled_from([DISC, BOX, ELL])


@pytest.mark.slow
@settings(max_examples=60)
@given(footprints, motions(), footprints, motions())
def test_distances_are_tight_lower_bounds(fa, wa, fb, wb):
    a, b = Sweep(fa, wa), Sweep(fb, wb)
    distance = a.distance_to(b)
    truth = shapely.distance(covered(fa, wa), covered(fb, wb))
    # The truth is sampled in time, between which a body moves by up to a few centimetres.
    assert distance <= truth + 1e-3
    assert distance >= truth - 0.1
    assert b.distance_to(a) == pytest.approx(distance, abs=1e-12)


@pytest.mark.slow
@given(footprints, motions())
def test_a_sweep_contains_the_body_at_all_times(footprint, moved):
    sweep = Sweep(footprint, moved)
    assert sweep.pad_m <= 0.0021 + (DISC.radius_m if footprint.is_disc else 0.0)
    area = sweep.shape.buffer(sweep.pad_m + 1e-4, quad_segs=64)
    for time in np.linspace(0.0, moved.duration_s, 40):
        body = footprint.placed(moved.at(time))
        assert body.difference(area).area < 1e-5
