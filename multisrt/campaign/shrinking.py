"""Shrinking: making the spec of a mission that fails simpler while it fails in the same way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

from multisrt.campaign.lasers import finds_all
from multisrt.campaign.mission import JUDGED, NO_ERROR, Verdict
from multisrt.campaign.simpler import simplifications
from multisrt.campaign.violations import Violation
from multisrt.spec import RunSpec

MAX_TRIES: Final = 120
"""Runs by which one failure is shrunk."""


class Shrunk(NamedTuple):
    """A failing spec that was made simpler.

    Attributes
    ----------
    spec : RunSpec
        The simplest that was found.
    violation : Violation
        How it fails.
    tries : int
        Number of runs that were made.
    """

    spec: RunSpec
    violation: Violation
    tries: int


def shrink(
    spec: RunSpec,
    violation: Violation,
    judge: Callable[[RunSpec], Verdict],
    max_tries: int = MAX_TRIES,
) -> Shrunk:
    """Make a failing spec simpler while it fails in the same way.

    Candidates are tried in order. One is kept if its run violates the same invariant, and its own
    simplifications are tried next, until none is kept.
    (Zeller and Hildebrandt, Simplifying and isolating failure-inducing input, 2002: the
    greedy form of it, on the parts of a spec instead of the characters of a text.)

    Parameters
    ----------
    spec : RunSpec
        The spec.
    violation : Violation
        How it fails.
    judge : callable
        Makes a run and judges it; what it returns depends on the spec alone.
    max_tries : int
        Upper bound of the number of runs.

    Returns
    -------
    Shrunk
        The simplest spec that was found; the same for equal arguments.

    Examples
    --------
    >>> import multisrt as ms
    >>> def judge(spec):
    ...     broke = Violation(invariant="few", says=f"{len(spec.robots)} robots")
    ...     return Verdict(outcome="complete", violations=(broke,) * (len(spec.robots) > 1))
    >>> spec = ms.RunSpec(
    ...     environment=ms.CatalogEnvironment(name="museum"),
    ...     robots=(ms.RobotSpec(footprint="box:0.4x0.3"),) * 6,
    ...     seed=7,
    ... )
    >>> shrunk = shrink(spec, judge(spec).violations[0], judge)
    >>> shrunk.spec.environment.name, len(shrunk.spec.robots), shrunk.violation.says
    ('open', 2, '2 robots')
    """
    tried = {spec.to_json()}
    simpler = simplifications(spec, violation.time_s)
    while (candidate := next(simpler, None)) is not None:
        text = candidate.to_json()
        if text in tried:
            continue
        if len(tried) > max_tries:
            break
        if not _is_sound(candidate):
            continue
        tried.add(text)
        alike = [found for found in judge(candidate).violations if is_alike(found, violation)]
        if alike:
            spec, violation = candidate, alike[0]
            simpler = simplifications(spec, violation.time_s)
    return Shrunk(spec, violation, len(tried) - 1)


def _is_sound(spec: RunSpec) -> bool:
    # Do not simplify to a world in which beams may miss walls: a collision there is documented
    # behaviour.
    try:
        return finds_all(spec)
    except Exception:  # of a generator: a world that cannot be built is no simpler one
        return False


def is_alike(one: Violation, other: Violation) -> bool:
    """Whether two runs fail in the same way: by the same invariant, or the same error.

    Parameters
    ----------
    one, other : Violation
        The violations.

    Returns
    -------
    bool
        For errors, whether they are of one kind and raised at one place.

    Examples
    --------
    >>> one = Violation(invariant="no-error", says="KeyError in team.py:12: 3")
    >>> is_alike(one, Violation(invariant="no-error", says="KeyError in team.py:12: 4"))
    True
    >>> is_alike(one, Violation(invariant="no-error", says="KeyError in mail.py:12: 3"))
    False
    """
    if one.invariant != other.invariant:
        return False
    if one.invariant not in (NO_ERROR, JUDGED):
        return True
    return one.says.partition(": ")[0] == other.says.partition(": ")[0]
