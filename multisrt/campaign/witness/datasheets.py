"""The data sheets that robots are given before they begin are what the spec says."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from multisrt.campaign.violations import Violation
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.robots.explorer import RobotSelf
from multisrt.simulation.setting_up import SetUp
from multisrt.spec import LateStart

NAME: Final = "data-sheet-matches-spec"


def told_what_they_are(setup: SetUp) -> Iterator[Violation]:
    """Yield robots that are told something else of themselves than the spec says.

    Of strategies of this package that do not see the world. Streams of random numbers must differ
    from robot to robot.

    Parameters
    ----------
    setup : SetUp
        The run, before it begins.
    """
    streams: list[object] = []
    for number, explorer in enumerate(setup.explorers):
        me = getattr(getattr(explorer, "robot", None), "me", None)
        if not isinstance(me, RobotSelf):
            return
        streams.append(me.rng.bit_generator.state)
        wrong = [what for what, told, true in _told(setup, number, me) if told != true]
        if streams.count(streams[-1]) > 1:
            wrong.append("rng")
        if wrong:
            says = f"robot {number} is told wrong values of {', '.join(wrong)}"
            yield Violation(invariant=NAME, says=says, robot=number, time_s=0.0)


def _told(setup: SetUp, number: int, me: RobotSelf) -> Iterator[tuple[str, object, object]]:
    spec, radio, sheet = setup.spec, setup.spec.radio, me.radio
    robot, base = spec.robots[number], spec.base
    yield "robot", me.robot, number
    yield "team", me.team, len(spec.robots)
    yield "start", tuple(me.start), tuple(setup.header.starts[number])
    yield "footprint", str(me.footprint), str(Footprint.parse(robot.footprint))
    yield "kinematics", me.kinematics, robot.drive.kinematics()
    yield "range_m", me.range_m, robot.range_finder.range_m
    yield "team_range_m", me.team_range_m, max(r.range_finder.range_m for r in spec.robots)
    yield "base", me.base, None if base is None else (base.x, base.y)
    yield "limit_s", me.limit_s, spec.stop.max_time_s
    late = [f.time_s for f in spec.faults if isinstance(f, LateStart) and f.robot == number]
    yield "time_s", me.time_s, min(late, default=0.0)
    yield "radio.range_m", sheet.range_m, radio.reach_m
    yield "radio.latency_s", sheet.latency_s, radio.latency_s + radio.jitter_s
    yield "radio.loss", sheet.loss, radio.loss
    yield "radio.multi_hop", sheet.multi_hop, radio.multi_hop
    reaches_all = radio.range_m is None and radio.walls == "pass" and radio.loss == 0.0
    yield "radio.reaches_all", sheet.reaches_all, reaches_all
    yield "radio.walls_matter", sheet.walls_matter, radio.walls != "pass"
