"""What the page shows and says of runs, in a browser."""

import itertools

import pytest
import shapely

import multisrt as ms
from multisrt.events import BaseLearned, GoalChosen, Learned, NodeAdded
from multisrt.explain.srt import explain
from multisrt.replay import save_replay
from tests.multisrt.drawing.recordings import recorded
from tests.multisrt.replay.shown import BELOW, PICTURE, Shown, click
from tests.multisrt.replay.staged import OTHER, SHOWN_S, staged

pytestmark = pytest.mark.slow


def test_each_layer_has_a_switch_and_draws_something(shown):
    page = shown("staged", "#t=0&layers=", viewport={"width": 900, "height": 600})
    names = page.value("[...document.querySelectorAll('#layers input')].map((box) => box.name)")
    assert sorted(names) == sorted(SHOWN_S)
    for layer, time_s in SHOWN_S.items():
        page.value(f"replay.player.seek({time_s})")
        page.settle()
        without = page.value(PICTURE)
        page.page.locator(f"#layers input[name={layer}]").check()
        page.settle()
        assert page.value(PICTURE) != without, layer
        page.page.locator(f"#layers input[name={layer}]").uncheck()
        page.settle()
        assert page.value(PICTURE) == without, layer


def test_it_tells_what_multisrt_why_tells(shown, team_run):
    page = shown()
    for robot in range(3):
        page.page.locator("#robot").select_option(str(robot))
        for at in (0.0, 7.31, 23.75, 60.0):
            page.value(f"replay.player.seek({at})")
            assert page.text("#why") == explain(team_run.recording, robot, at).rstrip("\n")


def test_messages_are_those_of_the_chosen_robot(shown):
    page = shown("staged", "#t=6.1&layers=messages")
    page.value(
        """(() => {
            const { marks } = replay.player.views[0], arrow = marks.arrow.bind(marks);
            window.arrows = 0;
            marks.arrow = (...ends) => { arrows++; arrow(...ends); };
        })()"""
    )
    # Robot 0 sends one to robot 1, which robot 2 does not receive.
    for robot, count in (("0", 2), ("1", 1), ("2", 1)):
        page.value("window.arrows = 0")
        page.page.keyboard.press(robot)
        page.settle()
        assert page.value("arrows") == count


def test_tables_are_not_wrapped(shown):
    page = shown("bids", "#t=12.34&robot=1")
    table = page.page.locator("#why .table")
    assert "frontier  " in table.first.text_content()
    lines = table.first.text_content().strip("\n").count("\n") + 1
    height, line = table.first.evaluate(
        "(one) => [one.clientHeight, parseFloat(getComputedStyle(one).lineHeight)]"
    )
    assert lines <= height / line < lines + 1
    assert page.page.locator("#why").evaluate("(one) => one.scrollWidth <= one.clientWidth")


def test_it_tells_why_robots_chose_frontiers(shown, bidding_run):
    page = shown("both", "#t=12.34&run=1&robot=1")
    assert page.text("#why") == explain(bidding_run.recording, 1, 12.34).rstrip("\n")
    assert bidding_run.recording.of(GoalChosen)


def test_a_click_on_a_robot_or_a_node_explains_it(shown):
    page = shown("staged", "#t=5.5")
    click(page, *OTHER)
    assert page.value("replay.player.robot") == 1
    assert page.text("#why") == explain(staged(), 1, 5.5).rstrip("\n")
    assert "it chose random draw" in page.text("#why")
    page.page.keyboard.press("Escape")
    click(page, 6.0, 4.0)  # the root of robot 1, which has left it
    assert page.value("replay.player.robot") == -1
    assert page.page.locator("#robot").input_value() == "-1"
    assert page.page.locator("#node").is_visible()
    assert page.text("#node").startswith("Node 0 of robot 1 at (6.00, 4.00): added at 0.00 s")
    page.page.get_by_role("button", name="Close").click()
    assert page.page.locator("#node").is_hidden()


def test_the_way_to_a_node_is_explained(shown, team_run):
    page = shown(address="#t=60")
    last = max(team_run.recording.of(NodeAdded), key=lambda node: node.time_s)
    number = team_run.recording.of(NodeAdded).index(last)
    page.value(f"replay.player.pick(0, {{ robot: {last.robot}, node: {number} }})")
    page.page.get_by_role("button", name=f"Why robot {last.robot} went there").click()
    assert page.value("replay.player.robot") == last.robot
    assert page.page.locator("#node").is_visible()
    assert 0.0 < page.value("replay.player.time") < last.time_s
    assert "What it decided" in page.text("#why")


def test_a_robot_has_a_map_of_its_own(shown, team_run):
    page = shown(address="#t=20")
    recording = team_run.recording
    for robot in range(3):
        made = [e for e in recording.of(NodeAdded) if e.robot == robot and e.time_s <= 20.0]
        learned = [e for e in recording.of(Learned) if e.robot == robot and e.time_s <= 20.0]
        count = len(made) + sum(len(event.nodes) for event in learned)
        known = page.value(
            f"[...replay.player.runs[0].knownBy({robot}).t].filter((t) => t <= 20).length"
        )
        assert known == count
    of_team = page.value(PICTURE)
    page.page.locator("#robot").select_option("0")
    page.settle()
    assert page.value(PICTURE) != of_team


def test_the_frontier_is_that_of_the_union_of_regions(shown, team_run):
    page = shown()
    nodes = team_run.recording.of(NodeAdded)
    for at in (0.0, 15.0, 59.0):
        known = [node for node in nodes if node.time_s <= at]
        edges = shapely.MultiLineString([edge for node in known for edge in frontier_edges(node)])
        covered = shapely.union_all([shapely.Polygon(node.boundary) for node in known])
        true = shapely.difference(edges, covered.buffer(-2e-3))
        drawn = shapely.MultiLineString(page.value(f"replay.frontier({at})"))
        assert drawn.length == pytest.approx(true.length, rel=0.15)
        assert shapely.difference(drawn, true.buffer(0.02)).length == 0.0
        # What is left is short, or an edge on which two regions meet.
        left = shapely.get_parts(shapely.difference(true, drawn.buffer(0.02)))
        assert shapely.length(left)[shapely.length(left) > 0.1].sum() < 0.05 * true.length


def frontier_edges(node):
    corners = [*node.boundary, node.boundary[0]]
    return [corners[k : k + 2] for k, tag in enumerate(node.tags) if tag in "12"]


def test_two_runs_stand_side_by_side_on_one_clock(shown, team_run, bidding_run):
    page = shown("both", "#t=30")
    assert page.page.locator(".view").count() == 2
    assert page.page.locator(".view .name").all_text_contents() == [
        "srt-radial in apartment, seed 1",
        "minpos in apartment, seed 1",
    ]
    ends = [run.recording.footer.time_s for run in (team_run, bidding_run)]
    assert page.value("replay.player.end") == pytest.approx(max(ends), abs=1e-3)
    page.page.locator("#run").select_option("1")
    page.page.locator("#robot").select_option("1")
    assert page.text("#why").startswith("Robot 1 at 30.00 s: it last chose a goal")
    page.page.keyboard.press("End")
    assert page.page.locator(".view.chosen .name").text_content().startswith("minpos")


def test_a_run_that_has_ended_or_lacks_the_robot_says_so(shown, bidding_run):
    page = shown("both", "#t=59&robot=2")
    states = page.page.locator(".view .state")
    end = bidding_run.recording.footer.time_s
    assert states.all_text_contents() == [
        "", f"no robot 2: map of the team; ended at {end:.1f} s"
    ]  # fmt: skip
    assert states.first.is_hidden()
    page.page.keyboard.press("Escape")
    page.value(f"replay.player.seek({end + 0.2})")
    page.settle()
    page.value("window.arrows = 0; replay.player.views[1].marks.arrow = () => arrows++; 0")
    page.value("replay.player.views[1].marks.draw(replay.player.runs[1].end)")
    assert page.value("arrows") == 0
    page.value(f"replay.player.seek({end - 0.1})")
    assert states.nth(1).is_hidden()


def test_runs_with_equal_names_are_numbered(shown):
    page = shown("four", "#t=12")
    names = page.page.locator(".view .name").all_text_contents()
    assert [name.rsplit(", ", 1)[1] for name in names] == ["run 1", "run 2", "run 3", "run 4"]
    assert page.page.locator("#curves .keys li").all_text_contents() == names


def test_what_a_run_was_made_with_is_told(shown):
    page = shown("staged")
    ended, made = page.page.locator("#about p").all_text_contents()[:2]
    assert ended.endswith("; robot 2 died at 20.0 s.")
    assert made.startswith("Set-up: 3 robots; scattered starts; radio 12 m; range finder 4 m;")


def test_the_map_has_a_legend(shown):
    page = shown("staged")
    assert page.page.locator("#symbols").is_hidden()
    page.page.locator("#fold-symbols summary").click()
    samples = page.page.locator("#symbols canvas").evaluate_all(
        "(all) => all.map((canvas) => canvas.toDataURL())"
    )
    words = page.page.locator("#symbols li").all_text_contents()
    assert len(set(samples)) == len(samples) == len(set(words)) == 24
    assert page.page.locator("#layers canvas").count() == len(SHOWN_S)
    page.page.click("#theme")
    again = page.page.locator("#symbols canvas").evaluate_all(
        "(all) => all.map((canvas) => canvas.toDataURL())"
    )
    assert not set(samples) & set(again)


def test_one_robot_has_nothing_of_a_team(browser, tmp_path):
    save_replay(recorded([(2.0, 4.0)], []), tmp_path / "replay.html")
    page = Shown(browser.new_page(), (tmp_path / "replay.html").as_uri()).open()
    titles = page.page.locator(".curve figcaption span").all_text_contents()
    assert titles[-1] == "Distance driven"
    assert not any("cut off" in text for text in (*titles, page.text("#lines"), page.text("#side")))
    names = page.value("[...document.querySelectorAll('#layers input')].map((box) => box.name)")
    assert not {"groups", "masters", "links", "messages"} & set(names)
    page.page.close()


@pytest.mark.parametrize(("name", "count"), [("three", 3), ("four", 4)])
def test_three_and_four_runs_stand_side_by_side(shown, name, count):
    page = shown(name, "#t=12")
    boxes = page.page.locator(".view").evaluate_all(
        "(all) => all.map((one) => one.getBoundingClientRect().toJSON())"
    )
    assert len(boxes) == count
    assert min(box["height"] for box in boxes) > 150
    for k, box in enumerate(boxes):
        for other in boxes[:k]:
            beside = box["left"] >= other["right"] or box["right"] <= other["left"]
            assert beside or box["top"] >= other["bottom"]
    assert page.page.locator(".strip").count() == count
    assert page.page.locator("#curves .keys li").count() == count
    # Layers of groups are on here, too.
    assert page.value("replay.player.layers.has('groups')")
    for number in range(count):
        page.page.locator(".view .top").nth(number).click(position={"x": 5, "y": 60})
        assert page.value("replay.player.run") == number
        assert page.page.locator(".view.chosen").count() == 1


def test_activities_can_be_told_apart_without_colours(shown):
    page = shown("staged")
    looks = page.page.locator("#strips .keys canvas").evaluate_all(
        """(all) => all.map((canvas) => {
            const { data } = canvas.getContext("2d").getImageData(0, 0, 64, 28);
            return Array.from({ length: 64 * 28 }, (_, k) => (data[4 * k + 3] > 127 ? 1 : 0)
              + (data[4 * k] > 250 && data[4 * k + 1] > 250 ? 1 : 0)).join("");
        })"""
    )
    names = page.page.locator("#strips .keys li").all_text_contents()
    assert len(set(looks)) == len(looks) == len(names) == 8


def test_what_the_base_station_knows_is_hatched(browser, tmp_path):
    # A robot that goes out of reach of the base station, and comes home.
    run = ms.explore(
        "apartment",
        strategy="minpos",
        start=(3.0, 3.6),
        base=(3.0, 3.6),
        radio_range_m=3.0,
        options={"home": "in-time"},
        max_time_s=80.0,
        seed=1,
    )
    save_replay(run.recording, tmp_path / "replay.html")
    learned = sorted({event.time_s for event in run.recording.of(BaseLearned)})
    away_s, home_s = max(itertools.pairwise(learned), key=lambda pair: pair[1] - pair[0])
    page = Shown(browser.new_page(), (tmp_path / "replay.html").as_uri()).open()
    assert "delivered" in page.value(
        "[...document.querySelectorAll('#layers input')].map((box) => box.name)"
    )
    page.value("replay.player.layers = new Set(['truth', 'delivered'])")
    pictures = []
    for time_s in (away_s + 0.01, home_s - 0.01, home_s + 0.01, away_s + 0.01):
        page.value(f"replay.player.seek({time_s})")
        page.settle()
        pictures.append(page.value(BELOW))
    # It stays as it is until the robot is heard again; and going back gives the same picture.
    assert pictures[0] == pictures[1] == pictures[3]
    assert pictures[2] != pictures[1]
    # The numbers of its nodes and times are those of the recording.
    nodes = page.value("replay.player.chosen.delivered.nodes.length")
    assert nodes == sum(len(event.nodes) for event in run.recording.of(BaseLearned))
    page.page.close()
