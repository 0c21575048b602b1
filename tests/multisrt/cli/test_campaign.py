"""The commands of `multisrt campaign`."""

from functools import partial

import pytest

from multisrt.campaign import lane, running
from multisrt.campaign.draws import draw
from multisrt.campaign.failure import Failure, write_failure
from multisrt.campaign.invariants import INVARIANTS
from multisrt.campaign.mission import Verdict
from multisrt.campaign.violations import Violation
from multisrt.spec import CatalogEnvironment, RunSpec
from tests.multisrt.campaign.test_store import mission_of

BROKE = Violation(invariant="ends", says="it broke")


class FakeLane:
    """Makes missions without runs; mission 2 fails."""

    def __init__(self, seed, folder, quota):
        self.folder = folder

    def make(self, number):
        """Make a mission."""
        if number != 2:
            yield mission_of(number, Verdict(outcome="out_of_time", digest="ab"))
            return
        folder = str(self.folder / "000002-ends")
        yield lane.Found(number, (BROKE,))
        yield mission_of(
            number, Verdict(outcome="complete", violations=(BROKE,)), folders=(folder,)
        )

    def close(self):
        """Let go of nothing."""

    stop = close


@pytest.fixture
def call(call, monkeypatch):
    """Run `multisrt campaign`, whose missions are not made."""
    monkeypatch.setattr(running, "Lane", FakeLane)
    return partial(call, "campaign")


def test_a_campaign_that_stops_at_its_first_failure_makes_no_more(call, folder):
    code, out, _ = call("run", "--missions", "5", "--stop-at-first")
    assert code == 1
    assert "3 missions, 1 of them failed" in out


def test_a_campaign_prints_failures_and_a_table(call, folder):
    code, out, err = call("run", "--missions", "5", "--seed", "7")
    assert (code, err) == (1, "")
    lines = [line for line in out.splitlines() if line.strip()]
    assert lines[:2] == [
        "mission 2: ends: it broke",
        "mission 2: multisrt campaign replay campaign-failures/000002-ends",
    ]
    assert lines[2].split() == [
        "strategy", "missions", "out_of_time", "complete", "s", "(median)", "ends",
    ]  # fmt: skip
    assert ["minpos", "5", "4", "1", "0.00", "1"] in [line.split() for line in lines]
    assert ["all", "5", "4", "1", "0.00", "1"] in [line.split() for line in lines]
    assert "5 missions, 1 of them failed; 0 were repeated in another process; 5 draws" in out
    assert lines[-1] == "missions: campaign.sqlite"
    assert (folder / "campaign.sqlite").is_file()


def test_the_same_command_goes_on(call):
    assert call("run", "--missions", "2", "--quiet")[0] == 0
    code, out, _ = call("run", "--missions", "3", "--seed", "0")
    assert code == 1
    assert "3 missions, 1 of them failed" in out
    code, _, err = call("run", "--missions", "3", "--seed", "1")
    assert code == 2
    assert "holds missions of seed 0, not 1" in err


def test_missing_folders_of_a_store_are_made(call, folder):
    code, out, err = call("run", "--missions", "2", "--store", "new/newer/x.sqlite")
    assert (code, err) == (0, "")
    assert out.splitlines()[-1] == "missions: new/newer/x.sqlite"
    assert (folder / "new/newer/x.sqlite").is_file()


@pytest.mark.parametrize("time", ["1.5h", "1h30m", "1 h 29 min 60s", "90m"])
def test_a_campaign_for_a_time(call, monkeypatch, time):
    given = {}
    monkeypatch.setattr(running, "run_campaign", lambda store, **more: given.update(more))
    code, out, _ = call("run", "--for", time, "--workers", "2", "--shrink", "0")
    assert code == 0
    assert "no mission is stored yet" in out
    assert (given["for_s"], given["missions"]) == (5400.0, None)
    assert (given["workers"], given["shrunk_each"]) == (2, 0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["run"], "give --missions or --for"),
        (["run", "--for", "2 weeks"], "'2 weeks' is not a duration such as 90s, 15m or 1h30m"),
        (["run", "--missions", "x"], "--missions: 'x' is not a whole number; see"),
        (["run", "--for", "0s"], "'0s' is not a duration"),
        (["run", "--for", "1h30"], "'1h30' is not a duration"),
        (["show", "nothing.sqlite"], "nothing.sqlite"),
        (["replay", "nothing"], "there is no nothing: name the folder of a failure"),
    ],
)
def test_bad_input_is_told(call, words, said):
    code, out, err = call(*words)
    assert (code, out) == (2, "")
    assert said in err
    assert len(err.splitlines()) == 1


def test_an_interrupted_campaign_says_what_is_stored(call, monkeypatch):
    def made(lane, number):
        if number == 3:
            raise KeyboardInterrupt
        yield mission_of(number, Verdict(outcome="complete"))

    monkeypatch.setattr(FakeLane, "make", made)
    code, _, err = call("run", "--missions", "9")
    assert code == 130
    assert "3 missions are stored in campaign.sqlite; the same command continues" in err


def test_a_campaign_is_shown_wherever_it_is_moved(call, folder):
    call("run", "--missions", "4", "--seed", "5", "--store", "x.sqlite")
    code, out, _ = call("show", "x.sqlite")
    assert code == 0
    assert "4 missions, 1 of them failed" in out
    assert out.splitlines()[-1] == "mission 2: ends: it broke"  # there is no folder
    (folder / "x-failures" / "000002-ends").mkdir(parents=True)
    command = "multisrt campaign replay x-failures/000002-ends"
    assert call("show", "x.sqlite")[1].splitlines()[-1] == f"mission 2: ends: it broke; {command}"
    (folder / "there").mkdir()
    for name in ("x.sqlite", "x-failures"):
        (folder / name).rename(folder / "there" / name)
    shown = call("show", "there/x.sqlite")[1].splitlines()[-1]
    assert (
        shown == "mission 2: ends: it broke; multisrt campaign replay there/x-failures/000002-ends"
    )


def test_the_spec_of_a_mission_is_printed(call):
    call("run", "--missions", "1", "--seed", "5", "--store", "x.sqlite")
    code, out, err = call("show", "x.sqlite", "--number", "3")
    assert code == 0
    assert RunSpec.from_toml(out) == draw(5, 3)
    assert err == "mission 3 is not in x.sqlite: not executed yet\n"
    assert call("show", "x.sqlite", "--number", "0")[2] == ""


@pytest.mark.parametrize(
    ("now", "code", "said"),
    [
        ((BROKE,), 1, "still fails: ends: it broke"),
        ((), 0, "does not fail any more"),
        (
            (Violation(invariant="no-error", says="it hurts"),),
            1,
            "fails differently: no-error: it hurts",
        ),
    ],
)
def test_a_failure_is_replayed(call, folder, monkeypatch, now, code, said):
    spec = RunSpec(environment=CatalogEnvironment(name="open"))
    failure = Failure(says="it broke", invariant="ends", seed=1, number=2)
    write_failure(folder / "failure", failure, spec, spec)
    asked = []

    def replayed(*given):
        asked.append(given)
        return now

    monkeypatch.setattr(lane, "replayed", replayed)
    found, out, _ = call("replay", "failure")
    assert found == code
    assert out.splitlines() == ["failed with: ends: it broke", said]
    assert asked[0][0] == spec


def test_an_unknown_invariant_is_not_replayed(call, folder):
    spec = RunSpec(environment=CatalogEnvironment(name="open"))
    failure = Failure(says="it broke", invariant="no-colision", seed=1, number=2)
    write_failure(folder / "failure", failure, spec, spec)
    code, out, err = call("replay", "failure")
    assert (code, out) == (2, "")
    assert err == (
        "error: failure/failure.toml: there is no invariant 'no-colision' (did you mean "
        "'no-collision'?); 'multisrt campaign invariants' lists them\n"
    )


def test_every_invariant_is_listed(call):
    code, out, _ = call("invariants")
    assert code == 0
    names = {line.split()[0] for line in out.splitlines() if line.strip()}
    assert names >= {*INVARIANTS, "no-error", "hangs", "equal-digest", "can-be-judged"}
    assert "The run raises no error" in out
    assert "Check that" not in out
    assert "No body touches an obstacle" in out


def test_numbers_of_a_summary_agree_with_their_verbs(call):
    _, out, _ = call("run", "--missions", "1")
    assert "1 mission, 0 of them failed; 0 were repeated" in out
    assert "; 1 draw was impossible and drawn again" in out
