"""The kinds of figures by name, and drawing one of them in a style."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Final, Protocol

from multisrt.analysis.heat_maps import VisitCount
from multisrt.drawing.figures.activity import activity_figure
from multisrt.drawing.figures.coverage import coverage_figure
from multisrt.drawing.figures.decisions import decisions_figure
from multisrt.drawing.figures.heat import isolation_figure, visits_figure
from multisrt.drawing.figures.robot_maps import robot_maps_figure
from multisrt.drawing.figures.run_map import map_figure
from multisrt.drawing.figures.style import FORMATS, FigureStyle, Format, figure_style, saved
from multisrt.drawing.figures.trajectories import trajectories_figure
from multisrt.geometry.errors import InvalidInputError, did_you_mean
from multisrt.recording import Recording, atomic_write
from multisrt.spec.numbering import missing

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class HasRecording(Protocol):
    """A run with its recording, such as `multisrt.Run`."""

    @property
    def recording(self) -> Recording:
        """Its recording."""


Recorded = Recording | HasRecording
"""What figures are drawn of."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureOptions:
    """What else a figure depends on.

    Attributes
    ----------
    times_s : tuple of float
        Times of the maps of robots, in seconds; empty for those of `default_times`.
    robots : tuple of int
        The robots that are shown; empty for all.
    count : {"passes", "robots", "scans", "viewers"}
        What a heat map of visits counts; see `multisrt.analysis.heat_maps.visits`.
    without : tuple of str
        Layers that the map of a run leaves out: names of `multisrt.drawing.LAYERS`.
    """

    times_s: tuple[float, ...] = ()
    robots: tuple[int, ...] = ()
    count: VisitCount = "passes"
    without: tuple[str, ...] = ("outlines",)


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureKind:
    """A kind of figures.

    Attributes
    ----------
    summary : str
        What it shows.
    draw : callable
        Takes recordings, style and options; returns the figure.
    several : bool
        Whether it shows several runs.
    one_world : bool
        Whether these must be of one world.
    options : frozenset of str
        The fields of `FigureOptions` that it depends on.
    """

    summary: str
    draw: Callable[[Sequence[Recording], FigureStyle, FigureOptions], Figure]
    several: bool = True
    one_world: bool = True
    options: frozenset[str] = field(default_factory=frozenset)


KINDS: Final[dict[str, FigureKind]] = {
    "map": FigureKind(
        summary="the map with trees or paths, nodes, and the area that each robot saw first",
        draw=lambda runs, style, given: map_figure(runs, style, given.without),
        options=frozenset({"without"}),
    ),
    "maps": FigureKind(
        summary="the map of each robot at some times, over the true one",
        draw=lambda runs, style, given: robot_maps_figure(
            runs[0], style, given.times_s, given.robots or None
        ),
        several=False,
        options=frozenset({"times_s", "robots"}),
    ),
    "trajectories": FigureKind(
        summary="the paths of the robots",
        draw=lambda runs, style, given: trajectories_figure(runs, style, given.robots or None),
        options=frozenset({"robots"}),
    ),
    "coverage": FigureKind(
        summary="coverage against time; several runs of a strategy as median and quartiles",
        draw=lambda runs, style, given: coverage_figure(runs, style),
    ),
    "activity": FigureKind(
        summary="what each robot was doing, against time",
        draw=lambda runs, style, given: activity_figure(runs[0], style, given.robots or None),
        several=False,
        options=frozenset({"robots"}),
    ),
    "visits": FigureKind(
        summary="how often, or by how many robots, places were driven over or seen",
        draw=lambda runs, style, given: visits_figure(runs, style, given.count),
        options=frozenset({"count"}),
    ),
    "isolation": FigureKind(
        summary="where robots were isolated from all others, and for how long",
        draw=lambda runs, style, given: isolation_figure(runs, style),
    ),
    "decisions": FigureKind(
        summary="how often robots chose what, and why, as a table",
        draw=lambda runs, style, given: decisions_figure(runs, style, given.robots or None),
        one_world=False,
        options=frozenset({"robots"}),
    ),
}
"""The kinds of figures by name."""

_NAMES: Final = {
    "times_s": "times",
    "robots": "robots",
    "count": "what is counted",
    "without": "layers",
}


def kind_named(name: str) -> FigureKind:
    """Return a kind of figures by its name.

    Raises
    ------
    InvalidInputError
        If there is no such kind.

    Examples
    --------
    >>> kind_named("coverage").several
    True
    """
    if name not in KINDS:
        hint = did_you_mean(name, KINDS) or f"; the kinds are {', '.join(KINDS)}"
        raise InvalidInputError(f"there is no kind of figures {name!r}{hint}")
    return KINDS[name]


def draw_figure(
    kind: str,
    recordings: Recorded | Sequence[Recorded],
    *,
    style: str = "screen",
    options: FigureOptions | None = None,
) -> Figure:
    """Return a figure of one or several runs.

    Parameters
    ----------
    kind : str
        Which figure: a name of `KINDS`.
    recordings : Recording, Run or sequence of these
        The runs.
    style : {"ieee", "ieee-wide", "springer", "springer-wide", "screen"}, optional
        Width and font of the figure; see `STYLES`.
    options : FigureOptions, optional
        Times, robots and the like, for kinds that depend on them.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, laid out; it belongs to no window.

    Raises
    ------
    InvalidInputError
        If there is no such kind or style, `recordings` are something else, the kind shows one run
        only or runs of one world only, it does not depend on an option that is given, or there is
        no such robot or time.
    MissingExtraError
        If matplotlib is not installed (``multisrt[plots]``).

    Examples
    --------
    >>> import multisrt as ms
    >>> runs = [ms.explore("open", seed=seed).recording for seed in (1, 2, 3)]
    >>> figure = draw_figure("coverage", runs, style="ieee")
    >>> float(figure.get_figwidth())
    3.5
    """
    runs = recordings_of(recordings)
    given = options or FigureOptions()
    require_fit(kind, runs, given)
    with figure_style(style) as own:
        return KINDS[kind].draw(runs, own, given)


def figure_bytes(
    kind: str,
    recordings: Recorded | Sequence[Recorded],
    file_format: Format = "svg",
    *,
    style: str = "screen",
    options: FigureOptions | None = None,
) -> bytes:
    """Return a figure as the bytes of a file; see `draw_figure`.

    Parameters
    ----------
    kind, recordings, style, options
        As for `draw_figure`.
    file_format : {"pdf", "svg", "png"}
        The kind of file. PDF embeds its fonts as TrueType; SVG of all styles but `screen` holds
        letters as outlines. The same recordings give the same bytes.

    Returns
    -------
    bytes
        The file.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", seed=1, max_time_s=10.0)
    >>> figure_bytes("trajectories", run.recording, "pdf")[:5]
    b'%PDF-'
    """
    figure = draw_figure(kind, recordings, style=style, options=options)
    with figure_style(style):
        return saved(figure, file_format, f"{kind}: {KINDS[kind].summary}")


def save_figure(
    kind: str,
    recordings: Recorded | Sequence[Recorded],
    path: str | Path,
    *,
    style: str = "screen",
    options: FigureOptions | None = None,
) -> None:
    """Write a figure to a file; see `draw_figure`.

    Parameters
    ----------
    kind, recordings, style, options
        As for `draw_figure`.
    path : str or Path
        The file: ``.pdf``, ``.svg`` or ``.png``. It is written completely or not at all, and
        replaced if it exists.

    Raises
    ------
    InvalidInputError
        As `draw_figure`; also if the suffix is none of these, or the file cannot be written.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> save_figure("activity", run.recording, "activity.pdf", style="springer")
    """
    drawn = figure_bytes(kind, recordings, format_of(Path(path)), style=style, options=options)
    with atomic_write(Path(path)) as file:
        file.write(drawn)


def recordings_of(given: object) -> list[Recording]:
    """Return the recordings of runs, which may be given as `multisrt.Run` as well.

    Raises
    ------
    InvalidInputError
        If something else is given.
    """
    several = given if isinstance(given, Iterable) and not isinstance(given, str) else [given]
    found = []
    for one in several:
        recording = getattr(one, "recording", one)
        if not isinstance(recording, Recording):
            raise InvalidInputError(
                f"figures are drawn of runs or recordings, not of {type(one).__name__} {one!r}"
            )
        found.append(recording)
    return found


def format_of(path: Path) -> Format:
    """Return the kind of file that a suffix names.

    Raises
    ------
    InvalidInputError
        If it names none.
    """
    for known in FORMATS:
        if path.suffix.lower() == f".{known}":
            return known
    raise InvalidInputError(f"{path}: figures are written as .pdf, .svg or .png")


def require_fit(name: str, runs: Sequence[Recording], given: FigureOptions) -> None:
    """Check that a kind of figures can show some runs with some options.

    Raises
    ------
    InvalidInputError
        As `draw_figure`.
    """
    kind = kind_named(name)
    if not runs:
        raise InvalidInputError("a figure needs a recording, and none is given")
    if len(runs) > 1 and not kind.several:
        raise InvalidInputError(f"a figure of kind {name} shows one run, not {len(runs)}")
    if kind.one_world:
        _require_one_world(name, runs)
    default = FigureOptions()
    for option, words in _NAMES.items():
        if getattr(given, option) != getattr(default, option) and option not in kind.options:
            others = ", ".join(kind for kind, own in KINDS.items() if option in own.options)
            raise InvalidInputError(
                f"a figure of kind {name} does not depend on {words}; these do: {others}"
            )
    team = max(len(run.spec.robots) for run in runs)
    for robot in given.robots:
        if not 0 <= robot < team:
            raise InvalidInputError(missing(robot, team))


def _require_one_world(name: str, runs: Sequence[Recording]) -> None:
    first = runs[0].header
    for run in runs[1:]:
        if run.header.free != first.free:
            what = f"{first.world!r} and {run.header.world!r}"
            if first.world == run.header.world:
                what = f"two that are called {first.world!r}"
            raise InvalidInputError(
                f"a figure of kind {name} needs runs of one world, and these are of {what}"
            )
