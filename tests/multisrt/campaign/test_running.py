"""Making the missions of a campaign that are missing."""

import threading
import time
from typing import ClassVar

import pytest

from multisrt.campaign import running
from multisrt.campaign.mission import Verdict
from multisrt.campaign.running import Progress, run_campaign
from multisrt.campaign.store import CampaignStore
from multisrt.campaign.summary import summary
from multisrt.campaign.violations import Violation
from multisrt.experiments.threads import StoppedError
from multisrt.geometry.errors import InvalidInputError
from tests.multisrt.campaign.test_store import mission_of


class FakeLane:
    """Makes missions without runs; those of numbers that end in 3 fail."""

    made: ClassVar[list[int]] = []
    shrunk: ClassVar[list[bool]] = []
    slow_s = 0.0

    def __init__(self, seed, folder, quota):
        self.seed, self.folder, self.quota = seed, folder, quota
        self.stopped = threading.Event()

    def make(self, number):
        """Make a mission."""
        if self.stopped.wait(self.slow_s):
            raise StoppedError
        FakeLane.made.append(number)
        if number % 10 != 3:
            yield mission_of(number, Verdict(outcome="complete"))
            return
        FakeLane.shrunk.append(self.quota("planted", "minpos"))
        broke = Violation(invariant="planted", says="it broke")
        verdict = Verdict(outcome="complete", violations=(broke,))
        yield mission_of(number, verdict, folders=(str(self.folder / str(number)),))

    def close(self):
        """Let go of nothing."""

    def stop(self):
        """Stop."""
        self.stopped.set()


@pytest.fixture(autouse=True)
def lanes(monkeypatch):
    """Make missions without runs."""
    monkeypatch.setattr(running, "Lane", FakeLane)
    monkeypatch.setattr(FakeLane, "made", [])
    monkeypatch.setattr(FakeLane, "shrunk", [])
    monkeypatch.setattr(FakeLane, "slow_s", 0.0)


def test_a_campaign_goes_on_where_it_ended(path):
    with CampaignStore.create_or_open(path, 2) as store:
        run_campaign(store, missions=7)
        run_campaign(store, missions=12, workers=3)
        assert store.done() == set(range(12))
    assert sorted(FakeLane.made) == list(range(12))
    with CampaignStore.create_or_open(path) as store:
        run_campaign(store, missions=12)
    assert len(FakeLane.made) == 12


def test_progress_is_told_after_every_mission(path):
    told: list[Progress] = []
    with CampaignStore.create_or_open(path) as store:
        run_campaign(store, missions=2)
        run_campaign(store, missions=5, progress=told.append)
    assert [now.done for now in told] == [2, 3, 4, 5]
    assert [now.made for now in told] == [0, 1, 2, 3]
    assert [now.failed for now in told] == [0, 0, 1, 1]
    assert told[0].latest is None
    assert told[2].latest is not None
    assert told[2].latest.number == 3


def test_after_its_time_no_mission_begins(path, monkeypatch):
    monkeypatch.setattr(FakeLane, "slow_s", 0.05)
    begin_s = time.monotonic()
    with CampaignStore.create_or_open(path) as store:
        run_campaign(store, for_s=0.3, workers=2)
        assert 0 < len(store.done()) < 40
    assert time.monotonic() - begin_s < 5.0


def test_few_failures_of_a_kind_are_shrunk(path):
    with CampaignStore.create_or_open(path) as store:
        run_campaign(store, missions=60, shrunk_each=2)
        (minpos, every) = summary(store.rows())
    assert FakeLane.shrunk == [True, True, False, False, False, False]
    assert every.failed == minpos.failed == 6
    assert every.violations == {"planted": 6}
    assert every.outcomes == {"complete": 60}
    assert every.refused == 60


def test_a_campaign_ends_with_its_first_failure_if_wanted(path):
    with CampaignStore.create_or_open(path) as store:
        run_campaign(store, missions=60, stop_at_first=True)
        assert store.done() == set(range(4))
        run_campaign(store, missions=60, stop_at_first=True)
        assert store.done() == set(range(4))
        run_campaign(store, missions=8)
        assert store.done() == set(range(8))


def test_other_workers_stop_with_the_first_failure(path, monkeypatch):
    monkeypatch.setattr(FakeLane, "slow_s", 0.02)
    with CampaignStore.create_or_open(path) as store:
        run_campaign(store, missions=1000, workers=3, stop_at_first=True)
        assert [row.number for row in store.rows() if row.violations] == [3]


def test_what_a_lane_raises_is_raised_and_the_others_stop(path, monkeypatch):
    def breaks(lane, number):
        if number == 4:
            raise InvalidInputError("the disk is full")
        yield mission_of(number)

    monkeypatch.setattr(FakeLane, "make", breaks)
    with CampaignStore.create_or_open(path) as store:
        with pytest.raises(InvalidInputError, match="disk is full"):
            run_campaign(store, missions=1000)
        assert store.done() == set(range(4))


def test_an_interrupt_stops_all_lanes(path, monkeypatch):
    monkeypatch.setattr(FakeLane, "slow_s", 0.02)

    def interrupts(now):
        if now.made == 2:
            raise KeyboardInterrupt

    with CampaignStore.create_or_open(path) as store:
        with pytest.raises(KeyboardInterrupt):
            run_campaign(store, missions=1000, workers=2, progress=interrupts)
        assert len(store.done()) == 2
    time.sleep(0.1)
    made = len(FakeLane.made)
    time.sleep(0.1)
    assert len(FakeLane.made) == made


@pytest.mark.parametrize(("given", "said"), [({}, "needs an end"), ({"workers": 0}, "at least 1")])
def test_a_campaign_without_end_or_workers_is_refused(path, given, said):
    with (
        CampaignStore.create_or_open(path) as store,
        pytest.raises(InvalidInputError, match=said),
    ):
        run_campaign(store, **({"missions": 1} | given if given else {}))
