"""The page of a run that goes on, in a browser: it follows, and stays as its reader left it."""

import re
import time
from contextlib import contextmanager

import pytest

import multisrt as ms
from multisrt.replay import LiveReplay, live
from tests.multisrt.replay.shown import DESKTOP, Shown

pytestmark = pytest.mark.slow

READY = "!!window.replay && !('goingOn' in document.documentElement.dataset)"


@pytest.fixture
def page(browser, tmp_path, monkeypatch):
    """A stepper, a function that writes the page of what it has done, and the page in a browser."""
    monkeypatch.setattr(live, "PAUSE_S", 0.3)
    monkeypatch.setattr(live, "MAX_SHARE", 1e9)
    stepper = ms.Stepper("apartment", robots=2, seed=1, starts="clustered", max_time_s=60.0)
    replay = LiveReplay(tmp_path / "replay.html")

    def go_on(time_s):
        stepper.run_until(time_s=time_s)
        replay._next_s = 0.0
        replay.look(lambda: stepper.recording)

    go_on(5.0)
    context = browser.new_context(viewport=DESKTOP)
    shown = Live(context.new_page(), (tmp_path / "replay.html").as_uri())
    shown.open()
    yield shown, go_on, replay, stepper
    assert shown.errors == []
    assert all(url.startswith(("file:", "about:", "blob:")) for url in shown.asked)
    context.close()


class Live(Shown):
    """A page that may be read anew at any time."""

    def value(self, expression):
        from playwright.sync_api import Error

        try:
            return self.page.evaluate(expression)
        except Error as error:
            # Between two pages there is nothing to evaluate.
            if "context was destroyed" not in str(error):
                raise
            return None

    def until(self, expression, timeout_s=20.0):
        late = time.monotonic() + timeout_s
        while not self.value(f"{READY} && ({expression})"):
            assert time.monotonic() < late, expression
            self.page.wait_for_timeout(20)

    @contextmanager
    def held(self, expression="true"):
        """Wait for something, and keep the page from being read anew meanwhile."""
        self.until(f"({expression}) && (replay.live.isHeld = true)")
        yield
        # A page that is just read anew is not held.
        self.value(f"{READY} && (replay.live.isHeld = false)")


def test_it_follows_the_run_to_its_end_and_keeps_what_is_chosen(page):
    shown, go_on, replay, stepper = page
    with shown.held("replay.player.end >= 5"):
        first = shown.value("replay.player.end")
        assert shown.value("replay.player.time") == first
        shown.page.uncheck("#layers input[name=seen]")
        shown.page.keyboard.press("1")
        shown.page.locator("#fold-events summary").click()
        shown.value("replay.player.views[0].zoom(2, 300, 200)")
        scale = shown.value("replay.player.views[0].camera.scale")
    go_on(15.0)
    with shown.held("replay.player.end > 14 && !replay.player.views[0].isWhole"):
        assert shown.value("replay.player.time") == shown.value("replay.player.end") > first
        assert not shown.value("replay.player.layers.has('seen')")
        assert shown.value("replay.player.robot") == 1
        assert not shown.value("document.getElementById('fold-events').open")
        assert shown.value("replay.player.views[0].camera.scale") == pytest.approx(scale)
        assert "The run goes on: 17" in shown.text("#live")
        assert "&live" in shown.value("replay.address.hash")
    replay.add(stepper.finish().recording)
    with replay:
        pass
    shown.until("!document.getElementById('live') && !replay.player.views[0].isWhole")
    assert shown.value("replay.player.time") == shown.value("replay.player.end")
    assert not shown.value("replay.player.layers.has('seen')")
    assert shown.value("replay.player.views[0].camera.scale") == pytest.approx(scale)
    assert "&live" not in shown.value("replay.address.hash")


def test_a_reader_who_looks_back_is_not_moved(page):
    shown, go_on, _, _ = page
    with shown.held():
        shown.page.locator("#scrub").fill("2")
        assert shown.page.is_visible("#follow")
    go_on(15.0)
    with shown.held("replay.player.end > 14"):
        assert shown.value("replay.player.time") == 2.0
        shown.page.click("#follow")
        assert shown.value("replay.player.time") == shown.value("replay.player.end")


def test_a_reader_who_reads_the_page_anew_while_it_plays(page):
    shown, *_ = page
    with shown.held():
        shown.page.keyboard.press("Home")
        shown.page.keyboard.press("1")
        shown.page.keyboard.press(" ")
        shown.page.uncheck("#layers input[name=seen]")
        shown.value("replay.player.views[0].zoom(2, 300, 200)")
        scale = shown.value("replay.player.views[0].camera.scale")
        shown.until("location.hash.includes('robot=1&layers=truth,regions')")
        shown.page.reload()
    with shown.held("replay.player.robot === 1 && !replay.player.views[0].isWhole"):
        assert not shown.value("replay.player.layers.has('seen')")
        assert shown.value("replay.player.views[0].camera.scale") == pytest.approx(scale)


def test_an_interrupted_run_says_so_and_plays(page):
    shown, _, replay, _ = page
    with pytest.raises(KeyboardInterrupt), replay:
        raise KeyboardInterrupt
    shown.until("document.getElementById('live').dataset.reloadS === ''")
    assert "The run was interrupted: the replay ends at" in shown.text("#live")
    (about,) = shown.page.locator("#about p").all_text_contents()[:1]
    assert re.fullmatch(r"srt-radial in apartment, seed 1: interrupted after \d+\.\d s\.", about)
    assert "finished" not in shown.text("#about")
    shown.page.click("#play")
    shown.until("replay.player.isPlaying && replay.player.time > 0.5")


def test_a_run_that_is_interrupted_at_its_start_says_so(browser, tmp_path):
    stepper = ms.Stepper("apartment", robots=2, seed=1, max_time_s=60.0)
    replay = LiveReplay(tmp_path / "replay.html")
    replay.look(lambda: stepper.recording)
    with pytest.raises(KeyboardInterrupt), replay:
        raise KeyboardInterrupt
    page = Shown(browser.new_page(), (tmp_path / "replay.html").as_uri()).open()
    assert page.text("#live span") == (
        "The run was interrupted: nothing had happened yet in srt-radial in apartment; "
        "the replay shows its start."
    )
    assert page.errors == []
    page.page.close()
