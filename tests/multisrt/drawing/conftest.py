"""Recordings that tests of drawings share."""

import pytest
import shapely

from multisrt.environments.catalog import environment
from multisrt.environments.environment import Environment
from multisrt.recording import Recording
from tests.multisrt.drawing.recordings import A, B, C, D, E, F, end, motion, node, recorded, run


@pytest.fixture(scope="session")
def museum() -> Recording:
    """A complete run."""
    return run(environment("museum"), seed=1)


@pytest.fixture(scope="session")
def cut_off() -> Recording:
    """A run that ends after a minute."""
    return run(environment("museum"), seed=1, max_time_s=60.0)


@pytest.fixture(scope="session")
def stalled() -> Recording:
    """A run that leaves frontier open."""
    options = {"complete": False, "approach": False, "max_draws": 1}
    return run(environment("museum"), seed=1, options=options)


@pytest.fixture(scope="session")
def one_node() -> Recording:
    """A run that sees the whole world from its start."""
    return run(Environment("closet", shapely.box(0, 0, 2, 1)), start=(0.5, 0.5))


@pytest.fixture(scope="session")
def support() -> Recording:
    """Robot 0 is done, crosses a bridge to the tree of robot 1, adds a node and goes home."""
    return recorded(
        [A, C],
        [
            node(0.0, 0, 0, A),
            node(0.0, 1, 0, C),
            motion(1.0, 0, A, B),
            motion(1.0, 1, C, D),
            node(2.0, 0, 1, B, parent=(0, 0)),
            node(2.0, 1, 1, D, parent=(1, 0)),
            end(2.0, 0, frontier=((9.0, 1.0, 9.0, 5.0),)),
            motion(3.0, 1, D, E),
            node(4.0, 1, 2, E, parent=(1, 1)),
            motion(5.0, 1, E, D, C),
            end(7.0, 1),
            motion(8.0, 0, A, B, E, purpose="support"),
            motion(11.0, 0, E, F, purpose="support"),
            node(12.0, 0, 2, F, parent=(1, 2)),
            motion(12.0, 0, F, E, B, A, purpose="home"),
            end(15.0, 0),
        ],
    )
