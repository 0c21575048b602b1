import webbrowser

import pytest

from multisrt.cli.view import MAX_RUNS as MAX_RUNS_OF_COMMAND
from multisrt.replay import MAX_RUNS, replay_html
from tests.multisrt.cli.commands import everything


@pytest.fixture
def opened(monkeypatch):
    """The addresses that a browser was asked to open."""
    found: list[str] = []

    def note(url):
        found.append(url)
        return True

    monkeypatch.setattr(webbrowser, "open", note)
    return found


@pytest.fixture
def out(call):
    call("explore", "room.wkt", "--out", "out", "--quiet")


def test_a_replay_stands_beside_the_recording_and_is_opened(call, folder, opened, out):
    assert call("view", "out") == (0, "out/replay.html\n", "")
    assert opened == [(folder / "out/replay.html").as_uri()]
    assert call("view", "out/recording.jsonl", "--out", "other.html")[0] == 0
    page = (folder / "other.html").read_bytes()
    assert page == (folder / "out/replay.html").read_bytes()
    assert page.startswith(b"<!doctype html>")


def test_nothing_is_opened_if_the_user_says_so(call, opened, out):
    assert call("view", "out", "--no-open")[0] == 0
    assert opened == []


def test_without_a_browser_the_page_is_named(call, monkeypatch, out):
    monkeypatch.setattr(webbrowser, "open", lambda url: False)
    code, printed, err = call("view", "out")
    assert (code, printed) == (0, "out/replay.html\n")
    assert err == "no browser could be opened: open out/replay.html in one\n"


def test_a_file_is_replaced_by_force_only(call, folder, opened, out):
    (folder / "mine.html").write_text("mine")
    code, _, err = call("view", "out", "--out", "mine.html")
    assert code == 2
    assert err == (
        "error: mine.html exists already: name another file, or replace it with --force\n"
    )
    assert (folder / "mine.html").read_text() == "mine"
    assert call("view", "out", "--out", "mine.html", "--force")[0] == 0
    assert (folder / "mine.html").read_text() != "mine"
    assert len(opened) == 1


def test_several_runs_are_shown_side_by_side(call, folder, opened):
    words = "--strategy", "closest", "--strategy", "srt-star", "--out", "two", "--quiet"
    call("explore", "room.wkt", *words)
    assert call("view", "two/closest", "two/srt-star", "--no-open") == (
        0,
        "two/closest/replay.html\n",
        "",
    )
    page = (folder / "two/closest/replay.html").read_bytes()
    assert b"<title>closest in room | srt-star in room: replay</title>" in page
    assert call("view", "two", "--no-open") == (0, "two/replay.html\n", "")
    assert (folder / "two/replay.html").read_bytes() == page


def test_explore_shows_its_runs(call, folder, opened):
    words = "--strategy", "closest", "--strategy", "srt-star", "--out", "two", "--quiet"
    assert call("explore", "room.wkt", *words, "--view")[0] == 0
    assert opened == [(folder / "two/replay.html").as_uri()]
    assert call("explore", "room.wkt", "--out", "one", "--quiet", "--view")[0] == 0
    assert opened[1:] == [(folder / "one/replay.html").as_uri()]


def test_too_many_runs_are_refused_before_they_are_made(call, folder):
    before = everything(folder)
    names = "closest", "srt-star", "srt-radial", "minpos", "greedy"
    words = [word for name in names for word in ("--strategy", name)]
    code, _, err = call("explore", "room.wkt", *words, "--view")
    assert (code, err.partition(";")[0]) == (2, "error: a replay shows at most 4 runs, not 5")
    code, _, err = call("view", *["out"] * 5)
    assert (code, err.partition(";")[0]) == (2, "error: a replay shows at most 4 runs, not 5")
    assert everything(folder) == before
    assert MAX_RUNS_OF_COMMAND == MAX_RUNS


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ([], "RECORDING... is missing"),
        (["none.jsonl"], "none.jsonl does not exist: name the folder of a run"),
        (["room.wkt"], "room.wkt is not a recording"),
        (
            ["out/run.json"],
            "out/run.json is not a recording; the recording of the run is out/recording",
        ),
        (["cut.jsonl"], "cut.jsonl: the run was cut off"),
        (["old.jsonl"], "old.jsonl: format version 2; this program reads"),
        (["out", "--out", "none/replay.html"], "cannot write none/replay.html"),
        (["out", "--out", "."], "cannot write ."),
    ],
)
def test_view_refuses_bad_input(call, folder, opened, out, words, named):
    lines = (folder / "out/recording.jsonl").read_text().splitlines(keepends=True)
    (folder / "cut.jsonl").write_text("".join(lines[:-1]))
    old = lines[0].replace('"format_version":5', '"format_version":2')
    (folder / "old.jsonl").write_text("".join([old, *lines[1:]]))
    before = everything(folder)
    code, printed, err = call("view", *words)
    assert (code, printed) == (2, "")
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert named in err
    assert everything(folder) == before
    assert opened == []


def test_the_page_is_that_of_the_library(call, folder, out):
    from multisrt.recording import Recording

    call("view", "out", "--no-open")
    page = replay_html(Recording.load("out/recording.jsonl"))
    assert (folder / "out/replay.html").read_text(encoding="utf-8") == page
