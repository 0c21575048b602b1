"""Missions executed one by one: each is judged, some are repeated, failures are shrunk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Final, NamedTuple

import msgspec

from multisrt.campaign.failure import SPEC_NAME, Failure, free_folder, write_failure
from multisrt.campaign.jobs import Judge, Make
from multisrt.campaign.mission import Verdict
from multisrt.campaign.mission_process import HANG_S, HANGS, MissionProcess
from multisrt.campaign.shrinking import MAX_TRIES, Shrunk, shrink
from multisrt.campaign.violations import Violation
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import RunSpec

EQUAL_DIGEST: Final = "equal-digest"
"""Name of the invariant that another process makes an equal recording."""

REPEATED_EVERY: Final = 20
"""Interval, in missions, at which one that holds all invariants is repeated in another process."""

HERE, ELSEWHERE = 1, 2
"""Seeds of the order of sets in processes that make missions, and in those that repeat them."""

HANG_SHRINK_S: Final = 120.0
"""Time limit of the runs by which a hanging one is shrunk (s)."""

HANG_TRIES: Final = 8
"""Maximum number of these runs, each of which takes up to twice that time."""

Quota = Callable[[str, str], bool]
"""Whether one more failure of an invariant and a strategy is to be shrunk."""


class Mission(msgspec.Struct, frozen=True, kw_only=True):
    """A mission that was made, and what was judged of it.

    Attributes
    ----------
    number : int
        Its number.
    spec : RunSpec or None
        The run; None if drawing it failed.
    refused : int
        Number of draws before it that the program refused as impossible.
    verdict : Verdict
        What is judged.
    repeated : bool
        Whether it was repeated in another process.
    folders : tuple of str
        Folders of its failures, one for each violated invariant; empty texts where there is no
        run.
    """

    number: int
    spec: RunSpec | None = None
    refused: int = 0
    verdict: Verdict
    repeated: bool = False
    folders: tuple[str, ...] = ()


class Found(NamedTuple):
    """What a mission violates, as long as its failures are not shrunk.

    Attributes
    ----------
    number : int
        Number of the mission.
    violations : tuple of Violation
        The invariants that it violates.
    """

    number: int
    violations: tuple[Violation, ...]


class Lane:
    """Makes missions of a campaign in one process, and repeats some in another.

    Use it from one thread; only `stop` may be called by another.

    Parameters
    ----------
    seed : int
        Seed of the campaign.
    folder : Path
        Folder for the folders of failures.
    quota : callable
        Takes an invariant and a strategy, and returns whether one more of their failures is to be
        shrunk.
    """

    def __init__(self, seed: int, folder: Path, quota: Quota) -> None:
        self._seed = seed
        self._folder = folder
        self._quota = quota
        self._process = MissionProcess(HERE)
        self._other = MissionProcess(ELSEWHERE)

    def close(self) -> None:
        """End both processes."""
        self._process.close()
        self._other.close()

    def stop(self) -> None:
        """Kill both processes, even at a mission; no other is started."""
        self._process.stop()
        self._other.stop()

    def make(self, number: int) -> Iterator[Found | Mission]:
        """Make a mission, and leave a folder for each invariant that it violates.

        Parameters
        ----------
        number : int
            Its number.

        Yields
        ------
        Found
            The invariants that it violates, if any, before its failures are shrunk.
        Mission
            The mission.

        Raises
        ------
        StoppedError
            If `stop` is called meanwhile.
        InvalidInputError
            If a failure cannot be written.
        """
        verdict, tried = self._process.ask(Make(seed=self._seed, number=number))
        if tried is None or tried.spec is None:  # it failed in drawing, as in building a world
            yield Mission(number=number, verdict=verdict, folders=("",) * len(verdict.violations))
            return
        spec = tried.spec
        repeated = bool(verdict.violations) or number % REPEATED_EVERY == 0
        if repeated:
            verdict = compared(spec, verdict, self._other)
        if verdict.violations:
            yield Found(number, verdict.violations)
        folders = [self._failure(number, spec, verdict, found) for found in verdict.violations]
        yield Mission(
            number=number,
            spec=spec,
            refused=tried.refused,
            verdict=verdict,
            repeated=repeated,
            folders=tuple(map(str, folders)),
        )

    def judge(self, spec: RunSpec, limit_s: float = HANG_S) -> Verdict:
        """Make a run and judge it; see `multisrt.campaign.mission.judge`.

        Parameters
        ----------
        spec : RunSpec
            The run.
        limit_s : float
            Time after which it is taken to hang (s).

        Returns
        -------
        Verdict
            What is judged, also of a run that hangs or takes its process down.
        """
        return self._process.ask(Judge(spec=spec), limit_s).verdict

    def _failure(self, number: int, drawn: RunSpec, verdict: Verdict, found: Violation) -> Path:
        shrunk = Shrunk(drawn, found, 0)
        if self._quota(found.invariant, drawn.strategy):
            shrunk = self._shrunk(drawn, found)
        folder = free_folder(self._folder, number, found.invariant)
        failure = Failure(
            seed=self._seed,
            number=number,
            tries=shrunk.tries,
            **msgspec.structs.asdict(shrunk.violation),
        )
        write_failure(folder, failure, shrunk.spec, drawn)
        if verdict.outcome != "lost":
            job = Judge(spec=shrunk.spec, folder=str(folder.resolve()))
            digest = self._process.ask(job).verdict.digest
            write_failure(
                folder, msgspec.structs.replace(failure, digest=digest), shrunk.spec, drawn
            )
        return folder

    def _shrunk(self, drawn: RunSpec, found: Violation) -> Shrunk:
        if found.invariant == HANGS:
            return shrink(drawn, found, lambda spec: self.judge(spec, HANG_SHRINK_S), HANG_TRIES)
        if found.invariant == EQUAL_DIGEST:
            return shrink(drawn, found, self._judge_twice, MAX_TRIES)
        return shrink(drawn, found, self.judge, MAX_TRIES)

    def _judge_twice(self, spec: RunSpec) -> Verdict:
        return compared(spec, self.judge(spec), self._other)


def compared(spec: RunSpec, verdict: Verdict, other: MissionProcess) -> Verdict:
    """Return a verdict, with a violation if another process makes another recording.

    Parameters
    ----------
    spec : RunSpec
        The run.
    verdict : Verdict
        What is judged of it. One without a recording is not compared.
    other : MissionProcess
        Makes the other recording.

    Returns
    -------
    Verdict
        The verdict.
    """
    if not verdict.digest:
        return verdict
    there = other.ask(Judge(spec=spec)).verdict
    if there.digest == verdict.digest:
        return verdict
    found = f"digest {there.digest[:12]}" if there.digest else f"{there.outcome}: {there.reason}"
    says = f"a run with digest {verdict.digest[:12]} has in another process {found}"
    violation = Violation(invariant=EQUAL_DIGEST, says=says)
    return msgspec.structs.replace(verdict, violations=(*verdict.violations, violation))


def replayed(spec: RunSpec, folder: Path, violation: Violation) -> Sequence[Violation]:
    """Run the spec of a failure again; if it still fails, write its recording and its replay.

    Parameters
    ----------
    spec : RunSpec
        The spec.
    folder : Path
        The folder of the failure.
    violation : Violation
        How it failed. Only where that says that another process made another recording is the run
        repeated in another one.

    Returns
    -------
    sequence of Violation
        The invariants that it violates now.

    Raises
    ------
    InvalidInputError
        If the program refuses the spec, or the recording or the replay cannot be written.
    """
    with closing(MissionProcess(HERE)) as process, closing(MissionProcess(ELSEWHERE)) as other:
        verdict = process.ask(Judge(spec=spec)).verdict
        if verdict.outcome == "refused":
            raise InvalidInputError(f"{folder / SPEC_NAME}: {verdict.reason}")
        if violation.invariant == EQUAL_DIGEST:
            verdict = compared(spec, verdict, other)
        if verdict.violations and verdict.outcome != "lost":
            process.ask(Judge(spec=spec, folder=str(folder.resolve())))
    return verdict.violations
