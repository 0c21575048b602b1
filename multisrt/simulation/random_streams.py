"""The independent random streams of a run, derived from its seed."""

from __future__ import annotations

from typing import Final

import numpy as np

STREAMS: Final = {"starts": 0, "radio": 1, "faults": 2, "robots": 3}
"""Keys of the independent random streams of a run."""


def random_stream(seed: int, stream: str, number: int = 0) -> np.random.Generator:
    """Return a random stream of a run, independent of all its others.

    Parameters
    ----------
    seed : int
        Seed of the run.
    stream : {"starts", "radio", "faults", "robots"}
        What draws from it.
    number : int
        The robot, where each has its own.
    """
    key = (STREAMS[stream], number)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
