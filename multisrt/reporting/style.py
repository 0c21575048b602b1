"""What figures look like: readable on a phone, in grey, and without telling red from green."""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from multisrt.drawing.colours import INK, ROBOT_COLOURS, tint
from multisrt.drawing.svg import printable

WIDTH_IN: Final = 4.2
"""So narrow that letters stay readable where a phone shows the whole width."""

MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X", "p")
DASHES: Final[tuple[Any, ...]] = (
    "-",
    (0, (5, 1.6)),
    (0, (1.2, 1.2)),
    (0, (5, 1.4, 1.2, 1.4)),
    (0, (9, 2)),
    (0, (2.6, 2.6)),
    (0, (9, 1.4, 1.2, 1.4, 1.2, 1.4)),
    (0, (6, 1.5, 2, 1.5)),
)

LINES_AT_ONCE: Final = 5
"""More strategies than these are spread over several figures, with the baseline in each."""

LONGEST_LABEL: Final = 26
LONGEST_IN_TWO_COLUMNS: Final = 17
LONGEST_HEADLINE: Final = 46
"""Letters of a strategy's label, of one in a legend of two columns, and of a headline."""

SETTINGS: Final[dict[Any, Any]] = {
    "axes.edgecolor": "#6a6a6a",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.labelcolor": INK,
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.unicode_minus": True,
    "figure.facecolor": "white",
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial"],
    "font.size": 9.0,
    "grid.color": "#dedede",
    "grid.linewidth": 0.5,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    # TrueType, as journals want it; one face only, since each is cut out anew for every figure.
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "multisrt",
    "text.color": INK,
    "text.parse_math": False,
    "text.usetex": False,
    "xtick.color": INK,
    "xtick.labelsize": 8.5,
    "xtick.major.width": 0.6,
    "ytick.color": INK,
    "ytick.labelsize": 8.5,
    "ytick.major.width": 0.6,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """What belongs to one strategy looks like."""

    colour: str
    light: str
    marker: str
    dashes: Any


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure, drawn.

    Attributes
    ----------
    name : str
        What files call it.
    title : str
        What it shows.
    alt : str
        What it says, for who cannot see it.
    svg, pdf : bytes
        The drawing; the same for the same results.
    """

    name: str
    title: str
    alt: str
    svg: bytes
    pdf: bytes


def look_of(number: int) -> Look:
    """Give the look of a strategy by its place among all."""
    colour = ROBOT_COLOURS[number % len(ROBOT_COLOURS)]
    turn = number + number // len(ROBOT_COLOURS)
    return Look(
        colour=colour,
        light=tint(colour, 0.35),
        marker=MARKERS[turn % len(MARKERS)],
        dashes=DASHES[turn % len(DASHES)],
    )


def short(label: str, most: int = LONGEST_LABEL) -> str:
    """Give a label that fits a figure: what is cut out is in the middle."""
    text = printable(label)
    if len(text) <= most:
        return text
    half = (most - 1) // 2
    return f"{text[: most - 1 - half]}…{text[-half:]}"


def short_labels(labels: Sequence[str], most: int = LONGEST_LABEL) -> dict[str, str]:
    """Give labels that fit a figure and still differ: what all begin with goes first.

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


def in_groups(strategies: Sequence[str], baseline: str) -> list[list[str]]:
    """Spread strategies over figures, in their order, with the baseline in each."""
    if len(strategies) <= LINES_AT_ONCE:
        return [list(strategies)]
    others = [strategy for strategy in strategies if strategy != baseline]
    step = LINES_AT_ONCE - 1
    return [[baseline, *others[i : i + step]] for i in range(0, len(others), step)]


def drawn(
    name: str, title: str, alt: str, height_in: float, draw: Callable[[Axes], None]
) -> Picture:
    """Draw a figure of one pair of axes."""
    with _settings():
        figure = Figure(figsize=(WIDTH_IN, height_in))
        FigureCanvasSVG(figure)  # by which letters are measured
        draw(figure.add_subplot())
        # Once for both files: a figure that lays itself out draws all twice for each of them.
        ConstrainedLayoutEngine().execute(figure)
        svg = _saved(figure, "svg", {"Date": None, "Creator": None, "Title": printable(title)})
        return Picture(
            name=name,
            title=printable(title),
            alt=printable(alt),
            svg=svg,
            pdf=_saved(figure, "pdf", {"CreationDate": None, "Title": printable(title)}),
        )


def headline(axes: Axes, text: str) -> None:
    """Write what a figure shows above it, from its left edge."""
    _figure(axes).suptitle(short(text, LONGEST_HEADLINE), x=0.01, ha="left", fontsize=10.5)


def legend_below(axes: Axes) -> None:
    """Explain lines below the axes, where they hide nothing."""
    handles, labels = axes.get_legend_handles_labels()
    columns = 2 if max(map(len, labels), default=0) <= LONGEST_IN_TWO_COLUMNS else 1
    _figure(axes).legend(handles, labels, loc="outside lower left", ncols=columns)


def _figure(axes: Axes) -> Figure:
    figure = axes.figure
    assert isinstance(figure, Figure)
    return figure


@contextmanager
def _settings() -> Iterator[None]:
    with mpl.rc_context(), warnings.catch_warnings():
        # Letters that the font for measuring lacks are the reader's font to show.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        mpl.rcdefaults()
        mpl.rcParams.update(SETTINGS)
        yield


def _saved(figure: Figure, kind: str, metadata: dict[str, str | None]) -> bytes:
    file = io.BytesIO()
    figure.savefig(file, format=kind, metadata=metadata)
    return file.getvalue()
