"""`explore --live`: the page while runs go on, at their end, and after an interrupt."""

import time
import webbrowser

import pytest

from multisrt.replay import live
from tests.multisrt.cli.commands import everything

GOES_ON = "data-going-on>"


@pytest.fixture
def opened(monkeypatch, folder):
    """The pages that a browser was asked to open, as they were then."""
    found: list[str] = []

    def note(url):
        found.append((folder / "out/replay.html").read_text(encoding="utf-8"))
        assert url == (folder / "out/replay.html").as_uri()
        return True

    monkeypatch.setattr(webbrowser, "open", note)
    return found


@pytest.fixture
def often(monkeypatch):
    """Write a page after every event of the clock."""
    monkeypatch.setattr(live, "PAUSE_S", 0.0)
    monkeypatch.setattr(live, "MAX_SHARE", 1e9)


WORDS = ("explore", "room.wkt", "--out", "out", "--quiet")


def test_the_page_goes_on_and_is_replaced_by_that_of_view(call, folder, opened):
    assert call(*WORDS, "--live") == (0, "", "")
    (first,) = opened
    assert GOES_ON in first
    assert "The run goes on: 0.0 s of srt-radial in room so far." in first
    call("view", "out", "--out", "same.html", "--no-open")
    assert (folder / "out/replay.html").read_bytes() == (folder / "same.html").read_bytes()
    assert GOES_ON not in (folder / "same.html").read_text(encoding="utf-8")


def test_it_changes_no_byte_of_the_recording(call, folder, often):
    call(*WORDS, "--live", "--no-open")
    call("explore", "room.wkt", "--out", "alone", "--quiet")
    live_one, alone = (everything(folder / name) for name in ("out", "alone"))
    assert live_one.pop("replay.html")
    for name in ("recording.jsonl", "tree.svg", "spec.toml"):
        assert live_one[name] == alone[name]
    assert live_one.keys() == alone.keys()


def test_no_browser_is_opened_if_the_user_says_so(call, opened):
    assert call(*WORDS, "--live", "--no-open")[0] == 0
    assert call("explore", "room.wkt", "--out", "two", "--quiet", "--view", "--no-open")[0] == 0
    assert opened == []


def test_strategies_follow_one_another_side_by_side(call, folder, monkeypatch, often):
    texts = []
    write = live.LiveReplay._write

    def note(self, status):
        texts.append((status.said, tuple(self._titles)))
        write(self, status)

    monkeypatch.setattr(live.LiveReplay, "_write", note)
    words = "--strategy", "closest", "--strategy", "srt-star", "--live", "--no-open"
    assert call(*WORDS, *words)[0] == 0
    titles = list(dict.fromkeys(shown for _, shown in texts))
    assert titles == [("closest in room",), ("closest in room", "srt-star in room")]
    assert len(texts) > 10
    page = (folder / "out/replay.html").read_text(encoding="utf-8")
    assert "<title>closest in room | srt-star in room: replay</title>" in page


def interrupt_at(monkeypatch, error, pages):
    # As if it came while an explorer thinks.
    look = live.LiveReplay.look

    def interrupted(self, so_far):
        if self.pages == pages:
            raise error
        look(self, so_far)

    monkeypatch.setattr(live.LiveReplay, "look", interrupted)


def test_an_interrupted_run_leaves_its_page(call, folder, monkeypatch, often):
    interrupt_at(monkeypatch, KeyboardInterrupt(), 6)
    code, _, err = call(*WORDS, "--live", "--no-open")
    assert code == 130
    said = [line for line in err.splitlines() if line]
    assert said == [
        "the runs as they go on: open out/replay.html in a browser",
        "the replay up to here: out/replay.html",
        "interrupted",
    ]
    assert list(everything(folder / "out")) == ["replay.html"]
    page = (folder / "out/replay.html").read_text(encoding="utf-8")
    assert "The run was interrupted: the replay ends at" in page
    assert GOES_ON not in page
    code, _, err = call(*WORDS, "--live", "--no-open")
    assert code == 2
    assert err.startswith("error: out/replay.html exists already")


def test_before_the_first_page_nothing_is_left(call, folder, monkeypatch):
    before = everything(folder)
    interrupt_at(monkeypatch, KeyboardInterrupt(), 0)
    assert call(*WORDS, "--live", "--no-open")[0] == 130
    assert everything(folder) == before


def test_no_open_needs_a_page(call):
    code, _, err = call(*WORDS, "--no-open")
    assert code == 2
    assert "--no-open needs --view or --live" in err


def test_pages_take_a_small_share_of_the_time(monkeypatch, tmp_path, team_recording):
    clock = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])

    def so_far():
        clock[0] += 1.0
        return team_recording

    page = live.LiveReplay(tmp_path / "page.html")
    page.look(so_far)  # it may compile kernels
    spent = 0.0
    clock[0] = begun = 1000.0
    while clock[0] < begun + 500.0:
        before = clock[0]
        page.look(so_far)
        spent += clock[0] - before
        clock[0] += 0.05
    assert spent / 500.0 <= 0.1
    assert page.pages > 20


@pytest.fixture
def team_recording():
    import multisrt as ms

    return ms.explore("open", robots=2, seed=1, max_time_s=5.0).recording
