"""Figures of measures in single settings, each small enough for a phone."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from multisrt.analysis.metrics import Metrics
from multisrt.drawing.colours import INK
from multisrt.drawing.looks import look_of
from multisrt.experiments.crossing import Condition
from multisrt.experiments.measures import Measure
from multisrt.experiments.results import Result
from multisrt.extras import extra
from multisrt.reporting.layout import number, slug
from multisrt.reporting.study import Study, team_name
from multisrt.reporting.style import (
    Picture,
    drawn,
    headline,
    in_groups,
    label_of,
    legend_below,
    shade,
)
from multisrt.statistics.curves import StepCurve, common_grid, curve_bands
from multisrt.statistics.intervals import Interval

with extra("plots", "a figure or a report"):
    from matplotlib.axes import Axes
    from matplotlib.ticker import FixedLocator, NullLocator, PercentFormatter

CURVE_POINTS = 120
"""Points of a curve of coverage."""

ROW_IN = 0.23
"""Height of a row of boxes, in inches."""

MAX_ROWS = 30
"""Upper bound of the rows in a figure of boxes; beyond, every team size has its own figure."""


MIN_RUNS_OF_A_BOX = 5
"""Minimum number of runs of a box; fewer runs are shown as points with their median."""


def box_plots(study: Study, measure: Measure) -> list[Picture]:
    """Return box plots of a measure: a figure per world, a box per strategy and team."""
    pictures = []
    for scene, settings in study.scenes().items():
        present = [setting for setting in settings if study.has(measure, setting)]
        rows = sum(len(study.here(setting)) + 1 for setting in present)
        parts = [present] if rows <= MAX_ROWS else [[setting] for setting in present]
        for part in parts:
            if any(study.finite(measure, s, name) for s in part for name in study.strategies):
                pictures.append(_boxes(study, measure, scene, part, alone=len(parts) > 1))
    return pictures


def against_team_size(study: Study, measure: Measure) -> list[Picture]:
    """Return medians with intervals against team size: a figure per world and group of lines."""
    pictures = []
    for scene, settings in study.scenes().items():
        present = [s for s in settings if study.has(measure, s) and not s.team]
        if len({setting.robots for setting in present}) < 2:
            continue
        for number_, group in enumerate(in_groups(study.strategies, study.baseline)):
            lines = {
                strategy: [
                    (setting.robots, study.median_interval(measure, setting, strategy))
                    for setting in present
                ]
                for strategy in group
            }
            where = study.scene_name(scene)
            pictures.append(size_lines(lines, study.strategies, measure, where, number_))
    return pictures


def size_lines(
    lines: Mapping[str, Sequence[tuple[int, Interval | None]]],
    strategies: Sequence[str],
    measure: Measure,
    where: str,
    part: int = 0,
) -> Picture:
    """Return medians against team size, a line for each strategy.

    Parameters
    ----------
    lines : mapping of str to sequence of (int, Interval or None)
        For each strategy the median of each team size with its interval. One that is not finite,
        or None, is not drawn.
    strategies : sequence of str
        All strategies of the experiment, by whose order a line gets its look.
    measure : Measure
        What the medians are of.
    where : str
        The world, in words.
    part : int, default 0
        Number of the figure among those of this world.
    """
    shown = {
        strategy: [(n, p) for n, p in own if p is not None and math.isfinite(p.value)]
        for strategy, own in lines.items()
    }
    sizes = sorted({n for own in lines.values() for n, _ in own})
    alt = f"Median {measure.heading} against the number of robots in {where}. " + "; ".join(
        f"{strategy}: " + ", ".join(f"{n} robots {number(p.value, measure.digits)}" for n, p in own)
        for strategy, own in shown.items()
    )

    def draw(axes: Axes) -> None:
        for strategy, own in shown.items():
            look = look_of(strategies.index(strategy))
            at = [n for n, _ in own]
            axes.plot(
                at,
                [p.value for _, p in own],
                color=look.colour,
                linestyle=look.dashes,
                marker=look.marker,
                markersize=5.0,
                label=label_of(strategies, strategy),
            )
            bounded = [(n, p.low, p.high) for n, p in own if math.isfinite(p.high - p.low)]
            if bounded:
                shade(axes, look, *np.array(bounded).T)
        if sizes[-1] > 2 * len(sizes):
            axes.set_xscale("log", base=2)
        axes.xaxis.set_major_locator(FixedLocator([float(size) for size in sizes]))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xticks(sizes, [str(size) for size in sizes])
        axes.set_xlabel("robots")
        axes.set_ylabel(textwrap.fill(measure.heading, 34))
        if measure.lower_is_better:
            axes.set_ylim(bottom=0.0)
        headline(axes, where)
        legend_below(axes)

    name = f"teams-{slug(measure.name)}-{slug(where)}-{part}"
    return drawn(name, f"{measure.title} against team size: {where}", alt, 3.3, draw)


@dataclass(frozen=True, slots=True, kw_only=True)
class Growing:
    """A share of the explorable area that grows in the course of a run.

    Attributes
    ----------
    name : str
        Beginning of the names of its figures.
    title : str
        Beginning of their titles.
    words : str
        What is the case with the share.
    times_s : callable
        Returns when each percent was reached in a run, from 0 to 100 (s); None where never.
    share : callable
        Returns the share in the end, or None if it was not measured.
    """

    name: str
    title: str
    words: str
    times_s: Callable[[Result], tuple[float | None, ...]]
    share: Callable[[Metrics], float | None]


COVERED: Final = Growing(
    name="coverage",
    title="Coverage against time",
    words="covered",
    times_s=lambda result: result.covered_at_s,
    share=lambda metrics: metrics.coverage,
)

DELIVERED: Final = Growing(
    name="delivered",
    title="Known to the base station against time",
    words="known to the base station",
    times_s=lambda result: result.delivered_at_s,
    share=lambda metrics: metrics.delivered_coverage,
)


def coverage_curves(study: Study) -> list[Picture]:
    """Return the coverage against time: a figure per setting and group of lines."""
    return _all_curves(study, COVERED)


def delivered_curves(study: Study) -> list[Picture]:
    """Return what the base station knew against time: as `coverage_curves`; none without one."""
    return _all_curves(study, DELIVERED)


def _all_curves(study: Study, what: Growing) -> list[Picture]:
    pictures = []
    for setting in study.settings:
        for number_, group in enumerate(in_groups(study.here(setting), study.baseline)):
            found = {strategy: _curves(study, setting, strategy, what) for strategy in group}
            curves = {strategy: own for strategy, own in found.items() if own}
            together = [curve for own in curves.values() for curve in own]
            if any(np.asarray(times)[-1] > 0.0 for times, _ in together):
                pictures.append(_coverage(study, setting, curves, number_, what))
    return pictures


# Boxes --------------------------------------------------------------------------------------


def _boxes(
    study: Study, measure: Measure, scene: Condition, settings: Sequence[Condition], *, alone: bool
) -> Picture:
    where = study.name(settings[0]) if alone else study.scene_name(scene)
    rows: list[tuple[float, str, Condition]] = []
    heads: list[tuple[float, str]] = []
    y = 0.0
    for setting in settings:
        heads.append((y, team_name(setting)))
        y += 0.9
        for strategy in study.here(setting):
            rows.append((y, strategy, setting))
            y += 1.0
        y += 0.3
    alt = f"Box plots of {measure.heading} in {where}. Medians: " + "; ".join(
        f"{team_name(setting)}, {strategy}: {_median_text(study, measure, setting, strategy)}"
        for _, strategy, setting in rows
    )

    def draw(axes: Axes) -> None:
        for at, strategy, setting in rows:
            _box(axes, study, measure, at, strategy, setting)
        for at, text in heads:
            axes.annotate(
                text,
                (0.0, at),
                xycoords=("axes fraction", "data"),
                xytext=(3, 0),
                textcoords="offset points",
                fontsize=9.5,
                va="center",
            )
        labels = [_with_count(study, measure, setting, strategy) for _, strategy, setting in rows]
        axes.set_yticks([at for at, _, _ in rows], labels)
        axes.set_ylim(y - 0.6, -0.7)
        axes.tick_params(axis="y", length=0)
        axes.grid(False, axis="y")
        axes.set_xlabel(textwrap.fill(measure.heading, 32))
        headline(axes, where)
        if measure.lower_is_better and axes.get_xlim()[0] > 0.0:
            axes.set_xlim(left=0.0)

    height = 1.0 + ROW_IN * (y + 0.4)
    name = f"boxes-{slug(measure.name)}-{slug(where)}"
    return drawn(name, f"{measure.title}: {where}", alt, height, draw)


def _box(
    axes: Axes, study: Study, measure: Measure, at: float, strategy: str, setting: Condition
) -> None:
    look = look_of(study.strategies.index(strategy))
    values = study.finite(measure, setting, strategy)
    if not values:
        return
    if len(values) < MIN_RUNS_OF_A_BOX:
        middle = float(np.median(values))
        axes.plot([middle, middle], [at - 0.31, at + 0.31], color=INK, linewidth=1.8)
    else:
        axes.boxplot(
            [values],
            positions=[at],
            widths=0.62,
            orientation="horizontal",
            manage_ticks=False,
            showfliers=False,
            patch_artist=True,
            boxprops={"facecolor": look.light, "edgecolor": look.colour, "linewidth": 1.0},
            medianprops={"color": INK, "linewidth": 1.8},
            whiskerprops={"color": look.colour, "linewidth": 1.0},
            capprops={"color": look.colour, "linewidth": 1.0},
        )
    spread = np.linspace(-0.2, 0.2, 5)[np.arange(len(values)) % 5]
    axes.plot(
        values,
        at + spread,
        look.marker,
        color=look.colour,
        markersize=2.6 if len(values) >= MIN_RUNS_OF_A_BOX else 4.0,
        alpha=0.75,
        markeredgewidth=0.0,
    )


def _with_count(study: Study, measure: Measure, setting: Condition, strategy: str) -> str:
    # The label of a strategy, with the number of runs that are drawn unless all of them are.
    drawn_ = len(study.finite(measure, setting, strategy))
    runs = len(study.distinct(setting, strategy))
    label = label_of(study.strategies, strategy)
    return label if drawn_ == runs else f"{label} {drawn_}/{runs}"


# Lines --------------------------------------------------------------------------------------


def _curves(study: Study, setting: Condition, strategy: str, what: Growing) -> list[StepCurve]:
    # The time at which each percent was covered, or delivered; runs that were not measured have no
    # curve. What was covered beyond the last whole percent is known to be so when the run ends.
    curves: list[StepCurve] = []
    for result in study.distinct(setting, strategy):
        steps = [
            (time, percent / 100.0)
            for percent, time in enumerate(what.times_s(result))
            if time is not None
        ]
        share = None if result.metrics is None else what.share(result.metrics)
        if steps and result.metrics is not None and share is not None and share > steps[-1][1]:
            ended_s = max(steps[-1][0], result.metrics.makespan_s)
            steps.append((ended_s, share))
        if steps:
            curves.append(([time for time, _ in steps], [share for _, share in steps]))
    return curves


def _coverage(
    study: Study,
    setting: Condition,
    curves: dict[str, list[StepCurve]],
    number_: int,
    what: Growing,
) -> Picture:
    where = study.name(setting)
    grid = common_grid([curve for own in curves.values() for curve in own], CURVE_POINTS)
    bands = {strategy: curve_bands(own, grid) for strategy, own in curves.items()}
    reached = {
        strategy: grid[band.median >= 0.9][0] if (band.median >= 0.9).any() else math.inf
        for strategy, band in bands.items()
    }
    alt = f"Share of the explorable area {what.words} against time in {where}. " + "; ".join(
        f"{strategy}: median of {len(curves[strategy])} runs "
        + (f"at 90 % after {number(t, 0)} s" if math.isfinite(t) else "never at 90 %")
        for strategy, t in reached.items()
    )

    def draw(axes: Axes) -> None:
        for strategy, band in bands.items():
            look = look_of(study.strategies.index(strategy))
            label = label_of(study.strategies, strategy)
            axes.plot(grid, band.median, color=look.colour, linestyle=look.dashes, label=label)
            shade(axes, look, grid, band.lower_quartile, band.upper_quartile)
        axes.set_xlim(0.0, grid[-1])
        axes.set_ylim(0.0, 1.02)
        axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))
        axes.set_xlabel("time (s)")
        axes.set_ylabel(what.words)
        headline(axes, where)
        legend_below(axes)

    name = f"{what.name}-{slug(where)}-{number_}"
    return drawn(name, f"{what.title}: {where}", alt, 3.1, draw)


def _median_text(study: Study, measure: Measure, setting: Condition, strategy: str) -> str:
    summary = study.summary(measure, setting, strategy)
    return "none" if summary is None else number(summary.median, measure.digits)
