"""Making one run of an experiment: environment, simulation and metrics."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import lru_cache
from pathlib import Path

import msgspec

from multisrt.analysis.measuring import Curves, measure_with_curves
from multisrt.analysis.metrics import SUCCESS_COVERAGE, Metrics
from multisrt.environments.environment import Environment
from multisrt.experiments.crossing import PlannedRun
from multisrt.experiments.job import Compilation, Compiled, Compiling
from multisrt.experiments.limits import OverTimeError, within
from multisrt.experiments.memory import peak_memory_mb, reset_peak_memory
from multisrt.experiments.results import Result, Status
from multisrt.experiments.spec import Limits
from multisrt.geometry.errors import InvalidInputError
from multisrt.geometry.numerics.compilation import watch_compilation
from multisrt.recording import Recording
from multisrt.robots.defects import ExplorerDefect
from multisrt.simulation.simulate import simulate
from multisrt.simulation.worlds import build_environment
from multisrt.spec import EnvironmentSpec

MAX_WORLDS_KEPT = 32
"""Environments that a process keeps built."""

MAX_REASON_LENGTH = 1000
"""Length to which reasons are cut, in characters."""


def make_run(
    run: PlannedRun,
    limits: Limits | None,
    recording_path: Path | None = None,
    *,
    only_failed: bool = False,
    success_coverage: float = SUCCESS_COVERAGE,
    horizon_s: float | None = None,
) -> Result:
    """Execute a run in this process; with limits, in its main thread.

    Parameters
    ----------
    run : PlannedRun
        The run.
    limits : Limits or None
        Its limits of computing time and memory; None: it has none.
    recording_path : Path, optional
        File for the recording; a run that does not come to an end has none.
    only_failed : bool
        Whether to write the recording only if the run is not a success.
    success_coverage : float
        Share of the explorable area that the run must cover to be a success.
    horizon_s : float, optional
        Time to which integrals run (s); by default to the end of the run.

    Returns
    -------
    Result
        The result; whatever goes wrong in the run is its status and reason.

    Raises
    ------
    InvalidInputError
        If the recording cannot be written; nothing is left behind.
    """
    reset_peak_memory()
    begin, computed_s = time.perf_counter(), time.process_time()
    status: Status
    recording: Recording | None = None
    metrics: Metrics | None = None
    curves = Curves(())
    try:
        with nullcontext() if limits is None else within(limits):
            where = world_of(run.spec.environment)
            recording = simulate(run.spec, where)
            metrics, curves = measure_with_curves(recording, where, horizon_s=horizon_s)
            # A value that JSON cannot hold, such as infinity, is an error of this run.
            metrics = msgspec.json.decode(msgspec.json.encode(metrics), type=Metrics)
        status, reason = recording.footer.outcome, recording.footer.reason
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # strategies may raise anything
        status, reason = _what_went_wrong(error, limits)
        recording, metrics, curves = None, None, Curves(())
    result = Result(
        key=run.key,
        condition=run.condition,
        repetition=run.repetition,
        status=status,
        reason=_one_line(reason),
        digest="" if recording is None else recording.footer.digest,
        metrics=metrics,
        horizon_s=None if metrics is None else horizon_s,
        success_coverage=success_coverage,
        chance=recording is None or recording.footer.chance,
        covered_at_s=curves.covered_at_s,
        delivered_at_s=curves.delivered_at_s,
        computing_s=time.process_time() - computed_s,
        wall_s=time.perf_counter() - begin,
        memory_mb=peak_memory_mb(),
    )
    if recording_path is not None and recording is not None and (result.failed or not only_failed):
        recording.save(recording_path)
    return result


@contextmanager
def compilation_told(tell: Callable[[Compilation], None]) -> Iterator[None]:
    """Report the kernels that are compiled while a ``with`` block is executed.

    Parameters
    ----------
    tell : callable
        Takes a `Compiling` before and after each compilation, and a `Compiled` when no kernel is
        being compiled any more.
    """
    with watch_compilation(
        lambda done, about: tell(Compiling(done, about)), lambda: tell(Compiled())
    ):
        yield


def world_of(spec: EnvironmentSpec) -> Environment:
    """Return the environment of a spec, from a cache of recent ones.

    Parameters
    ----------
    spec : EnvironmentSpec
        The spec.

    Returns
    -------
    Environment
        The environment.

    Raises
    ------
    InvalidInputError
        If it cannot be built.
    """
    return _world(msgspec.json.encode(spec))


@lru_cache(maxsize=MAX_WORLDS_KEPT)
def _world(spec: bytes) -> Environment:
    described: EnvironmentSpec = msgspec.json.decode(spec, type=EnvironmentSpec)
    return build_environment(described)


def _what_went_wrong(error: BaseException, limits: Limits | None) -> tuple[Status, str]:
    chain = _chain(error)
    over = [each for each in chain if isinstance(each, OverTimeError)]
    if over:
        return "over_time", str(over[0])
    if limits is not None and lacks_memory(error):
        return "over_memory", f"wants more than {limits.memory_mb} MB"
    said = str(error)
    while isinstance(error, ExplorerDefect) and error.__cause__ is not None:
        error = error.__cause__
    if isinstance(error, InvalidInputError):
        return "refused", said
    place = traceback.extract_tb(error.__traceback__)[-1]
    what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    return "error", f"{what} ({Path(place.filename).name}:{place.lineno})"


def _one_line(text: str) -> str:
    """Return a text of any content as one line of bounded length."""
    words = " ".join(text.encode(errors="replace").decode().split())
    return words if len(words) <= MAX_REASON_LENGTH else words[: MAX_REASON_LENGTH - 3] + "..."


def lacks_memory(error: BaseException) -> bool:
    """Whether an error or one of its causes is that no more memory could be allocated."""
    # Libraries in C++ report it by the name of their exception.
    return any(isinstance(e, MemoryError) or "bad_alloc" in str(e) for e in _chain(error))


def _chain(error: BaseException) -> list[BaseException]:
    """Return an exception and its causes, the latest first."""
    chain: list[BaseException] = []
    here: BaseException | None = error
    while here is not None and here not in chain:
        chain.append(here)
        here = here.__cause__ or here.__context__
    return chain
