"""How a run and what belongs to it show themselves."""

import re
import sys

import numpy as np
import pytest
import shapely
from matplotlib.figure import Figure

from multisrt.analysis.metrics import METRIC_GROUPS
from multisrt.environments.environment import Environment
from multisrt.events import AnyEvent
from multisrt.finished_run import Run
from multisrt.run import explore

NAMED = Environment("<b>room</b>", shapely.box(0, 0, 6, 5), starts=[(1.0, 1.0)])


@pytest.fixture(scope="module")
def run() -> Run:
    return explore(NAMED, seed=1, start=(1.0, 1.0))


def test_a_run_shows_its_picture_and_its_main_figures(run):
    shown = run._repr_html_()
    assert shown.count("<img") == 1
    assert "<b>" not in shown
    assert f"complete: {run.reason}" in shown
    assert "100.0 % of 30.0 m2 explorable" in shown
    assert "messages" not in shown


def test_metrics_show_every_metric_once(run):
    shown = run.metrics._repr_html_()
    cells = re.findall(r"<td[^>]*>(\w+)</td>", shown)
    for names in METRIC_GROUPS.values():
        for name in names:
            assert cells.count(name) >= 1, name
    assert shown.count("<tr>") == 1 + sum(map(len, METRIC_GROUPS.values()))


def test_a_world_shows_its_picture():
    shown = NAMED._repr_svg_()
    assert shown.count("<svg") == 1
    assert "<b>" not in shown


def test_curves_of_several_runs_share_axes(run):
    ax = Figure().add_subplot()
    run.plot_coverage(ax)
    run.plot_coverage(ax, label="again", color="#000000")
    assert [line.get_label() for line in ax.lines] == ["srt-radial", "again"]
    times, shares = map(np.asarray, ax.lines[0].get_data())
    assert (times[0], shares[-1]) == (0.0, run.metrics.coverage)
    assert (ax.get_xlabel(), ax.get_ylim()) == ("time (s)", (0.0, 1.02))


def test_what_the_base_station_knows_has_a_thin_line():
    home = explore(
        "open", strategy="minpos", base=(2.0, 2.0), radio_range_m=3.0, seed=1, max_time_s=20.0
    )
    ax = Figure().add_subplot()
    home.plot_coverage(ax, label="team", lw=3.0)
    covered, known = ax.lines
    assert [covered.get_label(), known.get_label()] == ["team", "team, at the base"]
    assert (covered.get_linewidth(), known.get_linewidth()) == (3.0, 1.5)
    assert covered.get_color() == known.get_color()
    assert np.asarray(known.get_ydata())[-1] == home.metrics.delivered_coverage


def test_labels_and_limits_of_given_axes_are_kept(run):
    ax = Figure().add_subplot(xlabel="t / s", ylim=(0.5, 1.0))
    run.plot_coverage(ax)
    assert (ax.get_xlabel(), ax.get_ylim()) == ("t / s", (0.5, 1.0))
    assert ax.get_ylabel() == "covered share of the explorable area"
    ax = Figure().add_subplot(ylabel="north (m)")
    run.plot(ax)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x (m)", "north (m)")


def test_a_run_is_the_same_with_and_without_progress(run, monkeypatch, capsys):
    seen: list[AnyEvent] = []
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    shown = explore(NAMED, seed=1, start=(1.0, 1.0), watch=seen.append, progress=True)
    assert shown.digest == run.digest
    assert tuple(seen) == shown.recording.events
    assert " seen, " in capsys.readouterr().err


def test_without_a_terminal_no_progress_is_shown(capsys):
    explore(NAMED, seed=1, start=(1.0, 1.0), progress=True)
    assert capsys.readouterr() == ("", "")
