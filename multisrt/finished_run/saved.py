"""A finished run and its files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from multisrt.extras.notebook import Text
from multisrt.finished_run.pictured import PicturedRun
from multisrt.recording import atomic_write

if TYPE_CHECKING:
    from multisrt.exporting import ExportOptions

RECORDING_NAME = "recording.jsonl"
RUN_NAME = "run.json"
TREE_NAME = "tree.svg"
SPEC_NAME = "spec.toml"
RUN_FILES = (TREE_NAME, RUN_NAME, SPEC_NAME, RECORDING_NAME)
"""Files of a run that was saved, in the order in which they are listed."""


class Run(PicturedRun):
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
