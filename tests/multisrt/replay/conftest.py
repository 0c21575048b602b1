"""Runs that are replayed, and pages that replay them."""

import pytest

import multisrt as ms
from multisrt.replay import save_replay
from tests.multisrt.replay.shown import DESKTOP, Shown
from tests.multisrt.replay.staged import staged


@pytest.fixture(scope="package")
def team_run():
    """A team of the SRT family, for a minute, with a limited radio."""
    return ms.explore(
        "apartment", robots=3, starts="clustered", seed=1, radio_range_m=12.5, max_time_s=60.0
    )


@pytest.fixture(scope="package")
def bidding_run():
    """Two robots that bid for frontiers, in the same world."""
    return ms.explore("apartment", robots=2, strategy="minpos", seed=1, max_time_s=40.0)


@pytest.fixture(scope="package")
def files(tmp_path_factory, team_run, bidding_run):
    folder = tmp_path_factory.mktemp("replays")
    save_replay(team_run.recording, folder / "team.html")
    save_replay([team_run.recording, bidding_run.recording], folder / "both.html")
    save_replay(bidding_run.recording, folder / "bids.html")
    save_replay(staged(), folder / "staged.html")
    save_replay([team_run.recording, bidding_run.recording, staged()], folder / "three.html")
    save_replay([staged()] * 4, folder / "four.html")
    return folder


@pytest.fixture
def shown(browser, files, request):
    opened = []

    def show(name="team", address="", **options):
        context = browser.new_context(**{"viewport": DESKTOP} | options)
        page = Shown(context.new_page(), (files / f"{name}.html").as_uri())
        opened.append((context, page))
        return page.open(address)

    yield show
    for context, page in opened:
        assert page.errors == []
        assert all(url.startswith(("file:", "about:", "blob:")) for url in page.asked)
        context.close()
