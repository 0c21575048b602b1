"""Trajectories of robots as CSV, JSON and in the format of the TUM RGB-D benchmark."""

from __future__ import annotations

import itertools
import json
import math
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from multisrt.analysis.poses import poses_on
from multisrt.analysis.run_tables import trajectories
from multisrt.exporting.options import MAX_RATE_HZ
from multisrt.exporting.sampling import inner_times
from multisrt.exporting.selection import require_robot
from multisrt.exporting.written import require_suffix, write_files
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording

MAX_POSES: Final = 20_000_000
"""Upper bound of the number of poses of all robots."""

COLUMNS: Final = ("robot", "time_s", "x_m", "y_m", "heading_rad", "motion", "purpose")
"""Columns of the tables, those of `multisrt.analysis.run_tables.trajectories`."""

TUM_HEADER: Final = "# timestamp tx ty tz qx qy qz qw"


class PoseRow(NamedTuple):
    """A pose of a robot: a waypoint, or a pose between two waypoints; see `COLUMNS`."""

    robot: int
    time_s: float
    x_m: float
    y_m: float
    heading_rad: float
    motion: int | None
    purpose: str | None


def pose_rows(
    recording: Recording, *, robot: int | None = None, rate_hz: float | None = None
) -> list[PoseRow]:
    """Return the waypoints of robots, and poses between them.

    Parameters
    ----------
    recording : Recording
        The run.
    robot : int, optional
        The robot, from 0; by default all.
    rate_hz : float, optional
        Poses of a moving robot per second, at multiples of the period, in addition to its
        waypoints; by default waypoints only.

    Returns
    -------
    list of PoseRow
        Sorted by robot, with times that never decrease; the first row of a robot is its start.

    Raises
    ------
    InvalidInputError
        If there is no such robot, the rate is out of range, or there would be too many poses.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", seed=1, max_time_s=10.0)
    >>> len(pose_rows(run.recording)) < len(pose_rows(run.recording, rate_hz=10.0))
    True
    """
    require_robot(recording, robot)
    columns = trajectories(recording)
    rows = [PoseRow(*row) for row in zip(*(columns[name].values for name in COLUMNS), strict=True)]
    rows = [row for row in rows if robot in (None, row.robot)]
    if rate_hz is None:
        return rows
    if not 0.0 < rate_hz <= MAX_RATE_HZ:
        raise InvalidInputError(
            f"the rate of poses must be above 0 and at most {MAX_RATE_HZ:g} Hz, not {rate_hz:g}"
        )
    if recording.footer.time_s * rate_hz * len(recording.starts) > MAX_POSES:
        raise InvalidInputError(
            f"{rate_hz:g} poses a second of {len(recording.starts)} robots are more than "
            f"{MAX_POSES:,}: choose a lower rate"
        )
    dense = rows[:1]
    for a, b in itertools.pairwise(rows):
        if (a.robot, a.motion) == (b.robot, b.motion) and a[2:5] != b[2:5]:
            dense += _between(a, b, 1.0 / rate_hz)
        dense.append(b)
    return dense


def _between(a: PoseRow, b: PoseRow, step_s: float) -> list[PoseRow]:
    times = inner_times(a.time_s, b.time_s, step_s)
    leg = np.broadcast_to(np.array([*a[1:5], *b[1:5]]), (len(times), 8))
    return [
        PoseRow(b.robot, time_s, x, y, heading, b.motion, b.purpose)
        for time_s, (x, y, heading) in zip(
            times.tolist(), poses_on(leg, times).tolist(), strict=True
        )
    ]


def save_trajectories(
    recording: Recording,
    path: str | Path,
    *,
    robot: int | None = None,
    rate_hz: float | None = None,
    overwrite: bool = False,
) -> list[Path]:
    """Write the trajectories of robots.

    Parameters
    ----------
    recording : Recording
        The run.
    path : str or Path
        The file, whose suffix determines the format: ``.csv``, ``.json``, or ``.tum`` or ``.txt``
        for the format of the TUM RGB-D benchmark, in which each robot has a file of its own. Files
        are written completely or not at all.
    robot, rate_hz
        As for `pose_rows`.
    overwrite : bool, optional
        Whether existing files are replaced.

    Returns
    -------
    list of Path
        The files. Those of a team in the TUM format have the numbers of the robots at the end of
        their names: ``run-0.tum``, ``run-1.tum``.

    Raises
    ------
    InvalidInputError
        If the suffix is another one, there is no such robot, there would be too many poses, a file
        exists and may not be replaced, or cannot be written.

    Examples
    --------
    >>> import multisrt as ms
    >>> run = ms.explore("open", robots=2, seed=1, max_time_s=10.0)
    >>> [file.name for file in save_trajectories(run.recording, "run.tum", rate_hz=10.0)]
    ['run-0.tum', 'run-1.tum']
    """
    path = Path(path)
    require_suffix(path, TRAJECTORY_FORMATS, "trajectories")
    paths = trajectory_files(recording, path, robot)
    rows = pose_rows(recording, robot=robot, rate_hz=rate_hz)
    if path.suffix.lower() in TUM_SUFFIXES:
        by_robot: dict[int, list[PoseRow]] = defaultdict(list)
        for row in rows:
            by_robot[row.robot].append(row)
        contents = [tum_bytes(own) for _, own in sorted(by_robot.items())]
    else:
        encoded = csv_bytes if path.suffix.lower() == ".csv" else json_bytes
        contents = [encoded(rows)]
    write_files(dict(zip(paths, contents, strict=True)), overwrite=overwrite)
    return paths


def trajectory_files(recording: Recording, path: Path, robot: int | None) -> list[Path]:
    """Return the files that `save_trajectories` writes."""
    robots = len(recording.starts)
    if path.suffix.lower() not in TUM_SUFFIXES or robot is not None or robots == 1:
        return [path]
    return [path.with_name(f"{path.stem}-{number}{path.suffix}") for number in range(robots)]


def csv_bytes(rows: Sequence[PoseRow]) -> bytes:
    """Return poses as CSV with a header; the start of a robot belongs to no motion."""
    lines = [",".join(COLUMNS)]
    lines += (",".join("" if value is None else str(value) for value in row) for row in rows)
    return ("\n".join(lines) + "\n").encode()


def json_bytes(rows: Sequence[PoseRow]) -> bytes:
    """Return poses as JSON: the names of the columns, and the rows of each robot, one per line.

    Parameters
    ----------
    rows : sequence of PoseRow
        By robot.

    Examples
    --------
    >>> found = json.loads(json_bytes([PoseRow(0, 0.0, 1.0, 2.0, 0.5, None, None)]))
    >>> found["columns"][:2], found["robots"]
    (['time_s', 'x_m'], [{'robot': 0, 'poses': [[0.0, 1.0, 2.0, 0.5, None, None]]}])
    """
    by_robot: dict[int, list[str]] = defaultdict(list)
    for row in rows:
        by_robot[row.robot].append(json.dumps(row[1:]))
    robots = ",\n".join(
        f'{{"robot": {robot}, "poses": [\n' + ",\n".join(own) + "\n]}"
        for robot, own in sorted(by_robot.items())
    )
    return f'{{"columns": {json.dumps(COLUMNS[1:])}, "robots": [\n{robots}\n]}}\n'.encode()


def tum_bytes(rows: Sequence[PoseRow]) -> bytes:
    r"""Return the poses of one robot in the format of the TUM RGB-D benchmark.

    Each line has the time in seconds, the position in metres with z = 0, and the heading as a
    quaternion. Times are strictly increasing: of several poses within a nanosecond, the last is
    kept.

    Parameters
    ----------
    rows : sequence of PoseRow
        Of one robot, by time.

    Examples
    --------
    >>> print(tum_bytes([PoseRow(0, 0.5, 1.0, 2.0, math.pi, None, None)]).decode())
    # timestamp tx ty tz qx qy qz qw
    0.500000000 1.000000000 2.000000000 0 0 0 1.000000000 0.000000000
    <BLANKLINE>

    Notes
    -----
    Source: Sturm et al., A Benchmark for the Evaluation of RGB-D SLAM Systems, IROS 2012, and the
    file formats on its page.
    """
    lines = {}
    for row in rows:
        time_s = f"{row.time_s:.9f}"
        half = 0.5 * row.heading_rad
        place = f"{row.x_m:.9f} {row.y_m:.9f}"
        lines[time_s] = f"{time_s} {place} 0 0 0 {math.sin(half):.9f} {math.cos(half):.9f}"
    return ("\n".join([TUM_HEADER, *lines.values()]) + "\n").encode()


TUM_SUFFIXES: Final = (".tum", ".txt")

TRAJECTORY_FORMATS: Final = {
    ".csv": "a table",
    ".json": "JSON",
    ".tum": "format of TUM",
    ".txt": "format of TUM",
}
"""Descriptions of the formats of trajectories by suffix."""
