"""Pictures of a finished run: trees, curves, figures, animations and replays."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from multisrt.extras.notebook import picture_html, table_html
from multisrt.finished_run.measured import MeasuredRun

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from multisrt.drawing.figures import FigureOptions


class PicturedRun(MeasuredRun):
    """A run with its pictures; see `Run`."""

    def plot(self, ax: Axes | None = None, *, without: Iterable[str] = ()) -> Axes:
        """Draw the run on matplotlib axes, with the content and colours of its SVG picture.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; their aspect is set to equal, and existing labels are kept. By default
            a new pyplot figure, with title and legend.
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
        """Draw the covered share of the explorable area against time.

        With a base station, a thin line shows the share that it knows.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on, to compare several runs; by default a new pyplot figure. Existing
            labels and limits are kept.
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
        drawn = {"label": self.spec.strategy} | line
        axes = plot_steps(times_s, shares, ax, **drawn)
        if "delivered" in self._curve:
            covered = axes.lines[-1]
            thin = drawn | {"label": f"{drawn['label']}, at the base"} if drawn["label"] else drawn
            plot_steps(times_s, self._curve["delivered"].values, axes, **thin)
            axes.lines[-1].set(color=covered.get_color(), linewidth=covered.get_linewidth() / 2.0)
        return axes

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
        """Write an animation of the run as MP4, GIF or animated SVG.

        Parameters
        ----------
        path : str or Path
            The file, ``.mp4``, ``.gif`` or ``.svg``; it is written completely or not at all.
        duration_s : float, optional
            Duration of the animation, from 0.5 to 600 seconds; the last picture is shown for
            another two. By default 24 s, or the duration of the run if that is shorter.
        speed : float, optional
            Factor by which it is faster than the robots, instead of a duration.
        fps : float, optional
            Frames per second, from 1 to 60; by default 25, and 10 in a GIF. In SVG, robots move
            smoothly and everything else is updated in steps, 5 per second by default.
        size : int or (int, int), optional
            Width in pixels, or width and height; by default the width is 1280, 720 for GIF, and 960
            for SVG.
        without : collection of str, optional
            Layers to leave out: ``areas``, ``paths``, ``edges``, ``nodes``, ``goals``, ``bodies``,
            ``caption``.

        Raises
        ------
        InvalidInputError
            If an argument is out of range, or the file cannot be written.
        MissingExtraError
            If imageio-ffmpeg is not installed and an MP4 or GIF is requested
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
        """Write a page that replays the run in a browser and needs no network or server.

        Parameters
        ----------
        path : str or Path
            The file, of at most 20 MB; it is written completely or not at all.

        Raises
        ------
        InvalidInputError
            If the file cannot be written, or would exceed this size.

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
            Kind of figure: `map`, `maps`, `trajectories`, `coverage`, `activity`, `visits`,
            `isolation` or `decisions`.
        path : str or Path
            The file: ``.pdf``, ``.svg`` or ``.png``. It is written completely or not at all.
        style : {"ieee", "ieee-wide", "springer", "springer-wide", "screen"}, optional
            Width and font of the figure.
        options : FigureOptions, optional
            Options such as times and robots, for kinds that depend on them; see
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

    def _repr_html_(self) -> str:
        from multisrt.drawing import tree_svg

        return picture_html(tree_svg(self.recording), repr(self)) + table_html(
            f"{self.outcome}: {self.reason}", [], self.metrics.outline(), labels=2
        )
