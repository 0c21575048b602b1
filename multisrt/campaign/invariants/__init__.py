"""Invariants: statements that hold in every run, checked on its recording and the true world.

Each invariant is checked by separate code, which uses the recorded motions, scans, messages and
regions and the true free space. Its docstring states what is required, the tolerances and the
reasons for them, and where events that explorers recorded are taken into account.

Examples
--------
>>> import multisrt as ms
>>> from multisrt.campaign.invariants import INVARIANTS, JudgedRun, check
>>> run = ms.explore("open", robots=2, seed=1, max_time_s=20.0)
>>> check(JudgedRun(recording=run.recording, environment=ms.environment("open")))
[]
>>> print(INVARIANTS["no-collision"].__doc__.splitlines()[0])
Check that no body touches an obstacle or another body, at any time of the run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

from multisrt.campaign.invariants.collision import no_collision
from multisrt.campaign.invariants.completeness import (
    boxed_in_is_boxed_in,
    chain_reaches_no_goal,
    complete_is_complete,
)
from multisrt.campaign.invariants.decisions import goals_by_rule
from multisrt.campaign.invariants.endings import ends
from multisrt.campaign.invariants.free_space import known_free_is_free
from multisrt.campaign.invariants.hearing import hearers_learn
from multisrt.campaign.invariants.isolation import isolated_without_links
from multisrt.campaign.invariants.knowledge import knowledge_by_scan_or_message
from multisrt.campaign.invariants.links import (
    losses_at_rate,
    messages_over_links,
    reaches_all_in_reach,
)
from multisrt.campaign.invariants.measures import measures_consistent
from multisrt.campaign.invariants.merging import closings_apply_where_valid, merge_order
from multisrt.campaign.invariants.motion import (
    motion_at_full_speed,
    motion_continuous,
    motion_within_drive,
)
from multisrt.campaign.invariants.progress import drives_get_somewhere
from multisrt.campaign.invariants.protective_stops import stops_before_bodies
from multisrt.campaign.invariants.reasons import boxed_in_after_attempts, incomplete_for_a_reason
from multisrt.campaign.invariants.returning import (
    data_is_returned,
    ends_at_home,
    turns_back_in_time,
)
from multisrt.campaign.invariants.starting import starts_and_faults
from multisrt.campaign.invariants.waiting import (
    waits_as_often_as_allowed,
    waits_within_limits,
)
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.violations import Violation

__all__ = ["INVARIANTS", "Invariant", "JudgedRun", "check"]

Invariant = Callable[[JudgedRun], Violation | None]
"""Checks a run: returns the earliest violation, or None."""

INVARIANTS: Final[Mapping[str, Invariant]] = MappingProxyType(
    {
        "ends": ends,
        "starts-and-faults": starts_and_faults,
        "motion-continuous": motion_continuous,
        "motion-within-drive": motion_within_drive,
        "motion-at-full-speed": motion_at_full_speed,
        "stops-before-bodies": stops_before_bodies,
        "no-collision": no_collision,
        "known-free-is-free": known_free_is_free,
        "messages-over-links": messages_over_links,
        "reaches-all-in-reach": reaches_all_in_reach,
        "losses-at-rate": losses_at_rate,
        "knowledge-by-scan-or-message": knowledge_by_scan_or_message,
        "hearers-learn": hearers_learn,
        "merge-order": merge_order,
        "closings-apply-where-valid": closings_apply_where_valid,
        "goals-by-rule": goals_by_rule,
        "data-is-returned": data_is_returned,
        "turns-back-in-time": turns_back_in_time,
        "ends-at-home": ends_at_home,
        "complete-is-complete": complete_is_complete,
        "boxed-in-is-boxed-in": boxed_in_is_boxed_in,
        "chain-reaches-no-goal": chain_reaches_no_goal,
        "incomplete-for-a-reason": incomplete_for_a_reason,
        "boxed-in-after-attempts": boxed_in_after_attempts,
        "waits-within-limits": waits_within_limits,
        "waits-as-often-as-allowed": waits_as_often_as_allowed,
        "drives-get-somewhere": drives_get_somewhere,
        "measures-consistent": measures_consistent,
        "isolated-without-links": isolated_without_links,
    }
)
"""All invariants by name."""


def check(run: JudgedRun) -> list[Violation]:
    """Check a run against all invariants.

    Parameters
    ----------
    run : JudgedRun
        The run.

    Returns
    -------
    list of Violation
        At most one for each invariant, in the order of `INVARIANTS`.
    """
    found = (invariant(run) for invariant in INVARIANTS.values())
    return [violation for violation in found if violation is not None]
