"""Robots that find no motion from their starts say so, and do not report a complete map."""

import pytest

from multisrt import RobotSpec, RunSpec, simulate
from multisrt.events import Ended, Motion
from multisrt.geometry.bodies.footprint import Footprint
from multisrt.spec import InlineEnvironment, RangeFinderSpec

HALL = InlineEnvironment(name="hall", wkt="POLYGON ((0 0, 9 0, 9 6, 0 6, 0 0))")


def run(strategy, footprint, gap_m, beams=None, **options):
    left, low, _, _ = Footprint.parse(footprint).placed((0.0, 0.0, 0.3)).bounds
    robot = RobotSpec(
        start=(gap_m - left, gap_m - low, 0.3),
        footprint=footprint,
        range_finder=RangeFinderSpec(range_m=3.0, beams=beams),
    )
    spec = RunSpec(environment=HALL, strategy=strategy, robots=(robot,), options=options)
    return simulate(spec)


@pytest.mark.parametrize("strategy", ["minpos", "gain", "srt-radial", "srt-star"])
@pytest.mark.parametrize(("gap_m", "beams"), [(0.0003, None), (0.001, 90)])
def test_a_box_in_a_corner_that_cannot_move_is_boxed_in(strategy, gap_m, beams):
    recording = run(strategy, "box:0.6x0.4", gap_m, beams)
    (end,) = recording.of(Ended)
    assert not recording.of(Motion)
    assert not end.complete
    assert end.reason.startswith("boxed in at the start, where the scan shows no way")
    assert recording.footer.outcome == "stalled"


@pytest.mark.parametrize("strategy", ["minpos", "gain", "srt-radial"])
@pytest.mark.parametrize("beams", [60, 116, None])
def test_a_disc_leaves_a_wall_that_it_begins_beside(strategy, beams):
    recording = run(strategy, "disc:0.25", 0.001, beams)
    assert len(recording.of(Motion)) > 3
    assert recording.footer.outcome == "complete"


@pytest.mark.parametrize("strategy", ["minpos", "srt-radial"])
def test_a_robot_that_sees_the_whole_room_from_a_corner_is_complete(strategy):
    # It cannot move, but nothing is left to be seen.
    left, low, _, _ = Footprint.parse("box:0.6x0.4").placed((0.0, 0.0, 0.3)).bounds
    robot = RobotSpec(
        start=(0.0003 - left, 0.0003 - low, 0.3),
        footprint="box:0.6x0.4",
        range_finder=RangeFinderSpec(range_m=20.0),
    )
    recording = simulate(RunSpec(environment=HALL, strategy=strategy, robots=(robot,)))
    assert recording.footer.outcome == "complete"
