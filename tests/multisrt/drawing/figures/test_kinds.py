"""Figures show what recordings say."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

import multisrt as ms
from multisrt.analysis.activity import activities
from multisrt.analysis.decision_counts import decision_counts
from multisrt.analysis.heat_maps import isolated_times, visits
from multisrt.analysis.isolation import isolation
from multisrt.analysis.run_tables import coverage_curve
from multisrt.drawing.colours import RobotStyles
from multisrt.drawing.figures import FigureOptions, draw_figure, figure_bytes
from multisrt.drawing.figures.activity import draw_activity
from multisrt.drawing.figures.coverage import draw_coverage
from multisrt.drawing.figures.run_map import draw_map
from multisrt.drawing.figures.trajectories import draw_trajectories
from multisrt.events import Decided, Decision, GoalChosen, Learned, Motion, NodeAdded
from multisrt.geometry.errors import InvalidInputError


@pytest.fixture
def ax():
    return Figure(figsize=(5, 4)).add_subplot()


def shown_by(image):
    return np.ma.filled(np.ma.asarray(image.get_array()), 0.0)


def corners_of(line):
    return np.asarray(line.get_xydata())


def stretches_of(line):
    """The parts of a line with gaps."""
    corners = corners_of(line)
    gaps = np.flatnonzero(np.isnan(corners[:, 0]))
    parts = np.split(corners, gaps)
    return shapely.MultiLineString([part[~np.isnan(part[:, 0])] for part in parts])


def waypoints(recording, robot):
    start = recording.header.starts[robot][:2]
    moved = [e for e in recording.events if isinstance(e, Motion) and e.robot == robot]
    return np.array([start, *(w[1:3] for e in moved for w in e.waypoints)])


@pytest.mark.slow
def test_trajectories_are_those_of_the_recording(bidders, growers, ax):
    led_back = []
    for recording in (bidders, growers):
        drawn = draw_trajectories(recording, ax, 80.0)
        assert len(drawn) == 3
        for robot, line in enumerate(drawn):
            own = waypoints(recording, robot)
            drawn_once = stretches_of(line)
            true = shapely.LineString(own)
            assert drawn_once.hausdorff_distance(true) < 1e-6
            # No leg is drawn twice: dashes would fill each other's gaps.
            legs = {frozenset(map(tuple, np.round(leg, 6).tolist())) for leg in pairwise(own)}
            once = sum(np.hypot(*np.subtract(*leg)) for leg in legs if len(leg) == 2)
            assert drawn_once.length == pytest.approx(once, rel=1e-6)
            assert line.get_label() == f"robot {robot}"
            led_back.append(drawn_once.length < true.length - 1.0)
    assert any(led_back)


@pytest.mark.slow
def test_single_robots_are_chosen(bidders, ax):
    (line,) = draw_trajectories(bidders, ax, 80.0, robots=[1])
    assert line.get_label() == "robot 1"
    assert [text.get_text() for text in ax.texts if text.get_text().isdigit()] == ["1"]


@pytest.mark.slow
def test_numbers_at_starts_do_not_touch(bidders):
    figure = draw_figure("trajectories", bidders, style="ieee")
    discs = [
        (figure.axes[0].transData.transform(corners_of(line)[0]), line.get_markersize())
        for line in figure.axes[0].lines
        if line.get_marker() == "o"
    ]
    assert len(discs) == 3
    for i, (one, size) in enumerate(discs):
        for other, _ in discs[i + 1 :]:
            assert np.hypot(*(one - other)) > size / 72.0 * figure.dpi


@pytest.mark.slow
def test_maps_have_all_nodes_edges_and_areas(growers, ax):
    sheet = draw_map(growers, ax, 80.0)
    by_label = {
        group.get("inkscape:label", ""): group
        for group in sheet.map
        if group.get("inkscape:groupmode") == "layer"
    }
    for robot in range(3):
        own = [n for n in growers.of(NodeAdded) if n.robot == robot]
        nodes = by_label[f"robot {robot}: nodes"]
        assert sum(path.get("d", "").count("M") for path in nodes.iter("path")) == len(own)
        edges = by_label[f"robot {robot}: tree"]
        drawn = sum(path.get("d", "").count("M") for path in edges.iter("path"))
        assert drawn == sum(n.parent is not None for n in own)
    assert "robot 0: regions" not in by_label


def known_at(recording, robot, time_s):
    """The free space that a robot knows, by the robot that made it, straight from the events."""
    nodes = {(n.robot, n.serial): n for n in recording.of(NodeAdded)}
    names = {n for n, e in nodes.items() if n[0] == robot and e.time_s <= time_s}
    for event in recording.of(Learned):
        if event.robot == robot and event.time_s <= time_s:
            names |= set(event.nodes)
    free = recording.environment().free
    return {
        maker: shapely.union_all(
            [shapely.make_valid(shapely.Polygon(nodes[n].boundary)) for n in names if n[0] == maker]
        ).intersection(free)
        for maker in {name[0] for name in names}
    }


def filled(ax):
    """The area of each patch with a name, by even-odd counting of its rings."""
    found = {}
    for patch in ax.patches:
        if (gid := patch.get_gid()) is not None:
            rings = [shapely.Polygon(r) for r in patch.get_path().to_polygons() if len(r) > 3]
            signs = [1 if r.exterior.is_ccw else -1 for r in rings]
            found[gid] = sum(s * r.area for s, r in zip(signs, rings, strict=True))
    return found


@pytest.mark.slow
def test_each_robots_map_is_what_it_made_and_learned(growers):
    times = (2.0, 50.0, 110.0)
    figure = draw_figure("maps", growers, options=FigureOptions(times_s=times))
    free = growers.environment().free
    assert len(figure.axes) == 9
    shares = []
    for number, ax in enumerate(figure.axes):
        robot, column = divmod(number, 3)
        true = known_at(growers, robot, times[column])
        drawn = filled(ax)
        assert set(drawn) == {f"seen by robot {maker}" for maker in true}
        for maker, area in true.items():
            # Outlines are drawn without corners that nobody sees.
            assert drawn[f"seen by robot {maker}"] == pytest.approx(area.area, rel=2e-3)
        share = shapely.union_all(list(true.values())).area / free.area
        assert ax.get_title().endswith(f"{100 * share:.0f} %")
        shares.append(share)
    assert len(set(shares)) > 4


@pytest.mark.slow
def test_columns_and_rows_of_maps_are_in_the_order_that_is_given(growers):
    given = FigureOptions(times_s=(80.0, 10.0), robots=(2, 0))
    figure = draw_figure("maps", growers, options=given)
    assert [ax.get_ylabel() for ax in figure.axes] == ["robot 2", "", "robot 0", ""]
    assert [ax.get_title().partition(":")[0] for ax in figure.axes[:2]] == ["80 s", "10 s"]
    areas = [sum(filled(ax).values()) for ax in figure.axes]
    assert areas[2] > areas[3]


def seen_by(figure):
    (legend,) = figure.legends
    return [t.get_text() for t in legend.get_texts() if t.get_text().startswith("seen by")]


@pytest.mark.slow
def test_the_legend_of_maps_lists_the_robots_whose_areas_are_shown(growers):
    early = draw_figure("maps", growers, options=FigureOptions(times_s=(0.5,), robots=(1,)))
    shown = {f"seen by robot {maker}" for maker in known_at(growers, 1, 0.5)}
    assert set(seen_by(early)) == shown
    assert len(seen_by(draw_figure("maps", growers))) == 3


@pytest.fixture(scope="module")
def crowd():
    """Thirty robots that move little."""
    return ms.explore("museum", strategy="closest", robots=30, seed=1, max_time_s=3.0).recording


@pytest.mark.slow
def test_maps_are_as_large_as_can_be_or_refused(crowd):
    figure = draw_figure("maps", crowd, style="ieee-wide", options=FigureOptions(times_s=(1.0,)))
    width_in, height_in = figure.get_size_inches()
    shown = [ax for ax in figure.axes if ax.get_visible()]
    assert sorted(ax.get_ylabel() for ax in shown) == sorted(f"robot {n}" for n in range(30))
    boxes = [ax.get_position() for ax in shown]
    assert min(max(box.width * width_in, box.height * height_in) for box in boxes) >= 0.9
    assert len({round(box.y0, 3) for box in boxes}) < 30
    with pytest.raises(InvalidInputError, match=r"90 maps .* choose at most (\d+) rob") as refused:
        draw_figure("maps", crowd, style="ieee")
    most = int(str(refused.value).partition("at most ")[2].split()[0])
    draw_figure("maps", crowd, style="ieee", options=FigureOptions(robots=tuple(range(most))))


@pytest.mark.slow
def test_many_runs_that_do_not_fit_are_refused(curves):
    with pytest.raises(InvalidInputError, match="fewer recordings or a wider style"):
        draw_figure("trajectories", curves * 16, style="ieee")


@pytest.mark.slow
def test_legends_of_large_teams_say_how_many_robots_they_leave_out(crowd):
    for kind in ("map", "trajectories"):
        (legend,) = draw_figure(kind, crowd).legends
        texts = [text.get_text() for text in legend.get_texts()]
        robots = [text for text in texts if text.startswith("robot ")]
        assert robots == [f"robot {number}" for number in range(23)]
        assert "and 7 more" in texts


@pytest.mark.slow
def test_the_legend_of_a_map_shows_the_areas_of_robots(growers):
    for without in ((), ("areas",)):
        figure = draw_figure("map", growers, options=FigureOptions(without=without))
        (legend,) = figure.legends
        texts = [text.get_text() for text in legend.get_texts()]
        assert ("seen first by a robot" in texts) == (not without)
        fills = {to_hex(patch.get_facecolor()) for patch in legend.get_patches()}
        assert (RobotStyles.of(1).area.fill in fills) == (not without)


def test_figures_are_drawn_of_runs_and_of_recordings_only():
    run = ms.explore("open", seed=1, max_time_s=5.0)
    of_recording = figure_bytes("trajectories", run.recording)
    assert figure_bytes("trajectories", run) == of_recording
    assert figure_bytes("trajectories", [run]) == of_recording
    several_wrong: list[Any] = [1, "recording.jsonl", [run, None]]
    for wrong in several_wrong:
        with pytest.raises(InvalidInputError, match="drawn of runs or recordings, not of"):
            draw_figure("coverage", wrong)


def at_times(curve, times):
    """A step curve at some times; 0 before its first change."""
    last = np.searchsorted(curve[0], times, side="right")
    return np.concatenate([[0.0], curve[1]])[last]


@pytest.mark.slow
def test_coverage_is_median_and_quartiles_of_the_runs(curves, ax):
    several, single = draw_coverage(curves, ax)
    exact = [
        (np.asarray(c["time_s"].values, float), np.asarray(c["coverage"].values, float))
        for c in (coverage_curve(run, run.environment()) for run in curves)
    ]
    times, shares = corners_of(several).T
    runs = np.stack([at_times(curve, times) for curve in exact[:4]])
    np.testing.assert_allclose(shares, np.median(runs, axis=0))
    (band,) = ax.collections
    corners = band.get_paths()[0].vertices
    low, high = np.quantile(runs, [0.25, 0.75], axis=0)
    for time_s, a, b in zip(times[1:-1:20], low[1:-1:20], high[1:-1:20], strict=True):
        own = corners[np.isclose(corners[:, 0], time_s), 1]
        assert own.min() == pytest.approx(a)
        assert own.max() == pytest.approx(b)
    np.testing.assert_allclose(corners_of(single).T, exact[4])
    assert [several.get_label(), single.get_label()] == ["srt-radial (4 runs)", "minpos"]
    assert several.get_linestyle() != single.get_linestyle()


@pytest.mark.slow
def test_strips_are_the_activities(growers, ax):
    draw_activity(growers, ax)
    end_s = growers.footer.time_s
    cut_off = isolation(growers)
    assert any(robot.spells for robot in cut_off)
    for robot, spells in enumerate(activities(growers, with_isolation=False)):
        drawn, bars = [], []
        for collection in ax.collections:
            name = collection.get_gid() or ""
            if name.startswith(f"robot {robot} "):
                activity = name.removeprefix(f"robot {robot} ")
                for path in collection.get_paths():
                    box = path.get_extents()
                    if activity == "cut off":
                        bars.append((box.x0, box.x1))
                        continue
                    drawn.append((box.x0, box.x1, activity))
        drawn.sort()
        assert [name for *_, name in drawn] == [spell.activity for spell in spells]
        spans = [(spell.start_s, spell.end_s) for spell in spells]
        np.testing.assert_allclose([span[:2] for span in drawn], spans, atol=1e-9)
        assert sum(b - a for a, b, _ in drawn) == pytest.approx(end_s)
        true = cut_off[robot].spells
        np.testing.assert_allclose(np.reshape(sorted(bars), (-1, 2)), np.reshape(true, (-1, 2)))
    assert {activity for *_, activity in drawn} >= {"dead"}


@pytest.mark.slow
def test_heat_maps_show_the_counts(bidders):
    for count in ("passes", "viewers"):
        figure = draw_figure("visits", bidders, options=FigureOptions(count=count))
        (image,) = figure.axes[0].images
        shown = shown_by(image)
        np.testing.assert_array_equal(shown, visits(bidders, count).values)
    figure = draw_figure("isolation", bidders)
    (image,) = figure.axes[0].images
    times = isolated_times(bidders)
    np.testing.assert_allclose(shown_by(image), times.values / times.cell_m**2)


@pytest.mark.slow
def test_colour_bars_of_counts_have_a_label_for_each_colour(bidders):
    figure = draw_figure("visits", bidders)
    labels = [label.get_text() for label in figure.axes[1].get_xticklabels()]
    most = int(visits(bidders, "passes").values.max())
    assert 1 < most <= 10
    assert labels == [str(count) for count in range(1, most + 1)]


@pytest.mark.slow
def test_a_team_that_was_never_isolated_is_said_to_be(curves):
    figure = draw_figure("isolation", curves[0])
    assert figure.axes[0].get_title(loc="left") == "never isolated"
    assert len(figure.axes) == 1
    figure = draw_figure("isolation", curves[:2])
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert titles == [
        f"({letter}) srt-radial, seed {seed}: never isolated"
        for letter, seed in (("a", 1), ("b", 2))
    ]


@pytest.mark.slow
def test_the_table_of_decisions_adds_up(bidders, growers):
    figure = draw_figure("decisions", [bidders, growers], style="ieee-wide")
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts[:2] == ["decision", "reason"]
    assert {"closest", "srt-radial"} <= set(texts)
    totals = [int(texts[k - 1].replace(",", "")) for k, t in enumerate(texts) if t.endswith("%")]
    kinds = Decision | GoalChosen | Decided
    decisions = [e for run in (bidders, growers) for e in run.events if isinstance(e, kinds)]
    assert sum(totals) == len(decisions)
    for run in (bidders, growers):
        for choice in set().union(*decision_counts(run)):
            for name in choice:
                assert any(text.startswith(f"{name}: ") for text in texts), name


@pytest.mark.slow
def test_texts_of_the_table_do_not_overlap(bidders, growers):
    for style in ("ieee", "springer", "screen"):
        figure = draw_figure("decisions", [bidders, growers], style=style)
        boxes = [t.get_window_extent() for t in figure.axes[0].texts]
        shapes = [shapely.box(b.x0, b.y0, b.x1, b.y1) for b in boxes]
        pairs = shapely.STRtree(shapes).query(shapes, predicate="overlaps").T
        assert pairs.tolist() == []
        assert max(b.x1 for b in boxes) <= figure.bbox.x1
        assert min(b.x0 for b in boxes) >= 0.0


def test_runs_with_other_options_and_limits_have_curves_of_their_own(ax):
    def recording(seed: int, **changes: Any) -> ms.Recording:
        given: dict[str, Any] = {"strategy": "minpos", "robots": 2, "base": (5.0, 5.0)}
        given |= {"max_time_s": 4.0}
        return ms.explore("open", seed=seed, **(given | changes)).recording

    runs = [
        recording(0),
        recording(1, base=(4.0, 4.0)),
        recording(0, options={"replan": "arrival"}),
        recording(0, robots=1, max_time_s=3.0),
    ]
    labels = [str(line.get_label()) for line in draw_coverage(runs, ax)]
    assert labels == [
        "minpos, 2 robots, scattered starts, at most 4 s (2 runs)",
        "minpos, 2 robots, scattered starts, replan = arrival, at most 4 s",
        "minpos, 2 robots, scattered starts, replan = arrival, at most 4 s, at the base",
        "minpos, 1 robot, at most 3 s",
        "minpos, 1 robot, at most 3 s, at the base",
    ]
