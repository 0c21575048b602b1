"""What figures show, read from their axes."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch

import multisrt as ms
from multisrt.drawing.colours import INK
from multisrt.drawing.looks import look_of
from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import measure_named
from multisrt.experiments.provenance import provenance
from multisrt.experiments.results import Result, Results
from multisrt.experiments.spec import ExperimentSpec
from multisrt.reporting import figures, overall_figures
from multisrt.reporting.study import Study
from multisrt.reporting.style import headline

TIME, COVERAGE = measure_named("known_complete_s"), measure_named("coverage")
TIMES: dict[tuple[str, int], list[float | None]] = {
    ("near", 1): [10.0, 20.0, 30.0, 40.0, 100.0],
    ("near", 2): [5.0, 6.0, 9.0, 11.0, 17.0, 30.0],
    ("far", 1): [200.0, 210.0, 250.0, 270.0, 280.0],
    ("far", 2): [130.0, None, 150.0, 110.0, 170.0, 190.0],
}


@pytest.fixture(scope="module")
def study() -> Study:
    plain = ms.explore("open", seed=1).metrics
    found = [
        Result(
            key=f"{strategy}-{robots}-{k}",
            condition=Condition(environment="hall", strategy=strategy, robots=robots),
            repetition=k,
            status="crashed" if time is None else "complete",
            reason="",
            metrics=None
            if time is None
            else msgspec.structs.replace(plain, known_complete_s=time, coverage=0.5 + time / 1e3),
            covered_at_s=() if time is None else tuple(time * p / 100.0 for p in range(101)),
        )
        for (strategy, robots), own in TIMES.items()
        for k, time in enumerate(own)
    ]
    spec = ExperimentSpec(
        name="x", environments=("open",), strategies=("srt-star",), success_coverage=0.5
    )
    return Study(Results(spec, found, len(found), provenance()))


Draw = Callable[..., dict[str, tuple[Axes, str]]]


@pytest.fixture
def axes_of(monkeypatch) -> Draw:
    """Return the axes and the description of each figure that a function draws, by name."""

    def draw_all(function: Callable[..., object], *given: object) -> dict[str, tuple[Axes, str]]:
        found = {}

        def kept(name, title, alt, height_in, draw):
            axes = Figure(figsize=(4.0, height_in)).add_subplot()
            draw(axes)
            found[name] = (axes, alt)

        with monkeypatch.context() as patch:
            patch.setattr(figures, "drawn", kept)
            patch.setattr(overall_figures, "drawn", kept)
            function(*given)
        return found

    return draw_all


def x_of(line: Line2D) -> np.ndarray:
    return np.asarray(line.get_xdata())


def y_of(line: Line2D) -> np.ndarray:
    return np.asarray(line.get_ydata())


def finite(strategy: str, robots: int) -> list[float]:
    return [time for time in TIMES[strategy, robots] if time is not None]


@pytest.mark.parametrize("measure", [TIME, COVERAGE])
def test_boxes_are_the_quartiles_of_their_runs(study, axes_of, measure):
    ((axes, alt),) = axes_of(figures.box_plots, study, measure).values()
    assert axes.get_xlabel().replace("\n", " ") == measure.heading
    rows = [("near", 1), ("far", 1), ("near", 2), ("far", 2)]
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels == ["near", "far", "near", "far 5/6"]
    assert [text.get_text() for text in axes.texts] == ["1 robot", "2 robots"]
    boxes = [patch for patch in axes.patches if isinstance(patch, PathPatch)]
    medians = [line for line in axes.lines if line.get_color() == INK]
    points = [line for line in axes.lines if line.get_linestyle() == "None"]
    for (strategy, robots), at, box, middle, dots in zip(
        rows, axes.get_yticks(), boxes, medians, points, strict=True
    ):
        own = finite(strategy, robots)
        own = own if measure is TIME else [0.5 + time / 1e3 for time in own]
        low, half, high = np.percentile(own, [25, 50, 75])
        across = np.asarray(box.get_path().vertices)[:, 0]
        assert (across.min(), across.max()) == pytest.approx((low, high))
        assert x_of(middle) == pytest.approx([half, half])
        assert np.mean(y_of(middle)) == pytest.approx(at)
        assert list(x_of(dots)) == pytest.approx(own)
        assert np.abs(y_of(dots) - at).max() < 0.5
        look = look_of(["near", "far"].index(strategy))
        assert to_hex(box.get_edgecolor()) == look.colour == dots.get_color()
    if measure is TIME:
        assert alt.endswith(
            "Medians: 1 robot, near: 30.0; 1 robot, far: 250.0; 2 robots, near: 10.0; "
            "2 robots, far: 160.0"
        )


def test_lines_against_team_size_are_medians_of_all_runs(study, axes_of):
    ((axes, _),) = axes_of(figures.against_team_size, study, TIME).values()
    shown = {line.get_label(): line for line in axes.lines}
    assert list(shown) == ["near", "far"]
    # The run that crashed counts as the slowest.
    all_runs = [math.inf if time is None else time for time in TIMES["far", 2]]
    assert list(x_of(shown["near"])) == [1, 2]
    assert list(y_of(shown["near"])) == [30.0, 10.0]
    assert list(y_of(shown["far"])) == [250.0, float(np.median(all_runs))]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["1", "2"]


def test_coverage_curves_are_medians_and_quartiles(study, axes_of):
    found = axes_of(figures.coverage_curves, study)
    assert list(found) == ["coverage-hall-1-robot-0", "coverage-hall-2-robots-0"]
    axes, alt = found["coverage-hall-1-robot-0"]
    near, far = axes.lines
    grid = x_of(near)
    at = int(np.searchsorted(grid, 30.0))
    shares = [min(1.0, math.floor(100.0 * grid[at] / time) / 100.0) for time in TIMES["near", 1]]
    assert y_of(near)[at] == pytest.approx(np.median(shares))
    band = np.asarray(axes.collections[0].get_paths()[0].vertices)
    there = band[np.isclose(band[:, 0], grid[at]), 1]
    assert (there.min(), there.max()) == pytest.approx(tuple(np.percentile(shares, [25, 75])))
    assert y_of(far)[at] < y_of(near)[at]
    # 90 % of a run of 30 s are covered after 27 s, of one of 250 s after 225 s.
    step = grid[1]
    near_s, far_s = (float(text.split(" s")[0]) for text in alt.split("at 90 % after ")[1:])
    assert 27.0 - 0.5 <= near_s <= 27.0 + step + 0.5
    assert 225.0 - 0.5 <= far_s <= 225.0 + step + 0.5


def test_coverage_curves_end_at_what_the_run_covered(study, axes_of):
    result = next(one for one in study.results if one.metrics is not None)
    metrics = msgspec.structs.replace(result.metrics, coverage=0.9998)
    curve = (*result.covered_at_s[:100], None)
    almost = msgspec.structs.replace(result, metrics=metrics, covered_at_s=curve)
    only = Study(Results(study.results.experiment, [almost], 1, provenance()))
    ((axes, _),) = axes_of(figures.coverage_curves, only).values()
    (line,) = axes.lines
    end_s = metrics.makespan_s
    assert (x_of(line)[-1], y_of(line)[-1]) == (end_s, pytest.approx(0.9998))
    before = y_of(line)[x_of(line) < end_s]
    assert before[-1] == pytest.approx(0.99)


def test_what_the_base_station_knew_has_a_curve_of_its_own(study, axes_of):
    assert axes_of(figures.delivered_curves, study) == {}
    results = []
    for one in study.results:
        late = tuple(None if t is None else 2.0 * t + 5.0 for t in one.covered_at_s)
        results.append(msgspec.structs.replace(one, delivered_at_s=late))
    known = Study(Results(study.results.experiment, results, len(results), provenance()))
    covered = axes_of(figures.coverage_curves, known)
    delivered = axes_of(figures.delivered_curves, known)
    assert [name.replace("delivered", "coverage") for name in delivered] == list(covered)
    for (axes, alt), (before, _) in zip(delivered.values(), covered.values(), strict=True):
        assert axes.get_ylabel() == "known to the base station"
        assert alt.startswith("Share of the explorable area known to the base station against")
        assert len(axes.collections) == len(axes.lines) == len(before.lines)
        # Twice as late, and 5 s: a median reaches 90 % later by as much.
        for line, earlier in zip(axes.lines, before.lines, strict=True):
            t90, was = (x_of(one)[np.argmax(y_of(one) >= 0.9)] for one in (line, earlier))
            step = x_of(line)[1]
            assert t90 == pytest.approx(2.0 * was + 5.0, abs=2.0 * step)


def test_rates_of_success_are_over_all_settings(study, axes_of):
    ((axes, alt),) = axes_of(overall_figures.success_rates, study).values()
    assert "near: 1.00" in alt
    assert f"far: {10 / 11:.2f}" in alt
    assert [label.get_text() for label in axes.get_yticklabels()] == ["near", "far"]


def test_a_long_headline_is_written_whole_and_makes_room():
    figure = Figure(figsize=(4.2, 2.0))
    text = "Time until one robot's map is complete, against srt-star"
    headline(figure.add_subplot(), text)
    assert figure.get_suptitle().replace("\n", " ") == text
    assert figure.get_figheight() > 2.0
