"""Measured isolation is that of the links between robots."""

from __future__ import annotations

import random
from typing import Final

from multisrt.analysis.isolation import Spell, isolation
from multisrt.campaign.judged_run import JudgedRun
from multisrt.campaign.links import Links
from multisrt.campaign.violations import Violation

NAME: Final = "isolated-without-links"

TIMES: Final = 40
"""Number of times at which links are computed."""

BESIDE_S: Final = 1e-3
"""Links are also computed by this before and after spells of isolation begin and end, in s."""


def isolated_without_links(run: JudgedRun) -> Violation | None:
    """Check that robots are measured as isolated when they have no link, and only then.

    At 40 times, drawn from the seed of the spec, and 1e-3 s before and after each beginning and end
    of a spell: a robot that certainly has a link to another active robot, or to a base station that
    relays and certainly has one to another active robot, is in no spell of isolation. One that
    cannot have any is in a spell, if another robot is active. Tolerances are those of
    `multisrt.campaign.links.Links`.

    Cost: one line for each pair of robots at each of these times.
    """
    if len(run.robots) < 2:
        return None
    measured = isolation(run.recording, run.environment)
    drawn = random.Random(run.recording.spec.seed)
    times_s = {drawn.uniform(0.0, run.end_s) for _ in range(TIMES)}
    for one in measured:
        times_s |= {t + s for spell in one.spells for t in spell for s in (-BESIDE_S, BESIDE_S)}
    asked_s = sorted(t for t in times_s if 0.0 < t < run.end_s)
    possible, certain = Links(run, asked_s), Links(run, asked_s, is_sure=True)
    for time_s in asked_s:
        for robot in run.robots:
            is_measured = _is_within(time_s, measured[robot].spells)
            if is_measured and _is_linked(run, certain, robot, time_s):
                return _violation(robot, time_s, "is measured as isolated, but has a link")
            may_be = _is_active(run, robot, time_s) and _others(run, robot, time_s)
            if may_be and not is_measured and not _is_linked(run, possible, robot, time_s):
                return _violation(robot, time_s, "has no link, but is not measured as isolated")
    return None


def _violation(robot: int, time_s: float, what: str) -> Violation:
    says = f"robot {robot} {what}, at {time_s:.3f} s"
    return Violation(invariant=NAME, says=says, robot=robot, time_s=time_s)


def _is_linked(run: JudgedRun, links: Links, robot: int, time_s: float) -> bool:
    others, base = _others(run, robot, time_s), len(run.robots)
    found = links.linked(robot, time_s)
    if base in found and run.recording.spec.radio.multi_hop:
        found |= links.linked(base, time_s)
    return bool(found & others)


def _others(run: JudgedRun, robot: int, time_s: float) -> set[int]:
    return {n for n in run.robots if n != robot and _is_active(run, n, time_s)}


def _is_active(run: JudgedRun, robot: int, time_s: float) -> bool:
    on_s, dead_s = run.present_s(robot)
    return on_s <= time_s < dead_s


def _is_within(time_s: float, spells: tuple[Spell, ...]) -> bool:
    return any(begin_s <= time_s <= end_s for begin_s, end_s in spells)
