"""Jobs for workers and their answers: JSON objects, one a line."""

from __future__ import annotations

import msgspec

from multisrt.analysis.metrics import SUCCESS_COVERAGE
from multisrt.experiments.crossing import Condition, PlannedRun
from multisrt.experiments.provenance import Provenance
from multisrt.experiments.results import Result, Status
from multisrt.experiments.spec import Limits
from multisrt.spec import RunSpec


class Job(msgspec.Struct, frozen=True, kw_only=True):
    """A run for a worker to make.

    Attributes
    ----------
    key, condition, repetition, spec
        The fields of the `PlannedRun`.
    limits : Limits
        Limits of computing time and memory.
    recording : str
        File for the recording; empty: none is written.
    only_failed : bool
        Whether to write the recording only if the run is not a success.
    success_coverage : float
        Share of the explorable area that the run must cover to be a success.
    horizon_s : float or None
        Time to which integrals run (s); None: to the end of the run.
    """

    key: str
    condition: Condition
    repetition: int
    spec: RunSpec
    limits: Limits
    recording: str = ""
    only_failed: bool = False
    success_coverage: float = SUCCESS_COVERAGE
    horizon_s: float | None = None

    @property
    def run(self) -> PlannedRun:
        """The planned run."""
        return PlannedRun(
            key=self.key, condition=self.condition, repetition=self.repetition, spec=self.spec
        )

    def without_result(
        self, status: Status, reason: str, *, wall_s: float = 0.0, computing_s: float = 0.0
    ) -> Result:
        """Return the result of a run whose process ended before it did.

        Parameters
        ----------
        status : str
            How it ended.
        reason : str
            Why, in words.
        wall_s, computing_s : float
            Elapsed time and computing time (s), where known.

        Returns
        -------
        Result
            A result without metrics.
        """
        return Result(
            key=self.key,
            condition=self.condition,
            repetition=self.repetition,
            status=status,
            reason=reason,
            success_coverage=self.success_coverage,
            wall_s=wall_s,
            computing_s=computing_s,
        )


class Ready(msgspec.Struct, frozen=True, tag="ready"):
    """First answer of a worker: it is ready, and which program it is."""

    provenance: Provenance


class Unable(msgspec.Struct, frozen=True, tag="unable"):
    """Answer of a worker that cannot begin, or cannot write a recording."""

    reason: str


class Compiling(msgspec.Struct, frozen=True, tag="compiling"):
    """Answer before that to a job: kernels are being compiled for its run.

    Attributes
    ----------
    done, about : int
        Number of kernels compiled so far, and about how many it will be.
    """

    done: int
    about: int


class Compiled(msgspec.Struct, frozen=True, tag="compiled"):
    """Answer before that to a job: no kernel is being compiled any more, for the time being."""


class Made(msgspec.Struct, frozen=True, tag="made"):
    """Answer to a job: the result of the run."""

    result: Result


Compilation = Compiling | Compiled
"""What a worker answers, any number of times, before it answers the job."""

Answer = Ready | Unable | Compilation | Made

ANSWERS = msgspec.json.Decoder(Answer)
"""Decodes a line that a worker wrote."""
