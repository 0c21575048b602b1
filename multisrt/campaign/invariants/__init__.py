"""What must hold in every run, judged from its recording and the true world."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from multisrt.campaign.violations import Violation
from multisrt.environments.environment import Environment
from multisrt.events import Collision
from multisrt.recording import Recording


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedRun:
    """A run that is judged.

    Attributes
    ----------
    recording : Recording
        All that happened.
    environment : Environment
        The world.
    """

    recording: Recording
    environment: Environment


Invariant = Callable[[JudgedRun], list[Violation]]
"""Returns the violations of one invariant in a run; the first line of its docstring says what it
demands."""


def no_collision(run: JudgedRun) -> list[Violation]:
    """No body touches a wall or another body."""
    return [
        Violation(
            invariant="no-collision",
            says=f"robot {event.robot} {event.account} at {event.time_s:g} s",
            robot=event.robot,
            time_s=event.time_s,
        )
        for event in run.recording.of(Collision)[:1]
    ]


def ends(run: JudgedRun) -> list[Violation]:
    """Every run ends with a stated outcome and a reason."""
    footer = run.recording.footer
    if footer.outcome and footer.reason.strip():
        return []
    return [Violation(invariant="ends", says="the run ends without a reason", time_s=footer.time_s)]


INVARIANTS: Mapping[str, Invariant] = MappingProxyType({"no-collision": no_collision, "ends": ends})
"""All invariants by name."""


def check(run: JudgedRun) -> list[Violation]:
    """Return the violations of all invariants in a run."""
    return [violation for invariant in INVARIANTS.values() for violation in invariant(run)]
