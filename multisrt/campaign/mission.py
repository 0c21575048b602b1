"""One mission: a run within a bound of events, and what is judged of it."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Final, NamedTuple

import msgspec

from multisrt.campaign.draws import OnDraw, drawn, is_refusal
from multisrt.campaign.invariants import JudgedRun, check
from multisrt.campaign.violations import MAX_LENGTH, Violation, quoted
from multisrt.campaign.witness import Witness
from multisrt.campaign.worlds import world_of
from multisrt.events import Event
from multisrt.experiments.mission import lacks_memory
from multisrt.recording import Recording
from multisrt.robots.defects import ExplorerDefect
from multisrt.simulation.setting_up import SetUp, set_up
from multisrt.simulation.simulation import Simulation
from multisrt.spec import RunSpec

NO_ERROR, ENDS, JUDGED = "no-error", "ends", "can-be-judged"
"""Names of the invariants that are judged here."""

MIN_STEPS: Final = 20_000
STEPS_PER_ROBOT_S: Final = 100
STEPS_PER_PAIR_S: Final = 30
"""Maximum number of events of the clock: in any run, and added for each second and each robot, and
for each pair of them in either order, as each tells the others what it sees."""

MAX_TEXT: Final = 400
"""Length to which messages of errors are cut, in characters."""

OVER_MEMORY: Final = "over_memory"
"""The outcome of a mission that could not allocate what it needs."""


class Verdict(msgspec.Struct, frozen=True, kw_only=True):
    """What is judged of a mission.

    Attributes
    ----------
    outcome : str
        How the run ended: "complete", "stalled" or "out_of_time" as its recording says; "refused"
        if the program refuses the spec as impossible; "error" if it raised an error, "over_memory"
        if that was for want of memory; "endless" if it exceeded the bound of events; "lost" if its
        process ended or hung.
    violations : tuple of Violation
        The invariants that do not hold.
    reason : str
        Why it ended, in words.
    time_s : float
        When it ended, in seconds of the run.
    events : int
        Number of recorded events.
    steps : int
        Number of events of the clock.
    digest : str
        Digest of the recording; empty if there is none.
    run_s, check_s : float
        Elapsed time of the run and of the invariants, in seconds.
    """

    outcome: str
    violations: tuple[Violation, ...] = ()
    reason: str = ""
    time_s: float = 0.0
    events: int = 0
    steps: int = 0
    digest: str = ""
    run_s: float = 0.0
    check_s: float = 0.0


class Judged(NamedTuple):
    """A verdict, and the recording that it is about.

    Attributes
    ----------
    verdict : Verdict
        What is judged.
    recording : Recording or None
        The recording; of a run that was cut off, up to there; None if it did not begin.
    """

    verdict: Verdict
    recording: Recording | None


class _EndlessError(Exception):
    """A run exceeded its bound of events."""


def judge(spec: RunSpec) -> Verdict:
    """Make a run, and judge whether all invariants hold.

    Parameters
    ----------
    spec : RunSpec
        The run.

    Returns
    -------
    Verdict
        What is judged. Whatever the program raises is a violation of "no-error".

    Examples
    --------
    >>> import multisrt as ms
    >>> world = ms.CatalogEnvironment(name="open", parameters={"size_m": 6.0})
    >>> verdict = judge(ms.RunSpec(environment=world, strategy="closest"))
    >>> verdict.outcome, verdict.violations
    ('complete', ())
    """
    return judge_recorded(spec).verdict


def judge_recorded(spec: RunSpec) -> Judged:
    """Make a run, judge it, and return its recording, too; see `judge`.

    Parameters
    ----------
    spec : RunSpec
        The run.

    Returns
    -------
    Judged
        Verdict and recording.
    """
    begin_s = time.perf_counter()
    try:
        environment = world_of(spec.environment)
        setup = set_up(spec, environment)
    except Exception as error:
        if is_refusal(error):
            return Judged(Verdict(outcome="refused", reason=str(error)), None)
        return Judged(_failed(error, 0, begin_s), None)
    return _judged(setup, begin_s)


def make(seed: int, number: int, on_draw: OnDraw | None = None) -> Verdict:
    """Draw a mission of a campaign, and judge it.

    Parameters
    ----------
    seed, number, on_draw
        As for `multisrt.campaign.draws.drawn`.

    Returns
    -------
    Verdict
        What is judged.
    """
    begin_s = time.perf_counter()
    try:
        mission = drawn(seed, number, on_draw)
    except Exception as error:  # of a generator, as only refusals are drawn again
        return _failed(error, 0, begin_s)
    if mission.setup is None:
        return judge(mission.spec)
    return _judged(mission.setup, time.perf_counter()).verdict


def max_steps(spec: RunSpec) -> int:
    """Return the number of events of the clock within which a run has to end.

    Parameters
    ----------
    spec : RunSpec
        The run.

    Examples
    --------
    >>> import multisrt as ms
    >>> stop = ms.StopRule(max_time_s=100.0)
    >>> max_steps(ms.RunSpec(environment=ms.CatalogEnvironment(name="open"), stop=stop))
    30000
    """
    team = len(spec.robots)
    a_second = STEPS_PER_ROBOT_S * team + STEPS_PER_PAIR_S * team * (team - 1)
    return MIN_STEPS + int(a_second * spec.stop.max_time_s)


def _judged(setup: SetUp, begin_s: float) -> Judged:
    steps, most = 0, max_steps(setup.spec)
    recorded = 0
    witness = Witness(setup)

    def watch(event: Event) -> None:
        # Events that are recorded within one event of the clock.
        nonlocal recorded
        recorded += 1
        if recorded > most:
            raise _EndlessError
        witness.watch(event)

    with closing(Simulation(setup, watch=watch, overhear=witness.overhear)) as simulation:
        try:
            while simulation.has_events():
                simulation.clock.step()
                steps += 1
                if steps > most:
                    raise _EndlessError
            recording = simulation.finish()
        except Exception as error:
            cut_off = _attempted(simulation.recording_so_far)
            if isinstance(error, _EndlessError):
                verdict = _endless(simulation.clock.now_s, steps, recorded, begin_s)
            else:
                verdict = _failed(error, steps, begin_s, simulation.clock.now_s)
            return Judged(verdict, cut_off)
    run_s = time.perf_counter() - begin_s
    footer = recording.footer
    violations: tuple[Violation, ...]
    try:
        run = JudgedRun(recording=recording, environment=setup.environment)
        violations = (*check(run), *witness.violations(run))
    except Exception as error:
        if lacks_memory(error):
            return Judged(_failed(error, steps, begin_s, footer.time_s), recording)
        violations = (Violation(invariant=JUDGED, says=quoted(described(error), MAX_LENGTH)),)
    verdict = Verdict(
        outcome=footer.outcome,
        violations=violations,
        reason=footer.reason,
        time_s=footer.time_s,
        events=len(recording.events),
        steps=steps,
        digest=footer.digest,
        run_s=run_s,
        check_s=time.perf_counter() - begin_s - run_s,
    )
    return Judged(verdict, recording)


def _attempted(record: Callable[[], Recording]) -> Recording | None:
    try:
        return record()
    except Exception:  # of a run that failed; what failed is in the verdict
        return None


def _failed(error: Exception, steps: int, begin_s: float, time_s: float = 0.0) -> Verdict:
    says = described(error)
    return Verdict(
        outcome=OVER_MEMORY if lacks_memory(error) else "error",
        violations=(Violation(invariant=NO_ERROR, says=quoted(says, MAX_LENGTH), time_s=time_s),),
        reason=says,
        time_s=time_s,
        steps=steps,
        run_s=time.perf_counter() - begin_s,
    )


def _endless(time_s: float, steps: int, recorded: int, begin_s: float) -> Verdict:
    says = f"at {time_s:g} s not ended after {steps} events of the clock, {recorded} recorded"
    return Verdict(
        outcome="endless",
        violations=(Violation(invariant=ENDS, says=says, time_s=time_s),),
        reason=says,
        time_s=time_s,
        events=recorded,
        steps=steps,
        run_s=time.perf_counter() - begin_s,
    )


def described(error: BaseException) -> str:
    r"""Return an error in one line: its kind and place, a colon, and its message.

    Parameters
    ----------
    error : BaseException
        The error; of an `ExplorerDefect` that another one caused, that one is described.

    Returns
    -------
    str
        Such as ``KeyError in team.py:120: 3``.

    Examples
    --------
    >>> described(ValueError("no such\nthing"))
    'ValueError: no such thing'
    """
    while isinstance(error, ExplorerDefect) and error.__cause__ is not None:
        error = error.__cause__
    places = traceback.extract_tb(error.__traceback__)
    at = f" in {Path(places[-1].filename).name}:{places[-1].lineno}" if places else ""
    said = " ".join(str(error).encode(errors="replace").decode().split())
    return f"{type(error).__name__}{at}" + (f": {said[:MAX_TEXT]}" if said else "")
