"""Styles of figures for papers, and the files that they are written to.

Fonts are those that come with matplotlib, so that a figure is the same on every machine: STIX
General, a typeface like Times, and DejaVu Sans.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final, Literal

from multisrt.drawing.colours import INK
from multisrt.drawing.svg import printable
from multisrt.extras import extra
from multisrt.geometry.errors import InvalidInputError, did_you_mean

with extra("plots", "a figure"):
    import matplotlib as mpl
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

Format = Literal["pdf", "svg", "png"]

FORMATS: Final[tuple[Format, ...]] = ("pdf", "svg", "png")
"""Kinds of files of figures."""

MM_PER_IN: Final = 25.4

MAX_LISTED: Final = 24
"""Upper bound of the entries of a legend for robots."""

MIN_MAP_IN: Final = 0.9
"""Lower bound of the longer side of a map, in inches."""

PNG_DPI: Final = 300
"""Resolution of figures that are written as PNG, in dots per inch."""

SHARED_SETTINGS: Final[dict[Any, Any]] = {
    "axes.edgecolor": "#6a6a6a",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.6,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.unicode_minus": True,
    "figure.facecolor": "white",
    "grid.color": "#dedede",
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    # Journals require TrueType. One typeface only: every figure embeds its own subset of it.
    "pdf.fonttype": 42,
    "svg.hashsalt": "multisrt",
    "text.color": INK,
    "text.parse_math": False,
    "text.usetex": False,
    "xtick.color": INK,
    "xtick.major.width": 0.6,
    "ytick.color": INK,
    "ytick.major.width": 0.6,
}
"""Settings of matplotlib for all figures, those of reports too."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureStyle:
    """The size and the letters of figures for one kind of page.

    Attributes
    ----------
    summary : str
        What it is for.
    width_in : float
        Width of every figure, in inches.
    max_height_in : float
        Upper bound of its height, in inches.
    font : str
        The typeface.
    text_pt, small_pt : float
        Sizes of labels of axes, and of all other letters, in points.
    letters_as_text : bool
        Whether SVG files hold letters as text, in the reader's font, rather than as outlines.
    """

    summary: str
    width_in: float
    max_height_in: float
    font: str
    text_pt: float
    small_pt: float
    letters_as_text: bool = False

    def settings(self) -> dict[Any, Any]:
        """Return the settings of matplotlib."""
        return SHARED_SETTINGS | {
            "axes.labelsize": self.text_pt,
            "axes.titlesize": self.text_pt,
            "figure.titlesize": self.text_pt,
            "font.family": [self.font],
            "font.size": self.text_pt,
            "legend.fontsize": self.small_pt,
            "lines.linewidth": 1.2,
            "svg.fonttype": "none" if self.letters_as_text else "path",
            "xtick.labelsize": self.small_pt,
            "ytick.labelsize": self.small_pt,
        }


SERIF: Final = "STIXGeneral"
SANS: Final = "DejaVu Sans"

STYLES: Final[dict[str, FigureStyle]] = {
    "ieee": FigureStyle(
        summary="a column of IEEE journals and conferences, 3.5 in",
        width_in=3.5,
        max_height_in=9.0,
        font=SERIF,
        text_pt=8.0,
        small_pt=8.0,
    ),
    "ieee-wide": FigureStyle(
        summary="both columns of IEEE, 7.16 in",
        width_in=7.16,
        max_height_in=9.0,
        font=SERIF,
        text_pt=8.0,
        small_pt=8.0,
    ),
    "springer": FigureStyle(
        summary="a column of Springer journals, 84 mm",
        width_in=84.0 / MM_PER_IN,
        max_height_in=234.0 / MM_PER_IN,
        font=SANS,
        text_pt=8.0,
        small_pt=7.0,
    ),
    "springer-wide": FigureStyle(
        summary="both columns of Springer, 174 mm",
        width_in=174.0 / MM_PER_IN,
        max_height_in=234.0 / MM_PER_IN,
        font=SANS,
        text_pt=8.0,
        small_pt=7.0,
    ),
    "screen": FigureStyle(
        summary="pages and slides, 6.4 in",
        width_in=6.4,
        max_height_in=8.0,
        font=SANS,
        text_pt=9.0,
        small_pt=8.5,
        letters_as_text=True,
    ),
}
"""The styles of figures by name."""


def style_named(name: str) -> FigureStyle:
    """Return a style by its name.

    Parameters
    ----------
    name : {"ieee", "ieee-wide", "springer", "springer-wide", "screen"}
        The name.

    Returns
    -------
    FigureStyle
        The style.

    Raises
    ------
    InvalidInputError
        If there is no such style.

    Examples
    --------
    >>> style_named("ieee").width_in
    3.5
    """
    if name not in STYLES:
        hint = did_you_mean(name, STYLES) or f"; the styles are {', '.join(STYLES)}"
        raise InvalidInputError(f"there is no style {name!r} of figures{hint}")
    return STYLES[name]


@contextmanager
def figure_style(name: str = "screen") -> Iterator[FigureStyle]:
    """Draw figures of matplotlib in a style of this package, for figures of your own.

    Parameters
    ----------
    name : str
        Name of the style; see `style_named`.

    Yields
    ------
    FigureStyle
        The style; its settings hold within the block.

    Raises
    ------
    InvalidInputError
        If there is no such style.

    Examples
    --------
    >>> import matplotlib as mpl
    >>> with figure_style("springer") as style:
    ...     mpl.rcParams["font.size"]
    8.0
    """
    style = style_named(name)
    with settings(style.settings()):
        yield style


@contextmanager
def settings(values: Mapping[Any, Any]) -> Iterator[None]:
    """Use settings of matplotlib within a block, in place of those of the user."""
    with mpl.rc_context(), warnings.catch_warnings():
        # The reader's font may have letters that the font for measuring lacks.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        mpl.rcdefaults()
        mpl.rcParams.update(values)
        yield


def saved(figure: Figure, kind: Format, title: str) -> bytes:
    """Return the bytes of a figure as a file, without times or names of programs.

    Parameters
    ----------
    figure : Figure
        The figure, within its settings.
    kind : {"pdf", "svg", "png"}
        The kind of file.
    title : str
        Title that PDF and SVG hold.

    Returns
    -------
    bytes
        The file; the same figure gives the same bytes.
    """
    metadata: dict[Format, dict[str, str | None]] = {
        "svg": {"Date": None, "Creator": None, "Title": printable(title)},
        "pdf": {"CreationDate": None, "Title": printable(title)},
        "png": {"Software": None},
    }
    file = io.BytesIO()
    dpi = PNG_DPI if kind == "png" else "figure"
    figure.savefig(file, format=kind, metadata=metadata[kind], dpi=dpi)
    return file.getvalue()


def new_figure(style: FigureStyle, rows: int = 1, columns: int = 1) -> tuple[Figure, list[Axes]]:
    """Return a figure as wide as a style says, and its axes, row by row."""
    figure = Figure(figsize=(style.width_in, style.width_in), layout="constrained")
    FigureCanvasAgg(figure)  # measures the size of text
    gaps = {"w_pad": 0.04, "h_pad": 0.05, "wspace": 0.0, "hspace": 0.0}
    engine = figure.get_layout_engine()
    assert engine is not None
    engine.set(**gaps)
    axes = figure.subplots(rows, columns, squeeze=False)
    return figure, list(axes.ravel())


def fit_maps(
    figure: Figure,
    rows: Sequence[Sequence[Axes]],
    max_height_in: float,
    remedy: str = "fewer recordings or a wider style (--style)",
) -> None:
    """Make a figure as high as its maps need, at their full width.

    Parameters
    ----------
    figure : Figure
        The figure, whose layout is constrained.
    rows : sequence of sequence of Axes
        The axes with maps, row by row; their limits are set.
    max_height_in : float
        Upper bound of the height, in inches.
    remedy : str, optional
        What an error advises to choose.

    Raises
    ------
    InvalidInputError
        If maps would have sides of less than `MIN_MAP_IN`.
    """
    is_laid_out = False
    for _ in range(4):
        is_laid_out = _is_laid_out(figure)
        width_in, height_in = map(float, figure.get_size_inches())
        lacking = sum(max(_lacking_in(ax, width_in, height_in) for ax in row) for row in rows)
        wanted = min(max_height_in, height_in + lacking)
        if abs(wanted - height_in) < 1e-3:
            break
        figure.set_size_inches(width_in, wanted)
        is_laid_out = _is_laid_out(figure)
    largest_in = max(_longer_side_in(ax) for row in rows for ax in row)
    if not is_laid_out or largest_in < MIN_MAP_IN:
        raise too_small(sum(map(len, rows)), width_in, max_height_in, remedy)
    freeze(figure)


def too_small(maps: int, width_in: float, height_in: float, remedy: str) -> InvalidInputError:
    """Return the error for maps that would not be legible."""
    return InvalidInputError(
        f"{maps} maps would be less than {MIN_MAP_IN:g} in wide in a figure of {width_in:.3g} by "
        f"{height_in:.3g} in: choose {remedy}"
    )


def _is_laid_out(figure: Figure) -> bool:
    # Whether there is room for the axes: matplotlib warns where there is none.
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message="constrained_layout not applied")
        try:
            figure.draw_without_rendering()
        except UserWarning:
            return False
    return True


def _longer_side_in(ax: Axes) -> float:
    width_in, height_in = map(float, ax.figure.get_size_inches())  # type: ignore[union-attr]
    box = ax.get_position()
    return max(box.width * width_in, box.height * height_in)


def _lacking_in(ax: Axes, width_in: float, height_in: float) -> float:
    # By how much a map would have to be higher to be as wide as its axes.
    box = ax.get_position(original=True)
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    return box.width * width_in * (y1 - y0) / (x1 - x0) - box.height * height_in


def freeze(figure: Figure) -> None:
    """Lay a figure out, and keep the layout."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")


def listed(handles: Sequence[Any]) -> list[Any]:
    """Return entries of a legend for robots, of which "and N more" stands for those beyond a limit.

    Parameters
    ----------
    handles : sequence of artist or tuple of artists
        An entry for each robot; see `legend_below`.

    Returns
    -------
    list of artist or tuple of artists
        At most `MAX_LISTED` entries.
    """
    from matplotlib.lines import Line2D

    if len(handles) <= MAX_LISTED:
        return list(handles)
    kept = MAX_LISTED - 1
    more = Line2D([], [], linestyle="none", label=f"and {len(handles) - kept:,} more")
    return [*handles[:kept], more]


def legend_below(figure: Figure, handles: Sequence[Any], style: FigureStyle) -> None:
    """Place a legend below all axes, in as many columns as fit.

    Parameters
    ----------
    figure : Figure
        The figure, whose layout is constrained.
    handles : sequence of artist or tuple of artists
        The entries. Artists of a tuple are drawn over one another; the last one has the label.
    style : FigureStyle
        The style, whose settings hold.
    """
    if not handles:
        return
    limit = style.width_in * figure.dpi
    labels = [str((one[-1] if isinstance(one, tuple) else one).get_label()) for one in handles]
    for columns in range(min(6, len(handles)), 0, -1):
        made = figure.legend(
            handles=handles,
            labels=labels,
            loc="outside lower left",
            ncols=columns,
            columnspacing=1.2,
            handlelength=2.2,
            handletextpad=0.6,
            borderaxespad=0.2,
        )
        if columns == 1 or made.get_window_extent().width <= limit:
            return
        made.remove()
