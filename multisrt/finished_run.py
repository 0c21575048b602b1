"""A finished run: its metrics, explanations, pictures, tables and files."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from multisrt.analysis.measuring import measure
from multisrt.analysis.metrics import Metrics
from multisrt.environments.environment import Environment
from multisrt.extras.frames import Column, DataFrame, Package, data_frame
from multisrt.extras.notebook import Text, picture_html, table_html
from multisrt.recording import Recording, RunOutcome, atomic_write
from multisrt.spec import RunSpec

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from multisrt.drawing.figures import FigureOptions
    from multisrt.exporting import ExportOptions

RECORDING_NAME = "recording.jsonl"
RUN_NAME = "run.json"
TREE_NAME = "tree.svg"
SPEC_NAME = "spec.toml"
RUN_FILES = (TREE_NAME, RUN_NAME, SPEC_NAME, RECORDING_NAME)
"""Files of a run that was saved, in the order in which they are listed."""


class Run:
    """A finished run: its recording and the environment it took place in.

    Parameters
    ----------
    recording : Recording
        The recording of the run.
    environment : Environment, optional
        The environment of the run. By default it is built from the recording's spec.

    Raises
    ------
    InvalidInputError
        If `environment` is not given and cannot be built from the recording.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", seed=1)
    >>> run.outcome, run.reason
    ('complete', 'robot 0: every frontier arc is explored or closed')
    >>> run.spec.seed
    1
    >>> run.save_svg("tree.svg")

    A saved recording can be measured and drawn again:

    >>> run.recording.save("recording.jsonl")
    >>> again = ms.Run(ms.Recording.load("recording.jsonl"))
    """

    def __init__(self, recording: Recording, environment: Environment | None = None) -> None:
        self.recording = recording
        self.environment = recording.environment() if environment is None else environment

    @property
    def spec(self) -> RunSpec:
        """The spec of the run."""
        return self.recording.spec

    @property
    def outcome(self) -> RunOutcome:
        """Outcome of the run: `complete`, `stalled` or `out_of_time`."""
        return self.recording.footer.outcome

    @property
    def reason(self) -> str:
        """Why the run ended, in words."""
        return self.recording.footer.reason

    @property
    def digest(self) -> str:
        """SHA-256 of spec, environment and events; runs of equal specs have equal digests."""
        return self.recording.footer.digest

    @cached_property
    def metrics(self) -> Metrics:
        """The metrics of the run, computed on first use."""
        return measure(self.recording, self.environment)

    def why(self, robot: int, time_s: float | None = None) -> Text:
        """Explain in words what a robot knew and decided.

        Parameters
        ----------
        robot : int
            Index of the robot, from 0.
        time_s : float, optional
            Time (s); the last decision up to this time is explained. By default the end of the
            run.

        Returns
        -------
        Text
            The explanation, of several lines: a str that shows itself as it reads.

        Raises
        ------
        InvalidInputError
            If there is no such robot, or it had made no decision by `time_s`.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1)
        >>> run.why(robot=0, time_s=30.0)  # doctest: +ELLIPSIS
        Robot 0 at 30.00 s...
        """
        from multisrt.explain.srt import explain

        return Text(explain(self.recording, robot, time_s))

    def trajectories(self, frame: Package | None = None) -> DataFrame:
        """Return where every robot was, as a data frame with a row for each waypoint.

        Parameters
        ----------
        frame : {"pandas", "polars"}, optional
            Library of the data frame; by default pandas if it is installed, else polars.

        Returns
        -------
        pandas.DataFrame or polars.DataFrame
            Its columns `robot`, `time_s`, `x_m`, `y_m`, `heading_rad`, `motion` and `purpose` are
            described at `multisrt.analysis.run_tables.trajectories`.

        Raises
        ------
        MissingExtraError
            If neither pandas nor polars is installed (``multisrt[frames]``).

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", start=(2.0, 4.0), seed=1, max_time_s=10.0)
        >>> run.trajectories()[["robot", "time_s", "x_m", "y_m"]].head(1)
           robot  time_s  x_m  y_m
        0      0     0.0  2.0  4.0
        """
        from multisrt.analysis.run_tables import trajectories

        return data_frame(trajectories(self.recording), frame)

    def coverage_curve(self, frame: Package | None = None) -> DataFrame:
        """Return what the team had covered and seen, as a data frame with a row for each change.

        Parameters and errors are those of `trajectories`.

        Returns
        -------
        pandas.DataFrame or polars.DataFrame
            Its columns `time_s`, `coverage`, `seen`, `covered_area_m2` and `seen_area_m2` are
            described at `multisrt.analysis.run_tables.coverage_curve`.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1)
        >>> float(run.coverage_curve()["coverage"].iloc[-1]) == run.metrics.coverage
        True
        """
        return data_frame(self._curve, frame)

    def events(self, frame: Package | None = None) -> DataFrame:
        """Return all that happened, as a data frame with a row for each event.

        Parameters and errors are those of `trajectories`.

        Returns
        -------
        pandas.DataFrame or polars.DataFrame
            Its columns `time_s`, `robot`, `event`, `x_m`, `y_m`, `heading_rad` and `fields` are
            described at `multisrt.analysis.run_tables.events`.

        Examples
        --------
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1, max_time_s=10.0).events()["event"].iloc[0]
        'sensed'
        """
        from multisrt.analysis.run_tables import events

        return data_frame(events(self.recording), frame)

    def plot(self, ax: Axes | None = None, *, without: Iterable[str] = ()) -> Axes:
        """Draw the run on axes of matplotlib: the same as in its SVG picture, in the same colours.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; their aspect becomes equal. By default a new figure of pyplot, with
            title and legend.
        without : iterable of str, optional
            Layers to leave out; see `save_svg`.

        Returns
        -------
        matplotlib.axes.Axes
            The axes; units are metres.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed (``multisrt[plots]``).

        Examples
        --------
        >>> import multisrt as ms
        >>> from matplotlib.figure import Figure
        >>> figure = Figure()
        >>> ms.explore("open", seed=1, max_time_s=10.0).plot(figure.add_subplot()).get_title()
        ''
        """
        from multisrt.drawing import plot_run

        return plot_run(self.recording, ax, without=without)

    def plot_coverage(self, ax: Axes | None = None, **line: Any) -> Axes:
        """Draw the share of the explorable area that the team had covered, against time.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw, so that several runs can be compared. By default a new figure of
            pyplot, with labels of the axes.
        **line
            Properties of the line, such as `color`; its label is the strategy by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed (``multisrt[plots]``).

        Examples
        --------
        >>> import multisrt as ms
        >>> from matplotlib.figure import Figure
        >>> ax = Figure().add_subplot()
        >>> run = ms.explore("open", seed=1, max_time_s=10.0)
        >>> [drawn.get_label() for drawn in run.plot_coverage(ax).lines]
        ['srt-radial']
        """
        from multisrt.drawing.axes import plot_steps

        times_s, shares = self._curve["time_s"].values, self._curve["coverage"].values
        return plot_steps(times_s, shares, ax, **{"label": self.spec.strategy} | line)

    @cached_property
    def _curve(self) -> Mapping[str, Column]:
        from multisrt.analysis.run_tables import coverage_curve

        return coverage_curve(self.recording, self.environment)

    def to_svg(self, *, without: Iterable[str] = ()) -> str:
        """Return the picture of the run: its exploration trees or paths, as an SVG document.

        Parameters
        ----------
        without : iterable of str, optional
            Layers to leave out; see `save_svg`.

        Returns
        -------
        str
            The document; equal runs have equal documents.

        Raises
        ------
        InvalidInputError
            If there is no such layer.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1, max_time_s=10.0)
        >>> run.to_svg(without=["outlines", "nodes"]).count("<svg")
        1
        """
        from multisrt.drawing import tree_svg

        return tree_svg(self.recording, without=without)

    def save_svg(self, path: str | Path, *, without: Iterable[str] = ()) -> None:
        """Draw the exploration trees, or the paths of frontier bidding, as SVG.

        Parameters
        ----------
        path : str or Path
            The file; it is written completely or not at all.
        without : iterable of str, optional
            Layers to leave out: names of `multisrt.drawing.LAYERS`, such as `outlines` or `nodes`.

        Raises
        ------
        InvalidInputError
            If there is no such layer, or the file cannot be written.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1, max_time_s=10.0)
        >>> run.save_svg("tree.svg")
        >>> run.save_svg("bare.svg", without=["outlines", "nodes"])
        """
        from multisrt.drawing import save_tree_svg

        save_tree_svg(self.recording, path, without=without)

    def animate(
        self,
        path: str | Path,
        *,
        duration_s: float | None = None,
        speed: float | None = None,
        fps: float | None = None,
        size: int | tuple[int, int] | None = None,
        without: Collection[str] = (),
    ) -> None:
        """Write an animation of the run, as MP4, GIF, or SVG that moves by itself.

        Parameters
        ----------
        path : str or Path
            The file, ``.mp4``, ``.gif`` or ``.svg``; it is written completely or not at all.
        duration_s : float, optional
            Time that the animation takes for the run, from 0.5 to 600 seconds; the last picture
            stays for another two. By default 24 s, or as long as the run if that is shorter.
        speed : float, optional
            How many times as fast as the robots it is, instead of a duration.
        fps : float, optional
            Pictures a second, from 1 to 60; 25 by default, 10 in a GIF. In SVG robots move
            smoothly, and all else appears in steps, 5 a second by default.
        size : int or (int, int), optional
            Width in pixels, or width and height; by default a width of 1280, of 720 for GIF and of
            960 for SVG.
        without : collection of str, optional
            Layers to leave out: ``areas``, ``paths``, ``edges``, ``nodes``, ``goals``, ``bodies``,
            ``caption``.

        Raises
        ------
        InvalidInputError
            If an argument is out of range, or the file cannot be written.
        MissingExtraError
            If an MP4 or GIF is to be written and imageio-ffmpeg is not installed
            (``multisrt[animation]``).
        EncodingError
            If ffmpeg fails.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1, max_time_s=10.0)
        >>> run.animate("run.svg")
        >>> run.animate("run.gif", duration_s=2.0, size=300)
        """
        from multisrt.drawing.animation import save_animation

        save_animation(
            self.recording,
            path,
            duration_s=duration_s,
            speed=speed,
            fps=fps,
            size=size,
            without=without,
        )

    def replay(self, path: str | Path) -> None:
        """Write a page that replays the run in a browser, without network or server.

        Parameters
        ----------
        path : str or Path
            The file, of at most 20 MB; it is written completely or not at all.

        Raises
        ------
        InvalidInputError
            If the file cannot be written, or would be larger.

        See Also
        --------
        multisrt.replay.save_replay : replays of several runs side by side.

        Examples
        --------
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1, max_time_s=10.0).replay("replay.html")
        """
        from multisrt.replay import save_replay

        save_replay(self.recording, path)

    def save_figure(
        self,
        kind: str,
        path: str | Path,
        *,
        style: str = "screen",
        options: FigureOptions | None = None,
    ) -> None:
        """Draw a figure for a paper, page or slide.

        Parameters
        ----------
        kind : str
            Which figure: `map`, `maps`, `trajectories`, `coverage`, `activity`, `visits`,
            `isolation` or `decisions`.
        path : str or Path
            The file: ``.pdf``, ``.svg`` or ``.png``. It is written completely or not at all.
        style : {"ieee", "ieee-wide", "springer", "springer-wide", "screen"}, optional
            Width and letters of the figure.
        options : FigureOptions, optional
            Times, robots and the like, for kinds that depend on them; see
            `multisrt.drawing.figures`.

        Raises
        ------
        InvalidInputError
            If there is no such kind, style, robot or time, or the file cannot be written.
        MissingExtraError
            If matplotlib is not installed (``multisrt[plots]``).

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
        >>> run.save_figure("trajectories", "trajectories.pdf", style="ieee")
        """
        from multisrt.drawing.figures import save_figure

        save_figure(kind, self.recording, path, style=style, options=options)

    def save_recording(self, path: str | Path) -> None:
        """Write the recording, one JSON object a line.

        Parameters
        ----------
        path : str or Path
            The file; it is written completely or not at all.

        Raises
        ------
        InvalidInputError
            If the file cannot be written.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", seed=1, max_time_s=10.0)
        >>> run.save_recording("recording.jsonl")
        >>> ms.Recording.load("recording.jsonl").footer.digest == run.digest
        True
        """
        self.recording.save(path)

    def save_spec(self, path: str | Path) -> None:
        """Write the spec as TOML, from which the run can be repeated.

        Parameters
        ----------
        path : str or Path
            The file; it is written completely or not at all.

        Raises
        ------
        InvalidInputError
            If the file cannot be written.

        Examples
        --------
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1, max_time_s=10.0).save_spec("spec.toml")
        >>> with open("spec.toml") as file:
        ...     spec = ms.RunSpec.from_toml(file.read())
        >>> spec.stop.max_time_s
        10.0
        """
        with atomic_write(Path(path)) as file:
            file.write(self.spec.to_toml().encode())

    def save_summary(self, path: str | Path) -> None:
        """Write spec, outcome, reason, digest and metrics as JSON.

        Parameters
        ----------
        path : str or Path
            The file; it is written completely or not at all.

        Raises
        ------
        InvalidInputError
            If the file cannot be written.

        Examples
        --------
        >>> import json
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1, max_time_s=10.0).save_summary("run.json")
        >>> with open("run.json") as file:
        ...     print(list(json.load(file)))
        ['spec', 'outcome', 'reason', 'digest', 'metrics']
        """
        summary = {
            "spec": self.spec,
            "outcome": self.outcome,
            "reason": self.reason,
            "digest": self.digest,
            "metrics": self.metrics,
        }
        text = msgspec.json.format(msgspec.json.encode(summary), indent=2)
        with atomic_write(Path(path)) as file:
            file.write(text + b"\n")

    def export(self, path: str | Path, options: ExportOptions | None = None) -> None:
        """Write the run as a file that Foxglove, ROS 2 or rerun show.

        Parameters
        ----------
        path : str or Path
            The file: ``.mcap`` for Foxglove and ROS 2, ``.rrd`` for rerun. It is written
            completely or not at all.
        options : ExportOptions, optional
            How densely the run is sampled: poses a second, time between maps, width of cells.

        Raises
        ------
        InvalidInputError
            If the suffix is another, the file cannot be written, or there would be too many poses
            or cells.
        MissingExtraError
            If a package is not installed that the format needs (``multisrt[mcap]``,
            ``multisrt[rerun]``).

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
        >>> run.export("run.mcap")
        """
        from multisrt.exporting import export_run

        export_run(self.recording, path, options=options, environment=self.environment)

    def __repr__(self) -> str:
        return (
            f"Run({self.spec.strategy!r} in {self.environment.name!r}, seed {self.spec.seed}: "
            f"{self.outcome}, {100.0 * self.metrics.coverage:.1f} % covered in "
            f"{self.metrics.makespan_s:.0f} s)"
        )

    def _repr_html_(self) -> str:
        from multisrt.drawing import tree_svg

        return picture_html(tree_svg(self.recording), repr(self)) + table_html(
            f"{self.outcome}: {self.reason}", [], self.metrics.outline(), labels=2
        )
