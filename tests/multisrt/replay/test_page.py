"""The page in a browser: opened from a file, as a user does."""

import re
import time
from pathlib import Path

import msgspec
import numpy as np
import pytest
import shapely

from multisrt.analysis.poses import poses
from multisrt.events import Decided, Decision, GoalChosen, Learned, NodeAdded
from multisrt.explain.srt import explain
from multisrt.recording import Recording
from multisrt.replay import replay_html, save_replay
from tests.multisrt.drawing.recordings import recorded
from tests.multisrt.replay.staged import OTHER, SHOWN_S, staged

pytestmark = pytest.mark.slow

DESKTOP, PHONE = {"width": 1300, "height": 850}, {"width": 390, "height": 844}
SETTLED = "!replay.player.isWaiting && replay.player.isComplete"
BELOW = "document.querySelector('.view .below').toDataURL()"
PICTURE = "[...document.querySelectorAll('.view canvas')].map((c) => c.toDataURL()).join()"


class Shown:
    """A page that is open, and what went wrong on it."""

    def __init__(self, page, url):
        self.page, self.url = page, url
        self.errors: list[str] = []
        self.asked: list[str] = []
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", self.hear)
        page.on("request", lambda request: self.asked.append(request.url))

    def hear(self, message):
        if message.type in ("error", "warning"):
            self.errors.append(message.text)

    def open(self, address=""):
        self.page.goto("about:blank")
        self.page.goto(self.url + address)
        self.until("!!window.replay")
        self.settle()
        return self

    def settle(self):
        self.until(SETTLED)

    def until(self, expression, timeout_s=20.0):
        # The page's policy forbids what wait_for_function does: to evaluate text within it.
        late = time.monotonic() + timeout_s
        while not self.page.evaluate(expression):
            assert time.monotonic() < late, expression
            self.page.wait_for_timeout(20)

    def text(self, selector):
        return self.page.locator(selector).text_content()

    def value(self, expression):
        return self.page.evaluate(expression)


@pytest.fixture(scope="module")
def files(tmp_path_factory, team_run, bidding_run):
    folder = tmp_path_factory.mktemp("replays")
    save_replay(team_run.recording, folder / "team.html")
    save_replay([team_run.recording, bidding_run.recording], folder / "both.html")
    save_replay(bidding_run.recording, folder / "bids.html")
    save_replay(staged(), folder / "staged.html")
    save_replay([team_run.recording, bidding_run.recording, staged()], folder / "three.html")
    save_replay([staged()] * 4, folder / "four.html")
    return folder


@pytest.fixture
def shown(browser, files, request):
    opened = []

    def show(name="team", address="", **options):
        context = browser.new_context(**{"viewport": DESKTOP} | options)
        page = Shown(context.new_page(), (files / f"{name}.html").as_uri())
        opened.append((context, page))
        return page.open(address)

    yield show
    for context, page in opened:
        assert page.errors == []
        assert all(url.startswith(("file:", "about:", "blob:")) for url in page.asked)
        context.close()


def test_it_opens_from_a_file_and_asks_for_nothing_else(shown, files, team_run):
    page = shown()
    assert page.page.title() == "srt-radial in apartment: replay"
    assert page.text("#clock") == f"0.0 / {team_run.recording.footer.time_s:.1f} s"
    text = (files / "team.html").read_text(encoding="utf-8")
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy.startswith("default-src 'none'; script-src &#39;sha256-")
    assert "unsafe" not in policy


def test_robots_are_where_they_were(shown, team_run):
    page = shown()
    times = np.linspace(0.0, team_run.recording.footer.time_s, 101)
    drawn = np.array([page.value(f"replay.poses({at})") for at in times])
    true = poses(team_run.recording, times)
    np.testing.assert_allclose(drawn[:, :, :2].swapaxes(0, 1), true[:, :, :2], atol=0.0025)
    turned = drawn[:, :, 2].T - true[:, :, 2]
    np.testing.assert_allclose(np.sin(turned / 2.0), 0.0, atol=0.004)


def test_it_plays_and_pauses(shown):
    page = shown(address="#t=0&speed=5")
    page.page.click("#play")
    assert page.page.get_attribute("#play", "aria-label") == "Pause"
    page.until("replay.player.time > 2")
    page.page.keyboard.press("Escape")
    page.page.locator("#scrub").focus()
    page.page.keyboard.press(" ")
    now = page.value("replay.player.time")
    assert page.text("#said") == f"paused at {now:.2f} s"
    page.page.wait_for_timeout(100)
    assert page.value("replay.player.time") == now
    assert page.page.locator("#said").get_attribute("aria-live") == "polite"


def test_it_stops_at_the_end_and_starts_again(shown):
    page = shown(address="#t=59.5&speed=100")
    page.page.click("#play")
    page.until("!replay.player.isPlaying")
    assert page.value("replay.player.time == replay.player.end")
    page.page.click("#play")
    page.until("replay.player.time > 0 && replay.player.time < 50")
    page.page.click("#play")


def test_it_goes_to_a_time(shown):
    page = shown()
    page.page.locator("#scrub").fill("30")
    assert page.text("#clock").startswith("30.0 /")
    assert page.page.get_attribute("#scrub", "aria-valuetext").startswith("30.0 s of")
    end = page.value("replay.player.end")
    click_plot(page, ".curve .plot", 0.25, 0.5)
    assert page.value("replay.player.time") == pytest.approx(end / 4, abs=0.5)
    click_plot(page, ".strip .plot", 0.5, 0.9)
    assert page.value("replay.player.time") == pytest.approx(end / 2, abs=0.5)
    assert page.value("replay.player.robot") == 2
    # The number of a row chooses the robot, and the time stays.
    page.page.locator(".strip .plot").click(position={"x": 40, "y": 12})
    assert page.value("replay.player.robot") == 0
    assert page.value("replay.player.time") == pytest.approx(end / 2, abs=0.5)


def click_plot(page, selector, across, down):
    """Click on a plot, at shares of the width and height that its axes enclose."""
    box = page.page.locator(selector).first.bounding_box()
    left, right, top, bottom = 46, 14, 6, 17
    x = left + across * (box["width"] - left - right)
    y = top + down * (box["height"] - top - bottom)
    page.page.mouse.click(box["x"] + x, box["y"] + y)


def test_going_back_gives_the_same_picture(shown):
    page = shown(address="#t=20")
    once = page.value(PICTURE)
    for at in (55, 3, 20):
        page.value(f"replay.player.seek({at})")
        page.settle()
    assert page.value(PICTURE) == once


def test_a_map_that_is_being_drawn_says_so(shown):
    page = shown(address="#t=0")
    assert page.page.locator(".view .drawing").is_hidden()
    # Time flies, so that little of a picture is drawn in one frame.
    page.value(
        """(() => {
            const { player } = replay, paint = player.paint.bind(player);
            let now = performance.now();
            performance.now = () => (now += 50);
            window.noted = [];
            player.paint = (time) => {
                paint(time);
                const busy = player.views[0].element.getAttribute("aria-busy");
                noted.push([!player.views[0].drawing.hidden, busy, player.isThere]);
            };
            player.seek(59);
        })()"""
    )
    page.settle()
    noted = page.value("noted")
    assert any(is_noted for is_noted, *_ in noted)
    assert {(busy, is_there) for is_noted, busy, is_there in noted if is_noted} == {("true", False)}
    assert page.page.locator(".view .drawing").is_hidden()
    assert page.page.get_attribute(".view", "aria-busy") == "false"


def test_the_panel_keeps_up_with_the_clock(shown):
    page = shown(address="#t=0&robot=1&speed=100")
    page.value(
        """(() => {
            const { player } = replay, paint = player.paint.bind(player);
            const why = document.getElementById("why");
            window.late = [];
            player.paint = (time) => {
                paint(time);
                late.push(player.time - Number(/at ([0-9.]+) s/.exec(why.textContent)[1]));
            };
            player.play();
        })()"""
    )
    page.until("!replay.player.isPlaying")
    late = page.value("late")
    assert len(late) > 5
    assert max(late) < 0.51


@pytest.mark.parametrize("layer", ["frontier", "paths"])
def test_nothing_of_another_time_is_drawn(shown, layer):
    without = shown(address="#t=0&layers=truth").value(BELOW)
    page = shown(address=f"#t=0&layers=truth,{layer}")
    # Time flies, so that little of a picture is drawn in one frame.
    page.value(
        """(() => {
            const { player } = replay, paint = player.paint.bind(player);
            let now = performance.now();
            performance.now = () => (now += 50);
            window.painted = [];
            player.paint = (time) => { paint(time); painted.push(BELOW); };
            player.seek(59);
        })()""".replace("BELOW", BELOW)
    )
    page.settle()
    *first, last = page.value("painted")
    assert last != without
    assert first
    assert set(first) <= {without, last}


def test_what_plays_waits_for_its_pictures(shown):
    page = shown(address="#t=0&layers=trees,regions,frontier&speed=100")
    page.value(
        """(() => {
            const { player } = replay, paint = player.paint.bind(player);
            let now = performance.now();
            performance.now = () => (now += 1);
            window.painted = [];
            player.paint = (time) => {
                paint(time);
                painted.push([player.time, player.isThere, player.views[0].ground.isThere]);
            };
            player.play();
        })()"""
    )
    page.until("!replay.player.isPlaying")
    painted = page.value("painted")
    assert len(painted) > 5
    assert all(is_there and of_ground for _, is_there, of_ground in painted)
    assert painted[-1][0] == page.value("replay.player.end")


def test_keys(shown):
    page = shown("staged")
    press = page.page.keyboard.press
    said = []
    for _ in range(5):
        press("ArrowRight")
        said.append(page.text("#said"))
    assert said[0] == "0.00 s, robot 0: added node 0 (root)"
    assert said[2:4] == [
        "0.00 s, robot 2: added node 0 (root)",
        "2.00 s, robot 0: added node 1 (random draw)",
    ]
    press("ArrowLeft")
    press("ArrowLeft")
    assert page.text("#said") == said[2]
    press("End")
    assert page.value("replay.player.time") == 100.0
    press("ArrowRight")
    assert page.text("#said") == "no later event"
    press("Home")
    press("Shift+ArrowRight")
    assert page.value("replay.player.time") == 1.0
    press("1")
    assert page.value("replay.player.robot") == 1
    press("ArrowRight")
    assert page.text("#said") == "2.00 s, robot 1: added node 1 (approach)"
    press("7")
    assert page.text("#said") == "there is no robot 7"
    press("Escape")
    assert page.value("replay.player.robot") == -1
    press("+")
    assert page.page.locator("#speed").input_value() == "20"
    press("-")
    assert page.page.locator("#speed").input_value() == "10"
    press("?")
    assert page.page.locator("#keys").is_visible()
    press("Escape")
    press("f")
    assert page.page.locator("#rate").is_visible()
    # Also with Caps Lock.
    press("F")
    assert page.page.locator("#rate").is_hidden()
    theme = page.page.get_attribute("html", "data-theme")
    press("D")
    assert page.page.get_attribute("html", "data-theme") != theme
    page.value("replay.player.views[0].zoom(2, 100, 100)")
    press("z")
    assert page.value("replay.player.views[0].isWhole")


def test_decisions_are_stepped_through(shown):
    page = shown("staged")
    press = page.page.keyboard.press
    said = []
    for _ in range(3):
        press(".")
        said.append(page.text("#said"))
    assert [text.split(": decided")[0] for text in said[:2]] == [
        "5.00 s, robot 0",
        "5.00 s, robot 1",
    ]
    assert said[2] == "no later decision"
    press(",")
    assert page.text("#said") == said[0]
    press(",")
    assert page.text("#said") == "no earlier decision"
    page.page.keyboard.press("1")
    press("Home")
    page.page.click("#next-decision")
    assert page.text("#said") == said[1]
    # All events go on from there.
    press("ArrowRight")
    assert "organised robots" in page.text("#said")
    page.page.click("#previous-decision")
    assert page.text("#said") == said[1]


def test_decisions_of_two_runs_are_stepped_through(shown, team_run, bidding_run):
    page = shown("both")
    kinds = (Decision, GoalChosen)
    times = sorted(
        event.time_s
        for run in (team_run, bidding_run)
        for event in run.recording.events
        if isinstance(event, kinds)
    )
    step = "replay.player.step({}, true), replay.player.time"
    on = [page.value(step.format(1)) for _ in times]
    assert on == pytest.approx(times, abs=1e-3)
    back = [page.value(step.format(-1)) for _ in times[1:]]
    assert back == pytest.approx(times[-2::-1], abs=1e-3)


def test_the_event_that_is_shown_is_marked(shown):
    page = shown("staged")
    current = page.page.locator("#events [aria-current=true]")
    assert current.count() == 0
    for expected in ("robot 0: added node 0 (root)", "robot 1: added node 0 (root)"):
        page.page.keyboard.press("ArrowRight")
        assert expected in current.text_content()


def test_nodes_are_chosen_by_keys(shown):
    page = shown("staged", "#t=5.5")
    press, said = page.page.keyboard.press, lambda: page.text("#said").split(" at ")[0]
    press("1")
    press("n")
    assert said() == "Node 1 of robot 1"
    press("n")
    assert said() == "Node 0 of robot 1"
    assert page.page.locator("#node").is_visible()
    press("n")
    assert said() == "no earlier node"
    page.value("replay.player.views[0].zoomBy(30)")
    press("Shift+N")
    assert said() == "Node 1 of robot 1"
    assert page.value("replay.player.robot") == 1
    view = "replay.player.views[0]"
    x, y, width, height = page.value(
        f"[{view}.x({OTHER[0]}), {view}.y({OTHER[1]}), {view}.width, {view}.height]"
    )
    assert 0 < x < width
    assert 0 < y < height


def test_keys_zoom_and_move_the_map(shown):
    page = shown("staged", "#t=5.5")
    left, bottom, scale = page.value(CAMERA)
    page.page.keyboard.press("Alt+ArrowDown")
    assert page.value(CAMERA) == [left, bottom, scale]
    page.page.locator(".view .top").focus()
    page.page.keyboard.press("Alt+ArrowRight")
    page.page.keyboard.press("Alt+ArrowUp")
    moved = page.value(CAMERA)
    assert moved[0] > left
    assert moved[1] > bottom
    page.page.keyboard.press("i")
    assert page.value(CAMERA)[2] == pytest.approx(1.25 * scale)
    page.page.keyboard.press("o")
    assert page.value(CAMERA) == pytest.approx(moved)
    assert page.value("replay.player.time") == 5.5


CAMERA = "(({ left, bottom, scale }) => [left, bottom, scale])(replay.player.views[0].camera)"


def test_the_map_is_dragged_zoomed_and_shown_whole(shown):
    page = shown("staged", "#t=12")
    whole = page.value(CAMERA)
    box = page.page.locator(".view").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(x + 60, y + 30, steps=5)
    page.page.mouse.up()
    left, bottom, scale = page.value(CAMERA)
    assert scale == whole[2]
    assert left == pytest.approx(whole[0] - 60 / scale)
    assert bottom == pytest.approx(whole[1] + 30 / scale)
    assert page.value("replay.player.robot") == -1
    page.page.mouse.wheel(0, -300)
    page.until(f"{CAMERA}[2] > {1.5 * scale}")
    page.settle()
    page.page.mouse.dblclick(x, y)
    assert page.value(CAMERA) == pytest.approx(whole)


def test_fingers_move_and_zoom_the_map(shown):
    page = shown("staged", "#t=12", viewport=PHONE, has_touch=True, is_mobile=True)
    protocol = page.page.context.new_cdp_session(page.page)

    def touch(kind, *places):
        points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
        protocol.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    left, _, scale = page.value(CAMERA)
    touch("touchStart", (200, 200))
    for k in range(6):
        touch("touchMove", (200 + 10 * k, 200))
    touch("touchEnd")
    assert page.value(CAMERA)[0] == pytest.approx(left - 50 / scale)
    touch("touchStart", (150, 200), (250, 200))
    for k in range(6):
        touch("touchMove", (150 - 10 * k, 200), (250 + 10 * k, 200))
    touch("touchEnd")
    assert page.value(CAMERA)[2] == pytest.approx(2 * scale, rel=0.05)
    assert page.value("scrollY") == 0


def test_what_is_chosen_is_read_out(shown):
    page = shown("staged", "#t=5.5")
    page.page.keyboard.press("1")
    assert page.text("#said").startswith("Robot 1 at 5.50 s: its last decision was at 5.00 s.")
    assert page.page.locator("#said").evaluate("(one) => one.scrollWidth <= one.clientWidth")
    # The clock would be read out in every frame.
    assert page.page.get_attribute("#clock", "aria-live") == "off"
    assert "it chose random draw" in page.text("#said")
    page.page.keyboard.press("Escape")
    assert page.text("#said") == "map of the team"
    click(page, 6.0, 4.0)
    assert page.text("#said").startswith("Node 0 of robot 1 at (6.00, 4.00)")
    page.page.keyboard.press("0")
    assert page.text("#said").startswith("Robot 0 at 5.50 s: ")


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


def click(page, x, y):
    view = "replay.player.views[0]"
    px, py, ratio = page.value(f"[{view}.x({x}), {view}.y({y}), {view}.camera.ratio]")
    page.page.locator(".view .top").first.click(position={"x": px / ratio, "y": py / ratio})


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


def test_an_address_is_followed_and_kept(shown):
    page = shown(address="#t=12.5&robot=2&layers=trees,truth&speed=50")
    state = "((p) => [p.time, p.robot, [...p.layers].join(), p.pace])(replay.player)"
    assert page.value(state) == [12.5, 2, "truth,trees", 50]
    page.value("location.hash = '#t=20&robot=1'")
    page.until("replay.player.time === 20 && replay.player.robot === 1")
    page.page.locator("#scrub").fill("30")
    page.until("location.hash.includes('t=30')")
    again = shown(address=page.value("location.hash"))
    assert again.value(state) == page.value(state)


def test_what_is_ignored_of_an_address_is_named(shown):
    page = shown(address="#t=20")
    assert page.page.locator("#ignored").is_hidden()
    page.value("location.hash = '#t=abc&robot=99&foo=1&layers=trees,none&speed=3'")
    page.until("!document.getElementById('ignored').hidden")
    end = page.value("replay.player.end")
    assert page.text("#ignored-text") == (
        "Ignored in the address: robot=99 (robots are 0 to 2); "
        "speed=3 (not one of 0.5, 1, 2, 5, 10, 20, 50, 100); layers=none (no such layer); "
        f"t=abc (not a time from 0 to {end:.1f} s); foo=1 (not known)."
    )
    assert page.page.locator("#ignored").get_attribute("role") == "status"
    page.page.locator("#ignored").get_by_role("button", name="Close").click()
    assert page.page.locator("#ignored").is_hidden()


def test_a_broken_address_does_no_harm(shown):
    page = shown()
    for address in ("#t=x&robot=99&run=7&speed=3&layers=none", "#t=-5", "#t=1e9", "#%"):
        page.open(address)
        assert 0.0 <= page.value("replay.player.time") <= page.value("replay.player.end")
        assert page.value("replay.player.robot") == -1


def test_a_phone_on_its_side_has_one_column(shown):
    page = shown(address="#t=20", viewport={"width": 844, "height": 390}, is_mobile=True)
    assert page.value("document.documentElement.scrollWidth") <= 844
    assert page.page.locator("#stage").bounding_box()["height"] > 200
    assert page.page.locator("#side").bounding_box()["width"] > 800
    for control in ("#previous-decision", "#play", "#next-decision", "#scrub", "#clock", "#speed"):
        box = page.page.locator(control).bounding_box()
        assert 0 <= box["x"] < box["x"] + box["width"] <= 844
        assert box["y"] + box["height"] <= 390


@pytest.mark.parametrize("name", ["team", "both"])
def test_it_fits_a_phone(shown, name):
    page = shown(name, "#t=20", viewport=PHONE, has_touch=True, is_mobile=True)
    assert page.value("document.documentElement.scrollWidth") <= PHONE["width"]
    assert page.value(
        "((title) => title.scrollWidth <= title.clientWidth)(document.querySelector('h1'))"
    )
    for control in ("#play", "#previous", "#next", "#scrub", "#speed"):
        box = page.page.locator(control).bounding_box()
        assert 0 <= box["x"] < box["x"] + box["width"] <= PHONE["width"]
        assert box["y"] + box["height"] <= PHONE["height"]
    page.page.locator("#play").tap()
    page.until("replay.player.time > 20.2")
    page.page.locator("#play").tap()
    assert not page.value("document.getElementById('fold-layers').open")
    page.page.locator("#fold-layers summary").tap()
    assert page.page.locator("#layers input[name=trees]").is_visible()


def test_curves_and_strips_have_axes(shown):
    page = shown(address="#t=20")
    # The texts that are drawn, when all is drawn anew.
    page.value(
        """(() => {
            const { prototype } = CanvasRenderingContext2D, draw = prototype.fillText;
            window.drawn = [];
            prototype.fillText = function (text, ...where) {
                drawn.push(text);
                draw.call(this, text, ...where);
            };
            replay.player.lines.redraw();
            prototype.fillText = draw;
        })()"""
    )
    drawn = page.value("drawn")
    assert {"0 %", "100 %", "0", "20", "60 s", "0 m", "robot", "1", "2"} <= set(drawn)


def test_what_a_radio_without_limit_makes_of_curves(shown):
    page = shown("bids", "#t=20")
    titles = page.page.locator(".curve figcaption span").all_text_contents()
    assert titles == ["Covered (seen: thin line)", "Distance driven, all robots"]
    assert page.text("#curves .without") == "No robot is ever cut off: radio unlimited."
    both = shown("both", "#t=20")
    values = both.page.locator(".curve figcaption b").all_text_contents()
    assert values[1] == "0 | radio unlimited"


def test_the_legend_chooses_robots(shown):
    page = shown("both", "#t=20")
    legend = page.page.locator("#legend button")
    assert legend.all_text_contents() == ["0", "1", "2"]
    colours = legend.locator(".swatch").evaluate_all(
        "(all) => all.map((one) => getComputedStyle(one).backgroundColor)"
    )
    assert len(set(colours)) == 3
    page.page.get_by_role("button", name="Robot 2", exact=True).click()
    assert page.value("replay.player.robot") == 2
    assert legend.nth(2).get_attribute("aria-pressed") == "true"
    page.page.locator("#run").select_option("1")
    assert legend.nth(2).is_disabled()
    page.page.get_by_role("button", name="Robot 1", exact=True).click()
    page.page.get_by_role("button", name="Robot 1", exact=True).click()
    assert page.value("replay.player.robot") == -1


def test_numbers_of_robots_do_not_cover_one_another(shown):
    page = shown(address="#t=0")
    boxes = page.value(
        """replay.player.views[0].marks.bodies.shapes.map((shape, k) => {
            const { bodies } = replay.player.views[0].marks, width = bodies.sprite(String(k)).width;
            return [bodies.box(shape, bodies.seats[k], 0.7 * width), shape];
        })"""
    )
    assert len(boxes) == 3
    for k, (box, shape) in enumerate(boxes):
        for other, other_shape in boxes[k + 1 :]:
            apart = abs(box["x"] - other["x"]), abs(box["y"] - other["y"])
            assert apart[0] >= box["width"] or apart[1] >= box["height"]
            assert (
                np.hypot(box["x"] - other_shape["x"], box["y"] - other_shape["y"]) > shape["size"]
            )


def test_it_follows_and_switches_the_theme(shown):
    page = shown(color_scheme="dark")
    assert page.page.get_attribute("html", "data-theme") == "dark"
    dark = page.value(PICTURE)
    page.page.click("#theme")
    page.settle()
    assert page.page.get_attribute("html", "data-theme") == "light"
    assert page.value(PICTURE) != dark


def test_every_control_has_a_name(shown):
    page = shown("both", "#t=20&robot=1")
    nameless = page.value(
        """[...document.querySelectorAll("button, input, select, canvas[tabindex], pre[tabindex]")]
        .filter((e) => e.checkVisibility() && !(e.getAttribute("aria-label")
          || (e.tagName === "BUTTON" && e.textContent.trim()) || (e.labels && e.labels.length)))
        .map((e) => e.outerHTML)"""
    )
    assert nameless == []


def test_texts_with_markup_are_shown_and_never_run(browser, tmp_path):
    evil = '</script><img src=x onerror="window.stolen=1"><b>'
    made = recorded(
        [(2.0, 4.0)], [Decided(time_s=0.0, robot=0, text=evil, goal=(3.0, 4.0))], strategy="minpos"
    )
    header = msgspec.structs.replace(made.header, world=evil)
    made = Recording(header=header, events=made.events, footer=made.footer)
    save_replay(made, tmp_path / "replay.html")
    page = Shown(browser.new_page(), (tmp_path / "replay.html").as_uri()).open("#t=1&robot=0")
    assert page.page.title() == f"minpos in {evil}: replay"
    assert evil in page.text(".view .name")
    assert evil in page.text("#why")
    assert evil in page.text("#events")
    assert page.page.locator("img").count() == 0
    assert page.value("window.stolen === undefined")
    assert page.errors == []
    page.page.close()


def test_an_old_browser_is_told_so(browser, files):
    page = browser.new_page()
    page.add_init_script("delete window.DecompressionStream")
    page.goto((files / "team.html").as_uri())
    page.wait_for_selector("#problem:not([hidden])")
    assert "too old for the replay" in page.text_content("#problem")
    page.close()


def test_motion_is_reduced_for_those_who_ask(shown):
    page = shown("staged", "#t=6.1", reduced_motion="reduce")
    assert page.value("replay.player.isStill")


def test_the_script_never_writes_markup():
    folder = Path(replay_html.__code__.co_filename).parent
    sources = "".join(path.read_text(encoding="utf-8") for path in folder.glob("*.js"))
    assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(", sources)
