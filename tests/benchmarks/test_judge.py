"""The judge against answers by hand, and small runs that it judges."""

import math

import numpy as np
import pytest
import shapely

from benchmarks.judge.areas import World, both, together
from benchmarks.judge.command import Case, exceptions, table
from benchmarks.judge.motions import smallest
from benchmarks.judge.verdict import Figure, judge, part_of
from benchmarks.judge.views import Views, chords, cut_at_range
from multisrt.campaign.bodies import body_of
from multisrt.campaign.tracks import Track
from multisrt.events import Motion
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import build_environment
from multisrt.spec import (
    CatalogEnvironment,
    Death,
    DriveSpec,
    RadioSpec,
    RangeFinderSpec,
    RobotSpec,
    RunSpec,
    StopRule,
)

SQUARE = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def test_a_range_beyond_the_corners_cuts_nothing():
    assert shapely.Polygon(cut_at_range(SQUARE, (0.2, -0.1), 5.0)).equals(shapely.Polygon(SQUARE))


def test_a_range_within_the_walls_leaves_the_chords_of_a_circle():
    cut = shapely.Polygon(cut_at_range(SQUARE, (0.0, 0.0), 0.5))
    n = chords(0.5)
    assert n == math.ceil(math.pi / math.acos(1.0 - 0.0025))
    assert cut.area == pytest.approx(0.5 * n * 0.25 * math.sin(2.0 * math.pi / n))


def test_a_range_between_walls_and_corners_cuts_the_corners():
    cut = shapely.Polygon(cut_at_range(SQUARE, (0.0, 0.0), 1.2))
    disc = shapely.Point(0.0, 0.0).buffer(1.2, quad_segs=500)
    exact = shapely.Polygon(SQUARE).intersection(disc)
    assert cut.within(exact.buffer(1e-5))
    assert 0.0 < exact.area - cut.area < 0.0025 * 1.2 * 1.2 * 2.0 * math.pi


def test_a_pillar_hides_what_is_behind_it():
    free = shapely.box(0, 0, 6, 4).difference(shapely.box(2, 1, 3, 3))
    assert isinstance(free, shapely.Polygon)
    seen = shapely.Polygon(Views(free).view(1.0, 2.0, 20.0))
    # Rays through the corners (2, 1) and (2, 3) meet the upper and the lower wall at x = 3.
    hidden = shapely.Polygon([(2, 1), (3, 0), (6, 0), (6, 4), (3, 4), (2, 3)])
    assert seen.symmetric_difference(shapely.box(0, 0, 6, 4) - hidden).area < 1e-9


def test_beams_end_before_the_nearest_of_three_readings():
    corners = Views(shapely.box(-1, -2, 1, 2)).beams(0.0, 0.0, 1.5, 8)
    radii = np.hypot(*corners.T)
    less = 1.0 - math.tan(math.pi / 8) / math.tan(math.pi / 8)
    assert less == pytest.approx(0.0)
    assert radii == pytest.approx(np.zeros(8), abs=1e-12)
    more = np.hypot(*Views(shapely.box(-1, -2, 1, 2)).beams(0.0, 0.0, 1.5, 16).T)
    less = 1.0 - math.tan(math.pi / 16) / math.tan(math.pi / 8)
    # Readings in the first quarter: 1, 1 / cos 22.5, 1 / cos 45, 1.5, 1.5 (the range).
    slanted = 1.0 / math.cos(math.pi / 8)
    expected = [1.0, 1.0, slanted, math.sqrt(2.0), 1.5]
    assert more[:5] == pytest.approx(less * np.array(expected))


def test_a_quarter_turn_is_a_quarter_of_a_circle():
    waypoints = ((1.0, 0.0, 0.0, 0.0), (3.0, 2.0, 2.0, math.pi / 2))
    motion = Motion(time_s=1.0, robot=0, waypoints=waypoints)
    track = Track((0.0, 0.0, 0.0), [motion], 5.0)
    assert track.lengths.sum() == pytest.approx(math.pi, rel=1e-6)
    half = math.sqrt(2.0)
    assert track.at(np.array([0.5, 2.0, 4.0])).tolist() == [
        pytest.approx((0.0, 0.0, 0.0)),
        pytest.approx((half, 2.0 - half, math.pi / 4)),
        pytest.approx((2.0, 2.0, math.pi / 2)),
    ]


def test_the_smallest_value_is_found_between_samples():
    def distance(which, places):
        return np.abs(places - 0.3 * (which + 1)) + 0.1 * which

    found = smallest(distance, np.zeros(2), np.ones(2), np.ones(2), math.inf)
    assert found == pytest.approx(0.0, abs=2e-5)


def test_bodies_are_read_from_their_text():
    assert body_of("disc:0.25").inscribed_m == 0.25
    box = body_of("box:0.8x0.6")
    assert (box.inscribed_m, box.circumscribed_m) == pytest.approx((0.3, 0.5))
    assert sum(shapely.Polygon(piece).area for piece in box.pieces()) == pytest.approx(0.48)


def test_unions_and_intersections_keep_areas_alone():
    left, right = shapely.box(0, 0, 1, 1), shapely.box(1, 0, 2, 1)
    assert both(left, right).is_empty
    assert together([left, right]).area == pytest.approx(2.0)


def test_what_differs_too_much_is_an_exception():
    spec = RunSpec(environment=CatalogEnvironment(name="open"), seed=3)
    right = Figure(name="seen", ours=1.0, judged=1.0, difference=0.0, allowed=0.1)
    wrong = Figure(name="seen", ours=1.0, judged=2.0, difference=1.0, allowed=0.1)
    cases = [Case(spec=spec, world="open", figures=[figure]) for figure in (right, wrong)]
    assert exceptions(cases[0]) == []
    assert "seen is 1, judged 2" in exceptions(cases[1])[0]
    assert table(cases)[1].split() == ["seen", "2", "1.00e+00", "1.00e-01", "1"]


OPEN = CatalogEnvironment(name="open", parameters={"size_m": 8.0})
LASER = RangeFinderSpec(range_m=2.5, beams=180)
DISC, BOX = RobotSpec(), RobotSpec(footprint="box:0.5x0.3", range_finder=LASER)
CAR = RobotSpec(drive=DriveSpec(kind="reeds-shepp", turning_radius_m=0.4))
RUNS = {
    "a disc with regions of stars": RunSpec(
        environment=OPEN, strategy="srt-star", stop=StopRule(max_time_s=120.0), seed=1
    ),
    "boxes with lasers, one of which dies": RunSpec(
        environment=OPEN,
        robots=(BOX, BOX),
        faults=(Death(robot=1, time_s=20.0),),
        stop=StopRule(max_time_s=60.0),
        seed=2,
    ),
    "cars that bid over a radio that walls block": RunSpec(
        environment=CatalogEnvironment(name="maze", parameters={"size_m": 8.0, "cells": 4}),
        strategy="minpos",
        robots=(CAR, DISC),
        radio=RadioSpec(range_m=5.0, walls="block"),
        stop=StopRule(max_time_s=40.0),
        seed=3,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNS)
def test_small_runs_are_measured_as_the_judge_does(name):
    spec = RUNS[name]
    world = build_environment(spec.environment)
    recording = simulate(spec, world)
    figures = judge(recording, world, World(part_of(recording)))
    assert exceptions(Case(spec=spec, world=world.name, figures=figures)) == []
    measured = {figure.name: figure.ours for figure in figures}
    assert measured["coverage"] > 0.5
    assert measured["distance"] > 1.0
    assert len(figures) >= 20
