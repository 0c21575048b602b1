"""Each wrong explorer is found quickly, with what is wrong, where, and what to do."""

import re
import time

import pytest

from multisrt.events import GoalChosen
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.explorer import Note, Receive, Sense
from multisrt.testing import check_explorer
from multisrt.testing.repetition import difference
from tests.multisrt.testing import wrong_explorers as wrong

MAX_SECONDS = 3.0
"""Computing time in which each must be found; most take a hundredth of a second."""

TOLD = {
    "DrivesBlind": (
        "the robot in 'two rooms', action 1: on its way from (10.369, 4.256, 0.000) to "
        "(10.669, 4.256, 0.000) its body covers 0.143 m2 that it has neither sensed nor "
        "been told of, around (10.766, 4.268); move within what its scans show to be "
        "free; only_known=False (--anywhere) lets this pass"
    ),
    "DrivesThroughAWall": (
        "the robot in 'two rooms', action 2: on its way from (10.369, 4.256, 0.000) to "
        "(30.369, 4.256, 0.000) its body covers 9.09 m2 that it has neither sensed nor "
        "been told of, around (21.307, 4.268); move within what its scans show to be "
        "free; only_known=False (--anywhere) lets this pass"
    ),
    "SharesAClassAttribute": (
        "the robot in 'two rooms', action 2: sent the same as before, it yielded "
        "Receive(timeout_s=3.0), not Receive(timeout_s=1.0): SharesAClassAttribute.seen "
        "changes, which explorers share; keep everything in self: no class attribute, "
        "global or default that changes"
    ),
    "SharesAGlobal": (
        "the robot in 'two rooms', action 2: sent the same as before, it yielded "
        "Receive(timeout_s=3.0), not Receive(timeout_s=1.0): global 'HEARD' changes, "
        "which explorers share; keep everything in self: no class attribute, global or "
        "default that changes"
    ),
    "SendsWhatCannotBeWritten": (
        "the robot in 'two rooms', action 2: it sent a message that cannot be written: "
        "Hello.content[1] is Generator(PCG64), a Generator; messages hold "
        "numbers, text, tuples, structures and read-only numpy arrays"
    ),
    "ChangesItsMessage": (
        "the robot in 'two rooms', action 4: a message (Hello) that it had sent was "
        "changed; copy what is to be changed: all that is given is kept"
    ),
    "SendsToNobody": (
        "the robot in 'two rooms', action 1: it sent a message to robot 7; it is alone: "
        "give None for all that there may be"
    ),
    "DrawsByRandom": (
        "the robot in 'two rooms', action 2: sent the same as before, it yielded Move to "
        "PLACE, not Move to PLACE: it draws on global random numbers: random.uniform "
        "(wrong_explorers.py:LINE); draw random numbers from the rng of its RobotSelf "
        "alone"
    ),
    "DrawsByNumpy": (
        "the robot in 'two rooms', action 2: sent the same as before, it yielded Move to "
        "PLACE, not Move to PLACE: it draws on global random numbers: np.random.uniform "
        "(wrong_explorers.py:LINE); draw random numbers from the rng of its RobotSelf "
        "alone"
    ),
    "DrawsFromAnUnseededGenerator": (
        "the robot in 'two rooms', action 2: sent the same as before, it yielded Move to "
        "PLACE, not Move to PLACE: it draws on other random numbers: "
        "np.random.default_rng (wrong_explorers.py:LINE); draw random numbers from the "
        "rng of its RobotSelf alone"
    ),
    "ReadsAClock": (
        "the robot in 'two rooms', action 2: sent the same as before, it yielded Move to "
        "PLACE, not Move to PLACE: it reads a clock: time.time (wrong_explorers.py:LINE);"
        " use the times of scans, motions and messages instead"
    ),
    "GoesByAddresses": (
        "the robot in 'two rooms', action 2: sent the same as before, it yielded Move to "
        "PLACE, not Move to PLACE: it depends on something besides what it was sent: "
        "perhaps on memory addresses, id (wrong_explorers.py:LINE); draw "
        "random numbers from the rng of its RobotSelf alone; do not depend on the order "
        "of a set; keep everything in self: no class attribute, global or default that "
        "changes"
    ),
    "WaitsForEver": (
        "a robot alone in 'two rooms': robot 0 is waiting for a message that never comes;"
        " give Receive a timeout_s, and end with Done"
    ),
    "PollsForEver": (
        "a robot alone in 'two rooms': robot 0 is not done after 2000 s; the last were "
        "100 Receive; see that every exploration ends with Done, or give a larger "
        "max_time_s (--max-time)"
    ),
    "DrivesToAndFro": (
        "a robot alone in 'two rooms': robot 0 is not done after 2000 s; the last were "
        "100 Move; see that every exploration ends with Done, or give a larger max_time_s"
        " (--max-time)"
    ),
    "NotesForEver": (
        "the robot in 'two rooms', action 1000: it yielded 1000 actions at 0 s and lets "
        "no time pass; the last were 100 Note; have it move, wait with a Receive that "
        "does not end at once, or end"
    ),
    "ComputesForEver": (
        "the robot in 'two rooms', action 1: it has computed for 0.3 s and yields nothing"
        " (wrong_explorers.py:LINE, in run: while best < scan.range_m:); see that every "
        "loop ends or yields, or give a larger max_decision_s (--max-decision)"
    ),
    "CatchesAll": (
        "the robot in 'two rooms', action 1: it has computed for 0.3 s and yields nothing"
        " (wrong_explorers.py:LINE, in run: while True:); see that every loop ends or "
        "yields, or give a larger max_decision_s (--max-decision)"
    ),
    "ReturnsAList": (
        "the robot in 'two rooms', before its first action: its run() returned a list, "
        "not a generator; have it yield every action, as in scan = yield Sense(), and at "
        "last yield Done(...)"
    ),
    "ReturnsNothing": (
        "the robot in 'two rooms', before its first action: its run() returned None, not "
        "a generator; have it yield every action, as in scan = yield Sense(), and at last"
        " yield Done(...)"
    ),
    "ReturnsWithoutDone": (
        "the robot in 'two rooms', action 1: its run() ended without a last action Done; "
        "yield Done(complete=..., reason=...) before it returns"
    ),
    "IsAsynchronous": (
        "the robot in 'two rooms', before its first action: its run() is asynchronous; "
        "write def run(self), not async def"
    ),
    "YieldsATuple": (
        "the robot in 'two rooms', action 1: it yielded 2 actions at once, in a tuple; "
        "yield them one by one: each has an outcome"
    ),
    "YieldsNothing": (
        "the robot in 'two rooms', action 1: it yielded None, which is no action; yield "
        "Sense(), not yield alone"
    ),
    "YieldsAClass": (
        "the robot in 'two rooms', action 1: it yielded the class Sense; yield an "
        "instance: Sense(...)"
    ),
    "YieldsAProcedure": (
        "the robot in 'two rooms', action 2: it yielded what go() returned, a generator; "
        "delegate to a procedure that yields actions: yield from go()"
    ),
    "YieldsATrajectory": (
        "the robot in 'two rooms', action 1: it yielded "
        "Trajectory(waypoints=(Waypoint(time_s=0.0, x=10.368737622511986, "
        "y=4.25561488..., which is no action; yield Move(trajectory=...) to follow it"
    ),
    "BeginsElsewhere": (
        "the robot in 'two rooms', action 2: its trajectory begins at (0.000, 0.000, "
        "0.000), but the robot is at (10.369, 4.256, 0.000); begin where the last Moved "
        "says that the robot is, heading included"
    ),
    "DrivesTooFast": (
        "the robot in 'two rooms', action 2: it drives 0.5 m from (10.369, 4.256, 0.000) "
        "to (10.869, 4.256, 0.000) in 0.1 s; its kinematics allow 0.5 m/s: give its "
        "waypoints later times, or let multisrt.planners.motion.steering make its "
        "trajectories"
    ),
    "DrivesToNowhere": (
        "the robot in 'two rooms', action 2: waypoint 1 of its trajectory is nan, a "
        "float; give a finite number"
    ),
    "IsDoneWhileItMoves": (
        "robot 0 of 3 in 'two rooms', action 3: it yielded Done while a motion goes on; "
        "yield Receive to wait for its end, or Stop"
    ),
    "StopsWhereItStands": (
        "the robot in 'two rooms', action 1: it yielded Stop, but it stands; Stop ends a "
        "motion: Move first"
    ),
    "NotesForAnother": (
        "the robot in 'two rooms', action 1: it put an event of robot 1 on record "
        "(wrong_explorers.py:LINE, in run: "
        "yield Note(MapComplete(time_s=0.0, robot=self.me.robot + 1))); give "
        "its MapComplete robot=0: a robot speaks for itself alone"
    ),
    "NotesTheFuture": (
        "the robot in 'two rooms', action 1: its MapComplete has time_s=60 at 0 s "
        "(wrong_explorers.py:LINE, in run: "
        "yield Note(MapComplete(time_s=60.0, robot=self.me.robot))); give "
        "the present time: every outcome has it as time_s, those of Sense, Move, Stop and Receive "
        "(also TimedOut), and at the start its RobotSelf"
    ),
    "EndsWithAWord": (
        "the robot in 'two rooms', action 2: complete of its Done is 'yes', a str; give "
        "True or False: bool(x)"
    ),
    "ImportsTheWorld": (
        "the robot in 'two rooms', before its first action: it reaches the truth: import "
        "of multisrt.environments.catalog is the module multisrt.environments.catalog; an"
        " explorer knows its scans, its messages and its RobotSelf, and that is all"
    ),
    "SearchesMemory": (
        "the robot in 'two rooms', before its first action: its code names gc.get_objects"
        " (wrong_explorers.py:LINE), by which it could reach the truth; an explorer "
        "knows its scans, its messages and its RobotSelf, and that is all"
    ),
    "LooksIntoFrames": (
        "the robot in 'two rooms', before its first action: its code names .tb_frame "
        "(wrong_explorers.py:LINE), by which it could reach the truth; an explorer knows"
        " its scans, its messages and its RobotSelf, and that is all"
    ),
    "WritesALog": (
        "the robot in 'two rooms', before its first action: its code names open "
        "(wrong_explorers.py:LINE), by which it could read files while it runs, such as the "
        "recording that is being written; read what it needs, such as weights, when its module is "
        "imported or in __init__; log by the module logging, or put decisions on record with "
        "decided(...)"
    ),
    "ChangesItsScan": (
        "the robot in 'two rooms', action 1: a scan that it was sent was changed; copy "
        "what is to be changed: all that is given is kept"
    ),
    "RaisesAnError": (
        "the robot in 'two rooms', action 1: it raised KeyError: 'goal' "
        '(wrong_explorers.py:LINE, in best: return costs["goal"]); correct that line: an '
        "explorer ends with Done, whatever happens"
    ),
    "Exits": (
        "the robot in 'two rooms', action 1: it raised SystemExit: 0 "
        "(wrong_explorers.py:LINE, in run: raise SystemExit(0)); correct that line: an "
        "explorer ends with Done, whatever happens"
    ),
    "CannotBeBuilt": (
        "a robot alone in 'two rooms': building the explorer of robot 0: it raised "
        "AttributeError: 'Footprint' object has no attribute 'breadth_m' (did you mean 'width_m'?) "
        "(wrong_explorers.py:LINE, in __init__: self.width_m = me.footprint.breadth_m); "
        "correct that line: build it from its RobotSelf and its options alone"
    ),
    "HasNoRun": (
        "explorer of strategy 'has-no-run': the class HasNoRun has no run(); write def "
        "run(self), a generator that yields actions and is sent their outcomes"
    ),
    "TakesTooMuch": (
        "tests.multisrt.testing.wrong_explorers.TakesTooMuch must take the robot (a "
        "RobotSelf) and the options, and nothing else: it needs world, too; write 'def "
        "__init__(self, me, options)'"
    ),
    "ForgetsYieldFrom": (
        "a robot alone in 'two rooms': it calls self.look_around(), which yields actions, and "
        "lets go of them (wrong_explorers.py:LINE, in run): nothing of it is done; write yield "
        "from self.look_around()"
    ),
    "ForgetsYield": (
        "a robot alone in 'two rooms': it makes a Sense and does not yield it "
        "(wrong_explorers.py:LINE, in run): nothing comes of it; write yield Sense()"
    ),
    "UsesAnAction": (
        "the robot in 'two rooms', action 1: it raised AttributeError: 'Sense' object has no "
        "attribute 'time_s' (wrong_explorers.py:LINE, in run: yield "
        "Receive(timeout_s=scan.time_s)); a Sense is an action, and what comes of it is sent back "
        "when it is yielded: write scan = yield Sense()"
    ),
    "MisspellsAnAttribute": (
        "the robot in 'two rooms', action 1: it raised AttributeError: 'ExactScan' object has no "
        "attribute 'times_s' (did you mean 'time_s'?) (wrong_explorers.py:LINE, in run: yield "
        "Receive(timeout_s=scan.times_s)); correct that line: an explorer ends with Done, whatever "
        "happens"
    ),
    "GivesArgumentsByPlace": (
        "the robot in 'two rooms', action 1: it raised TypeError: Extra positional arguments "
        "provided (wrong_explorers.py:LINE, in run: yield Move(self.at, guard=0.1)  # type: "
        "ignore[call-arg]); write Move(trajectory=..., purpose=..., guard_m=..., listen=...)"
    ),
    "ForgetsSuper": (
        "the robot in 'two rooms', before its first action: it raised AttributeError: "
        "'ForgetsSuper' object has no attribute '_explorer'; begin ForgetsSuper.__init__ with "
        "super().__init__(me, options)"
    ),
    "MisspellsChoose": (
        "explorer of strategy 'misspells-choose': the class MisspellsChoose does not define "
        "choose() (did you mean 'chose'?)"
    ),
    "misspells_a_function": (
        "the robot in 'two rooms', action 2: it raised AttributeError: 'numpy.ndarray' object has "
        "no attribute 'argmim' (did you mean 'argmin'?) (wrong_explorers.py:LINE, in "
        "misspells_a_function: return costs[robot].argmim()); correct that line: an explorer ends "
        "with Done, whatever happens"
    ),
    "Collides": (
        "a team of 3 in 'two rooms': robot 1 touched robot 2 at (3.117, 3.022) on its way"
        " from (2.632, 2.902), at 6.18154 s; keep the body in what is sensed to be free; "
        "give Move a guard_m where other robots are about"
    ),
}

WARNED = {
    "NeverSenses": (
        "it never senses: no robot takes a scan, so all that it knows is where it stands;"
        " yield Sense(), and read the Scan that it is sent",
        "it says that it is complete but covered 0.0 % in 6 runs; give Done complete=True "
        "only where no frontier is left: from 95 % on a run is a success",
    ),
    "EndsAtOnce": (
        "it ends at once: its first action is Done; yield Sense() first, and move to "
        "where it sees more",
    ),
    "NeverMoves": (
        "it never moves: it sees what can be seen from its start alone; yield Move(...) "
        "to a place that its scan shows to be free",
    ),
    "ForgetsReturn": (
        "choose (wrong_explorers.py:LINE) returns nothing: the robot is done at once; return the "
        "place to go to",
        "it says that it is complete but covered 21.0 % (1 robot in 'maze'), 35.2 % (1 robot in "
        "'open') and less than 95 % in 4 other runs; give Done complete=True only where no "
        "frontier is left: from 95 % on a run is a success",
    ),
    "CoversLittle": (
        "it covered little in all runs: 21.0 % (1 robot in 'maze'), 35.2 % (1 robot in "
        "'open') and less than 95 % in 4 other runs; a run is a success from 95 % on: see "
        "that it drives on while a frontier is left",
    ),
}


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    # The first runs compile kernels, which is no part of a check.
    check_explorer(wrong.CoversLittle)


def checked(name):
    """Check a wrong explorer within the budget, and return what is said of it."""
    # A busy machine may keep any other from its first action for a second.
    max_decision_s = 0.3 if "computed for 0.3 s" in TOLD.get(name, "") else 10.0
    began_s = time.process_time()
    try:
        explorer = getattr(wrong, name)
        return check_explorer(explorer, max_decision_s=max_decision_s, max_time_s=2000.0)
    finally:
        assert time.process_time() - began_s < MAX_SECONDS


def without_chance(text):
    """Return a message without what differs from run to run, and without numbers of lines."""
    text = re.sub(r"(\.py):\d+", r"\1:LINE", text)
    text = re.sub(r"Move to \(.*?\)", "Move to PLACE", text)
    return re.sub(r"0x[0-9A-Fa-f]+", "ADDRESS", text)


@pytest.mark.parametrize("name", TOLD)
def test_a_wrong_explorer_is_told_what_to_change(name):
    with pytest.raises(InvalidInputError) as caught:
        checked(name)
    assert without_chance(str(caught.value)) == TOLD[name]


@pytest.mark.parametrize("name", WARNED)
def test_a_useless_explorer_is_warned_of(name):
    said = checked(name)
    assert tuple(map(without_chance, said.warnings)) == WARNED[name]
    assert str(said).count("WARNING: ") == len(said.warnings)


def test_a_place_in_a_message_is_the_line_with_the_mistake():
    with pytest.raises(InvalidInputError, match=r"wrong_explorers.py:(\d+)") as caught:
        checked("RaisesAnError")
    found = re.search(r"wrong_explorers.py:(\d+)", str(caught.value))
    assert found is not None
    line = int(found[1])
    with open(wrong.__file__, encoding="utf-8") as file:
        assert file.readlines()[line - 1].strip() == 'return costs["goal"]'


def test_a_list_of_the_module_is_no_random_number():
    with pytest.raises(InvalidInputError) as caught:
        checked("keeps_a_list")
    assert "global 'HEARD' changes, which explorers share" in str(caught.value)
    assert "global random numbers" not in str(caught.value)


def test_of_long_actions_the_first_field_that_differs_is_told():
    def noted(rule, because="far"):
        return Note(GoalChosen(time_s=0.0, robot=0, rule=rule * 130, because=because, goal=None))

    assert difference(noted("x"), noted("x", "near")) == (
        "Note with event.because = 'far', not 'near'"
    )
    assert difference(noted("x"), Sense()) == ""
    assert difference(Receive(timeout_s=1.0), Receive(timeout_s=2.0)) == ""
