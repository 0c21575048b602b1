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


class RandomStreams:
    """The random streams of a run, and whether anything was drawn from them.

    Parameters
    ----------
    seed : int
        Seed of the run.

    Examples
    --------
    >>> streams = RandomStreams(1)
    >>> radio = streams.of("radio")
    >>> streams.are_drawn_from
    False
    >>> 0.0 <= radio.random() < 1.0, streams.are_drawn_from
    (True, True)
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._streams: dict[tuple[str, int], tuple[np.random.Generator, object]] = {}

    def of(self, stream: str, number: int = 0) -> np.random.Generator:
        """Return a stream, the same one at every call; see `random_stream`."""
        if (stream, number) not in self._streams:
            generator = random_stream(self._seed, stream, number)
            self._streams[stream, number] = generator, generator.bit_generator.state
        return self._streams[stream, number][0]

    @property
    def are_drawn_from(self) -> bool:
        """Whether a number was drawn from any of them; if not, the seed makes no difference."""
        return any(
            generator.bit_generator.state != at_first
            for generator, at_first in self._streams.values()
        )
