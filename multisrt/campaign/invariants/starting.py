"""Robots start as specified, and faults occur as specified."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Final

from multisrt.campaign.judged_run import ROUNDING_M, ROUNDING_S, JudgedRun, silences
from multisrt.campaign.violations import Violation
from multisrt.events import CameBack, Died, Ended, FellSilent, Joined, Motion, Organized
from multisrt.spec import Death, LateStart

NAME: Final = "starts-and-faults"

Said = tuple[int, float, str]
"""A robot, a time in seconds, and what it does then against what it was told."""


def starts_and_faults(run: JudgedRun) -> Violation | None:
    """Check that the starts and faults of robots are those of the spec.

    A robot with a given start begins there, to 1e-6 m and rad. A robot with a late start is
    switched on at that time. A death occurs at its time or, if it depends on what the robot is
    doing, later and while the robot does that: by the end of the first motion from then on, when
    the robot first stands still before it ends, or when it next organises a group. A radio fails
    when its silence begins, or when the robot is switched on, and works again when the silence
    ends, unless another one continues. Faults due at the end of the run, or at the death of the
    robot, may have occurred or not.

    Cost: negligible.
    """
    found = [*_starts(run), *_late(run), *_deaths(run), *_silences(run)]
    if not found:
        return None
    robot, time_s, what = min(found, key=lambda said: said[1])
    return Violation(
        invariant=NAME, says=f"robot {robot} {what}, {time_s:.2f} s", robot=robot, time_s=time_s
    )


def _starts(run: JudgedRun) -> Iterator[Said]:
    for number, (spec, pose) in enumerate(
        zip(run.recording.spec.robots, run.recording.header.starts, strict=True)
    ):
        if spec.start is None:
            continue
        x, y, heading = (*spec.start, 0.0)[:3]
        turn = abs(math.remainder(pose[2] - heading, 2.0 * math.pi))
        if math.dist(pose[:2], (x, y)) > ROUNDING_M or turn > ROUNDING_M:
            yield number, 0.0, f"starts at {_place(pose)} instead of {_place((x, y, heading))}"


def _place(pose: Sequence[float]) -> str:
    # In seven digits: poses differ by more than `ROUNDING_M`.
    return f"({', '.join(f'{value:.7g}' for value in pose)})"


def _late(run: JudgedRun) -> Iterator[Said]:
    late = {f.robot: f.time_s for f in run.recording.spec.faults if isinstance(f, LateStart)}
    joined = {event.robot: event.time_s for event in run.recording.of(Joined)}
    for robot, time_s in joined.items():
        if abs(late.get(robot, math.inf) - time_s) > ROUNDING_S:
            yield robot, time_s, f"is switched on, which is due at {late.get(robot, 0.0):.2f} s"
    for robot, time_s in late.items():
        if robot not in joined and time_s < _over_s(run, robot):
            yield robot, time_s, "is not switched on"


def _deaths(run: JudgedRun) -> Iterator[Said]:
    due = {f.robot: f for f in run.recording.spec.faults if isinstance(f, Death)}
    died = {event.robot: event for event in run.recording.of(Died)}
    for robot, event in died.items():
        death = due.get(robot)
        if death is None or event.time_s < death.time_s - ROUNDING_S:
            yield robot, event.time_s, "dies, which is not due"
        elif death.when not in ("any", event.doing):
            yield robot, event.time_s, f"dies {event.doing}, and was to die {death.when}"
    for robot, death in due.items():
        last_s = died[robot].time_s if robot in died else math.inf
        by_s = _dies_by_s(run, death)
        if last_s > by_s + ROUNDING_S and by_s < run.end_s - ROUNDING_S:
            yield robot, by_s, "does not die"


def _dies_by_s(run: JudgedRun, death: Death) -> float:
    """Return the time by which a death must have occurred, as far as the record tells."""
    match death.when:
        case "any":
            return death.time_s
        case "moving":
            times_s = (end_s for _, end_s in _motions(run, death.robot))
        case "waiting":
            return _waits_at_s(run, death)
        case "master":
            times_s = (e.time_s for e in run.recording.of(Organized) if e.robot == death.robot)
    return min((t for t in times_s if t > death.time_s + ROUNDING_S), default=math.inf)


def _waits_at_s(run: JudgedRun, death: Death) -> float:
    """Return when a robot first stands still from the time of a death on, before it ends."""
    ends_s = min(
        (e.time_s for e in run.recording.of(Ended) if e.robot == death.robot), default=math.inf
    )
    time_s = max(death.time_s, run.present_s(death.robot)[0])
    for begin_s, end_s in sorted(_motions(run, death.robot)):
        if begin_s > time_s + ROUNDING_S:
            break
        time_s = max(time_s, end_s)
    return time_s if time_s < ends_s - ROUNDING_S else math.inf


def _motions(run: JudgedRun, robot: int) -> Iterator[tuple[float, float]]:
    """Yield when motions of a robot begin and end, in seconds."""
    for event in run.recording.of(Motion):
        if event.robot == robot:
            yield event.waypoints[0][0], event.waypoints[-1][0]


def _silences(run: JudgedRun) -> Iterator[Said]:
    fell, back = defaultdict[int, list[float]](list), defaultdict[int, list[float]](list)
    for silent in run.recording.of(FellSilent):
        fell[silent.robot].append(silent.time_s)
    for again in run.recording.of(CameBack):
        back[again.robot].append(again.time_s)
    for robot in run.robots:
        spells = silences(run.recording.spec.faults, robot, run.present_s(robot)[0])
        for times_s, due_s, what in (
            (fell[robot], [begin_s for begin_s, _ in spells], "falls silent"),
            (back[robot], [end_s for _, end_s in spells], "works again"),
        ):
            for time_s in times_s:
                if not _is_among(time_s, due_s):
                    yield robot, time_s, f"{what}, which is not due"
            for time_s in due_s:
                if time_s < _over_s(run, robot) and not _is_among(time_s, times_s):
                    yield robot, time_s, f"has a radio that never {what}, which is due"


def _over_s(run: JudgedRun, robot: int) -> float:
    """Return the time before which the faults of a robot that are due must have occurred."""
    return min(run.end_s, run.present_s(robot)[1]) - ROUNDING_S


def _is_among(time_s: float, times_s: list[float]) -> bool:
    return any(abs(time_s - other_s) <= ROUNDING_S for other_s in times_s)
