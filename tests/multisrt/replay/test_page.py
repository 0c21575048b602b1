"""The page in a browser: opened from a file, as a user does."""

import re
from pathlib import Path

import msgspec
import numpy as np
import pytest

from multisrt.analysis.poses import poses
from multisrt.events import Decided
from multisrt.recording import Recording
from multisrt.replay import replay_html, save_replay
from tests.multisrt.drawing.recordings import recorded
from tests.multisrt.replay.shown import PHONE, PICTURE, Shown

pytestmark = pytest.mark.slow


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
