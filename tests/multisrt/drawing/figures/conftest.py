"""Runs that figures are drawn of."""

import pytest

import multisrt as ms
from multisrt.recording import Recording

RADIO = ms.RadioSpec(range_m=6.0)


@pytest.fixture(scope="session")
def bidders() -> Recording:
    """Three robots that bid for frontiers, out of each other's range for a while."""
    return ms.explore(
        "apartment", strategy="closest", robots=3, starts="clustered", seed=1, radio=RADIO
    ).recording


@pytest.fixture(scope="session")
def growers() -> Recording:
    """Three robots that grow trees, out of range for a while; one of them dies."""
    return ms.explore(
        "apartment",
        robots=3,
        seed=1,
        radio=ms.RadioSpec(range_m=12.0),
        max_time_s=120.0,
        faults=[ms.Death(robot=2, time_s=60.0)],
    ).recording


@pytest.fixture(scope="session")
def curves() -> list[Recording]:
    """Four short runs of one strategy and one of another, in one world."""
    runs = [ms.explore("open", robots=2, seed=seed, max_time_s=60.0) for seed in (1, 2, 3, 4)]
    runs.append(ms.explore("open", strategy="minpos", robots=2, seed=1, max_time_s=60.0))
    return [run.recording for run in runs]
