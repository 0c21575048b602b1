"""A finished run and its files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from multisrt.extras.notebook import Text
from multisrt.finished_run.pictured import PicturedRun
from multisrt.recording import atomic_write
from multisrt.simulation.worlds import with_record

if TYPE_CHECKING:
    from collections.abc import Iterable

    from multisrt.environments.environment import Environment
    from multisrt.exporting import ExportOptions, MapOptions

RECORDING_NAME = "recording.jsonl"
RUN_NAME = "run.json"
TREE_NAME = "tree.svg"
SPEC_NAME = "spec.toml"
RUN_FILES = (TREE_NAME, RUN_NAME, SPEC_NAME, RECORDING_NAME)
"""Files of a saved run, in the order in which they are listed."""


class Run(PicturedRun):
    """A finished run: its recording and its environment.

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

    def why(self, robot: int, time_s: float | None = None) -> Text:
        """Explain what a robot knew and decided.

        Parameters
        ----------
        robot : int
            Index of the robot, from 0.
        time_s : float, optional
            Time (s); the last decision up to this time is explained. By default the end of the run.

        Returns
        -------
        Text
            The explanation, in several lines: a str that is displayed without quotes.

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

    def save_recording(self, path: str | Path) -> None:
        """Write the recording, one JSON object per line.

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

        For a world from a file it contains the digest, so that changes of the file are detected.

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
            spec = with_record(self.spec, self.environment.digest, self._suggested_starts)
            file.write(spec.to_toml().encode())

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
        """Write the run as a file for Foxglove, ROS 2 or rerun.

        Parameters
        ----------
        path : str or Path
            The file: ``.mcap`` for Foxglove and ROS 2, ``.rrd`` for rerun. It is written
            completely or not at all.
        options : ExportOptions, optional
            Sampling of the run: poses per second, time between maps, cell width.

        Raises
        ------
        InvalidInputError
            If the suffix is not supported, the file cannot be written, or there would be too many
            poses or cells.
        MissingExtraError
            If a package that the format needs is not installed (``multisrt[mcap]``,
            ``multisrt[rerun]``).

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
        >>> run.export("run.mcap")
        """
        from multisrt.exporting import export_run

        export_run(self.recording, path, options=options, environment=self.environment)

    def known_map(self, *, robot: int | None = None, time_s: float | None = None) -> Environment:
        """Return the free space that a robot or the team knew at a given time.

        Parameters
        ----------
        robot : int, optional
            The robot, from 0; by default the combined knowledge of all robots.
        time_s : float, optional
            The time in seconds; by default the end of the run.

        Returns
        -------
        Environment
            The known free space, with the starts of robots that lie in it.

        Raises
        ------
        InvalidInputError
            If there is no such robot or time, or nothing was known at that time.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", robots=2, seed=1)
        >>> run.known_map(robot=0, time_s=1.0).area_m2 < run.known_map().area_m2
        True
        """
        from multisrt.exporting import known_map

        return known_map(self.recording, self.environment, robot=robot, time_s=time_s)

    def save_map(
        self,
        path: str | Path,
        *,
        robot: int | None = None,
        time_s: float | None = None,
        options: MapOptions | None = None,
        without: Iterable[str] = (),
        overwrite: bool = False,
    ) -> None:
        """Write the map that a robot or the team had at a given time to a file.

        Parameters
        ----------
        path : str or Path
            The file: ``.yaml``, ``.geojson``, ``.wkt``, ``.svg``, ``.dxf``, ``.stl`` or ``.glb``;
            see `multisrt.exporting.save_map`. It is written completely or not at all.
        robot, time_s
            As for `known_map`.
        options : MapOptions, optional
            Pixel width; height and thickness of walls.
        without : iterable of {"edges", "paths"}, optional
            Lines to omit from solids: edges of trees, or paths of robots.
        overwrite : bool, optional
            Whether an existing file is replaced.

        Raises
        ------
        InvalidInputError
            If the suffix is not supported, there is no such robot or time, nothing was known at
            that time, the file exists and `overwrite` is false, or it cannot be written.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
        >>> run.save_map("team.yaml")
        >>> run.save_map("robot-1.geojson", robot=1, time_s=5.0)
        """
        from multisrt.exporting import save_map

        save_map(
            self.recording,
            path,
            robot=robot,
            time_s=time_s,
            environment=self.environment,
            options=options,
            without=without,
            overwrite=overwrite,
        )

    def save_trees(
        self,
        path: str | Path,
        *,
        robot: int | None = None,
        time_s: float | None = None,
        overwrite: bool = False,
    ) -> None:
        """Write the exploration trees as GraphML or GeoJSON; see `multisrt.exporting.save_trees`.

        Parameters
        ----------
        path : str or Path
            The file: ``.graphml``, ``.geojson`` or ``.json``. It is written completely or not at
            all.
        robot, time_s
            As for `known_map`.
        overwrite : bool, optional
            Whether an existing file is replaced.

        Raises
        ------
        InvalidInputError
            If the suffix is not supported, there is no such robot or time, no node existed at that
            time, the file exists and `overwrite` is false, or it cannot be written.

        Examples
        --------
        >>> import multisrt as ms
        >>> ms.explore("open", seed=1, max_time_s=10.0).save_trees("tree.graphml")
        """
        from multisrt.exporting import save_trees

        save_trees(self.recording, path, robot=robot, time_s=time_s, overwrite=overwrite)

    def save_trajectories(
        self,
        path: str | Path,
        *,
        robot: int | None = None,
        rate_hz: float | None = None,
        overwrite: bool = False,
    ) -> list[Path]:
        """Write the trajectories of robots; see `multisrt.exporting.save_trajectories`.

        Parameters
        ----------
        path : str or Path
            The file: ``.csv``, ``.json``, or ``.tum`` or ``.txt`` in the format of the TUM RGB-D
            benchmark, with one file per robot.
        robot : int, optional
            The robot, from 0; by default all.
        rate_hz : float, optional
            Poses per second while a robot moves, in addition to its waypoints; by default only
            waypoints.
        overwrite : bool, optional
            Whether existing files are replaced.

        Returns
        -------
        list of Path
            The files.

        Raises
        ------
        InvalidInputError
            If the suffix is not supported, there is no such robot, the rate is out of range, a file
            exists and `overwrite` is false, or it cannot be written.

        Examples
        --------
        >>> import multisrt as ms
        >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
        >>> [file.name for file in run.save_trajectories("run.tum", rate_hz=10.0)]
        ['run-0.tum', 'run-1.tum']
        """
        from multisrt.exporting import save_trajectories

        return save_trajectories(
            self.recording, path, robot=robot, rate_hz=rate_hz, overwrite=overwrite
        )
