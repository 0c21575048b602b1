"""Runs of the competition, their results, and the file in which results are stored."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path

import msgspec

from multisrt.geometry.errors import InvalidInputError

STORE = "runs.jsonl"
"""Name of the file of results: one line per run."""

TABLE = "runs.csv"
"""Name of the table of the runs of the last call."""


class Job(msgspec.Struct, frozen=True, kw_only=True):
    """One run of a policy.

    Attributes
    ----------
    map : str
        Name of the map.
    robots : int
        Number of robots.
    start : (int, int)
        Column and row of the cell in which the base stands and all robots start.
    steps : int
        Number of steps.
    """

    map: str
    robots: int
    start: tuple[int, int]
    steps: int


class JobResult(msgspec.Struct, frozen=True, kw_only=True):
    """The result of a run.

    Attributes
    ----------
    coverage : float
        Share of the map that the base knows at the end, as the competition's ``scoring.py``
        computes it.
    decision_s : float
        Mean time that the policy took per robot and step, in seconds.
    wall_s : float
        Time that the whole run took, in seconds.
    replaced : tuple of str
        Modules that stand-ins replaced; see `multisrt.competition.stand_ins`.
    fast : bool
        Whether faster functions replaced the simulator's; see `multisrt.competition.faster`.
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
    """A store of results in a folder, to which each result is written as its run ends.

    Parameters
    ----------
    folder : Path
        The folder; created if it is missing.
    policy, clone : str
        Digests of the policy and of the simulator. Results with other digests stay in the file, but
        are not used.

    Attributes
    ----------
    folder : Path
        The folder.
    results : dict of Job to JobResult
        The results with these digests.

    Raises
    ------
    InvalidInputError
        If the folder cannot be created, or its file is not a file of results.

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
            if text and not text.endswith(b"\n"):  # the process was killed while it wrote
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
        """Store the result of a run."""
        row = _Row(policy=self._policy, clone=self._clone, job=job, result=result)
        with (self.folder / STORE).open("ab") as file:
            file.write(msgspec.json.encode(row) + b"\n")
        self.results[job] = result

    def write_table(self, jobs: Iterable[Job]) -> Path:
        """Write the results of some runs as a CSV file, and return its path."""
        path = self.folder / TABLE
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(
                ("map", "robots", "start_x", "start_y", "steps", "coverage", "decision_s", "wall_s")
            )
            for job in jobs:
                result = self.results[job]
                writer.writerow(
                    (
                        job.map, job.robots, *job.start, job.steps, round(result.coverage, 6),
                        round(result.decision_s, 6), round(result.wall_s, 3),
                    )
                )  # fmt: skip
        return path


def mean_coverages(
    results: Mapping[Job, JobResult], maps: Iterable[str], robots: int
) -> list[float]:
    """Return the mean coverage on each map for a number of robots, in per cent."""
    means = []
    for name in maps:
        values = [
            result.coverage
            for job, result in results.items()
            if job.map == name and job.robots == robots
        ]
        means.append(100.0 * sum(values) / len(values))
    return means
