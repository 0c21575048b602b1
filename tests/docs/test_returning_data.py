"""The numbers that the page about returning data states of its examples."""

from pathlib import Path

import pytest
import shapely

import multisrt as ms
from multisrt.environments.environment import Environment

PAGE = (Path(__file__).parents[2] / "docs/returning-data.md").read_text()

CORRIDOR = Environment("corridor", shapely.box(0, 0, 60, 1.2))


def in_the_corridor(home):
    """One robot that begins at the base station."""
    return ms.explore(
        CORRIDOR,
        strategy="minpos",
        starts=[(1.0, 0.6)],
        base=(1.0, 0.6),
        radio_range_m=3.0,
        options={"home": home},
        max_time_s=100.0,
    ).metrics


def test_the_numbers_of_the_corridor_are_measured():
    without, in_time = in_the_corridor("never"), in_the_corridor("in-time")
    assert in_time.delivered_coverage == pytest.approx(in_time.coverage, abs=1e-9)
    assert (
        f"It delivers {100 * in_time.coverage:.0f} % of the corridor; without the option it covers "
        f"{100 * without.coverage:.0f} % and delivers {100 * without.delivered_coverage:.0f} %."
    ) in PAGE


def test_the_chain_of_the_example_delivers_at_once():
    metrics = ms.explore(
        "office",
        strategy="minpos",
        robots=4,
        starts=[(2.0, 3.0), (2.8, 3.0), (2.0, 3.8), (2.8, 3.8)],
        base=(2.0, 3.0),
        radio_range_m=9.0,
        options={"home": "chain"},
        max_time_s=600.0,
        seed=0,  # the default of the command
    ).metrics
    assert metrics.delivery_delay_s is not None
    assert metrics.delivered_coverage is not None
    assert metrics.delivery_delay_s < 0.05  # at once
    assert f"covers {100 * metrics.delivered_coverage:.0f} % of the office" in PAGE
    assert "--start 2,3 --start 2.8,3 --start 2,3.8 --start 2.8,3.8 --option home=chain" in PAGE
