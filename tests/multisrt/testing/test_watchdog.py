"""The limit on the time that an explorer may compute."""

import gc
import time
import weakref
from typing import Any

import pytest

from multisrt.testing.watchdog import ComputesTooLong, Watchdog


def busy(seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pass


def test_a_call_within_its_time_returns_what_it_computes() -> None:
    with Watchdog(1.0) as watchdog:
        assert watchdog.call(sum, [1, 2]) == 3


def test_a_call_that_computes_too_long_is_ended() -> None:
    begin = time.monotonic()
    with Watchdog(0.05) as watchdog, pytest.raises(ComputesTooLong):
        watchdog.call(busy, 60.0)
    assert time.monotonic() - begin < 30.0


def test_a_callback_of_the_garbage_collection_is_not_interrupted() -> None:
    """What it raises would be lost, with a warning: the call is ended after it."""
    ended = []

    def callback(phase: str, info: dict[str, Any]) -> None:
        if phase == "start":
            busy(0.3)
            ended.append(phase)

    def collect() -> None:
        gc.collect()
        busy(60.0)

    gc.callbacks.append(callback)
    try:
        with Watchdog(0.05) as watchdog, pytest.raises(ComputesTooLong) as raised:
            watchdog.call(collect)
    finally:
        gc.callbacks.remove(callback)
    assert ended
    assert raised.value.frame is not None
    assert raised.value.frame.f_code is busy.__code__


def test_a_callback_of_a_weak_reference_is_not_interrupted() -> None:
    """What it raises would be lost, too."""
    ended = []

    class Key:
        pass

    class Value:
        def __del__(self) -> None:
            busy(0.3)
            ended.append("value")

    keys = [Key()]
    values = weakref.WeakKeyDictionary({keys[0]: Value()})

    def drop() -> None:
        keys.clear()
        busy(60.0)

    with Watchdog(0.05) as watchdog, pytest.raises(ComputesTooLong) as raised:
        watchdog.call(drop)
    assert ended
    assert not values
    assert raised.value.frame is not None
    assert raised.value.frame.f_code is busy.__code__
