"""Runs that are replayed."""

import pytest

import multisrt as ms


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
