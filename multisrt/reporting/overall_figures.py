"""Figures over all settings: profiles, probabilities of improvement, gaps, success rates."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from multisrt.drawing.looks import look_of
from multisrt.experiments.measures import MEASURES, Measure, measure_named
from multisrt.extras import extra
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.reporting.layout import number, slug
from multisrt.reporting.study import SEED, Study
from multisrt.reporting.style import (
    Picture,
    drawn,
    headline,
    in_groups,
    label_of,
    legend_below,
    shade,
    short,
)
from multisrt.reporting.tables import GAPS, gaps_above, settings_with
from multisrt.statistics.improvement import probability_of_improvement
from multisrt.statistics.intervals import Interval, wilson
from multisrt.statistics.profiles import performance_profile

with extra("plots", "a figure or a report"):
    from matplotlib.axes import Axes
    from matplotlib.ticker import PercentFormatter


def profiles(study: Study) -> list[Picture]:
    """Return performance profiles, of times relative to the lower bound or to the best time."""
    ratios, axis = _ratios(study)
    finite = [v for own in ratios.values() for sample in own for v in sample if math.isfinite(v)]
    if not finite:
        return []
    most = max(finite)
    thresholds = np.linspace(1.0, max(most, 1.01), 100)
    return [
        _profile(study, {s: ratios[s] for s in group}, thresholds, axis, number_)
        for number_, group in enumerate(in_groups(list(ratios), study.baseline))
    ]


def improvement(study: Study, measure: Measure) -> list[Picture]:
    """Return the probabilities that a run of a strategy is better than one of the baseline."""
    settings = [s for s in study.shared_settings() if study.has(measure, s)]
    rivals = study.rivals_in(measure)
    if not settings or not rivals:
        return []
    found = {}
    for strategy in rivals:
        mine = [measure.values(study.distinct(s, strategy)) for s in settings]
        theirs = [measure.values(study.distinct(s, study.baseline)) for s in settings]
        found[strategy] = probability_of_improvement(
            mine, theirs, lower_is_better=measure.lower_is_better, rng=SEED
        )
    title = f"Probability that a run is better than one of {study.baseline}: {measure.title}"

    def finish(axes: Axes) -> None:
        axes.set_xlim(-0.02, 1.02)
        axes.axvline(0.5, color="#6a6a6a", linewidth=1.0, linestyle=(0, (4, 2)))
        axes.set_xlabel(f"worse  {chr(8592)}  probability  {chr(8594)}  better")

    return [
        _forest(
            study,
            f"improvement-{slug(measure.name)}",
            title,
            f"{measure.title}, against {label_of(study.strategies, study.baseline)}",
            found,
            finish,
            digits=2,
        )
    ]


def gaps(study: Study) -> list[Picture]:
    """Return the gaps above the times of the informed plan, and above lower bounds."""
    pictures = []
    for name, told in GAPS.items():
        found = {s: v for s, v in gaps_above(study, name).items() if math.isfinite(v.value)}
        if found:
            pictures.append(_gap(study, name, told.title, found))
    return pictures


def _gap(study: Study, name: str, title: str, found: dict[str, Interval]) -> Picture:
    lowest = min(interval.low for interval in found.values())

    def finish(axes: Axes) -> None:
        axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))
        axes.set_xlim(left=min(0.0, 1.1 * lowest))
        axes.set_xlabel("above the lower bound" if name == "over_bound" else "above informed")

    return _forest(study, f"gap-{slug(name)}", title, title, found, finish, digits=2)


def success_rates(study: Study) -> list[Picture]:
    """Return the success rates of the strategies over all settings; no figure if none failed."""
    if not any(result.failed for result in study.results):
        return []
    found = {}
    for strategy in study.strategies:
        own = [r for setting in study.settings for r in study.distinct(setting, strategy)]
        found[strategy] = wilson(sum(r.success for r in own), len(own))

    def finish(axes: Axes) -> None:
        axes.set_xlim(-0.02, 1.02)
        axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))
        share = 100.0 * study.results.experiment.success_coverage
        axes.set_xlabel(f"at least {share:g} % covered, without a collision")

    title = "Success rates over all settings"
    return [_forest(study, "success-rates", title, title, found, finish, digits=2)]


def _ratios(study: Study) -> tuple[dict[str, list[FloatArray]], str]:
    # Times by strategy and setting, divided by a reference time of the setting.
    bounded = settings_with(study, "over_bound")
    if bounded:
        over = measure_named("over_bound")
        return {
            strategy: [np.array(over.values(study.of(s, strategy))) for s in bounded]
            for strategy in study.strategies
        }, "makespan over its lower bound"
    time = MEASURES[0]
    found: dict[str, list[FloatArray]] = {strategy: [] for strategy in study.strategies}
    for setting in study.shared_settings():
        own = {s: np.array(time.values(study.of(setting, s))) for s in study.strategies}
        best = min(float(values.min()) for values in own.values())
        if 0.0 < best < math.inf:
            for strategy, values in own.items():
                found[strategy].append(values / best)
    return {
        s: v for s, v in found.items() if v
    }, f"{short(time.title).lower()} over the setting's best"


def _profile(
    study: Study,
    ratios: dict[str, list[FloatArray]],
    thresholds: FloatArray,
    axis: str,
    number_: int,
) -> Picture:
    bands = {s: performance_profile(own, thresholds, rng=SEED) for s, own in ratios.items()}
    settings = len(next(iter(ratios.values())))
    middle = thresholds[len(thresholds) // 2]
    alt = (
        f"Share of the runs whose {axis} is at most a threshold, over {settings} settings. "
        + "; ".join(
            f"{strategy}: {100 * float(band.value[len(thresholds) // 2]):.0f} % within "
            f"{middle:.1f} times"
            for strategy, band in bands.items()
        )
    )

    def draw(axes: Axes) -> None:
        for strategy, band in bands.items():
            look = look_of(study.strategies.index(strategy))
            label = label_of(study.strategies, strategy)
            axes.plot(band.at, band.value, color=look.colour, linestyle=look.dashes, label=label)
            shade(axes, look, band.at, band.low, band.high)
        axes.set_xlim(1.0, thresholds[-1])
        axes.set_ylim(0.0, 1.02)
        axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))
        axes.set_xlabel(axis)
        axes.set_ylabel("share of runs")
        headline(axes, "Performance profiles")
        legend_below(axes)

    return drawn(f"profiles-{number_}", "Performance profiles", alt, 3.2, draw)


def _forest(
    study: Study,
    name: str,
    title: str,
    heading: str,
    found: dict[str, Interval],
    finish: Callable[[Axes], None],
    *,
    digits: int,
) -> Picture:
    alt = f"{title}, with 95 % intervals. " + "; ".join(
        f"{strategy}: {number(v.value, digits)} ({number(v.low, digits)} to "
        f"{number(v.high, digits)})"
        for strategy, v in found.items()
    )

    ends = [end for v in found.values() for end in (v.value, v.high) if math.isfinite(end)]
    beyond = 1.1 * max(ends)

    def draw(axes: Axes) -> None:
        for at, (strategy, interval) in enumerate(found.items()):
            look = look_of(study.strategies.index(strategy))
            high = min(interval.high, beyond)
            axes.plot([interval.low, high], [at, at], color=look.colour, linewidth=3.0)
            if high < interval.high:
                # With runs that did not succeed the interval has no upper end.
                axes.plot([high], [at], ">", color=look.colour, markersize=6.0)
            axes.plot([interval.value], [at], look.marker, color=look.colour, markersize=7.0)
        axes.set_yticks(
            range(len(found)), [label_of(study.strategies, strategy) for strategy in found]
        )
        axes.set_ylim(len(found) - 0.4, -0.6)
        axes.tick_params(axis="y", length=0)
        headline(axes, heading)
        finish(axes)

    return drawn(name, title, alt, 1.0 + 0.28 * (len(found) + 0.5), draw)
