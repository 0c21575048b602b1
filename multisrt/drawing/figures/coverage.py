"""Coverage against time: a curve for each strategy, with quartiles of repeated runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from multisrt.analysis.run_tables import coverage_curve
from multisrt.drawing.axes import plot_steps
from multisrt.drawing.figures.style import FigureStyle, freeze, legend_below, new_figure
from multisrt.drawing.looks import look_of
from multisrt.drawing.svg import printable
from multisrt.explain.conditions import conditions
from multisrt.geometry.numerics.kernel import FloatArray
from multisrt.recording import Recording
from multisrt.statistics.curves import StepCurve, common_grid, curve_bands

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

THIN_PT = 0.7
"""Width of lines of what base stations know, in points."""

HEIGHT_SHARE = 0.62
"""Height of the axes as a share of the width of the figure."""


def draw_coverage(recordings: Sequence[Recording], ax: Axes) -> list[Line2D]:
    """Draw the share of the explorable area that teams had covered, against time.

    Parameters
    ----------
    recordings : sequence of Recording
        The runs. Those that differ at most in their seeds, faults and base stations are drawn
        together: the median, with a band from the lower to the upper quartile. A single one has its
        exact curve and, with a base station, a thin line of the share that this knows.
    ax : Axes
        Where to draw.

    Returns
    -------
    list of Line2D
        A line for each strategy and what else differs, in the order of their first runs.
    """
    curves: dict[str, list[StepCurve]] = {}
    delivered: dict[str, FloatArray] = {}
    for recording, label in zip(recordings, _labels(recordings), strict=True):
        columns = coverage_curve(recording, recording.environment())
        curve = np.asarray(columns["time_s"].values), np.asarray(columns["coverage"].values)
        curves.setdefault(label, []).append(curve)
        if "delivered" in columns:
            delivered[label] = np.asarray(columns["delivered"].values)
    lines: list[Line2D] = []
    for number, (name, own) in enumerate(curves.items()):
        look = look_of(number)
        label = printable(name)
        drawn: dict[str, Any] = {"color": look.colour, "linestyle": look.dashes, "label": label}
        if len(own) == 1 or max(float(np.asarray(times)[-1]) for times, _ in own) <= 0.0:
            times_s, shares = map(np.asarray, own[0])
            lines.append(plot_steps(times_s, shares, ax, **drawn).lines[-1])
            if (at_base := delivered.get(name)) is not None:
                thin = drawn | {"label": f"{label}, at the base", "linewidth": THIN_PT}
                lines.append(plot_steps(times_s, at_base, ax, **thin).lines[-1])
            continue
        bands = curve_bands(own, common_grid(own))
        drawn["label"] = f"{label} ({len(own)} runs)"
        lines += ax.plot(bands.times, bands.median, **drawn)
        band = bands.lower_quartile, bands.upper_quartile
        ax.fill_between(bands.times, *band, color=look.colour, alpha=0.17, linewidth=0)
    return lines


def _labels(recordings: Sequence[Recording]) -> list[str]:
    """Return for each run its strategy, and the conditions that not all runs have."""
    told = [conditions(recording.spec, repeated=True) for recording in recordings]
    common = set(told[0]).intersection(*told) if told else set()
    return [
        ", ".join([recording.spec.strategy, *(phrase for phrase in own if phrase not in common)])
        for recording, own in zip(recordings, told, strict=True)
    ]


def coverage_figure(recordings: Sequence[Recording], style: FigureStyle) -> Figure:
    """Return a figure with the coverage of runs of one world; see `draw_coverage`."""
    from matplotlib.ticker import PercentFormatter

    figure, (ax,) = new_figure(style)
    figure.set_size_inches(style.width_in, HEIGHT_SHARE * min(style.width_in, 5.0))
    lines = draw_coverage(recordings, ax)
    ax.set_ylim(0.0, 1.02)
    ax.set_xlim(left=0.0)
    ax.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))
    ax.set_xlabel("time (s)")
    ax.set_ylabel("covered")
    legend_below(figure, lines, style)
    freeze(figure)
    return figure
