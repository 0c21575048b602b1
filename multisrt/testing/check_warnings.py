"""Warnings about explorers that keep to the contract but probably do not do what was intended."""

from __future__ import annotations

from collections.abc import Sequence

from multisrt.analysis.metrics import SUCCESS_COVERAGE
from multisrt.robots.naming import joined
from multisrt.testing.checked_run import CheckedRun
from multisrt.testing.forgotten import forgotten_return, writes_run

MAX_EXAMPLES = 2
"""How many runs a warning names, and how many robots of each."""

ENOUGH = f"{100.0 * SUCCESS_COVERAGE:.0f} %"
"""The share of the explorable area that makes a run a success, in words."""


def warnings_about(runs: Sequence[CheckedRun], cls: type) -> tuple[str, ...]:
    """Return warnings about an explorer whose runs have no defect.

    Parameters
    ----------
    runs : sequence of CheckedRun
        All its runs.
    cls : type
        Its class.

    Returns
    -------
    tuple of str
        What it does, and what to do; empty if there is nothing to warn of.

    Examples
    --------
    >>> from multisrt.robots.explorer import Done
    >>> run = CheckedRun(
    ...     world="hall",
    ...     robots=1,
    ...     outcome="complete",
    ...     time_s=0.0,
    ...     covered=0.0,
    ...     actions={"Done": 1},
    ...     digest="0" * 64,
    ... )
    >>> class Idle:
    ...     def run(self):
    ...         yield Done(complete=True, reason="has nothing to do")
    >>> [warning.partition(";")[0] for warning in warnings_about([run], Idle)]  # doctest: +ELLIPSIS
    ['it ends at once: its first action is Done', ...]
    """
    warnings = []
    kinds = {kind for run in runs for kind in run.actions}
    if lacks := forgotten_return(cls):
        warnings.append(f"{lacks}: the robot is done at once; return the place to go to")
    elif not writes_run(cls) and not kinds & {"Move"}:
        warnings.append(
            "it never moves: it sees what can be seen from its start alone; see that its choice "
            "is a place or frontier as long as one can be reached"
        )
    elif kinds == {"Done"}:
        warnings.append(
            "it ends at once: its first action is Done; yield Sense() first, and move to where it "
            "sees more"
        )
    elif "Sense" not in kinds:
        warnings.append(
            "it never senses: no robot takes a scan, so all that it knows is where it stands; "
            "yield Sense(), and read the Scan that it is sent"
        )
    elif "Move" not in kinds:
        warnings.append(
            "it never moves: it sees what can be seen from its start alone; yield Move(...) to a "
            "place that its scan shows to be free"
        )
    small = [run for run in runs if run.covered < SUCCESS_COVERAGE]
    claims = [run for run in small if run.outcome == "complete"]
    if claims:
        warnings.append(
            f"it says that it is complete but covered {_shares(claims)}; give Done complete=True "
            f"only where no frontier is left: from {ENOUGH} on a run is a success"
        )
    elif len(small) == len(runs) and not warnings:
        warnings.append(
            f"it covered little in all runs: {_shares(small)}; a run is a success from "
            f"{ENOUGH} on: see that it drives on while a frontier is left"
        )
    if stalls := [run for run in runs if _stalls_as_a_team(run, runs)]:
        warnings.append(
            f"it stalls in a team: {_stalls(stalls)}; while another body is in the way, drive back "
            "to let it pass or wait with Receive(timeout_s=...), and plan again before Done"
        )
    if any(run.unlearned for run in runs):
        warnings.append(
            "it sends nodes to other robots, and none records Learned: on record each robot knows "
            "its own nodes alone; after a merge yield Note(Learned(time_s=..., robot=..., "
            "nodes=new)) with the nodes that were new"
        )
    return tuple(warnings)


def _stalls_as_a_team(run: CheckedRun, runs: Sequence[CheckedRun]) -> bool:
    # Where one robot alone does not complete the world either, the team is not the reason.
    if run.robots == 1 or run.outcome != "stalled":
        return False
    alone = [other.outcome for other in runs if other.robots == 1 and other.world == run.world]
    if alone:
        return "complete" in alone
    return any(robot.blocked_by is not None for robot in run.unfinished)


def _stalls(runs: Sequence[CheckedRun]) -> str:
    texts = []
    for run in runs[:MAX_EXAMPLES]:
        names = [str(robot) for robot in run.unfinished[:MAX_EXAMPLES]]
        if (more := len(run.unfinished) - len(names)) > 0:
            names.append(f"{more} more")
        verb = "ends" if len(names) == 1 else "end"
        texts.append(f"{joined(names)} {verb} without completing ({run.title})")
    more = len(runs) - len(texts)
    return ", ".join(texts) + (f", and so in {_other_runs(more)}" if more else "")


def _other_runs(count: int) -> str:
    return f"{count} other run{'s' * (count > 1)}"


def _shares(runs: Sequence[CheckedRun]) -> str:
    # Those with the smallest shares, and how many more there are.
    if len(runs) > 1 and len({run.percent for run in runs}) == 1:
        return f"{runs[0].percent} in {len(runs)} runs"
    least = sorted(runs, key=lambda run: run.covered)
    texts = [f"{run.percent} ({run.title})" for run in least[:MAX_EXAMPLES]]
    more = len(runs) - len(texts)
    if more == 0:
        return " and ".join(texts)
    return f"{', '.join(texts)} and less than {ENOUGH} in {_other_runs(more)}"
