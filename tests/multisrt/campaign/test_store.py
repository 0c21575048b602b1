"""The store of a campaign."""

import sqlite3

import pytest

from multisrt.campaign import store as store_module
from multisrt.campaign.lane import Mission
from multisrt.campaign.mission import Verdict
from multisrt.campaign.store import CampaignStore, row_of
from multisrt.campaign.violations import Violation
from multisrt.experiments.spec import ExperimentSpec
from multisrt.experiments.store import Store
from multisrt.geometry.errors import InvalidInputError
from multisrt.spec import CatalogEnvironment, RobotSpec, RunSpec

BROKE = Violation(invariant="no-collision", says="it broke", robot=1, time_s=2.5)
VERDICT = Verdict(
    outcome="stalled", violations=(BROKE,), reason="why", time_s=9.5, events=7, steps=8, digest="ab"
)


def mission_of(number: int, verdict: Verdict = VERDICT, **more) -> Mission:
    """Return a mission that was made."""
    spec = RunSpec(
        environment=CatalogEnvironment(name="open"), strategy="minpos", robots=(RobotSpec(),) * 2
    )
    more = {"folders": ("a/b",) * len(verdict.violations)} | more
    return Mission(number=number, spec=spec, refused=1, verdict=verdict, **more)


def test_missions_are_read_as_they_were_added(path):
    rows = [row_of(mission_of(number, folders=("a/b",), repeated=True)) for number in (3, 1)]
    with CampaignStore.create_or_open(path, 5) as store:
        for row in rows:
            store.add(row)
        assert store.done() == {1, 3}
    with CampaignStore.open(path) as store:
        assert list(store.rows()) == rows[::-1]
        assert store.seed == 5
        assert store.is_of_this_program
    assert not list(path.parent.glob("*-wal"))


def test_a_mission_is_stored_once(path):
    with CampaignStore.create_or_open(path) as store:
        store.add(row_of(mission_of(1)))
        store.add(row_of(mission_of(1, Verdict(outcome="complete"))))
        assert [row.outcome for row in store.rows()] == ["stalled"]


def test_another_seed_is_refused(path):
    CampaignStore.create_or_open(path, 5).close()
    with CampaignStore.create_or_open(path) as store:
        assert store.seed == 5
    with pytest.raises(InvalidInputError, match="missions of seed 5, not 6"):
        CampaignStore.create_or_open(path, 6)


def test_missions_of_another_program_are_not_continued(path, monkeypatch):
    CampaignStore.create_or_open(path).close()
    monkeypatch.setattr(store_module, "program_digest", lambda *also: "0" * 16)
    with pytest.raises(InvalidInputError, match="another version of this program"):
        CampaignStore.create_or_open(path)
    with CampaignStore.open(path) as store:
        assert not store.is_of_this_program


def test_other_files_are_refused(path, tmp_path):
    experiment = ExperimentSpec(name="x", environments=("open",), strategies=("minpos",))
    Store.create_or_open(path, experiment).close()
    with pytest.raises(InvalidInputError, match="not one of a campaign"):
        CampaignStore.open(path)
    with pytest.raises(InvalidInputError, match="not one of a campaign"):
        CampaignStore.create_or_open(path)
    text = tmp_path / "text.sqlite"
    text.write_text("missions")
    with pytest.raises(InvalidInputError):
        CampaignStore.create_or_open(text)


def test_a_file_that_is_written_cannot_be_written_by_another(path):
    with (
        CampaignStore.create_or_open(path),
        pytest.raises(InvalidInputError, match="another process"),
    ):
        CampaignStore.create_or_open(path)


def test_a_damaged_mission_is_told(path):
    with CampaignStore.create_or_open(path) as store:
        store.add(row_of(mission_of(1)))
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE missions SET violations = '{'")
    with (
        CampaignStore.open(path) as store,
        pytest.raises(InvalidInputError, match="damaged: a mission"),
    ):
        list(store.rows())


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("UPDATE missions SET folders = '[]'", "mission 1 has not one folder for each violation"),
        ("UPDATE meta SET value = '-1' WHERE name = 'seed'", "is 0 or positive, not -1"),
        ("UPDATE meta SET value = 'zz' WHERE name = 'seed'", "its seed is 'zz', no whole number"),
        ("DELETE FROM meta WHERE name = 'seed'", "it does not say the seed of its campaign"),
        ("UPDATE meta SET value = x'ff' WHERE name = 'seed'", "its table meta is no text"),
        ("UPDATE missions SET time_s = 9e999", "a number of inf"),
        ("CREATE VIEW more AS SELECT * FROM missions", "its tables are not those"),
    ],
)
def test_damage_is_told(path, change, said):
    with CampaignStore.create_or_open(path) as store:
        store.add(row_of(mission_of(1)))
    with sqlite3.connect(path) as connection:
        connection.execute(change)
    with pytest.raises(InvalidInputError, match=said), CampaignStore.open(path) as store:
        list(store.rows())


def test_a_file_with_a_damaged_page_is_refused_before_a_mission_is_made(path):
    with CampaignStore.create_or_open(path) as store:
        for number in range(200):
            store.add(row_of(mission_of(number)))
    content = bytearray(path.read_bytes())
    assert len(content) > 8 * 4096
    content[-2 * 4096 : -4096] = b"\x55" * 4096
    path.write_bytes(content)
    with pytest.raises(InvalidInputError, match="a damaged file of missions"):
        CampaignStore.create_or_open(path)
    assert bytes(content) == path.read_bytes()
