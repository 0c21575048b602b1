"""What campaigns came to, added up."""

import pytest

from benchmarks import campaigns
from benchmarks.campaigns import add, campaign_of, kept, page
from multisrt.campaign.mission import Verdict
from multisrt.campaign.store import CampaignStore, row_of
from multisrt.campaign.violations import Violation
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.campaign.test_store import mission_of

BROKE = Violation(invariant="boxed-in-is-boxed-in", says="it had a way")


@pytest.fixture
def files(tmp_path):
    """Two campaigns of three missions each; one mission stalled, and need not have."""
    found = []
    for seed in (3, 4):
        path = tmp_path / f"{seed}.sqlite"
        with CampaignStore.create_or_open(path, seed) as store:
            for number in range(3):
                verdict = Verdict(outcome="complete", events=10 * seed + number)
                if (seed, number) == (4, 1):
                    verdict = Verdict(outcome="stalled", events=5, violations=(BROKE,))
                folders = ("there",) * len(verdict.violations)
                store.add(row_of(mission_of(number, verdict, folders=folders)))
        found.append(path)
    return found


def test_campaigns_are_added_once_each(files, tmp_path):
    path = tmp_path / "kept.jsonl"
    add(files[:1], path)
    assert [each.seed for each in add(files, path)] == [3, 4]
    assert kept(path) == [campaign_of(file) for file in files]
    assert len({each.program for each in kept(path)}) == 1


def test_the_page_adds_up_what_they_came_to(files):
    text = page([campaign_of(file) for file in files])
    assert "executed 6 missions" in text
    assert "In 1 of them a check reported a violation" in text
    assert "| all | 6 | 5 | 1 | 1 | 0 | 1 | 42 | 0 |" in text
    assert "0 were repeated in another process; 6 draws were impossible and drawn again." in text
    assert "- A car that cannot reverse was boxed in while driving" in text


def test_the_page_needs_a_campaign(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(campaigns, "KEPT", tmp_path / "none.jsonl")
    with pytest.raises(SystemExit) as ended:
        campaigns.main(["page"])
    assert ended.value.code == 2
    assert capsys.readouterr().err == (
        "no campaign was added yet: add the missions of a file by "
        "'python -m benchmarks.campaigns add FILE'\n"
    )


def test_what_was_found_is_said_in_a_sentence_each(tmp_path, monkeypatch):
    said = campaigns.found_before()
    assert len(said) == len(list(campaigns.FOUND.glob("*.toml")))
    assert all(line[0].isupper() and line.endswith(".") for line in said)
    (tmp_path / "mute.toml").write_text('strategy = "minpos"\n')
    monkeypatch.setattr(campaigns, "FOUND", tmp_path)
    with pytest.raises(InvalidInputError, match=r"mute.toml: its first line is no comment"):
        campaigns.found_before()


@pytest.mark.parametrize("command", [(), ("add",), ("page",)])
def test_the_help_has_examples(command, capsys):
    with pytest.raises(SystemExit):
        campaigns.main([*command, "--help"])
    _, _, examples = capsys.readouterr().out.partition("examples:\n")
    calls = [line.split() for line in examples.splitlines()]
    assert calls
    assert all(call[:3] == ["python", "-m", "benchmarks.campaigns"] for call in calls)
    assert {call[3] for call in calls} == set(command or ("add", "page"))
