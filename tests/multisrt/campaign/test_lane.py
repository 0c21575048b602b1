"""Missions in processes of their own."""

from contextlib import closing

import msgspec
import pytest

from multisrt.campaign import lane as lane_module
from multisrt.campaign import mission_process
from multisrt.campaign.draws import draw
from multisrt.campaign.failure import read_failure
from multisrt.campaign.jobs import Attempt, Judge, Make
from multisrt.campaign.lane import EQUAL_DIGEST, Found, Lane, Mission, compared, replayed
from multisrt.campaign.mission import Verdict, judge
from multisrt.campaign.mission_process import MissionProcess, Told
from multisrt.campaign.store import NOT_DRAWN, row_of
from multisrt.campaign.violations import Violation
from multisrt.experiments.threads import StoppedError
from multisrt.geometry.errors import InvalidInputError
from multisrt.recording import Recording
from multisrt.spec import CatalogEnvironment, RobotSpec, RunSpec, StopRule

HALL = CatalogEnvironment(name="open", parameters={"size_m": 6.0})
SPEC = RunSpec(environment=HALL, strategy="closest", stop=StopRule(max_time_s=30.0))


class FakeProcess(MissionProcess):
    """Judges runs in this process, by an invariant that wants at most one robot."""

    drawn = msgspec.structs.replace(SPEC, robots=(RobotSpec(footprint="disc:0.2"),) * 4, seed=8)
    tried = Attempt(spec=drawn, refused=2)

    def __init__(self, hash_seed):
        """Begin."""

    def ask(self, job, limit_s=0.0):
        """Judge a run."""
        if isinstance(job, Make):
            return Told(self.ask(Judge(spec=self.drawn)).verdict, self.tried)
        broke = Violation(invariant="planted", says=f"{len(job.spec.robots)} robots")
        fails = len(job.spec.robots) > 1
        verdict = Verdict(outcome="complete", violations=(broke,) * fails, digest="same")
        return Told(verdict, None)

    def close(self):
        """Let go of nothing."""


@pytest.fixture
def fake(monkeypatch):
    """A lane whose process judges nothing but the number of robots."""
    monkeypatch.setattr(lane_module, "MissionProcess", FakeProcess)
    return FakeProcess


def made_by(lane: Lane, number: int) -> tuple[list[Found], Mission]:
    """What a lane tells of a mission before it is made, and the mission."""
    *told, mission = lane.make(number)
    assert isinstance(mission, Mission)
    return [found for found in told if isinstance(found, Found)], mission


@pytest.mark.slow
def test_a_lane_makes_the_missions_that_are_drawn(tmp_path):
    lane = Lane(3, tmp_path, lambda invariant, strategy: True)
    try:
        missions = [made_by(lane, number)[1] for number in (1, 20)]
    finally:
        lane.close()
    assert [mission.spec for mission in missions] == [draw(3, 1), draw(3, 20)]
    assert [mission.repeated for mission in missions] == [
        bool(missions[0].verdict.violations),
        True,
    ]
    assert missions[0].verdict.digest == judge(draw(3, 1)).digest


@pytest.mark.slow
def test_a_run_that_hangs_and_one_that_takes_its_process_down(monkeypatch):
    monkeypatch.setattr(mission_process, "COMPILATION_S", 0.0)
    process = MissionProcess(1)
    try:
        hung = process.ask(Judge(spec=SPEC), limit_s=0.05).verdict
        assert (hung.outcome, hung.violations[0].invariant) == ("lost", "hangs")
        assert "not done after 0.05 s" in hung.reason
        monkeypatch.setattr(mission_process, "PROGRAM", "multisrt.nothing_of_that_name")
        ended = process.ask(Judge(spec=SPEC)).verdict
        assert (ended.outcome, ended.violations[0].invariant) == ("lost", "no-error")
        assert ended.reason == "its process ended with exit code 1"
    finally:
        process.close()


@pytest.mark.parametrize(
    ("outcome", "asked"), [("over_memory", 2), ("lost", 2), ("error", 1), ("complete", 1)]
)
def test_what_the_machine_may_have_done_is_tried_again(monkeypatch, outcome, asked):
    told = iter([Told(Verdict(outcome=outcome), None), Told(Verdict(outcome="stalled"), None)])
    closed = []
    process = MissionProcess(1)
    monkeypatch.setattr(process, "_ask", lambda job, limit_s: next(told))
    monkeypatch.setattr(process, "close", lambda: closed.append(True))
    found = process.ask(Judge(spec=SPEC)).verdict.outcome
    assert found == ("stalled" if asked == 2 else outcome)
    assert len(closed) == asked - 1


@pytest.mark.slow
def test_recording_and_replay_of_a_failure_are_left(tmp_path):
    found = Violation(invariant="planted", says="it broke")
    assert replayed(SPEC, tmp_path, found) == ()
    assert not list(tmp_path.iterdir())  # it does not fail
    with closing(MissionProcess(1)) as process:
        process.ask(Judge(spec=SPEC, folder=str(tmp_path)))
        assert Recording.load(tmp_path / "recording.jsonl").spec == SPEC.canonical()
        assert "<html" in (tmp_path / "replay.html").read_text()[:200]
        (tmp_path / "recording.jsonl").unlink()
        (tmp_path / "recording.jsonl").mkdir()
        with pytest.raises(InvalidInputError, match=r"recording\.jsonl"):
            process.ask(Judge(spec=SPEC, folder=str(tmp_path)))
        assert process.ask(Judge(spec=SPEC)).verdict.digest


@pytest.mark.slow
def test_a_spec_that_the_program_refuses_is_no_longer_a_failure_that_is_mended(tmp_path):
    found = Violation(invariant="planted", says="it broke")
    spec = msgspec.structs.replace(SPEC, strategy="utilty")
    with pytest.raises(InvalidInputError, match=r"spec\.toml: .*did you mean 'utility'"):
        replayed(spec, tmp_path, found)


def test_a_stopped_process_makes_nothing_more():
    process = MissionProcess(1)
    process.stop()
    with pytest.raises(StoppedError):
        process.ask(Judge(spec=SPEC))


def test_a_failure_is_shrunk_and_left_in_its_folder(tmp_path, fake):
    found, mission = made_by(Lane(3, tmp_path, lambda invariant, strategy: True), 17)
    assert found == [Found(17, mission.verdict.violations)]
    assert mission.folders == (str(tmp_path / "000017-planted"),)
    assert (mission.spec, mission.refused) == (fake.drawn, 2)
    failure, spec = read_failure(tmp_path / "000017-planted")
    assert (failure.says, failure.number, failure.digest) == ("2 robots", 17, "same")
    assert failure.tries > 3
    assert spec.robots == (RobotSpec(),) * 2
    _, as_drawn = made_by(Lane(3, tmp_path, lambda invariant, strategy: False), 17)
    assert as_drawn.folders == (str(tmp_path / "000017-planted-2"),)  # nothing is overwritten
    failure, spec = read_failure(tmp_path / "000017-planted-2")
    assert (failure.says, failure.tries, spec) == ("4 robots", 0, fake.drawn)
    assert as_drawn.verdict == mission.verdict


def test_a_mission_that_is_lost_before_it_is_drawn_is_told(tmp_path, fake, monkeypatch):
    monkeypatch.setattr(fake, "tried", Attempt(spec=None, refused=4))
    found, mission = made_by(Lane(3, tmp_path, lambda invariant, strategy: True), 17)
    assert found == []
    assert (mission.spec, mission.folders) == (None, ("",))
    assert row_of(mission).strategy == NOT_DRAWN
    assert not list(tmp_path.iterdir())


def test_another_digest_in_another_process_is_a_violation(fake):
    verdict = judge(SPEC)
    same = msgspec.structs.replace(verdict, digest="same")
    assert compared(SPEC, same, FakeProcess(2)) == same
    (found,) = compared(SPEC, verdict, FakeProcess(2)).violations
    assert found.invariant == EQUAL_DIGEST
    assert f"digest {verdict.digest[:12]}" in found.says
    nothing = Verdict(outcome="error")
    assert compared(SPEC, nothing, FakeProcess(2)) == nothing
