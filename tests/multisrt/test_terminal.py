"""The line of progress, and lines that stay."""

import sys
import time

from multisrt import terminal
from multisrt.terminal import LiveLine


def wait_for(condition):
    until = time.monotonic() + 5.0
    while not condition() and time.monotonic() < until:
        time.sleep(0.01)


def test_a_line_that_stays_comes_before_the_first_one_of_progress(monkeypatch, capsys):
    monkeypatch.setattr(terminal, "FIRST_S", 0.3)
    monkeypatch.setattr(terminal, "EVERY_S", 0.01)
    with LiveLine(True, "working") as line:
        line.tell("hall: 12 x 8 m")
        wait_for(lambda: not line._told)
        line.update(description="drawing")
        time.sleep(0.1)
    assert capsys.readouterr() == ("", "hall: 12 x 8 m\nworking\ndrawing\n")


def test_no_line_stays_of_what_is_done_at_once(capsys):
    with LiveLine(True, "working") as line:
        line.tell("hall: 12 x 8 m")
    with LiveLine(False) as line:
        line.tell("hall: 12 x 8 m")
    assert capsys.readouterr() == ("", "")


def test_on_a_terminal_a_line_that_stays_is_written_at_once(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with LiveLine(True, "working") as line:
        line.tell("[b]hall[/b]: 12 x 8 m")
    out, err = capsys.readouterr()
    assert out == ""
    assert "[b]hall[/b]: 12 x 8 m\n" in err
