"""The frontier that is left, as it is computed from a recording and drawn."""

import re
from dataclasses import replace

import numpy as np
import pytest
import shapely

import multisrt as ms
from multisrt.analysis.remaining_frontier import arcs_given_up, remaining_frontier
from multisrt.drawing import tree_svg
from multisrt.environments.catalog import environment
from multisrt.events import ArcClosed, ArcReason, ArcReopened, Died, Ended, NodeAdded, Segment
from tests.multisrt.drawing.pictures import SVG, layers, lines, paths, texts
from tests.multisrt.drawing.recordings import A, C, F, node, recorded, run, team


def test_a_run_that_is_cut_off_shows_its_frontier(cut_off, museum):
    assert cut_off.footer.outcome == "out_of_time"
    frontier = lines(paths(layers(tree_svg(cut_off))["robot 0: frontier"]))
    length = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in frontier)
    said = re.findall(r"([\d.]+) m of open frontier left", texts(tree_svg(cut_off))[1])
    assert length == pytest.approx(float(said[0]), abs=0.1)
    assert length > 10
    assert "open frontier" in texts(tree_svg(cut_off))
    assert paths(layers(tree_svg(museum))["robot 0: frontier"]) == ""
    assert "open frontier" not in texts(tree_svg(museum))


def test_the_computed_frontier_is_that_reported_by_the_robot(stalled, museum):
    for recording in (stalled, museum):
        said = next(event.frontier for event in recording.events if isinstance(event, Ended))
        silent = replace(
            recording, events=tuple(e for e in recording.events if not isinstance(e, Ended))
        )
        assert remaining_frontier(recording) == {0: said}
        assert set(remaining_frontier(silent)[0]) == set(said)
    assert stalled.footer.outcome == "stalled"


def test_closed_arcs_are_drawn_by_reason_and_are_no_frontier(cut_off):
    left = remaining_frontier(cut_off)[0]
    arcs: dict[int, list[Segment]] = {n: [] for n in range(100)}
    boundaries = {
        e.serial: shapely.LinearRing(e.boundary) for e in cut_off.events if isinstance(e, NodeAdded)
    }
    for segment in left:
        middle = shapely.Point((segment[0] + segment[2]) / 2, (segment[1] + segment[3]) / 2)
        node = min(boundaries, key=lambda k: boundaries[k].distance(middle))
        arcs[node].append(segment)
    node, arc = next((n, tuple(a)) for n, a in arcs.items() if a)
    closing = ArcClosed(time_s=60.0, robot=0, node=(0, node), reason="not reachable", arc=arc)
    closed = replace(cut_off, events=(*cut_off.events, closing))
    assert set(remaining_frontier(closed)[0]) == set(left) - set(arc)
    svg = tree_svg(closed)
    drawn = layers(svg)["robot 0: frontier given up"].findall(SVG + "path")
    assert len(drawn) == 1
    assert drawn[0].get("stroke-dasharray")
    assert "frontier given up: not reachable" in texts(svg)


def test_the_frontier_of_an_isolated_robot_bounds_its_area(cut_off):
    seen = shapely.union_all(
        [shapely.Polygon(e.boundary) for e in cut_off.events if isinstance(e, NodeAdded)]
    )
    walls = cut_off.environment().free.boundary
    for x0, y0, x1, y1 in remaining_frontier(cut_off)[0]:
        middle = shapely.Point((x0 + x1) / 2, (y0 + y1) / 2)
        assert seen.boundary.distance(middle) < 1e-6
        assert walls.distance(middle) > 1e-6


def test_a_frontier_that_another_robot_has_seen_is_not_left(cut_off):
    everything = run(environment("museum"), seed=2)
    assert len(remaining_frontier(cut_off)[0]) > 10
    assert remaining_frontier(team(cut_off, everything)) == {0: (), 1: ()}


def test_the_last_report_of_a_robot_counts(support):
    assert remaining_frontier(support) == {0: (), 1: ()}
    early = replace(support, events=support.events[:11])
    assert remaining_frontier(early) == {0: ((9.0, 1.0, 9.0, 5.0),), 1: ()}


def test_going_on_after_an_end_withdraws_its_report(support):
    dying = Died(time_s=13.0, robot=0, configuration=(*F, 0.0), doing="waiting")
    dead = replace(support, events=(*support.events[:-2], dying))
    # Nobody saw the hall's upper wall.
    left = remaining_frontier(dead)
    assert left[1] == ()
    seen = shapely.union_all(
        [shapely.Polygon(e.boundary) for e in dead.events if isinstance(e, NodeAdded)]
    )
    assert left[0]
    for x0, y0, x1, y1 in left[0]:
        middle = shapely.Point((x0 + x1) / 2, (y0 + y1) / 2)
        assert seen.boundary.distance(middle) < 1e-6
        assert shapely.box(1e-6, 1e-6, 20 - 1e-6, 8 - 1e-6).contains(middle)


@pytest.mark.parametrize("reason", ["too narrow", "not reachable", "seen from near"])
def test_an_arc_that_any_robot_gave_up_counts_as_closed(reason):
    events = [node(0.0, 0, 0, A), node(0.0, 1, 0, C)]
    arc = remaining_frontier(recorded([A, C], events))[0]
    assert arc
    closing = ArcClosed(time_s=1.0, robot=1, node=(0, 0), reason=reason, arc=arc)
    closed = recorded([A, C], [*events, closing])
    assert remaining_frontier(closed)[0] == ()
    assert remaining_frontier(closed)[1] != ()
    svg = tree_svg(closed)
    assert f"frontier given up: {reason}" in texts(svg)
    assert len(layers(svg)["robot 1: frontier given up"]) == 1


def test_an_arc_blocked_by_a_robot_stays_open_and_may_be_taken_up_again():
    nodes = [node(0.0, 0, 0, A), node(0.0, 1, 0, C)]
    arc = remaining_frontier(recorded([A, C], nodes))[0]
    assert arc
    reason: ArcReason = "blocked by a robot"
    closing = ArcClosed(time_s=1.0, robot=1, node=(0, 0), reason=reason, arc=arc)
    blocked = recorded([A, C], [*nodes, closing])
    assert remaining_frontier(blocked)[0] == arc
    svg = tree_svg(blocked)
    assert f"frontier given up: {reason}" in texts(svg)
    assert len(layers(svg)["robot 1: frontier given up"]) == 1
    assert arcs_given_up(blocked) == (closing,)
    opening = ArcReopened(time_s=2.0, robot=1, node=(0, 0), arc=arc)
    again = recorded([A, C], [*nodes, closing, opening])
    assert arcs_given_up(again) == ()
    assert remaining_frontier(again)[0] == arc
    svg = tree_svg(again)
    assert f"frontier given up: {reason}" not in texts(svg)
    assert len(layers(svg)["robot 1: frontier given up"]) == 0


def test_frontier_left_by_a_robot_that_went_home_in_time():
    # A corridor of 60 m in 100 s, there and back: all of the rest lies behind the open frontier.
    corridor = ms.Environment("corridor", shapely.box(0.0, 0.0, 60.0, 1.2))
    for strategy in ("minpos", "srt-radial"):
        done = ms.explore(
            corridor,
            strategy=strategy,
            start=(1.0, 0.6),
            base=(1.0, 0.6),
            radio_range_m=3.0,
            options={"home": "in-time"},
            max_time_s=100.0,
        )
        assert done.metrics.frontier_left_m == pytest.approx(1.2, abs=0.1)
        left_m2 = done.metrics.explorable_area_m2 * (1.0 - done.metrics.coverage)
        assert done.metrics.given_up_m2 == {"left open": pytest.approx(left_m2)}
