"""How one run of a checked explorer went."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from multisrt.recording import RunOutcome
from multisrt.testing.unfinished import Unfinished


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckedRun:
    """One of the runs of a checked explorer.

    Attributes
    ----------
    world : str
        Name of the world.
    robots : int
        Number of robots.
    outcome : {"complete", "stalled", "out_of_time"}
        How it ended.
    time_s : float
        When it ended, in the time of the run.
    covered : float
        Share of what can be explored that counts as covered, from 0 to 1.
    actions : mapping of str to int
        Number of actions of each kind that the explorers yielded.
    digest : str
        Digest of the recording.
    differences : tuple of str
        Where the explorers' own account and their scans differ; see `multisrt.testing.account`.
    unfinished : tuple of Unfinished
        The robots that have ended without having completed their exploration.
    unlearned : bool
        Whether robots that record nodes were sent nodes of others, and none recorded `Learned`.

    Examples
    --------
    >>> run = CheckedRun(
    ...     world="hall",
    ...     robots=2,
    ...     outcome="complete",
    ...     time_s=81.4,
    ...     covered=0.994,
    ...     actions={"Sense": 20, "Move": 18, "Done": 2},
    ...     digest="0" * 64,
    ... )
    >>> print(run)
    2 robots in 'hall': complete after 81 s, 99.4 % covered, 40 actions
    """

    world: str
    robots: int
    outcome: RunOutcome
    time_s: float
    covered: float
    actions: Mapping[str, int]
    digest: str
    differences: tuple[str, ...] = ()
    unfinished: tuple[Unfinished, ...] = ()
    unlearned: bool = False

    @property
    def title(self) -> str:
        """The team and the world, in words."""
        team = "1 robot" if self.robots == 1 else f"{self.robots} robots"
        return f"{team} in {self.world!r}"

    @property
    def percent(self) -> str:
        """The share of the explorable area that was covered, as text."""
        return f"{100.0 * self.covered:.1f} %"

    def __str__(self) -> str:
        count = sum(self.actions.values())
        return (
            f"{self.title}: {self.outcome.replace('_', ' ')} after {self.time_s:.0f} s, "
            f"{self.percent} covered, {count} action{'s' * (count > 1)}"
        )
