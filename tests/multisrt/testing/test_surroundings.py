"""Runs repeat: no clocks, no global random numbers, no state that explorers share."""

import datetime
import random
import time
from collections.abc import Callable
from time import time as clock
from typing import Any, ClassVar

import numpy as np
import pytest

from multisrt.robots.explorer import Receive, Sense
from multisrt.spec import RobotSpec
from multisrt.testing import ExplorerDefect, check_explorer
from tests.multisrt.testing.explorers import HALL, WORLD, Base, check, explorer, refused


def drives_by(number: Callable[[Any], float]) -> type[Base]:
    """Return an explorer that drives a distance given by a number from 0 to 1."""

    def act(self):
        yield Sense()
        yield self.to(x=number(self))

    return explorer(act)


def test_the_random_stream_of_the_robot_is_allowed():
    check(drives_by(lambda self: self.me.rng.random()))


@pytest.mark.parametrize("draw", [lambda _: random.random(), lambda _: np.random.rand()])  # noqa: NPY002
def test_global_random_numbers_are_found(draw):
    assert "rng" in refused(drives_by(draw), "global random numbers").remedy


def test_a_random_generator_without_a_seed_is_found():
    unseeded = drives_by(lambda _: np.random.default_rng().random())
    refused(unseeded, r"other random numbers: np.random.default_rng \(test_surroundings.py:\d+\)")


@pytest.mark.parametrize(
    "read",
    [
        lambda: time.time(),
        lambda: 1e-9 * time.perf_counter_ns(),
        lambda: clock(),
        lambda: datetime.datetime.now().timestamp(),
    ],
)
def test_a_clock_that_is_read_is_found(read):
    refused(drives_by(lambda _: (read() / 7e9) % 1.0), "reads a clock")


class Counting(Base):
    made = 0

    def act(self):
        Counting.made += 1
        yield Sense()
        yield self.to(x=0.001 * Counting.made)


class Listing(Base):
    places: ClassVar[list[int]] = []

    def act(self):
        yield Sense()
        Listing.places.append(self.me.robot)
        yield self.to(x=0.001 * len(Listing.places))


SHARED = {"n": 0}


def by_a_global(self):
    SHARED["n"] += 1
    yield Sense()
    yield self.to(x=0.001 * SHARED["n"])


def by_a_default(self, seen=[]):  # noqa: B006
    seen.append(1)
    yield Sense()
    yield self.to(x=0.001 * len(seen))


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (Counting, "Counting.made"),
        (Listing, "Listing.places"),
        (explorer(by_a_global), "SHARED"),
        (explorer(by_a_default), "default of by_a_default"),
    ],
)
def test_state_that_explorers_share(make, name):
    defect = refused(make, "which explorers share")
    assert name in defect.what
    assert "self" in defect.remedy


def test_shared_state_is_found_although_every_run_repeats():
    class Board(Base):
        told: ClassVar[dict[int, float]] = {}

        def act(self):
            # The first robot clears the shared state: no run knows of another one.
            if self.me.robot == 0:
                Board.told.clear()
            Board.told[self.me.robot] = self.at.x
            yield Sense()
            yield Receive(timeout_s=1.0)
            yield self.to(heading=0.01 * len(Board.told))

    refused(Board, "Board.told.*share", teams=(3,), world=WORLD)
    check(Board)


def test_state_shared_by_simultaneous_explorers_is_found():
    # Each restores the shared state at its end: only simultaneous explorers disturb it.
    class Turnstile(Base):
        inside: ClassVar[set[int]] = set()

        def act(self):
            others = len(Turnstile.inside)
            Turnstile.inside.add(id(self))
            yield Sense()
            others = max(others, len(Turnstile.inside) - 1)
            yield self.to(x=0.1 * others + 0.1)
            Turnstile.inside.discard(id(self))

    with pytest.raises(ExplorerDefect, match="shares state with explorers that run at the same"):
        check_explorer(Turnstile, worlds=[HALL, HALL], teams=[1], robot=RobotSpec(start=(3.0, 3.0)))
