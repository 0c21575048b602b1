"""The style of figures: readable on a phone, in grey, and without telling red from green."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from multisrt.drawing.looks import Look
from multisrt.drawing.svg import printable
from multisrt.extras import extra
from multisrt.geometry.numerics.arrays import FloatArray
from multisrt.reporting.compact import compact

with extra("plots", "a figure or a report"):
    import matplotlib  # noqa: F401
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    from multisrt.drawing.figures.style import SHARED_SETTINGS, saved, settings

WIDTH_IN: Final = 4.2
"""Width of every figure; letters stay readable where a phone shows the whole width."""

MAX_LINES: Final = 5
"""Upper bound of the strategies in a figure; more are spread over several figures."""

MAX_LABEL: Final = 26
"""Upper bound of the letters of a strategy's label."""

MAX_LABEL_OF_TWO_COLUMNS: Final = 17
"""Upper bound of the letters of labels that a legend shows in two columns."""

MAX_HEADLINE: Final = 46
"""Upper bound of the characters in a line of a headline."""

HEADLINE_ROW_IN: Final = 0.17
"""Height of each further line of a headline, in inches."""

SETTINGS: Final[dict[Any, Any]] = SHARED_SETTINGS | {
    "axes.labelsize": 9.0,
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial"],
    "font.size": 9.0,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.5,
    "svg.fonttype": "none",
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A drawn figure.

    Attributes
    ----------
    name : str
        Stem of its file names.
    title : str
        Caption.
    alt : str
        Text with the same information, for readers who cannot see the figure.
    svg, pdf : bytes
        The drawing. Equal results give equal bytes.
    """

    name: str
    title: str
    alt: str
    svg: bytes
    pdf: bytes


def short(label: str, most: int = MAX_LABEL) -> str:
    """Return a label of at most `most` letters; an ellipsis replaces the middle of a longer one."""
    text = printable(label)
    if len(text) <= most:
        return text
    half = (most - 1) // 2
    return f"{text[: most - 1 - half]}…{text[-half:]}"


def short_labels(labels: Sequence[str], most: int = MAX_LABEL) -> dict[str, str]:
    """Return labels that fit a figure and still differ, by the full labels.

    The beginning that all labels share is cut first.

    Examples
    --------
    >>> short_labels(["star", "radial"])
    {'star': 'star', 'radial': 'radial'}
    >>> short_labels(["star of the 1st kind", "star of the 2nd kind"], 12)
    {'star of the 1st kind': '…1st kind', 'star of the 2nd kind': '…2nd kind'}
    """
    first, *others = map(printable, labels)
    shared = next(
        (i for i, letters in enumerate(zip(first, *others, strict=False)) if len(set(letters)) > 1),
        0,
    )
    begin = first.rfind(" ", 0, shared) + 1
    tries = (
        [short(label, most) for label in labels],
        [short(f"…{printable(label)[begin:]}", most) for label in labels],
        [f"{number}: {short(label, most - 4)}" for number, label in enumerate(labels, start=1)],
    )
    found = next((own for own in tries if len(set(own)) == len(labels)), tries[-1])
    return dict(zip(labels, found, strict=True))


def label_of(strategies: Sequence[str], strategy: str) -> str:
    """Return the label of one strategy beside those of the others; see `short_labels`."""
    return short_labels(strategies)[strategy]


def in_groups(strategies: Sequence[str], baseline: str) -> list[list[str]]:
    """Distribute strategies over figures, in their order, with the baseline in each."""
    if len(strategies) <= MAX_LINES:
        return [list(strategies)]
    others = [strategy for strategy in strategies if strategy != baseline]
    step = MAX_LINES - 1
    return [[baseline, *others[i : i + step]] for i in range(0, len(others), step)]


def drawn(
    name: str, title: str, alt: str, height_in: float, draw: Callable[[Axes], None]
) -> Picture:
    """Draw a figure of one pair of axes."""
    with settings(SETTINGS):
        figure = Figure(figsize=(WIDTH_IN, height_in))
        FigureCanvasSVG(figure)  # measures the size of text
        draw(figure.add_subplot())
        # The layout is computed once; with a layout engine each of the two files would redo it.
        ConstrainedLayoutEngine().execute(figure)
        return Picture(
            name=name,
            title=printable(title),
            alt=printable(alt),
            svg=compact(saved(figure, "svg", title)),
            pdf=saved(figure, "pdf", title),
        )


def headline(axes: Axes, text: str) -> None:
    """Write the headline of a figure above its axes, flush left, in as many lines as it needs."""
    lines = textwrap.wrap(printable(text), MAX_HEADLINE) or [""]
    figure = _figure(axes)
    figure.set_figheight(figure.get_figheight() + HEADLINE_ROW_IN * (len(lines) - 1))
    figure.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=10.5)


def shade(axes: Axes, look: Look, at: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Shade the band between two lines in the colour of a strategy."""
    axes.fill_between(at, low, high, color=look.colour, alpha=0.17, linewidth=0)


def legend_below(axes: Axes) -> None:
    """Place the legend below the axes, where it hides nothing."""
    handles, labels = axes.get_legend_handles_labels()
    columns = 2 if max(map(len, labels), default=0) <= MAX_LABEL_OF_TWO_COLUMNS else 1
    _figure(axes).legend(handles, labels, loc="outside lower left", ncols=columns)


def _figure(axes: Axes) -> Figure:
    figure = axes.figure
    assert isinstance(figure, Figure)
    return figure
