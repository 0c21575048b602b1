"""The clock, keys, buttons and the pointer of the page in a browser."""

import pytest

from multisrt.events import Decision, GoalChosen
from tests.multisrt.replay.shown import BELOW, PHONE, PICTURE, click
from tests.multisrt.replay.staged import OTHER

pytestmark = pytest.mark.slow


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
