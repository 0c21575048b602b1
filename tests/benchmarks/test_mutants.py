"""Planted defects: their texts, the copy of the program, and the table of what is found."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import multisrt
from benchmarks.mutants import command
from benchmarks.mutants.campaigns import Campaigns, finding_of
from benchmarks.mutants.catalogue import CONTROL, MUTANTS
from benchmarks.mutants.command import main
from benchmarks.mutants.copies import ProgramCopy
from benchmarks.mutants.findings import Finding, Findings, key_of
from benchmarks.mutants.mutant import Mutant
from benchmarks.mutants.page import page
from multisrt.campaign.mission import Verdict
from multisrt.campaign.store import CampaignStore, row_of
from multisrt.campaign.violations import Violation
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.campaign.test_store import mission_of

PACKAGE = Path(str(multisrt.__file__)).parent

SPEED = "too-fast"


def finding(name: str, mission: int | None, missions: int = 300) -> Finding:
    return Finding(
        mutant=name,
        key=key_of(MUTANTS.get(name), 0),
        missions=missions if mission is None else mission,
        mission=mission,
        invariants=() if mission is None else ("ends", "no-error"),
        says="" if mission is None else "it broke",
        seconds=12.0,
    )


@pytest.fixture
def campaign(monkeypatch):
    """Make campaigns without runs: mission 5 of the program with the defect `SPEED` fails."""
    calls: list[tuple[str, int]] = []

    def run(self, name, copy, store):
        calls.append((name, self.missions))
        broke = (Violation(invariant="motion-within-drive", says="it is too fast"),)
        with CampaignStore.create_or_open(store, self.seed) as opened:
            for number in range(self.missions):
                fails = name == SPEED and number == 4
                verdict = Verdict(outcome="complete", violations=broke if fails else ())
                opened.add(row_of(mission_of(number, verdict)))
                if fails:
                    return

    monkeypatch.setattr(Campaigns, "_run", run)
    return calls


def test_there_are_defects_of_all_parts():
    assert len(MUTANTS) == 60
    assert len({mutant.digest for mutant in MUTANTS.values()}) == 60
    parts = {mutant.file.split("/")[0] for mutant in MUTANTS.values()}
    assert parts >= {"simulation", "robots", "planners", "geometry", "analysis"}


@pytest.mark.parametrize("mutant", MUTANTS.values(), ids=list(MUTANTS))
def test_a_defect_changes_a_file_that_can_be_compiled(mutant):
    source = (PACKAGE / mutant.file).read_text()
    changed = mutant.changed(source)
    assert changed != source
    compile(changed, mutant.file, "exec")


@pytest.mark.parametrize("text", ["no such text", "import"])
def test_a_text_that_is_not_there_once_is_an_error(text):
    mutant = Mutant(name="mine", breaks="It.", file="simulation/mail.py", old=text, new="")
    with pytest.raises(InvalidInputError, match="mutant mine: its text occurs"):
        mutant.changed((PACKAGE / mutant.file).read_text())


def test_a_copy_has_one_defect_at_a_time_and_is_the_one_in_use(tmp_path):
    copy = ProgramCopy(tmp_path)
    first, second = MUTANTS[SPEED], MUTANTS["90-after-95"]
    copy.prepare(first)
    (copy.package / "stale.py").write_text("")
    kept = (copy.package / "simulation/radio.py").stat().st_mtime_ns
    copy.prepare(second)
    assert kept == (PACKAGE / "simulation/radio.py").stat().st_mtime_ns
    assert (copy.package / first.file).read_bytes() == (PACKAGE / first.file).read_bytes()
    assert second.new in (copy.package / second.file).read_text()
    assert not (copy.package / "stale.py").exists()
    code = "import multisrt.analysis.measuring as m, inspect; print(m.__file__, '0.97' in "
    code += "inspect.getsource(m._time))"
    done = subprocess.run(
        [sys.executable, "-P", "-c", code],
        env=copy.environment(),
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == [str(copy.package / second.file), "True"]
    copy.prepare(None)
    assert (copy.package / second.file).read_bytes() == (PACKAGE / second.file).read_bytes()


def test_what_a_campaign_came_to_is_read_from_its_missions(tmp_path):
    store = tmp_path / "a.sqlite"
    broke = (Violation(invariant="ends", says="it broke"), Violation(invariant="x", says="y"))
    with CampaignStore.create_or_open(store) as opened:
        for number, violations in enumerate([(), broke, ()]):
            verdict = Verdict(outcome="complete", violations=violations, run_s=2.0, check_s=0.5)
            opened.add(row_of(mission_of(number, verdict)))
    found = finding_of("mine", "key", store)
    assert (found.missions, found.mission, found.invariants) == (3, 2, ("ends", "x"))
    assert (found.says, found.seconds) == ("it broke", 7.5)


def test_a_campaign_goes_on_where_it_ended(tmp_path, campaign, capsys):
    order = ["--out", str(tmp_path), "--only", "closing-for-all", SPEED, CONTROL]
    assert main([*order, "--missions", "10"]) == 1
    assert campaign == [("closing-for-all", 10), (SPEED, 10), (CONTROL, 10)]
    line = capsys.readouterr().out.splitlines()[1]
    assert line.startswith("too-fast ")
    assert "`motion-within-drive`; missions: 5;" in line
    campaign.clear()
    assert main([*order, "--missions", "10"]) == 1
    assert campaign == []
    assert main([*order, "--missions", "12"]) == 1
    assert campaign == [("closing-for-all", 12), (CONTROL, 12)]
    assert main(["--out", str(tmp_path), "--only", SPEED, CONTROL, "--missions", "12"]) == 0


def test_a_defect_is_tried_anew_if_the_program_changes(tmp_path, campaign, monkeypatch):
    order = ["--out", str(tmp_path), "--only", SPEED, "--missions", "9"]
    assert main(order) == 0
    monkeypatch.setattr("benchmarks.mutants.findings.program_digest", lambda *also: "changed")
    assert main(order) == 0
    assert campaign == [(SPEED, 9), (SPEED, 9)]
    assert main([*order, "--seed", "1"]) == 0
    assert len(campaign) == 3


def test_a_program_that_does_not_start_is_an_error(tmp_path, monkeypatch, capsys):
    def fails(*given, **options):
        return subprocess.CompletedProcess(given, 3, "", "no such module")

    monkeypatch.setattr("benchmarks.mutants.campaigns.subprocess.run", fails)
    assert main(["--out", str(tmp_path), "--only", SPEED]) == 2
    assert f"the campaign of {SPEED} ended with 3: no such module" in capsys.readouterr().err


def test_the_page_is_made_from_what_is_kept(tmp_path, monkeypatch):
    kept = Findings(tmp_path / "findings.jsonl")
    for found in (finding(SPEED, None), finding(SPEED, 3), finding(CONTROL, None, 900)):
        kept.add(found)
    monkeypatch.setattr(command, "PAGE", tmp_path / "mutants.md")
    assert main(["--out", str(tmp_path), "--page"]) == 0
    text = (tmp_path / "mutants.md").read_text()
    assert "Campaigns found 1 of 60 defects, each within 100 missions" in text
    assert "The unmodified program ran 900 missions; none of them failed." in text
    assert text.splitlines()[2].startswith(
        "Made with `python -m benchmarks.mutants` and `python -m benchmarks.mutants --page`. A "
    )
    rows = {line.split(" | ")[0].strip("| "): line for line in text.splitlines() if "| " in line}
    assert rows[SPEED].endswith("| `ends`, `no-error` | 3 | 12 |")
    assert rows[CONTROL].endswith("| nothing | 900, none failed | 12 |")
    assert rows["overheard"].endswith("| not tried yet |  |  |")
    assert page({CONTROL: finding(CONTROL, 7)}, 0).count("the last failed (ends, no-error") == 1
    assert text == page({SPEED: finding(SPEED, 3), CONTROL: finding(CONTROL, None, 900)}, 0)


def test_the_page_counts_what_was_found():
    some = {SPEED: finding(SPEED, 200), "overheard": finding("overheard", None)}
    text = page(some, 4)
    assert "`python -m benchmarks.mutants --seed 4` and" in text
    assert "Campaigns found 1 of 60 defects, 0 of them within 100 missions" in text


@pytest.mark.parametrize("option", ["--missions", "--workers"])
def test_numbers_out_of_bounds_are_refused(option, capsys):
    with pytest.raises(SystemExit) as ended:
        main([option, "0"])
    assert ended.value.code == 2
    assert "'0' is not a whole number of at least 1" in capsys.readouterr().err


def test_a_damaged_file_of_findings_is_named(tmp_path, capsys):
    (tmp_path / "findings.jsonl").write_text("{}\n")
    assert main(["--out", str(tmp_path), "--page"]) == 2
    assert "findings.jsonl, line 1: no finding" in capsys.readouterr().err
    assert not os.path.exists(tmp_path / "missions")


def test_all_defects_are_listed(capsys):
    assert main(["--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(MUTANTS)
