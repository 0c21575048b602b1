"""Export of a whole run for viewers, in a format chosen by the suffix of the file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Final

from multisrt.environments.environment import Environment
from multisrt.exporting.grids import grid_of
from multisrt.exporting.mcap_export import write_mcap
from multisrt.exporting.moments import Moment, moments
from multisrt.exporting.options import ExportOptions
from multisrt.exporting.rerun_export import write_rerun
from multisrt.exporting.written import require_suffix
from multisrt.recording import Recording, atomic_write

Progress = Callable[[float], None]
"""Takes the share of the work that is done, from 0 to 1."""

FORMATS: Final = {
    ".mcap": "MCAP with messages of ROS 2, for Foxglove and 'ros2 bag'",
    ".rrd": "rerun",
}
"""Descriptions of the formats by suffix."""


def export_run(
    recording: Recording,
    path: str | Path,
    *,
    options: ExportOptions | None = None,
    environment: Environment | None = None,
    progress: Progress | None = None,
) -> None:
    """Write a run to a file for viewers such as Foxglove, rviz2 and rerun.

    Parameters
    ----------
    recording : Recording
        The run.
    path : str or Path
        The file, whose suffix determines the format: ``.mcap`` or ``.rrd``. It is written
        completely or not at all, and replaced if it exists.
    options : ExportOptions, optional
        Layers that are left out, and how densely the run is sampled.
    environment : Environment, optional
        Its world; by default it is built from the recording.
    progress : callable, optional
        Called with the share that is done, from 0 to 1.

    Raises
    ------
    InvalidInputError
        If the suffix is another one, the file cannot be written, the recording contradicts
        itself, or there would be too many poses or cells.
    MissingExtraError
        If a package that the format needs is not installed.

    Examples
    --------
    >>> import multisrt as ms
    >>> from multisrt.exporting import export_run
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> export_run(run.recording, "run.mcap")
    """
    path = Path(path)
    require_format(path)
    options = options or ExportOptions()
    environment = environment or recording.environment()
    grid = grid_of(recording, environment, options)
    contents: Iterable[Moment] = moments(recording, environment, grid, options)
    if progress is not None:
        contents = _watched(contents, progress, recording.footer.time_s)
    with atomic_write(path) as file:
        if path.suffix.lower() == ".mcap":
            write_mcap(file, recording, grid, contents)
        else:
            write_rerun(Path(file.name), recording, environment, grid, contents)


def require_format(path: Path) -> None:
    """Raise an `InvalidInputError` if the suffix of a path is none of `FORMATS`."""
    require_suffix(path, FORMATS, "runs")


def _watched(contents: Iterable[Moment], progress: Progress, end_s: float) -> Iterator[Moment]:
    shown = 0.0
    for now, content in contents:
        share = min(1.0, now / (1e9 * end_s)) if end_s > 0.0 else 1.0
        if share > shown + 0.01:
            shown = share
            progress(share)
        yield now, content
