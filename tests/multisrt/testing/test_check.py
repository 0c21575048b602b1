import datetime
import random
import subprocess
import sys
import time
from time import time as clock

import numpy as np
import pytest

from multisrt.events import NodeAdded
from multisrt.geometry.errors import InvalidInputError, MultiSrtError
from multisrt.robots.explorer import Done, Note, Receive, Sense
from multisrt.robots.registry import strategies, strategy
from multisrt.spec import DriveSpec, RangeFinderSpec, RobotSpec
from multisrt.testing import check_explorer
from tests.multisrt.testing.explorers import HALL, WORLD, Base, check, explorer, refused


@pytest.mark.slow
@pytest.mark.parametrize("name", ["srt-star", "srt-radial"])
def test_the_strategies_of_the_registry_pass(name):
    checked = check_explorer(strategy(name), worlds=[WORLD], max_actions=3000)
    assert checked.name == name
    assert [run.outcome for run in checked.runs] == ["complete", "complete"]
    assert [run.robots for run in checked.runs] == [1, 3]


@pytest.mark.slow
@pytest.mark.parametrize(
    "robot",
    [
        RobotSpec(footprint="box:0.5x0.3"),
        RobotSpec(drive=DriveSpec(kind="holonomic")),
        RobotSpec(drive=DriveSpec(kind="reeds-shepp")),
        RobotSpec(range_finder=RangeFinderSpec(range_m=3.0, beams=360)),
    ],
)
def test_bodies_drives_and_lasers_of_all_kinds_pass(robot):
    check_explorer(strategy("srt-radial"), worlds=[WORLD], teams=[2], robot=robot)


@pytest.mark.slow
def test_the_summary_says_what_was_checked():
    checked = check_explorer(strategy("srt-radial"))
    assert {run.world for run in checked.runs} == {"two rooms", "open", "maze"}
    text = str(checked)
    assert "srt-radial keeps to the contract" in text
    assert "3 robots in 'maze': complete" in text
    assert "does not reach the truth" in text
    assert len({run.digest for run in checked.runs}) == len(checked.runs)


def test_options_are_those_of_the_strategy():
    checked = check_explorer(strategy("srt-star"), options={"cones": 8}, worlds=[HALL], teams=[1])
    assert checked.runs[0].outcome == "complete"
    with pytest.raises(InvalidInputError, match="coned"):
        check_explorer(strategy("srt-star"), options={"coned": 8})
    with pytest.raises(InvalidInputError, match="base has no option 'cones'; it has: none"):
        check_explorer(Base, options={"cones": 8})


def test_a_check_needs_a_world():
    with pytest.raises(InvalidInputError, match="at least one"):
        check_explorer(Base, worlds=[])


def global_random_states() -> tuple[object, list[int]]:
    state = np.random.get_state(legacy=False)  # noqa: NPY002
    return random.getstate(), state["state"]["key"].tolist()


def test_a_check_leaves_no_trace():
    before = [s.name for s in strategies()]
    states = global_random_states()
    clocks = time.time, time.monotonic_ns, datetime.datetime, clock
    check(Base)
    refused(explorer(lambda self: iter([1])), "no action")
    assert [s.name for s in strategies()] == before
    assert global_random_states() == states
    assert (time.time, time.monotonic_ns, datetime.datetime, clock) == clocks


@pytest.mark.slow
def test_the_checker_does_not_need_pytest():
    code = "import sys, multisrt.testing.check; sys.exit('pytest' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_defect_says_what_is_wrong_where_and_the_remedy():
    defect = refused(explorer(lambda self: iter([Sense(), 1])), "no action")
    assert isinstance(defect, AssertionError)
    assert isinstance(defect, MultiSrtError)
    assert defect.where == "the robot in 'hall', action 2"
    assert str(defect) == f"{defect.where}: {defect.what}; {defect.remedy}"
    assert "\n" not in str(defect)


def test_a_collision_is_found():
    def act(self):
        yield Sense()
        yield self.to(x=2.9)

    refused(explorer(act), "touched an obstacle", only_known=False)


def test_endless_actions_without_time_are_found():
    def act(self):
        while True:
            yield Sense()

    refused(explorer(act), "100 actions and was not Done", max_actions=100)


def test_endless_waiting_is_found():
    def act(self):
        while True:
            yield Receive(timeout_s=10.0)

    refused(
        explorer(act),
        r"robot 0 is not done after 1000 s; the last were 100 Receive",
        max_time_s=1000.0,
    )


def test_waiting_for_a_message_that_never_comes_is_found():
    refused(explorer(lambda self: iter([Receive()])), "never comes")


def test_an_end_without_done_is_found():
    class Short(Base):
        def run(self):
            yield Sense()

    refused(Short, "without a last action Done")


def test_a_run_that_is_no_generator_is_found():
    class Listed(Base):
        def run(self):
            return [Sense(), Done(complete=True, reason="")]

    refused(Listed, "returned a list, not a generator")


def test_errors_of_the_explorer_are_reported_as_the_cause():
    def act(self):
        yield Sense()
        raise KeyError("lost")

    assert isinstance(refused(explorer(act), "raised KeyError").__cause__, KeyError)


def test_explorers_that_cannot_be_built_are_found():
    refused(
        lambda me: me.nonsense,
        r"building .* raised AttributeError.*\(test_check.py:\d+, in <lambda>",
    )
    refused(lambda me: 7, r"an int, which has no run\(\)")


class ClaimsMore(Base):
    """Looks round once, and says that it knows what lies elsewhere."""

    def act(self):
        scan = yield Sense()
        x, y, _ = self.me.start
        x += 1.0
        ring = ((x - 1, y - 1), (x + 1, y - 1), (x + 1, y + 1), (x - 1, y + 1))
        yield Note(
            NodeAdded(
                time_s=scan.time_s,
                robot=self.me.robot,
                serial=0,
                parent=None,
                configuration=(x, y, 0.0),
                stage="root",
                boundary=ring,
                tags="0000",
            )
        )


class LooksRound(Base):
    """Looks round once, and puts nothing on record."""

    def act(self):
        yield Sense()


def test_the_summary_says_where_its_own_account_differs_from_its_scans():
    narrow = RobotSpec(range_finder=RangeFinderSpec(range_m=2.0))
    checked = check_explorer(LooksRound, worlds=[HALL], teams=[1], robot=narrow)
    assert checked.runs[0].outcome == "complete"
    nodes, complete = checked.runs[0].differences
    assert nodes == "notes no node, and is measured by its scans"
    assert complete.startswith("notes no MapComplete: when a robot knows its map complete stays")
    assert "note: it notes no node, and is measured by its scans" in str(checked)
    (run,) = check_explorer(ClaimsMore, worlds=[HALL], teams=[1], robot=narrow).runs
    assert "its scans at their places had not shown" in " ".join(run.differences)
    (run,) = check_explorer(strategy("srt-radial"), worlds=[HALL], teams=[1]).runs
    assert run.differences == ()
