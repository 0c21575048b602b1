"""The runs to make, their results, and the file that keeps them."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path

import msgspec

from multisrt.geometry.errors import InvalidInputError

STORE = "runs.jsonl"
"""File of the results: a line for each run."""

TABLE = "runs.csv"
"""Table of the runs of the last call."""


class Job(msgspec.Struct, frozen=True, kw_only=True):
    """One run of a policy.

    Attributes
    ----------
    map : str
        Name of the map.
    robots : int
        Number of robots.
    start : (int, int)
        Column and row of the cell where the base is and all robots start.
    steps : int
        Number of steps.
    """

    map: str
    robots: int
    start: tuple[int, int]
    steps: int


class JobResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came of a run.

    Attributes
    ----------
    coverage : float
        Share of the map that the base knows at the end, by the competition's ``scoring.py``.
    decision_s : float
        Mean time of the policy for a robot and step, in seconds.
    wall_s : float
        Time of the whole run in seconds.
    replaced : tuple of str
        Modules in whose place a stand-in computed; see `multisrt.competition.stand_ins`.
    fast : bool
        Whether faster functions were in place; see `multisrt.competition.faster`.
    """

    coverage: float
    decision_s: float
    wall_s: float
    replaced: tuple[str, ...]
    fast: bool = False


class _Row(msgspec.Struct, frozen=True, kw_only=True):
    policy: str
    clone: str
    job: Job
    result: JobResult


class JobStore:
    """Results in a folder, each line written when its run has ended.

    Parameters
    ----------
    folder : Path
        Made if it is missing.
    policy, clone : str
        Digests of what the results depend on; results of others are kept, and not used.

    Raises
    ------
    InvalidInputError
        If the folder cannot be made, or its file is not one of results.

    Examples
    --------
    >>> store = JobStore(Path("compete"), "a policy", "a clone")
    >>> job = Job(map="env1", robots=1, start=(100, 60), steps=1000)
    >>> store.add(job, JobResult(coverage=0.7, decision_s=0.01, wall_s=50.0, replaced=()))
    >>> JobStore(Path("compete"), "a policy", "a clone").results[job].coverage
    0.7
    >>> len(JobStore(Path("compete"), "another policy", "a clone").results)
    0
    """

    def __init__(self, folder: Path, policy: str, clone: str) -> None:
        self.folder = folder
        self._policy, self._clone = policy, clone
        self.results: dict[Job, JobResult] = {}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path = folder / STORE
            text = path.read_bytes() if path.exists() else b""
            if text and not text.endswith(b"\n"):  # killed while it wrote
                text = text[: text.rfind(b"\n") + 1]
                path.write_bytes(text)
        except OSError as error:
            raise InvalidInputError(f"cannot write {folder}: {error.strerror}") from error
        for number, line in enumerate(text.splitlines(), 1):
            try:
                row = msgspec.json.decode(line, type=_Row)
            except msgspec.MsgspecError as error:
                raise InvalidInputError(
                    f"{path}, line {number} is not a result: {error}; give another --out"
                ) from error
            if (row.policy, row.clone) == (policy, clone):
                self.results[row.job] = row.result

    def add(self, job: Job, result: JobResult) -> None:
        """Keep the result of a run."""
        row = _Row(policy=self._policy, clone=self._clone, job=job, result=result)
        with (self.folder / STORE).open("ab") as file:
            file.write(msgspec.json.encode(row) + b"\n")
        self.results[job] = result

    def write_table(self, jobs: Iterable[Job]) -> Path:
        """Write the results of some runs as CSV, and return the file."""
        path = self.folder / TABLE
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(
                ("map", "robots", "start_x", "start_y", "steps", "coverage", "decision_s", "wall_s")
            )
            for job in jobs:
                found = self.results[job]
                writer.writerow(
                    (
                        job.map, job.robots, *job.start, job.steps, round(found.coverage, 6),
                        round(found.decision_s, 6), round(found.wall_s, 3),
                    )
                )  # fmt: skip
        return path


def means(results: Mapping[Job, JobResult], maps: Iterable[str], robots: int) -> list[float]:
    """Return the mean coverage on each of some maps for a number of robots, in per cent."""
    found = []
    for name in maps:
        values = [
            result.coverage
            for job, result in results.items()
            if job.map == name and job.robots == robots
        ]
        found.append(100.0 * sum(values) / len(values))
    return found
